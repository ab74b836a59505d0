"""Who does the same work for many items: this process, or the ones that a matrix has left."""

from collections.abc import Callable, Sequence
from typing import Protocol, TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")


class Each(Protocol):
    """Does work for every item."""

    def __call__(self, work: Callable[[Item], Result], items: Sequence[Item]) -> list[Result]:
        """What a function of a module makes of every item, in their order. Both may go to another process."""


def one_by_one(work: Callable[[Item], Result], items: Sequence[Item]) -> list[Result]:
    """All of it in this process."""
    return [work(item) for item in items]
