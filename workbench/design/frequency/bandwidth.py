"""Bandwidths: all frequencies at which a gain crosses a level, as isolated roots of a polynomial."""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Context, Decimal
from fractions import Fraction
from typing import TYPE_CHECKING

from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import positive
from workbench.core.validation.signatures import check_arguments
from workbench.design.frequency.axis_loop import axis_frequency
from workbench.design.frequency.certified_values import INFINITE, ZERO, CertifiedValue, root_of
from workbench.design.frequency.integer_polynomials import add, scale, squared_modulus, trim
from workbench.design.frequency.positive_roots import Root, positive_roots
from workbench.design.frequency.stable_ratios import StableRatio, stable_ratio
from workbench.design.matrices import DesignError

if TYPE_CHECKING:
    import control

DROP = 3.0  # dB
DIGITS = 120  # of the level, which is no fraction
LARGEST_DROP = 1000.0  # dB
NO_STATE = "its answers to sines do not settle, and it has no bandwidth"


@dataclass(frozen=True)
@show
class LevelCrossing:
    """A `frequency` in rad/s at which a gain falls below a level, if `is_falling`, or else rises above it."""

    frequency: CertifiedValue
    is_falling: bool


@dataclass(frozen=True)
@show
class Bandwidth:
    """The `frequency` in rad/s up to which a system follows, and all `crossings` of the `level` that decides it.

    `frequency` is infinite if the gain does not reach the level, in a discrete system up to Nyquist's frequency.
    """

    frequency: CertifiedValue
    level: CertifiedValue
    crossings: tuple[LevelCrossing, ...]


@check_arguments
def bandwidth(system: control.TransferFunction | control.StateSpace, drop: float = DROP) -> Bandwidth:
    """The bandwidth of a stable system: the first frequency at which its gain falls below its gain at zero by `drop`.

    python-control and MATLAB define it in the same way. A gain that rises again and falls again has further
    `crossings`; all of them are found, however narrow a notch or a resonance is.

    Parameters
    ----------
    system
        A stable `TransferFunction` or `StateSpace` with one input and one output, continuous or discrete.
    drop
        The fall of the gain in dB, above 0 and up to 1000.

    Raises
    ------
    ValueError
        If `system` is not a linear system with one input and one output, has more zeros than poles, or has numbers that
        are not finite; or if `drop` is out of its range.
    DesignError
        If the system is not stable, has an integrator, a gain of zero at the frequency zero, or more than 40 states.

    Examples
    --------
    >>> import control
    >>> wb.bandwidth(control.tf([1], [1, 1.4, 1])).frequency.value
    1.0088750172497358
    """
    low, high = _shares(positive("bandwidth(drop=...)", drop, " of dB"))
    ratio = stable_ratio("bandwidth", system, NO_STATE)
    if ratio.final == 0:
        raise DesignError(
            f"`bandwidth(system)` is where the gain has fallen from that at the frequency zero, and '{system.name}' "
            "passes nothing there; take `hinf_norm` for its peak, or the system whose output shall follow."
        )
    return _bandwidth(ratio, low * ratio.final**2, high * ratio.final**2, is_falling=True)


def sensitivity_bandwidth(system: control.TransferFunction | control.StateSpace, drop: float = DROP) -> Bandwidth:
    """The first frequency in rad/s at which a sensitivity S rises above -`drop` dB; feedback is of use up to it.

    It is zero if |S| is above this level at the frequency zero already. Refusals are those of `bandwidth`.

    References
    ----------
    Skogestad and Postlethwaite (2005), Multivariable Feedback Control, 2nd edition, section 2.4.5.

    Examples
    --------
    >>> import control
    >>> from workbench.design.frequency import sensitivity_bandwidth
    >>> sensitivity_bandwidth(control.ss([[0.0, 1.0], [-2.0, -0.3]], [[0.0], [1.0]], [[1.0, 0.0]], 0.0), 3.0)
    Bandwidth(frequency=CertifiedValue(...), level=CertifiedValue(...), ...)
    """
    ratio = stable_ratio("sensitivity_bandwidth", system, NO_STATE)
    low, high = _shares(positive("sensitivity_bandwidth(drop=...)", drop, " of dB"))
    return _bandwidth(ratio, low, high, is_falling=False)


def _shares(drop: float) -> tuple[Fraction, Fraction]:
    """Bounds of 10^(-drop / 10)."""
    if drop > LARGEST_DROP:
        raise ValueError(f"`bandwidth(drop=...)` must be at most {LARGEST_DROP:g} dB; got {drop:g} dB.")
    power = Fraction(Context(prec=DIGITS).power(Decimal(10), Context(prec=DIGITS).divide(Decimal(-drop), Decimal(10))))
    doubt = power / 10 ** (DIGITS - 5)  # of the exponent, which is rounded to as many digits, and of the power
    return power - doubt, power + doubt


def _bandwidth(ratio: StableRatio, low: Fraction, high: Fraction, is_falling: bool) -> Bandwidth:
    """The crossings of a level whose square lies between two fractions, and the first one of a direction."""
    crossings = _crossings(ratio, low, high)
    level = root_of(low, high)
    if not is_falling and ratio.final**2 >= low:
        return Bandwidth(ZERO, level, crossings)
    first = next((row.frequency for row in crossings if row.is_falling == is_falling), INFINITE)
    return Bandwidth(first, level, crossings)


def _crossings(ratio: StableRatio, low: Fraction, high: Fraction) -> tuple[LevelCrossing, ...]:
    """All frequencies at which |G|^2 crosses a level between two fractions that agree in a hundred digits."""
    N, D = ratio.on_axis()
    A, B = squared_modulus(N), squared_modulus(D)
    excess = [trim(add(scale(A, c.denominator), scale(B, -c.numerator))) for c in (low, high)]
    roots = [positive_roots(p) for p in excess]
    pairs = list(zip(*roots, strict=False))
    touched = any(root.multiplicity > 1 for pair in pairs for root in pair)
    if touched or len(roots[0]) != len(roots[1]):
        raise DesignError(
            "`bandwidth(system)`: the gain touches the level within a hundred digits, so that no arithmetic tells "
            "whether it crosses; choose another `drop`."
        )
    above, found = ratio.final**2 > high, []
    for pair in pairs:
        both = Root(min(root.low for root in pair), max(root.high for root in pair))
        found.append(LevelCrossing(axis_frequency(both, ratio.period), above))
        above = not above
    return tuple(found)
