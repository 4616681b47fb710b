"""Switches: the instants, known before a run, at which a rate jumps or bends, read from the expression of the rate.

A comparison, floor, sign or the like of what depends on time and on steady numbers alone switches where an affine
function of time passes a number: at one instant, or at every `spacing` of a lattice of them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise, product

import casadi as ca
import numpy as np

from workbench.core.expressions import rows
from workbench.validation.refusals import Array

MOST_FORMS = 8  # affine pieces of one value that are told apart
# As a share of the time: an instant so near to the end of a step, or to another instant, is that end. It is far beyond
# the rounding of a time, so that the middle of a segment is on one side of every switch.
NEAR = 2.0**-46
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
    unknown: tuple[str, ...]  # operations that switch at instants not known before
    p: ca.SX  # symbol of the parameters

    @property
    def known(self) -> bool:
        """True if there is an instant to be met."""
        return bool(self.instants.numel() + self.firsts.numel())

    @property
    def warnings(self) -> tuple[str, ...]:
        """A sentence for a reader of results, where it switches in time at instants that are not known before."""
        if not self.unknown:
            return ()
        return (
            f"it switches in time at instants that are not known before a run ({', '.join(self.unknown)}), so that a "
            "pulse shorter than the step may be missed",
        )

    def come(self, p: Array) -> bool:
        """True if a run with one of the rows p (B, np) may have a switch behind time 0."""
        if self.firsts.numel() or not self._timed:
            return True
        return bool((self._values(p)[:, : self.instants.numel()] > 0).any())

    def densest(self, p: Array) -> float:
        """The least spacing in s of a lattice of instants with the rows p (B, np); infinite if there is none."""
        if not self.spacings.numel() or not self._timed:
            return math.inf
        spacings = self._values(p)[:, self.instants.numel() :]
        return float(np.min(spacings, where=spacings == spacings, initial=math.inf))

    @cached_property
    def _timed(self) -> bool:
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

        It is infinite where one step has more than `DENSEST` instants of a lattice, so that such a run diverges.
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
            end = ca.if_else(spacing * DENSEST < length, ca.inf, end)
        return end


@dataclass(frozen=True)
class _Form:
    """One piece of a value: slope t + offset, or that and any multiple of a lattice."""

    slope: ca.SX
    offset: ca.SX
    lattice: ca.SX | None = None

    @property
    def key(self) -> tuple[int | float | None, ...]:
        parts = (self.slope, self.offset, self.lattice)
        return tuple(p if p is None else float(p) if p.is_constant() else p.element_hash() for p in parts)


Forms = tuple[_Form, ...] | None  # the pieces of a value; None where they are not affine, or too many
FLAT: Forms = ()  # constant pieces of any values


@dataclass(frozen=True, eq=False)
class _Value:
    """A value of the rate: with jumps at the middle, all of it at the middle if no moving state enters, its forms."""

    now: ca.SX
    middle: ca.SX | None
    timed: bool  # time enters it, and no moving state
    forms: Forms


def find_switches(rate: ca.SX, t: ca.SX, x: ca.SX, p: ca.SX) -> Switches:
    """The switches of x' = rate(t, x, p)."""
    if not rate.numel() or not ca.depends_on(rate, t):
        return Switches(ca.SX.sym("m"), rate, *[ca.SX(0, 1)] * 3, (), p)
    return _Search(rate, t, x, p).switches


class _Search:
    """The reading of a rate, operation by operation."""

    def __init__(self, rate: ca.SX, t: ca.SX, x: ca.SX, p: ca.SX) -> None:
        self.p = p
        self.m, self.found, self.unknown = ca.SX.sym("m"), list[_Form](), dict[str, None]()
        self.made: dict[tuple[object, ...], _Value] = {}
        moves = [not entry.is_zero() for entry in ca.vertsplit(ca.densify(rate))]
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
                registers[writes[0]] = self._source(symbol, reads[0] == 0, reads[0] == 1 and moves[reads[1]])
            elif code == ca.OP_CONST:
                registers[writes[0]] = self._steady(ca.SX(function.instruction_constant(line)))
            elif code == ca.OP_CALL:
                operands = [registers[i] for i in reads]
                registers |= self._call(expressions.nz[line].which_function(), operands, writes)
            else:
                registers[writes[0]] = self._once(code, [registers[i] for i in reads])
        self.switches = self._gathered(ca.vertcat(*results))

    def _gathered(self, rate: ca.SX) -> Switches:
        singles = [-form.offset / form.slope for form in self.found if form.lattice is None]
        lattices = [form for form in self.found if form.lattice is not None]
        firsts = [-form.offset / form.slope for form in lattices]
        spacings = [ca.fabs(form.lattice / form.slope) for form in lattices]
        columns = [ca.vertcat(ca.SX(0, 1), *part) for part in (singles, firsts, spacings)]
        return Switches(self.m, rate, *columns, tuple(self.unknown), self.p)

    def _steady(self, value: ca.SX) -> _Value:
        return _Value(value, value, False, (_Form(ca.SX(0), value),))

    def _source(self, symbol: ca.SX, is_time: bool, moves: bool) -> _Value:
        if is_time:
            return _Value(symbol, self.m, True, (_Form(ca.SX(1), ca.SX(0)),))
        return _Value(symbol, None, False, None) if moves else self._steady(symbol)

    def _call(self, called: ca.Function, operands: list[_Value], writes: list[int]) -> dict[int, _Value]:
        """The results of a function that is not written out; its knots in time, if any, are not known."""
        sizes = [called.numel_in(i) for i in range(called.n_in())]

        def columns(parts: list[ca.SX]) -> list[ca.SX]:
            ends = pairwise([sum(sizes[:i]) for i in range(len(sizes) + 1)])
            return [ca.reshape(ca.vertcat(*parts[a:b]), *called.size_in(i)) for i, (a, b) in enumerate(ends)]

        def results(parts: list[ca.SX]) -> list[ca.SX]:
            return [entry for made in called.call(columns(parts)) for entry in ca.vertsplit(ca.vec(made))]

        now, middles = results([operand.now for operand in operands]), [operand.middle for operand in operands]
        held = [part for part in middles if part is not None]
        alone = len(held) == len(middles)
        timed = alone and any(operand.timed for operand in operands)
        if timed:
            self.unknown[called.name()] = None
        middle: list[ca.SX] | list[None] = results(held) if alone else [None] * len(now)
        return {
            place: _Value(value, at, timed, None if timed or at is None else (_Form(ca.SX(0), value),))
            for place, value, at in zip(writes, now, middle, strict=True)
        }

    def _once(self, code: int, operands: list[_Value]) -> _Value:
        """The value of an operation, each one made once, so that equal instants are one."""
        key = (code, *map(id, operands))
        if key not in self.made:
            self.made[key] = self._operation(code, operands)
        return self.made[key]

    def _operation(self, code: int, operands: list[_Value]) -> _Value:
        now = _applied(code, [operand.now for operand in operands])
        middles = [operand.middle for operand in operands if operand.middle is not None]
        if len(middles) < len(operands):
            return _Value(now, None, False, None)
        if not any(operand.timed for operand in operands):
            return self._steady(now)
        middle, forms = _applied(code, middles), [operand.forms for operand in operands]
        self._note(code, forms)
        if code in JUMPS:
            now = middle
        elif code == ca.OP_FMOD:  # a - b trunc(a / b), with the last factor that of the middle
            flat = ca.is_equal(operands[0].now, middles[0])
            now = middle if flat else operands[0].now - (middles[0] - middle)
        return _Value(now, middle, True, _forms_of(code, forms))

    def _note(self, code: int, forms: list[Forms]) -> None:
        """Note the switches of an operation."""
        if code in COMPARISONS or code in CORNERS:
            passed = _summed(forms[0], _scaled(forms[1], lambda part: -part))
        elif code in (ca.OP_SIGN, ca.OP_FABS):
            passed = forms[0]
        elif code in (ca.OP_FLOOR, ca.OP_CEIL, ca.OP_FMOD):
            passed = _on_lattice(forms[0], ca.SX(1) if code != ca.OP_FMOD else _steady_value(forms[1]))
        else:
            return
        if passed is None:
            if code in JUMPS or code == ca.OP_FMOD:
                self.unknown[NAMES[code]] = None
            return
        keys = {form.key for form in self.found}
        self.found += [form for form in passed if not form.slope.is_zero() and form.key not in keys]


NAMES = {getattr(ca, f"OP_{name.upper()}"): name for name in "lt le eq ne floor ceil sign fmod".split()}


def _applied(code: int, operands: list[ca.SX]) -> ca.SX:
    if code == ca.OP_ASSIGN:
        return operands[0]
    return ca.SX.binary(code, *operands) if len(operands) == 2 else ca.SX.unary(code, *operands)


def _forms_of(code: int, forms: list[Forms]) -> Forms:
    """The pieces of the result of an operation on values of which time enters some."""
    first, second = forms[0], forms[-1]
    one, zero = _Form(ca.SX(0), ca.SX(1)), _Form(ca.SX(0), ca.SX(0))
    match code:
        case ca.OP_ASSIGN:
            return first
        case ca.OP_ADD:
            return _summed(first, second)
        case ca.OP_SUB:
            return _summed(first, _scaled(second, lambda part: -part))
        case ca.OP_NEG:
            return _scaled(first, lambda part: -part)
        case ca.OP_TWICE:
            return _scaled(first, lambda part: 2 * part)
        case ca.OP_MUL | ca.OP_DIV:
            return _multiplied(first, second, code)
        case ca.OP_LT | ca.OP_LE | ca.OP_EQ | ca.OP_NE | ca.OP_NOT | ca.OP_AND | ca.OP_OR:
            return zero, one
        case ca.OP_SIGN:
            return _Form(ca.SX(0), ca.SX(-1)), zero, one
        case ca.OP_FLOOR | ca.OP_CEIL:
            return FLAT if _is_flat(first) else (_Form(ca.SX(0), ca.SX(0), ca.SX(1)),)
        case ca.OP_FMOD:
            return FLAT if _is_flat(first) else _on_lattice(first, _steady_value(second))
        case ca.OP_FMIN | ca.OP_FMAX:
            return _joined(first, second)
        case ca.OP_FABS:
            return _joined(first, _scaled(first, lambda part: -part))
        case ca.OP_IF_ELSE_ZERO:
            return _joined(second, (zero,))
    return FLAT if all(map(_is_flat, forms)) else None


def _is_flat(forms: Forms) -> bool:
    return forms is not None and all(form.slope.is_zero() for form in forms)


def _bounded(forms: Iterable[_Form], flat: bool) -> Forms:
    """Different pieces, if they are not too many; many constant ones are `FLAT`."""
    different = tuple({form.key: form for form in forms}.values())
    if len(different) <= MOST_FORMS:
        return different
    return FLAT if flat else None


def _joined(first: Forms, second: Forms) -> Forms:
    if first is None or second is None:
        return None
    flat = _is_flat(first) and _is_flat(second)
    if FLAT in (first, second):
        return FLAT if flat else None
    return _bounded((*first, *second), flat)


def _summed(first: Forms, second: Forms) -> Forms:
    if first is None or second is None:
        return None
    flat = _is_flat(first) and _is_flat(second)
    if FLAT in (first, second) or (flat and len(first) * len(second) > MOST_FORMS):
        return FLAT if flat else None
    if len(first) * len(second) > MOST_FORMS**2:
        return None
    forms = []
    for a, b in product(first, second):
        if a.lattice is not None and b.lattice is not None:
            if not flat:
                return None
            return FLAT
        lattice = b.lattice if a.lattice is None else a.lattice
        forms.append(_Form(a.slope + b.slope, a.offset + b.offset, lattice))
    return _bounded(forms, flat)


def _scaled(forms: Forms, scale: Callable[[ca.SX], ca.SX]) -> Forms:
    if forms is None:
        return None
    parts = ((form.slope, form.offset, form.lattice) for form in forms)
    return tuple(_Form(scale(a), scale(b), None if q is None else scale(q)) for a, b, q in parts)


def _multiplied(first: Forms, second: Forms, code: int) -> Forms:
    """A product or a quotient, one factor of which is piece by piece a known number."""
    if first is None or second is None:
        return None
    if _is_flat(first) and _is_flat(second) and FLAT in (first, second):
        return FLAT
    if code == ca.OP_MUL and not _are_numbers(second):
        first, second = second, first
    if not _are_numbers(second) or len(first) * len(second) > MOST_FORMS**2 or FLAT == first:
        return FLAT if _is_flat(first) and _is_flat(second) else None
    forms: list[_Form] = []
    for number in second:
        value = number.offset
        made = _scaled(first, (lambda part, v=value: part * v) if code == ca.OP_MUL else (lambda part, v=value: part / v))
        assert made is not None
        forms += made
    return _bounded(forms, _is_flat(first))


def _are_numbers(forms: Forms) -> bool:
    return bool(forms) and _is_flat(forms) and all(form.lattice is None for form in forms or ())


def _steady_value(forms: Forms) -> ca.SX | None:
    return forms[0].offset if forms and len(forms) == 1 and _are_numbers(forms) else None


def _on_lattice(forms: Forms, lattice: ca.SX | None) -> Forms:
    """The pieces and all multiples of a number beside them; what is constant has no lattice of its own."""
    if forms is None or _is_flat(forms):
        return forms
    if lattice is None or any(form.lattice is not None for form in forms if not form.slope.is_zero()):
        return None
    return tuple(_Form(form.slope, form.offset, lattice) for form in forms)
