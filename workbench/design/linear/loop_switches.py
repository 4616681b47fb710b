"""Switching functions within bounded loops: of each pass, at the values that this pass has.

A loop is passed once more, with its switching functions as a further row. One whose value a choice leaves out counts as
1, as no corner of it can be seen: `if_else(c, a, b)` needs a only where c holds.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import casadi as ca
import numpy as np

from workbench.core import Ode
from workbench.core.bounded_loop import LoopBody, called_loop, loop_function, operation_codes
from workbench.core.expressions import call_again
from workbench.core.notation.program import NAMES
from workbench.core.validation.refusals import Array

BENDS = {ca.OP_FABS, ca.OP_FMIN, ca.OP_FMAX}  # without a jump: what meets there with one slope has no corner
CORNERS = {ca.OP_FABS, ca.OP_FMIN, ca.OP_FMAX, ca.OP_SIGN, ca.OP_LT, ca.OP_LE, ca.OP_COPYSIGN}
LOOKS = 2  # directions, and their opposites, in which choices are looked at beside the point
Mask = np.ndarray[tuple[int, ...], np.dtype[np.bool_]]
STEEPEST = 1e8  # the largest slope at which a switching function is looked for near its zero


class OperationLine(NamedTuple):
    """An operation of an SX function: its code, the places of its operands and results, and the function it calls."""

    code: int
    operands: tuple[int, ...]
    results: tuple[int, ...]
    callee: ca.Function | None


@dataclass(frozen=True, eq=False)
class LoopSwitches:
    """The switching functions (m, 1) of all passes of the loops of an `Ode`, with their texts.

    `bends` (m,) marks those at which a value has two slopes, but no jump. `values` is sigma as a function (t, x, p).
    """

    ode: Ode
    texts: tuple[str, ...]
    bends: Mask
    sigma: ca.SX
    values: ca.Function

    @staticmethod
    def of(ode: Ode) -> LoopSwitches | None:
        """The switching functions of the loops of an equation; None where it has none."""
        symbols = [ode.t, ode.x, ode.p]
        both = ca.Function("both", symbols, [ca.vertcat(ode.rate, ode.output)], {"cse": True})
        if not CORNERS & set(operation_codes(both)[both.n_instructions() :]):
            return None
        _, held = _watch(both, lambda part, entry: symbols[part][entry], ca.SX(1), False)
        texts, bends, column = (
            tuple(f"{one.text} of a loop" for one in held),
            [one.bends for one in held],
            _column(held),
        )
        return LoopSwitches(ode, texts, np.array(bends), column, ca.Function("sigma", symbols, [column]))

    def near(self, points: Sequence[tuple[float, Array, Array]], reach: Array) -> list[int]:
        """The places of those that may be zero within a reach in x and u of the first of some points (t, x, p).

        The others lie beside it, where a choice may need what it leaves out at the first.
        """
        values = np.abs(np.column_stack([np.array(self.values(*point)) for point in points]))
        places = np.flatnonzero((values <= STEEPEST * reach.max()).any(axis=1))
        if not places.size:
            return []
        ode, z = self.ode, ca.vertcat(self.ode.x, self.ode.input_symbols)
        J = ca.Function("J", [ode.t, ode.x, ode.p], [ca.densify(ca.jacobian(self.sigma[places.tolist()], z))])
        sizes = np.column_stack([np.abs(np.array(J(*point))) @ reach for point in points])
        may = (values[places] <= 2 * sizes) & ((sizes > 0) | ~self.bends[places, np.newaxis])
        return [int(place) for place in places[may.any(axis=1)]]


class Switch(NamedTuple):
    """A switching function of a loop: its text, its value, and True if the operation bends without a jump."""

    text: str
    value: ca.SX
    bends: bool


def _column(switches: Sequence[Switch]) -> ca.SX:
    return ca.vertcat(*(one.value for one in switches))


@lru_cache(maxsize=64)
def _watched_loop(name: str, loop: LoopBody) -> tuple[ca.Function, tuple[Switch, ...]] | None:
    """A loop with its switching functions as a further row, and with a last shared number that says if it is needed.

    Beside it stand the switching functions of its passes; their values are those of the row, column by column.
    """
    body = loop.function
    if not CORNERS & set(operation_codes(body)):
        return None
    symbols, needed = body.sx_in(), ca.SX.sym("needed")
    flat = [ca.vertsplit(symbol) if symbol.numel() else [] for symbol in symbols]
    results, own = _watch(body, lambda part, entry: flat[part][entry], needed, True)
    shared = ca.vertcat(symbols[-1], needed)
    watched = ca.Function("watched", [*symbols[:-1], shared], [*results, _column(own)])
    passes = range(1, loop.count + 1)
    return (
        loop_function(watched, loop.count, loop.backward),
        tuple(one._replace(text=f"{one.text} in pass {i} of {loop.count}") for i in passes for one in own),
    )


def _watch(
    function: ca.Function, source: Callable[[int, int], ca.SX], needed: ca.SX, own: bool
) -> tuple[list[ca.SX], list[Switch]]:
    """The results of an SX function, and the switching functions of its loops.

    With `own` it is the body of a loop, whose operations are looked at, too.
    """
    lines, values, results, ends = _lines(function, source)
    needs = _needs(lines, values, ends)
    switches: list[Switch] = []
    for line in lines:
        guard = _both(needed, _any_of([needs[i] for i in line.results]))
        operands = [values[i] for i in line.operands]
        if own and line.code in CORNERS:
            alone = len(operands) == 1 or line.code == ca.OP_COPYSIGN
            value = _guarded(guard, operands[0] if alone else operands[0] - operands[1])
            switches.append(Switch(f"{NAMES[line.code].lower()}(...)", value, line.code in BENDS))
        loop = None if line.callee is None else called_loop(line.callee)
        watched = None if loop is None else _watched_loop(loop.name, loop)
        if watched is not None:
            of_passes = ca.vertsplit(ca.vec(_results(watched[0], [*operands, guard])[-1]))
            switches += [one._replace(value=value) for one, value in zip(watched[1], of_passes, strict=True)]
    return results, switches


def _lines(
    function: ca.Function, source: Callable[[int, int], ca.SX]
) -> tuple[list[OperationLine], list[ca.SX], list[ca.SX], set[int]]:
    """The operations of an SX function, each result with a place of its own, with all values, and the final ones."""
    lines, values, places = list[OperationLine](), list[ca.SX](), dict[int, int]()
    results = [ca.SX.zeros(function.numel_out(i)) for i in range(function.n_out())]
    ends = set[int]()
    for k in range(function.n_instructions()):
        code, callee = function.instruction_id(k), None
        reads, writes = function.instruction_input(k), function.instruction_output(k)
        if code == ca.OP_OUTPUT:
            ends.add(places[reads[0]])
            row = function.sparsity_out(writes[0]).row()[writes[1]]
            results[writes[0]][row] = values[places[reads[0]]]
            continue
        operands = () if code in (ca.OP_INPUT, ca.OP_CONST) else tuple(places[i] for i in reads if i >= 0)
        arguments = [values[i] for i in operands]
        if code == ca.OP_INPUT:
            made = [source(reads[0], reads[1])]
        elif code == ca.OP_CONST:
            made = [ca.SX(function.instruction_constant(k))]
        elif code == ca.OP_CALL:
            callee = function.instructions_sx()[k].which_function()
            made = call_again(callee, arguments)
        elif code == ca.OP_ASSIGN:
            made = arguments
        else:
            made = [ca.SX.unary(code, *arguments) if len(arguments) == 1 else ca.SX.binary(code, *arguments)]
        own = range(len(values), len(values) + len(made))
        values += made
        places |= {register: i for register, i in zip(writes, own, strict=True) if register >= 0}
        lines.append(OperationLine(code, operands, tuple(own), callee))
    return lines, values, results, ends


def _needs(lines: Sequence[OperationLine], values: Sequence[ca.SX], ends: set[int]) -> list[ca.SX]:
    """For each value a truth: that a result needs it at this point, as no choice leaves it out."""
    needs = [ca.SX(int(i in ends)) for i in range(len(values))]
    for line in reversed(lines):
        need = _any_of([needs[i] for i in line.results])
        for k, i in enumerate(line.operands):
            chosen = line.code == ca.OP_IF_ELSE_ZERO and k == 1
            own = _both(need, values[line.operands[0]] != 0) if chosen else need
            needs[i] = _any_of([needs[i], own])
    return needs


def _any_of(truths: Sequence[ca.SX]) -> ca.SX:
    every = [truth for truth in truths if not truth.is_zero()]
    if not every or any(truth.is_one() for truth in every):
        return ca.SX(int(bool(every)))
    total = every[0]
    for truth in every[1:]:
        total = total if truth.element_hash() == total.element_hash() else ca.logic_or(total, truth)
    return total


def _both(a: ca.SX, b: ca.SX) -> ca.SX:
    return b if a.is_one() else a if b.is_one() else ca.logic_and(a, b)


def _guarded(truth: ca.SX, value: ca.SX) -> ca.SX:
    return value if truth.is_one() else ca.if_else(truth, value, 1.0)


def _results(function: ca.Function, entries: Sequence[ca.SX]) -> list[ca.SX]:
    """The results of a function of dense arguments whose entries, one behind the other, are these."""
    sizes = [function.numel_in(i) for i in range(function.n_in())]
    ends = np.cumsum(sizes)
    columns = (ca.vertcat(ca.SX(0, 1), *entries[end - size : end]) for size, end in zip(sizes, ends, strict=True))
    return list(function.call([ca.reshape(c, *function.size_in(i)) for i, c in enumerate(columns)]))
