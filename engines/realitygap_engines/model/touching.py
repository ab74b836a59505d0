"""Which links touch the ground."""

from collections.abc import Sequence
from pathlib import Path

from realitygap_engines.errors import ModelError
from realitygap_engines.model.robot import Joint, Link


def touching(path: Path, links: Sequence[Link], joints: Sequence[Joint], wanted: list[str] | None) -> set[str]:
    """The names of the links that touch the ground: those asked for, or the base and the leaves.

    Raises:
        ModelError: where a link is asked for that is not there.
    """
    if wanted is None:
        parents = {joint.parent for joint in joints}
        return {link.name for i, link in enumerate(links) if i == 0 or i not in parents}
    known = {name: link.name for link in links for name in link.merged}
    for name in wanted:
        if name not in known:
            raise ModelError(f"{path}: has no link {name} that could touch the ground; it has {', '.join(known)}")
    return {known[name] for name in wanted}
