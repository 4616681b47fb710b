"""Fallbacks of predictive laws: the input and the plan of a period in which no good plan was made.

A period is bad if a number that the law reads is not finite, if its plan has a number that is not, or if the residual
of its plan passes the bound of the law. The law has a form for such periods:

    form            residual beyond its bound               a number read is not finite
    warm            the input of the plan; it goes on       the safe command; the plan waits
    safe_command    the safe command; the plan goes on      the safe command; the plan waits
    last_good       the next input of the last good plan;   the same; the plan moves on by a stage
                    the plan goes on
    cold            the LQR input within its limits; the    the safe command; the plan begins anew
                    plan begins anew

Behind the last input of a good plan comes the safe command. A plan with a number that is not finite begins anew.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import reduce
from types import MappingProxyType

import casadi as ca
import numpy as np

from workbench.core import Entry
from workbench.core.block import Vector
from workbench.core.bounded_loop import bounded_loop
from workbench.core.numbers import Bounds
from workbench.core.units import ANY

WARM, SAFE, LAST_GOOD, COLD = "warm", "safe_command", "last_good", "cold"
FORMS: Mapping[str, str] = MappingProxyType(
    {
        WARM: "the plan goes on, and waits where a number is not finite",
        SAFE: "the safe command",
        LAST_GOOD: "the next input of the last good plan, and the safe command behind its last one",
        COLD: "the LQR input, and a plan that begins anew",
    }
)
BAD, INPUTS = "bad_periods", "good_inputs"
LARGEST = 1e300
Parts = Mapping[str, ca.SX]


@dataclass(frozen=True)
class PeriodVerdict:
    """The verdict on a period: 1 if the numbers read are finite, if those of the plan are, and if all is good."""

    readable: ca.SX
    finite: ca.SX
    good: ca.SX


@dataclass(frozen=True)
class Fallback:
    """The fallback of a law: its form, the safe command and the bound of the residual; None without them.

    The safe command and all inputs are in the same coordinates.
    """

    form: str
    safe: ca.SX | None
    bound: ca.SX | None

    @staticmethod
    def of(form: str, safe: Vector | None, bound: Vector | None) -> Fallback:
        """The fallback of the numbers of a block, or of its twin with symbols."""
        return Fallback(form, None if safe is None else ca.SX(safe), None if bound is None else ca.SX(bound))

    def refuse_unfit(self, call: str) -> None:
        """Refuse a form without the safe command that it needs."""
        if self.form != WARM and self.safe is None:
            raise ValueError(
                f"`{call}(fallback={self.form!r})` must come with `safe_command`, the inputs where no plan is left; "
                "give a number for each input, by name."
            )

    @property
    def is_declared(self) -> bool:
        """True if the law has a safe command or a bound of its residual."""
        return self.safe is not None or self.bound is not None

    def memory(self, count: int, horizon: int) -> tuple[Entry, ...]:
        """The number of bad periods in a row, and the next inputs of the last good plan, less the safe command.

        A run in which a period is bad passes the bound of the first, which its warnings say.
        """
        if not self.is_declared:
            return ()
        inputs = (Entry(INPUTS, np.zeros(count * horizon), ANY),) if self.form == LAST_GOOD else ()
        return Entry(BAD, np.zeros(()), "1", Bounds(high=0.0)), *inputs

    def verdict(self, readable: ca.SX | None, finite: ca.SX, residual: ca.SX) -> PeriodVerdict:
        """The verdict on a period. Without a safe command a number that is not finite ends the run, and none is bad."""
        one = ca.SX(1.0)
        checks = (one, one) if readable is None or self.safe is None else (readable, finite)
        kept = one if self.bound is None else residual <= self.bound
        return PeriodVerdict(*checks, reduce(ca.logic_and, (*checks, kept)))

    def chosen_input(
        self, z: Parts, verdict: PeriodVerdict, own: ca.SX, lqr: ca.SX, clip: Callable[[ca.SX], ca.SX]
    ) -> ca.SX:
        """The input (nu, 1) of a period from that of its plan and from that of LQR; `clip` keeps the limits."""
        if self.safe is None:
            return own
        ready = ca.logic_and(verdict.readable, verdict.finite)
        if self.form == WARM:
            return ca.if_else(ready, own, self.safe)
        other = self.safe
        if self.form == LAST_GOOD:
            other = clip(self.safe + z[INPUTS][: own.numel()])
        if self.form == COLD:
            other = ca.if_else(ready, lqr, self.safe)
        return ca.if_else(verdict.good, own, other)

    def following(self, z: Parts, verdict: PeriodVerdict, plan: Parts, worth: Parts, inputs: ca.SX) -> dict[str, ca.SX]:
        """The memory after a period, from the parts (m, N) of its shifted plan, what it was worth, and its inputs.

        `inputs` (nu, N) has the inputs of the plan from the present one on.
        """
        if not self.is_declared:
            return {name: ca.vec(part) for name, part in {**plan, **worth}.items()}
        after = {name: ca.vec(self._next_plan(verdict, part, z[name])) for name, part in plan.items()}
        after |= {name: self._checked(verdict, part, z[name]) for name, part in worth.items()}
        after[BAD] = ca.if_else(verdict.good, 0.0, z[BAD] + 1)
        if self.form == LAST_GOOD:
            assert self.safe is not None
            last = ca.SX.zeros(inputs.shape[0])
            new = ca.horzcat(inputs[:, 1:] - ca.repmat(self.safe, 1, inputs.shape[1] - 1), last)
            old = ca.horzcat(ca.reshape(z[INPUTS], inputs.shape)[:, 1:], last)
            after[INPUTS] = ca.vec(_by_stage(_either, new, old, verdict.good))
        return after

    def _next_plan(self, verdict: PeriodVerdict, part: ca.SX, before: ca.SX) -> ca.SX:
        """A part (m, N) of the plan for the next period."""
        old = ca.reshape(before, part.shape)
        if self.form == LAST_GOOD:
            old = ca.horzcat(old[:, 1:], old[:, -1])

        def stage(new: ca.SX, old: ca.SX, readable: ca.SX, finite: ca.SX, good: ca.SX) -> ca.SX:
            if self.form == COLD:
                return ca.if_else(good, new, 0.0)
            return ca.if_else(readable, ca.if_else(finite, new, 0.0), old)

        return _by_stage(stage, part, old, verdict.readable, verdict.finite, verdict.good)

    def _checked(self, verdict: PeriodVerdict, part: ca.SX, before: ca.SX) -> ca.SX:
        return ca.if_else(verdict.readable, ca.if_else(verdict.finite, part, 0.0), before)


def finite_columns(columns: ca.SX) -> ca.SX:
    """1 if all numbers (m, N) are finite, else 0, by a loop over the columns."""

    def add(total: ca.SX, own: ca.SX) -> tuple[ca.SX, ...]:
        return (total + ca.sum1(ca.fabs(own)),)

    (total,) = bounded_loop(columns.shape[1], add, ca.SX(0.0), columns)
    return total <= LARGEST  # false for NaN, too


def _either(new: ca.SX, old: ca.SX, good: ca.SX) -> ca.SX:
    return ca.if_else(good, new, old)


def _by_stage(choose: Callable[..., ca.SX], new: ca.SX, old: ca.SX, *flags: ca.SX) -> ca.SX:
    """A choice between the columns of two matrices (m, N) by flags, as a loop over the stages."""

    def stage(none: ca.SX, *parts: ca.SX) -> tuple[ca.SX, ...]:
        return none, choose(*parts)

    return bounded_loop(new.shape[1], stage, ca.SX(0, 1), new, old, constants=flags)[1]
