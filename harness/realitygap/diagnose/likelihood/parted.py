"""Matrices with a row for every sample, most of whose columns are zero in most channels.

What is off at one joint shows in its own signals, what is late in one motion in no other. A humanoid has some hundred
such columns, and nearly all of the time that its evidence takes would go into multiplying zeros.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from realitygap.robot.drive import Array


@dataclass(frozen=True)
class Part:
    """The rows of one channel: where they are, the numbers of the columns that are not zero there, (n,), and these in
    them, (k, n).
    """

    rows: slice
    at: NDArray[np.int64]
    block: Array


@dataclass(frozen=True)
class Parted:
    """A matrix by the rows of each channel.

    Attributes:
        parts: one after the other.
        width: how many columns it has.
    """

    parts: tuple[Part, ...]
    width: int

    @classmethod
    def of(cls, columns: Array, sizes: Sequence[int]) -> Parted:
        """A matrix, (m, q), where channels have so many rows each."""
        parts = []
        for first, last in pairwise(np.cumsum([0, *sizes]).tolist()):
            block = columns[first:last]
            at = np.flatnonzero(block.any(axis=0))
            parts.append(Part(slice(first, last), at, np.ascontiguousarray(block[:, at])))
        return cls(tuple(parts), columns.shape[1])

    def every(self, strides: Sequence[int]) -> Parted:
        """Of the rows of each channel only every so manieth."""
        blocks = [p.block[::stride] for p, stride in zip(self.parts, strides, strict=True)]
        ends = pairwise(np.cumsum([0, *map(len, blocks)]).tolist())
        parts = [Part(slice(*e), p.at, b) for e, p, b in zip(ends, self.parts, blocks, strict=True)]
        return Parted(tuple(parts), self.width)

    def beside(self, other: Parted) -> Parted:
        """With the columns of another after its own."""
        parts = [
            Part(a.rows, np.concatenate([a.at, self.width + b.at]), np.hstack([a.block, b.block]))
            for a, b in zip(self.parts, other.parts, strict=True)
        ]
        return Parted(tuple(parts), self.width + other.width)

    def scaled(self, rows: Array) -> Parted:
        """With rows multiplied. Shape (m,)."""
        parts = [Part(p.rows, p.at, p.block * rows[p.rows, None]) for p in self.parts]
        return Parted(tuple(parts), self.width)

    def stretched(self, columns: Array) -> Parted:
        """With columns multiplied. Shape (q,)."""
        return Parted(tuple(Part(p.rows, p.at, p.block * columns[p.at]) for p in self.parts), self.width)

    def gram(self) -> Array:
        """The inner products of its columns. Shape (q, q)."""
        out = np.zeros((self.width, self.width))
        for p in self.parts:
            out[np.ix_(p.at, p.at)] += p.block.T @ p.block
        return out

    def on(self, columns: Array) -> Array:
        """The inner products of its columns with others. Shape (m, n) -> (q, n)."""
        out = np.zeros((self.width, columns.shape[1]))
        for p in self.parts:
            out[p.at] += p.block.T @ columns[p.rows]
        return out

    def times(self, amounts: Array) -> Array:
        """Its columns, so many times each. Shape (q, n) -> (m, n)."""
        return np.vstack([p.block @ amounts[p.at] for p in self.parts])
