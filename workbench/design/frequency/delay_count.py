"""Stability of a loop with a delay: the roots in the right half-plane, counted as the delay grows from zero.

References
----------
Walton and Marshall (1987), Direct method for TDS stability analysis, IEE Proceedings D 134(2).
"""

from __future__ import annotations

import math

from workbench.design.frequency.axis_loop import AxisLoop
from workbench.design.frequency.crossovers import UnitGain, unit_gains
from workbench.design.frequency.half_planes import is_hurwitz, unstable_roots
from workbench.design.frequency.integer_polynomials import add, trim
from workbench.design.frequency.rational_peaks import ZERO
from workbench.design.matrices import DesignError

TURN = 2 * math.pi


def is_stable(loop: AxisLoop) -> bool:
    """True if all roots of the closed loop, hidden modes included, lie on the left and stay away from the axis.

    Raises
    ------
    DesignError
        If a root is so near to the axis that doubles do not tell its side, or touches it without a delay.
    """
    if not loop.delay:
        return len(loop.closed_polynomial) == loop.degree + 1 and is_hurwitz(loop.closed_polynomial)
    if not is_hurwitz(loop.hidden_modes) or (len(loop.A) == len(loop.B) and abs(loop.A[-1]) >= loop.B[-1]):
        return False  # |L| >= 1 at infinity: a chain of roots at or beyond the axis
    without = trim(add(loop.numerator, loop.denominator))
    if without[0] == 0:  # a root at s = 0, for any delay
        return False
    count = unstable_roots(without)[0]
    for gain in unit_gains(loop):
        if gain.place is not ZERO:
            count += _change(loop, gain)
    return count == 0


def _change(loop: AxisLoop, gain: UnitGain) -> int:
    """The change of the number of roots on the right, as the delay grows to its value, by one pair at one frequency."""
    lag = gain.phase.value % TURN
    turned = gain.frequency.value * float(loop.delay)
    doubt = 4e-15 * (turned + TURN) + (gain.frequency.high - gain.frequency.low) * float(loop.delay)
    on_axis = gain.phase.low <= 0 <= gain.phase.high  # a root of the loop without its delay
    if on_axis and gain.direction == 0:
        raise DesignError(
            f"A loop whose roots only touch the axis at {gain.frequency.value:.6g} rad/s without a delay cannot be "
            "counted with one. Change a coefficient in its last digits, and look on both sides."
        )
    crossings = (turned - (0.0 if on_axis else lag)) / TURN
    if abs(crossings - round(crossings)) * TURN < doubt and not (on_axis and round(crossings) == 0):
        raise DesignError(
            f"A closed loop must have no root on the axis to be judged; at {gain.frequency.value:.6g} rad/s one is so "
            "near that doubles do not tell its side. Change the gain or the delay in its last digits."
        )
    if on_axis:  # it leaves the axis to the right, where it was not counted, or to the left
        later = math.floor(crossings)
        return 2 * gain.direction * later + (2 if gain.direction > 0 else 0)
    return 2 * gain.direction * max(math.floor(crossings) + 1, 0)
