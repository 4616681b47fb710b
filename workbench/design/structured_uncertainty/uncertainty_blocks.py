"""The blocks of a structured perturbation Delta = diag(Delta_1, ..., Delta_k), and the places of each in a matrix."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from workbench.core.validation.notebook_display import show
from workbench.core.validation.signatures import check_arguments
from workbench.design.matrices import Complex


@dataclass(frozen=True)
@show
@check_arguments
class FullBlock:
    """A full complex matrix of shape (rows, columns), for unmodelled dynamics; square if `columns` is left out.

    Examples
    --------
    >>> wb.structured_uncertainty.FullBlock(2)
    FullBlock(rows=2)
    """

    rows: int
    columns: int | None = None

    def __post_init__(self) -> None:
        _refuse_size(f"FullBlock(rows={self.rows})", self.rows)
        _refuse_size(f"FullBlock(columns={self.columns})", self.shape[1])

    @property
    def shape(self) -> tuple[int, int]:
        """The rows and columns of the block."""
        return self.rows, self.rows if self.columns is None else self.columns


@dataclass(frozen=True)
@show
@check_arguments
class ComplexScalar:
    """One complex number that occurs `count` times on the diagonal, for one unmodelled gain and phase.

    Examples
    --------
    >>> wb.structured_uncertainty.ComplexScalar(3)
    ComplexScalar(count=3)
    """

    count: int = 1

    def __post_init__(self) -> None:
        _refuse_size(f"ComplexScalar(count={self.count})", self.count)

    @property
    def shape(self) -> tuple[int, int]:
        """The rows and columns of the block."""
        return self.count, self.count


@dataclass(frozen=True)
@show
@check_arguments
class RealScalar:
    """One real number that occurs `count` times on the diagonal, for an uncertain parameter.

    Examples
    --------
    >>> wb.structured_uncertainty.RealScalar()
    RealScalar(count=1)
    """

    count: int = 1

    def __post_init__(self) -> None:
        _refuse_size(f"RealScalar(count={self.count})", self.count)

    @property
    def shape(self) -> tuple[int, int]:
        """The rows and columns of the block."""
        return self.count, self.count


UncertaintyBlock: TypeAlias = FullBlock | ComplexScalar | RealScalar


@dataclass(frozen=True)
class Places:
    """A block with the first of its rows and columns in a square matrix, and its size there.

    A block that is not square is filled with zeros up to a square one, which changes no structured singular value.
    """

    block: UncertaintyBlock
    start: int
    size: int

    @property
    def span(self) -> slice:
        """The rows, and columns, of the block."""
        return slice(self.start, self.start + self.size)

    @property
    def real(self) -> bool:
        """True for a real scalar."""
        return isinstance(self.block, RealScalar)

    @property
    def full(self) -> bool:
        """True for a full block of more than one row or column."""
        return isinstance(self.block, FullBlock) and self.size > 1


def places_of(blocks: Sequence[UncertaintyBlock]) -> tuple[Places, ...]:
    """The blocks one after the other."""
    places, start = [], 0
    for block in blocks:
        size = max(block.shape)
        places.append(Places(block, start, size))
        start += size
    return tuple(places)


def refuse_shape(call: str, shape: tuple[int, int], blocks: Sequence[UncertaintyBlock]) -> None:
    """Refuse a matrix that the blocks do not fit: Delta has the shape of its transpose."""
    wanted = sum(block.shape[1] for block in blocks), sum(block.shape[0] for block in blocks)
    if not blocks or shape != wanted:
        raise ValueError(f"`{call}`: Delta has {len(blocks)} blocks, so M must have the shape {wanted}; got {shape}.")


def pad(M: Complex, blocks: Sequence[UncertaintyBlock]) -> Complex:
    """The matrix with rows and columns of zeros where blocks are filled up."""
    rows, columns = _filled(blocks, 1), _filled(blocks, 0)
    padded = np.zeros((len(rows), len(rows)), dtype=complex)
    padded[np.ix_(rows, columns)] = M
    return padded


def unpad(Delta: Complex, blocks: Sequence[UncertaintyBlock]) -> Complex:
    """The perturbation without what was filled up."""
    return Delta[np.ix_(_filled(blocks, 0), _filled(blocks, 1))]


def _filled(blocks: Sequence[UncertaintyBlock], axis: int) -> list[bool]:
    return [i < block.shape[axis] for block in blocks for i in range(max(block.shape))]


def _refuse_size(call: str, size: int) -> None:
    if size < 1:
        raise ValueError(f"`{call}` must be a whole number from 1; got {size}.")
