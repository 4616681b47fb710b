"""Switches: the instants, known before a run, at which a rate jumps or bends, read from the expression of the rate.

A comparison, floor, sign or the like of what depends on time and on steady numbers alone switches where an affine
function of time passes a number: at one instant, or at every `spacing` of a lattice of them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import casadi as ca
import numpy as np

from workbench.core.affine_pieces import (
    AffinePiece,
    Pieces,
    add_pieces,
    on_lattice,
    pieces_of,
    scale_pieces,
    steady_value,
)
from workbench.core.expressions import rows
from workbench.core.validation.refusals import Array

# As a share of the time: an instant so near to the end of a step, or to another instant, is that end. It is far beyond
# the rounding of a time, so that the middle of a segment is on one side of every switch.
NEAR = 2.0**-46
MOST_INSTANTS = 100_000  # of one lattice in a run that are listed
DENSEST = 1_000  # instants of one lattice in a step, beyond which its state is no number

COMPARISONS = (ca.OP_LT, ca.OP_LE, ca.OP_EQ, ca.OP_NE)
CORNERS = (ca.OP_FMIN, ca.OP_FMAX)
JUMPS = {*COMPARISONS, ca.OP_FLOOR, ca.OP_CEIL, ca.OP_SIGN}  # whose values are constant from switch to switch


@dataclass(frozen=True, eq=False)
class Switches:
    """The switches of a rate; `rate` is the same one whose jumps in time are those at `m`, the middle of a segment."""

    m: ca.SX  # symbol of a time in s, (1, 1)
    rate: ca.SX  # (nx, 1), in t, m, x and p
    instants: ca.SX  # in s, (n, 1), in p and those x whose rate is zero
    firsts: ca.SX  # in s, (l, 1): an instant of each lattice
    spacings: ca.SX  # in s, (l, 1)
    p: ca.SX  # symbol of the parameters
    unknown_operations: tuple[str, ...] = ()  # operations that switch at instants not known before

    @property
    def has_instants(self) -> bool:
        """True if there is an instant to be met."""
        return bool(self.instants.numel() + self.firsts.numel())

    @property
    def warnings(self) -> tuple[str, ...]:
        """A sentence for a reader of results, where it switches in time at instants that are not known before."""
        if not self.unknown_operations:
            return ()
        return (
            f"it switches in time at instants that are not known before a run ({', '.join(self.unknown_operations)}), "
            "so that a pulse shorter than the step may be missed",
        )

    def can_occur(self, p: Array) -> bool:
        """True if a run with one of the rows p (B, np) may have a switch behind time 0."""
        if self.firsts.numel() or not self._is_timed:
            return True
        return bool((self._values(p)[:, : self.instants.numel()] > 0).any())

    def depends_on(self, places: Sequence[int]) -> bool:
        """True if an instant depends on one of the parameters at these places."""
        turned = ca.vertcat(ca.SX(0, 1), *[self.p[place] for place in places])
        return bool(turned.numel() and ca.depends_on(ca.vertcat(self.instants, self.firsts, self.spacings), turned))

    def densest(self, p: Array) -> float:
        """The least spacing in s of a lattice of instants with the rows p (B, np); infinite if there is none."""
        if not self.spacings.numel() or not self._is_timed:
            return math.inf
        spacings = self._values(p)[:, self.instants.numel() :]
        return float(np.min(spacings, where=spacings == spacings, initial=math.inf))

    def until(self, p: Array, end: float) -> list[Array]:
        """The different instants in s from 0 to `end` of each row of p (B, np); none where a state says when."""
        if not self.has_instants or not self._is_timed:
            return [np.zeros(0)] * len(p)
        function = ca.Function("all", [self.p], [ca.densify(ca.vertcat(self.instants, self.firsts, self.spacings))])
        n, lattices, found = self.instants.numel(), self.firsts.numel(), []
        for row in rows(function, np.ascontiguousarray(p)):
            parts = [row[:n]]
            for first, spacing in zip(row[n : n + lattices], row[n + lattices :], strict=True):
                count = min(end / spacing, MOST_INSTANTS) if spacing > 0 else 0.0
                parts.append(first % spacing + spacing * np.arange(int(count) + 1) if spacing > 0 else row[:0])
            times = np.concatenate(parts)
            found.append(np.unique(times[(times >= 0) & (times <= end)]))
        return found

    @cached_property
    def _is_timed(self) -> bool:
        """True if parameters alone say when it switches, and no steady state."""
        known = {symbol.element_hash() for symbol in ca.symvar(self.p)}
        return all(symbol.element_hash() in known for symbol in ca.symvar(ca.vertcat(self.instants, self.spacings)))

    @cached_property
    def _function(self) -> ca.Function:
        return ca.Function("instants", [self.p], [ca.densify(ca.vertcat(self.instants, self.spacings))], {"cse": True})

    def _values(self, p: Array) -> Array:
        return rows(self._function, np.ascontiguousarray(p))

    def after(self, begin: ca.SX, s: ca.SX, length: ca.SX) -> ca.SX:
        """The first offset beyond s from `begin` at which there is a switch, at most `length`; all in s.

        It is no number where a step has more than `DENSEST` instants of a lattice, so that such a run diverges.
        """
        near = NEAR * (begin + length)
        from_here, end = s + near, length

        def sooner(end: ca.SX, offset: ca.SX) -> ca.SX:
            return ca.fmin(end, ca.if_else(offset > from_here, offset, length))

        for instant in ca.vertsplit(self.instants):
            end = sooner(end, instant - begin)
        for first, spacing in zip(ca.vertsplit(self.firsts), ca.vertsplit(self.spacings), strict=True):
            number = ca.floor((begin + from_here - first) / spacing)
            for ahead in (1, 2):  # the second where rounding takes the first back
                end = sooner(end, first + (number + ahead) * spacing - begin)
        end = ca.if_else(end > length - near, length, end)
        for spacing in ca.vertsplit(self.spacings):
            room = spacing * DENSEST - length
            end = ca.if_else(room < 0, ca.sqrt(room), end)
        return end


@dataclass(frozen=True, eq=False)
class _Value:
    """A value of the rate: with jumps at the middle, all of it at the middle if no moving state enters, its pieces."""

    now: ca.SX
    middle: ca.SX | None
    is_timed: bool  # time enters it, and no moving state
    pieces: Pieces


def find_switches(rate: ca.SX, t: ca.SX, x: ca.SX, p: ca.SX, values: ca.SX | None = None) -> Switches:
    """The switches of x' = rate(t, x, p), or of `values` (k, 1), in t, x and p, if these are given."""
    seen = rate if values is None else values
    if not seen.numel() or not ca.depends_on(seen, t):
        none = ca.SX(0, 1)
        return Switches(ca.SX.sym("m"), seen, none, none, none, p)
    moves = [not entry.is_zero() for entry in ca.vertsplit(ca.densify(rate))]
    return _Search(seen, moves, t, x, p).switches


class _Search:
    """The reading of a rate, operation by operation."""

    def __init__(self, rate: ca.SX, moves: Sequence[bool], t: ca.SX, x: ca.SX, p: ca.SX) -> None:
        self.p, self.m = p, ca.SX.sym("m")
        self.pieces_by_key, self.unknown_operations = dict[tuple[object, ...], AffinePiece](), dict[str, None]()
        # by operation and operands, which are held so that no other object gets their identities
        self.calls: dict[tuple[object, ...], tuple[_Value, list[_Value]]] = {}
        symbols = [t, x, p]
        function = ca.Function("rate", symbols, [ca.densify(rate)])
        expressions = function.instructions_sx()
        registers: dict[int, _Value] = {}
        results = [ca.SX(0.0)] * rate.numel()
        for line in range(function.n_instructions()):
            code = function.instruction_id(line)
            reads, writes = function.instruction_input(line), function.instruction_output(line)
            if code == ca.OP_OUTPUT:
                results[writes[1]] = registers[reads[0]].now
            elif code == ca.OP_INPUT:
                symbol = symbols[reads[0]].nz[reads[1]]
                moving = reads[0] == 1 and moves[reads[1]]
                registers[writes[0]] = self._held(tuple(reads), self._source(symbol, reads[0] == 0, moving))
            elif code == ca.OP_CONST:
                number = function.instruction_constant(line)
                registers[writes[0]] = self._held((number.hex(),), self._steady(ca.SX(number)))
            elif code == ca.OP_CALL:
                operands = [registers[i] for i in reads]
                registers |= self._call(expressions.nz[line].which_function(), operands, writes)
            else:
                registers[writes[0]] = self._once(code, [registers[i] for i in reads])
        self.switches = self._gather(ca.vertcat(*results))

    def _gather(self, rate: ca.SX) -> Switches:
        singles, firsts, spacings = list[ca.SX](), list[ca.SX](), list[ca.SX]()
        for piece in self.pieces_by_key.values():
            instant = -piece.offset / piece.slope
            if piece.lattice is None:
                singles.append(instant)
            else:
                firsts.append(instant)
                spacings.append(ca.fabs(piece.lattice / piece.slope))
        single, first, spacing = (ca.vertcat(ca.SX(0, 1), *part) for part in (singles, firsts, spacings))
        return Switches(self.m, rate, single, first, spacing, self.p, tuple(self.unknown_operations))

    def _steady(self, value: ca.SX) -> _Value:
        return _Value(value, value, False, (AffinePiece(ca.SX(0), value),))

    def _source(self, symbol: ca.SX, is_time: bool, moves: bool) -> _Value:
        if is_time:
            return _Value(symbol, self.m, True, (AffinePiece(ca.SX(1), ca.SX(0)),))
        return _Value(symbol, None, False, None) if moves else self._steady(symbol)

    def _call(self, function: ca.Function, operands: list[_Value], writes: list[int]) -> dict[int, _Value]:
        """The results of a function that is not written out; its knots in time, if any, are not known."""
        sizes = [function.numel_in(i) for i in range(function.n_in())]

        def columns(parts: list[ca.SX]) -> list[ca.SX]:
            ends = pairwise([sum(sizes[:i]) for i in range(len(sizes) + 1)])
            return [ca.reshape(ca.vertcat(*parts[a:b]), *function.size_in(i)) for i, (a, b) in enumerate(ends)]

        def results(parts: list[ca.SX]) -> list[ca.SX]:
            return [entry for made in function.call(columns(parts)) for entry in ca.vertsplit(ca.vec(made))]

        now, middles = results([operand.now for operand in operands]), [operand.middle for operand in operands]
        held = [part for part in middles if part is not None]
        alone = len(held) == len(middles)
        timed = alone and any(operand.is_timed for operand in operands)
        if timed:
            self.unknown_operations[function.name()] = None
        middle: list[ca.SX] | list[None] = results(held) if alone else [None] * len(now)
        return {
            place: _Value(value, at, timed, None if timed or at is None else (AffinePiece(ca.SX(0), value),))
            for place, value, at in zip(writes, now, middle, strict=True)
        }

    def _once(self, code: int, operands: list[_Value]) -> _Value:
        """The value of an operation, each one made once, so that equal instants are one."""
        key = (code, "of", *map(id, operands))
        return self.calls[key][0] if key in self.calls else self._held(key, self._operation(code, operands), operands)

    def _held(self, key: tuple[object, ...], value: _Value, operands: Sequence[_Value] = ()) -> _Value:
        return self.calls.setdefault(key, (value, [*operands]))[0]

    def _operation(self, code: int, operands: list[_Value]) -> _Value:
        now = _apply(code, [operand.now for operand in operands])
        middles = [operand.middle for operand in operands if operand.middle is not None]
        if len(middles) < len(operands):
            return _Value(now, None, False, None)
        if not any(operand.is_timed for operand in operands):
            return self._steady(now)
        middle, pieces = _apply(code, middles), [operand.pieces for operand in operands]
        self._note(code, pieces)
        if code in JUMPS:
            now = middle
        elif code == ca.OP_FMOD:  # a - b trunc(a / b), with the last factor that of the middle
            flat = ca.is_equal(operands[0].now, middles[0])
            now = middle if flat else operands[0].now - (middles[0] - middle)
        return _Value(now, middle, True, pieces_of(code, pieces))

    def _note(self, code: int, pieces: list[Pieces]) -> None:
        """Note the switches of an operation."""
        if code in COMPARISONS or code in CORNERS:
            passed = add_pieces(pieces[0], scale_pieces(pieces[1], lambda part: -part))
        elif code in (ca.OP_SIGN, ca.OP_FABS):
            passed = pieces[0]
        elif code in (ca.OP_FLOOR, ca.OP_CEIL, ca.OP_FMOD):
            passed = on_lattice(pieces[0], ca.SX(1) if code != ca.OP_FMOD else steady_value(pieces[1]))
        else:
            return
        if passed is None:
            if code in JUMPS or code == ca.OP_FMOD:
                self.unknown_operations[NAMES.get(code, "fmod")] = None
            return
        self.pieces_by_key |= {
            piece.key: piece for piece in passed if not piece.is_flat and piece.key not in self.pieces_by_key
        }


NAMES = {getattr(ca, f"OP_{name.upper()}"): name for name in ("lt", "le", "eq", "ne", "floor", "ceil", "sign")}


def _apply(code: int, operands: list[ca.SX]) -> ca.SX:
    if code == ca.OP_ASSIGN:
        return operands[0]
    return ca.SX.binary(code, *operands) if len(operands) == 2 else ca.SX.unary(code, *operands)
