"""Corners: where a rate has a kink or a jump in the state, as with a saturation or Coulomb friction."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import casadi as ca

from workbench.core.ode import Ode

MOST = 24  # corners of one rate; each is tested in every step
LEAST = 1 / 64  # of a step: the shortest segment that begins or ends at a corner
COMPARISON_CODES = {ca.OP_FMIN, ca.OP_FMAX, ca.OP_LT, ca.OP_LE}
ALONE = {ca.OP_SIGN, ca.OP_FABS}


@dataclass(frozen=True, eq=False)
class Corners:
    """The numbers g(t, x, p), (n, 1), at whose zeros the rate has a corner, and their slopes dg/dt along a run."""

    g: ca.SX
    slope: ca.SX
    t: ca.SX
    x: ca.SX

    def lies_between(self, begin: ca.SX, start: ca.SX, length: ca.SX, end: ca.SX) -> ca.SX:
        """True if a corner lies between the state `start` at `begin` and the state `end` at `begin` + `length` [s]."""
        at_begin, at_end = self._at(self.g, begin, start), self._at(self.g, begin + length, end)
        found = ca.SX(0)
        for a, b in zip(ca.vertsplit(at_begin), ca.vertsplit(at_end), strict=True):
            found = ca.logic_or(found, a * b < 0)
        return found

    def next(self, begin: ca.SX, s: ca.SX, length: ca.SX) -> ca.SX:
        """The offset [s] of the first corner after s that the slopes at s predict, or `length`; x is the state at s."""
        g, slope = (self._at(part, begin + s, self.x) for part in (self.g, self.slope))
        least, end = LEAST * length, length
        for value, rise in zip(ca.vertsplit(g), ca.vertsplit(slope), strict=True):
            ahead = -value / rise
            inside = ca.logic_and(ahead > least, s + ahead < length - least)
            end = ca.fmin(end, ca.if_else(inside, s + ahead, length))
        return end

    def _at(self, value: ca.SX, t: ca.SX, x: ca.SX) -> ca.SX:
        return ca.substitute(value, ca.vertcat(self.t, self.x), ca.vertcat(t, x))


@lru_cache(maxsize=64)
def corners_of(ode: Ode) -> Corners | None:
    """The corners of an equation; None if it has none, or too many."""
    symbols = [ode.t, ode.x, ode.p]
    function = ca.Function("rate", symbols, [ca.densify(ode.rate)])
    entries = zip(ca.vertsplit(ode.x), ca.vertsplit(ca.densify(ode.rate)), strict=True)
    moving = ca.vertcat(*[x for x, rate in entries if not rate.is_zero()])
    registers: dict[int, ca.SX] = {}
    found: dict[int, ca.SX] = {}
    for line in range(function.n_instructions()):
        code = function.instruction_id(line)
        reads, writes = function.instruction_input(line), function.instruction_output(line)
        if code == ca.OP_OUTPUT:
            continue
        if code == ca.OP_INPUT:
            registers[writes[0]] = symbols[reads[0]].nz[reads[1]]
        elif code == ca.OP_CONST:
            registers[writes[0]] = ca.SX(function.instruction_constant(line))
        elif code == ca.OP_CALL:
            return None
        else:
            operands = [registers[i] for i in reads]
            if code in COMPARISON_CODES or code in ALONE:
                passed = operands[0] - operands[1] if code in COMPARISON_CODES else operands[0]
                if ca.depends_on(passed, moving):
                    found.setdefault(passed.element_hash(), passed)
            registers[writes[0]] = _apply(code, operands)
    if not 0 < len(found) <= MOST:
        return None
    g = ca.vertcat(*found.values())
    return Corners(g, ca.jtimes(g, ode.x, ode.rate) + ca.jtimes(g, ode.t, ca.SX(1)), ode.t, ode.x)


def _apply(code: int, operands: list[ca.SX]) -> ca.SX:
    if code == ca.OP_ASSIGN:
        return operands[0]
    return ca.SX.binary(code, *operands) if len(operands) == 2 else ca.SX.unary(code, *operands)
