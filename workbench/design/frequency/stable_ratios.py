"""A stable system with one channel as a ratio of polynomials with whole coefficients, exactly that of its doubles."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from workbench.design.control_system import System
from workbench.design.frequency.axis_loop import period_of, refuse_odd_loop, whole_coefficients
from workbench.design.frequency.exact_systems import MOST_STATES
from workbench.design.frequency.half_planes import is_hurwitz
from workbench.design.frequency.integer_polynomials import Polynomial, bilinear
from workbench.design.frequency.polynomial_ratios import lowest_terms
from workbench.design.matrices import DesignError, pole_text

if TYPE_CHECKING:
    import control

ONE_CHANNEL = "Take one output and one input, as `system[0, 0]`."


@dataclass(frozen=True)
class StableRatio:
    """G = numerator / denominator in lowest terms, polynomials of s, or of z with a `period` in s, lowest power first.

    All poles, those that cancel included, lie inside the region of stability: this is decided exactly.
    """

    numerator: Polynomial
    denominator: Polynomial
    period: float | None

    @property
    def final(self) -> Fraction:
        """The gain at s = 0 or z = 1, to which the step response tends."""
        if self.period is None:
            return Fraction(self.numerator[0] if self.numerator else 0, self.denominator[0])
        return Fraction(sum(self.numerator), sum(self.denominator))

    def on_axis(self) -> tuple[Polynomial, Polynomial]:
        """Numerator and denominator as polynomials of s, or of v with z = (1 + v) / (1 - v)."""
        if self.period is None:
            return self.numerator, self.denominator
        padded = self.numerator + [0] * (len(self.denominator) - len(self.numerator))
        return bilinear(padded), bilinear(self.denominator)


def stable_ratio(call: str, system: System, purpose: str) -> StableRatio:
    """The ratio of a system of python-control; `purpose` says what an unstable one lacks.

    Raises
    ------
    ValueError
        If it is no system with one channel, has more zeros than poles, no denominator, or numbers that are not finite.
    DesignError
        If it is not stable, hidden modes included, or has more than 40 states.
    """
    refuse_odd_loop(call, system, "system", ONE_CHANNEL)
    if system.nstates and system.nstates > MOST_STATES:
        raise DesignError(
            f"`{call}(system)` works in exact arithmetic, which takes seconds for {MOST_STATES} states and minutes for "
            f"more; '{system.name}' has {system.nstates}. Reduce its order first: `wb.reduction` takes up to 60 "
            "states, `control.balred` with Slycot more."
        )
    period = period_of(call, system, "system")
    numerator, denominator = whole_coefficients(call, system, "system")
    if not denominator:
        raise ValueError(f"`{call}(system=...)` must have a denominator that is not zero; got 0.")
    if len(numerator) > len(denominator):
        raise ValueError(
            f"`{call}(system=...)` must be proper; the numerator of '{system.name}' has degree {len(numerator) - 1}, "
            f"its denominator {len(denominator) - 1}. Add the poles that its differentiation has in truth."
        )
    on_axis = denominator if period is None else bilinear(denominator)
    if not is_hurwitz(on_axis):
        raise DesignError(_not_stable(call, system, period, denominator, purpose))
    return StableRatio(*lowest_terms(numerator, denominator), period)


def _not_stable(
    call: str,
    system: control.StateSpace | control.TransferFunction,
    period: float | None,
    denominator: Polynomial,
    purpose: str,
) -> str:
    """The sentence that names an integrator, or the pole that is nearest to instability or beyond."""
    integrates = denominator[0] == 0 if period is None else sum(denominator) == 0
    poles = np.asarray(system.poles(), dtype=complex)
    worst = complex(poles[(poles.real if period is None else np.abs(poles)).argmax()])
    beyond = worst.real > 1e-6 * abs(worst) if period is None else abs(worst) > 1 + 1e-6
    if integrates and not beyond:
        where, advice = ("s = 0" if period is None else "z = 1"), "Close a loop around it first"
        return f"`{call}(system)`: '{system.name}' has an integrator, a pole at {where}, and so {purpose}. {advice}."
    region = "left of the imaginary axis" if period is None else "inside the unit circle"
    return (
        f"`{call}(system)`: '{system.name}' is not stable, as its pole near {pole_text(worst)} does not lie {region}, "
        f"and so {purpose}. Stabilise it first; a pole that cancels counts, too."
    )
