"""A one-channel loop L on the imaginary axis in exact polynomials of x = omega^2; the unit circle is mapped to it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from workbench.core.validation.refusals import refusal
from workbench.design.control_system import System
from workbench.design.frequency.certified_values import CertifiedValue, enclosure, root_of
from workbench.design.frequency.exact_systems import MOST_STATES
from workbench.design.frequency.integer_polynomials import (
    Polynomial,
    add,
    bilinear,
    mirror,
    multiply,
    primitive,
    quotient,
    scale,
    squared_modulus,
    trim,
)
from workbench.design.frequency.polynomial_ratios import lowest_terms
from workbench.design.frequency.positive_roots import Root
from workbench.design.frequency.rational_matrices import whole
from workbench.design.frequency.transfer_polynomials import TransferPolynomials
from workbench.design.linear.operating_point import state_space
from workbench.design.matrices import DesignError

if TYPE_CHECKING:
    import control

LONGEST_DELAY = 200  # periods


@dataclass(frozen=True)
class AxisLoop:
    """L = (P + j omega Q) / B exp(-j omega delay), |L|^2 = A / B; in z, omega stands for tan(omega period / 2).

    `closed_polynomial` is N + D before common factors are cancelled, `numerator` and `denominator` are N and D after.
    All are polynomials with whole coefficients, of s or v and of x = omega^2, lowest power first.
    """

    numerator: Polynomial
    denominator: Polynomial
    hidden_modes: Polynomial
    degree: int
    A: Polynomial
    B: Polynomial
    P: Polynomial
    Q: Polynomial
    period: float | None
    delay: Fraction

    @property
    def closed_polynomial(self) -> Polynomial:
        """The characteristic polynomial N + D of the closed loop without its delay, hidden modes included."""
        return trim(multiply(self.hidden_modes, add(self.numerator, self.denominator)))

    @property
    def top(self) -> CertifiedValue:
        """The frequency in rad/s at which x is infinite: infinity, or that of Nyquist."""
        return axis_frequency(None, self.period)

    def frequency(self, root: Root) -> CertifiedValue:
        """The frequency in rad/s that belongs to a value of x."""
        return axis_frequency(root, self.period)


def axis_frequency(root: Root | None, period: float | None) -> CertifiedValue:
    """The frequency in rad/s that belongs to a value of x, None for infinity; in z it is 2 atan(x^0.5) / h."""
    omega = CertifiedValue(math.inf, math.inf, math.inf) if root is None else root_of(root.low, root.high)
    if period is None:
        return omega
    first, last = (2 * math.atan(end) / period for end in (omega.low, omega.high))
    return enclosure(first, last, steps=3)


def axis_loop(call: str, loop: control.TransferFunction | control.StateSpace, delay: float) -> AxisLoop:
    """The polynomials of a loop with one channel, exactly those of its doubles.

    Raises
    ------
    ValueError
        If it has several channels, no finite numbers, more zeros than poles, or no denominator; if the delay is
        negative, or of a discrete loop no multiple of its period.
    DesignError
        If 1 + L is zero at infinity.
    """
    numerator, denominator = whole_coefficients(call, loop)
    if not denominator:
        raise ValueError(f"`{call}(loop=...)` must have a denominator that is not zero; got 0.")
    if len(numerator) > len(denominator):
        raise ValueError(
            f"`{call}(loop=...)` must be proper, so that it has an answer at infinity; its numerator has degree "
            f"{len(numerator) - 1}, its denominator {len(denominator) - 1}. Add the poles that the hardware has."
        )
    period = period_of(call, loop)
    late = exact_delay(call, delay, period)
    if period is not None:
        denominator, late = [0] * int(late) + denominator, Fraction(0)
    degree = len(denominator) - 1
    whole = trim(add(numerator, denominator))
    if len(whole) <= degree and not late:
        raise DesignError(
            f"`{call}(loop=...)` must be well-posed; here 1 + L is zero at infinity, so the feedback is an algebraic "
            "loop without a solution. Add a pole or a period of delay."
        )
    N, D = lowest_terms(numerator, denominator)
    hidden = quotient(primitive(denominator), primitive(D))
    if period is not None:
        N, D = (bilinear(p + [0] * (len(D) - len(p))) for p in (N, D))
        hidden = bilinear(hidden)
    return AxisLoop(trim(N), trim(D), trim(hidden), degree, *_moduli(trim(N), trim(D)), period, late)


def _moduli(N: Polynomial, D: Polynomial) -> tuple[Polynomial, Polynomial, Polynomial, Polynomial]:
    """A = |N|^2, B = |D|^2, and P, Q of N(j omega) D(-j omega) = P + j omega Q."""
    (n_even, n_odd), (d_even, d_odd) = ((mirror(p[0::2]), mirror(p[1::2])) for p in (N, D))
    P = add(multiply(n_even, d_even), [0, *multiply(n_odd, d_odd)])
    Q = add(multiply(n_odd, d_even), scale(multiply(n_even, d_odd), -1))
    return trim(squared_modulus(N)), trim(squared_modulus(D)), trim(P), trim(Q)


def whole_coefficients(call: str, loop: System, name: str = "loop") -> tuple[Polynomial, Polynomial]:
    """Numerator and denominator of a system with one channel as whole numbers; `name` is that of the argument."""
    import control

    if isinstance(loop, control.TransferFunction):
        if len(loop.den[0][0]) > MOST_STATES + 1:
            raise DesignError(
                f"`{call}({name}=...)` must have at most {MOST_STATES} poles as a `TransferFunction`, as doubles do "
                f"not hold the coefficients of more; got {len(loop.den[0][0]) - 1}. Give a `StateSpace`."
            )
        numerator, denominator = (np.asarray(p[0][0], dtype=float)[::-1] for p in (loop.num, loop.den))
        if not (np.isfinite(numerator).all() and np.isfinite(denominator).all()):
            raise ValueError(f"`{call}({name}=...)` must have finite numbers; got nan or an infinity.")
        numbers, _ = whole(np.concatenate([numerator, denominator]))
        return trim(numbers[: len(numerator)].tolist()), trim(numbers[len(numerator) :].tolist())
    transfer = TransferPolynomials.of(*state_space(call, loop), discrete=False)
    poles = scale(transfer.in_variable(transfer.denominator), transfer.constant)
    return trim(transfer.in_variable(transfer.numerators[0][0])), trim(poles)


CHANNEL_ADVICE = (
    "A margin is that of one channel while the loop is closed at the others: "
    "`workbench.design.linear.one_loop(loop, place)` closes them."
)
SAMPLED_ADVICE = (
    "The margins of a sampled loop gain of several channels need the loop that it is part of: ask "
    "`linear_loop(digital_loop).margins()`."
)


def refuse_odd_loop(call: str, loop: System, name: str = "loop", advice: str = "") -> None:
    """Refuse what is no linear system of python-control with one channel; by default one that is a loop gain."""
    import control

    if not isinstance(loop, control.StateSpace | control.TransferFunction):
        raise refusal(f"{call}({name}=...)", "a `StateSpace` or `TransferFunction` of python-control", loop)
    if loop.ninputs != 1 or loop.noutputs != 1:
        raise ValueError(
            f"`{call}({name}=...)` must have one channel; got {loop.noutputs} outputs and {loop.ninputs} inputs. "
            f"{advice or (SAMPLED_ADVICE if loop.dt else CHANNEL_ADVICE)}"
        )


def period_of(call: str, loop: System, name: str = "loop") -> float | None:
    """The period in s of a discrete loop, None for a continuous one."""
    if not loop.dt:
        return None
    if loop.dt is True:
        raise ValueError(f"`{call}({name}=...)` must have a period in s, or be continuous (dt = 0); got dt = True.")
    return float(loop.dt)


def exact_delay(call: str, delay: float, period: float | None) -> Fraction:
    """The delay in s, or in periods of a discrete loop."""
    if not (math.isfinite(delay) and delay >= 0):
        raise ValueError(f"`{call}(delay=...)` must be finite and not negative, as no loop foresees; got {delay:g} s.")
    if period is None or delay == 0:
        return Fraction(delay)
    count = round(delay / period)
    if abs(delay - count * period) > 1e-12 * delay or count > LONGEST_DELAY:
        raise ValueError(
            f"`{call}(delay=...)` of a discrete loop must be at most {LONGEST_DELAY} whole periods of {period:g} s; "
            f"got {delay:g} s. Discretise the plant with its delay."
        )
    return Fraction(count)
