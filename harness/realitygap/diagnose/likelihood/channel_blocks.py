"""Matrices with a row for every sample, stored by channel with only the columns that are not zero there (block sparse).

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
class ChannelBlock:
    """The rows of one channel, without the columns that are zero in all of them.

    Attributes:
        rows: where they are in the matrix, k of them.
        columns: the numbers of the columns that are not zero there. Shape (n,).
        values: these columns in these rows. Shape (k, n).
    """

    rows: slice
    columns: NDArray[np.int64]
    values: Array


@dataclass(frozen=True)
class ChannelBlocks:
    """A matrix (m, q) by the rows of each channel.

    Attributes:
        blocks: one for each channel, one after the other.
        width: how many columns it has, q.
    """

    blocks: tuple[ChannelBlock, ...]
    width: int

    @classmethod
    def of(cls, columns: Array, sizes: Sequence[int]) -> ChannelBlocks:
        """A dense matrix, (m, q), where channels have so many rows each."""
        blocks = []
        for first, last in pairwise(np.cumsum([0, *sizes]).tolist()):
            values = columns[first:last]
            at = np.flatnonzero(values.any(axis=0))
            blocks.append(ChannelBlock(slice(first, last), at, np.ascontiguousarray(values[:, at])))
        return cls(tuple(blocks), columns.shape[1])

    def every(self, strides: Sequence[int]) -> ChannelBlocks:
        """Subsampled: of the rows of each channel only every so manieth."""
        values = [b.values[::stride] for b, stride in zip(self.blocks, strides, strict=True)]
        ends = pairwise(np.cumsum([0, *map(len, values)]).tolist())
        blocks = [ChannelBlock(slice(*e), b.columns, v) for e, b, v in zip(ends, self.blocks, values, strict=True)]
        return ChannelBlocks(tuple(blocks), self.width)

    def beside(self, other: ChannelBlocks) -> ChannelBlocks:
        """With the columns of another after its own (hstack)."""
        blocks = [
            ChannelBlock(a.rows, np.concatenate([a.columns, self.width + b.columns]), np.hstack([a.values, b.values]))
            for a, b in zip(self.blocks, other.blocks, strict=True)
        ]
        return ChannelBlocks(tuple(blocks), self.width + other.width)

    def scaled(self, rows: Array) -> ChannelBlocks:
        """With rows multiplied: diag(rows)·A. Shape (m,)."""
        blocks = [ChannelBlock(b.rows, b.columns, b.values * rows[b.rows, None]) for b in self.blocks]
        return ChannelBlocks(tuple(blocks), self.width)

    def stretched(self, columns: Array) -> ChannelBlocks:
        """With columns multiplied: A·diag(columns). Shape (q,)."""
        blocks = [ChannelBlock(b.rows, b.columns, b.values * columns[b.columns]) for b in self.blocks]
        return ChannelBlocks(tuple(blocks), self.width)

    def gram(self) -> Array:
        """The Gram matrix Aᵀ·A, the inner products of its columns. Shape (q, q)."""
        out = np.zeros((self.width, self.width))
        for b in self.blocks:
            out[np.ix_(b.columns, b.columns)] += b.values.T @ b.values
        return out

    def on(self, columns: Array) -> Array:
        """Aᵀ·columns, the inner products of its columns with others. Shape (m, n) -> (q, n)."""
        out = np.zeros((self.width, columns.shape[1]))
        for b in self.blocks:
            out[b.columns] += b.values.T @ columns[b.rows]
        return out

    def times(self, amounts: Array) -> Array:
        """A·amounts, its columns so many times each. Shape (q, n) -> (m, n)."""
        return np.vstack([b.values @ amounts[b.columns] for b in self.blocks])
