"""Pieces: a value piece by piece as an affine function of time, as far as an expression is known to be one."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import product

import casadi as ca

MOST_PIECES = 8  # of one value that are told apart


@dataclass(frozen=True)
class AffinePiece:
    """One piece of a value: slope t + offset, or that and any multiple of a lattice."""

    slope: ca.SX
    offset: ca.SX
    lattice: ca.SX | None = None

    @property
    def is_flat(self) -> bool:
        """True if it is constant."""
        return bool(self.slope.is_zero())

    @property
    def key(self) -> tuple[int | float | None, ...]:
        """The same for equal pieces, as far as their expressions are the same."""
        parts = (self.slope, self.offset, self.lattice)
        return tuple(p if p is None else float(p) if p.is_constant() else p.element_hash() for p in parts)


Pieces = tuple[AffinePiece, ...] | None  # the pieces of a value; None where they are not affine, or too many
FLAT: Pieces = ()  # constant pieces of any values


def pieces_of(code: int, operands: list[Pieces]) -> Pieces:
    """The pieces of the result of an operation on values of which time enters some."""
    first, second = operands[0], operands[-1]
    one, zero = AffinePiece(ca.SX(0), ca.SX(1)), AffinePiece(ca.SX(0), ca.SX(0))
    match code:
        case ca.OP_ASSIGN:
            return first
        case ca.OP_ADD:
            return add_pieces(first, second)
        case ca.OP_SUB:
            return add_pieces(first, scale_pieces(second, lambda part: -part))
        case ca.OP_NEG:
            return scale_pieces(first, lambda part: -part)
        case ca.OP_TWICE:
            return scale_pieces(first, lambda part: 2 * part)
        case ca.OP_MUL | ca.OP_DIV:
            return _multiply_pieces(first, second, code)
        case ca.OP_LT | ca.OP_LE | ca.OP_EQ | ca.OP_NE | ca.OP_NOT | ca.OP_AND | ca.OP_OR:
            return zero, one
        case ca.OP_SIGN:
            return AffinePiece(ca.SX(0), ca.SX(-1)), zero, one
        case ca.OP_FLOOR | ca.OP_CEIL:
            return FLAT if are_flat(first) else (AffinePiece(ca.SX(0), ca.SX(0), ca.SX(1)),)
        case ca.OP_FMOD:
            return FLAT if are_flat(first) else on_lattice(first, steady_value(second))
        case ca.OP_FMIN | ca.OP_FMAX:
            return _join_pieces(first, second)
        case ca.OP_FABS:
            return _join_pieces(first, scale_pieces(first, lambda part: -part))
        case ca.OP_IF_ELSE_ZERO:
            return _join_pieces(second, (zero,))
    return FLAT if all(map(are_flat, operands)) else None


def are_flat(pieces: Pieces) -> bool:
    """True if all pieces are constant."""
    return pieces is not None and all(piece.is_flat for piece in pieces)


def _limit_pieces(pieces: Iterable[AffinePiece], flat: bool) -> Pieces:
    """Different pieces, if they are not too many; many constant ones are `FLAT`."""
    different = tuple({piece.key: piece for piece in pieces}.values())
    if len(different) <= MOST_PIECES:
        return different
    return FLAT if flat else None


def _join_pieces(first: Pieces, second: Pieces) -> Pieces:
    if first is None or second is None:
        return None
    flat = are_flat(first) and are_flat(second)
    if FLAT in (first, second):
        return FLAT if flat else None
    return _limit_pieces((*first, *second), flat)


def add_pieces(first: Pieces, second: Pieces) -> Pieces:
    """The pieces of a sum."""
    if first is None or second is None:
        return None
    flat = are_flat(first) and are_flat(second)
    if FLAT in (first, second) or (flat and len(first) * len(second) > MOST_PIECES):
        return FLAT if flat else None
    if len(first) * len(second) > MOST_PIECES**2:
        return None
    pieces = []
    for a, b in product(first, second):
        if a.lattice is not None and b.lattice is not None:
            return FLAT if flat else None
        lattice = b.lattice if a.lattice is None else a.lattice
        pieces.append(AffinePiece(a.slope + b.slope, a.offset + b.offset, lattice))
    return _limit_pieces(pieces, flat)


def scale_pieces(pieces: Pieces, scale: Callable[[ca.SX], ca.SX]) -> Pieces:
    """The pieces with each number scaled."""
    if pieces is None:
        return None
    parts = ((piece.slope, piece.offset, piece.lattice) for piece in pieces)
    return tuple(AffinePiece(scale(a), scale(b), None if q is None else scale(q)) for a, b, q in parts)


def _multiply_pieces(first: Pieces, second: Pieces, code: int) -> Pieces:
    """A product or a quotient, one factor of which is piece by piece a known number."""
    if first is None or second is None:
        return None
    if are_flat(first) and are_flat(second) and FLAT in (first, second):
        return FLAT
    if code == ca.OP_MUL and not _are_numbers(second):
        first, second = second, first
    if not _are_numbers(second) or second is None or first in (None, FLAT):
        return FLAT if are_flat(first) and are_flat(second) else None
    made: list[AffinePiece] = []
    for number in second:
        value = number.offset

        def scale(part: ca.SX, value: ca.SX = value) -> ca.SX:
            return part * value if code == ca.OP_MUL else part / value

        made += scale_pieces(first, scale) or ()
    return _limit_pieces(made, are_flat(first))


def _are_numbers(pieces: Pieces) -> bool:
    return bool(pieces) and are_flat(pieces) and all(piece.lattice is None for piece in pieces or ())


def steady_value(pieces: Pieces) -> ca.SX | None:
    """The value of a single constant piece."""
    return pieces[0].offset if pieces and len(pieces) == 1 and _are_numbers(pieces) else None


def on_lattice(pieces: Pieces, lattice: ca.SX | None) -> Pieces:
    """The pieces and all multiples of a number beside them; what is constant has no lattice of its own."""
    if pieces is None or are_flat(pieces):
        return pieces
    if lattice is None or any(piece.lattice is not None for piece in pieces if not piece.is_flat):
        return None
    return tuple(AffinePiece(piece.slope, piece.offset, lattice) for piece in pieces)
