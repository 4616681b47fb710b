"""`c2d`: a design in continuous time as one in discrete time, by four methods."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from workbench.core.validation.number_types import Numbers
from workbench.core.validation.refusals import Array, finite, one_of, refusal, seconds
from workbench.core.validation.signatures import check_arguments
from workbench.design.control_system import System
from workbench.design.frequency.exponentials import held_map
from workbench.design.frequency.matched_roots import matched_polynomials, matched_space
from workbench.design.linear.operating_point import state_space
from workbench.design.matrices import DesignError

if TYPE_CHECKING:
    import control

METHODS = ("zoh", "tustin", "prewarped", "matched")
NEAR = 1e-10  # of 2 / h: a pole that near maps beyond z = 1e10
Polynomials = tuple[Array, Array]


@check_arguments
def c2d(
    system: System, period: float, method: str = "zoh", frequency: float | None = None
) -> control.InputOutputSystem:
    """A system sampled at a period h, with the same names and about the same operating point:

        zoh        what the samples of the output do behind a zero-order hold, exactly,
        tustin     s = (2 / h) (z - 1) / (z + 1), the trapezoidal rule,
        prewarped  s = w / tan(w h / 2) (z - 1) / (z + 1), which is exact at the frequency w,
        matched    each pole and zero by z = e^(s h), zeros at infinity but one by z = -1, the gain that of s = 0.

    If poles or zeros lie at s = 0, `matched` compares the gains without them. For a `StateSpace` it keeps the states
    and how the outputs depend on them, and changes the effect of the input.

    Parameters
    ----------
    system
        A `StateSpace` or `TransferFunction` in continuous time; for `matched` from one input to one output.
    period
        The period h in s.
    method
        "zoh", "tustin", "prewarped" or "matched", as above.
    frequency
        The frequency w in rad/s, between 0 and Nyquist's pi / h, for `prewarped` alone.

    Raises
    ------
    ValueError
        If an argument is not as above, or a transfer function is improper.
    DesignError
        If the method has no answer. `tustin` maps a pole at s = 2 / h to infinity, and `prewarped` a pole at
        s = w / tan(w h / 2). `matched` needs an observable system without a pole at a multiple of the sampling
        frequency.

    References
    ----------
    Franklin, Powell and Workman (1998), Digital Control of Dynamic Systems, sections 4.3 and 6.1 to 6.3 (`matched` is
    the modified method there).

    Examples
    --------
    >>> motor = wb.linearize(wb.open_loop(wb.DCMotor()), 0.0, [0.0, 0.0])
    >>> wb.c2d(motor, 0.01).dt
    0.01
    """
    import control

    h = seconds("c2d(period=...)", period)
    rule = one_of("c2d(method=...)", method, METHODS)
    if not isinstance(system, control.StateSpace | control.TransferFunction):
        raise refusal("c2d(system=...)", "a `StateSpace` or `TransferFunction` of python-control", system)
    if system.isdtime(strict=True):
        raise ValueError(f"`c2d(system=...)` must be in continuous time; '{system.name}' has dt = {system.dt}.")
    alpha = _alpha(rule, h, frequency)
    if isinstance(system, control.StateSpace):
        return _state_space(system, h, rule, alpha)
    return _transfer_function(system, h, rule, alpha)


def _alpha(rule: str, h: float, frequency: float | None) -> float:
    """The factor of (z - 1) / (z + 1) in 1/s."""
    if (frequency is not None) != (rule == "prewarped"):
        raise ValueError(
            f"`c2d(frequency=...)` must be given for the method 'prewarped', and for no other; got {frequency!r} for "
            f"'{rule}'."
        )
    if frequency is None:
        return 2 / h
    w = finite("c2d(frequency=...)", frequency, " of rad/s")
    if not 0 < w < math.pi / h:
        raise ValueError(
            f"`c2d(frequency=...)` must lie between 0 and Nyquist's frequency, {math.pi / h:.6g} rad/s at this period; "
            f"got {w:g} rad/s."
        )
    return w / math.tan(w * h / 2)


def _state_space(system: control.StateSpace, h: float, rule: str, alpha: float) -> control.StateSpace:
    import control

    from workbench.design.linear.pointed_systems import PointedSpace, point_of

    A, B, Cy, D = state_space("c2d", system)
    if rule == "matched":
        _refuse_channels(system)
        matrices = matched_space(system, h)
    elif rule == "zoh":
        E, G = held_map(A, B, h)
        matrices = (np.eye(len(A)) + E, G, Cy, D)
    else:
        _refuse_pole(np.linalg.eigvals(A), alpha)
        inverse = np.linalg.inv(np.eye(len(A)) - A / alpha)
        Bd = inverse @ B * (2 / alpha)
        matrices = (inverse @ (np.eye(len(A)) + A / alpha), Bd, Cy @ inverse, D + Cy @ Bd / 2)
    names = {"states": system.state_labels, "inputs": system.input_labels, "outputs": system.output_labels}
    sampled = control.ss(*matrices, h, name=f"{system.name}$sampled", **names)
    point = point_of(system)
    return sampled if point is None else PointedSpace(sampled, point)


def _transfer_function(system: control.TransferFunction, h: float, rule: str, alpha: float) -> control.TransferFunction:
    import control

    from workbench.design.linear.pointed_systems import PointedTransfer, point_of

    if rule == "matched":
        _refuse_channels(system)
    change: Callable[[Array, Array], Polynomials] = {
        "zoh": lambda num, den: _zero_order_hold(num, den, h),
        "matched": lambda num, den: matched_polynomials(num, den, h),
    }.get(rule, lambda num, den: _bilinear(num, den, alpha))
    entries = [
        [change(*_proper(system.name, num, den)) for num, den in zip(*rows, strict=True)]
        for rows in zip(system.num_list, system.den_list, strict=True)
    ]
    if not all(np.isfinite(p).all() for row in entries for entry in row for p in entry):
        raise DesignError(
            f"`c2d(...)`: '{system.name}' grows beyond the range of floating-point numbers within a period of {h:g} s; "
            "take a shorter one."
        )
    nums, dens = ([[entry[k] for entry in row] for row in entries] for k in (0, 1))
    names = {"inputs": system.input_labels, "outputs": system.output_labels, "name": f"{system.name}$sampled"}
    sampled = control.tf(nums, dens, h, **names)
    point = point_of(system)
    return sampled if point is None else PointedTransfer(sampled, point)


def _refuse_channels(system: control.StateSpace | control.TransferFunction) -> None:
    """Refuse for `matched` a system with several inputs or outputs."""
    if not system.issiso():
        raise ValueError(
            f"`c2d(method='matched')` maps the poles and zeros from one input to one output; '{system.name}' has "
            f"{system.ninputs} inputs and {system.noutputs} outputs: take 'zoh' or 'tustin', or one entry at a time."
        )


def _proper(name: str, num: Numbers, den: Numbers) -> Polynomials:
    """Numerator and denominator, the latter monic, without leading zeros; an improper one is refused."""
    num, den = (np.trim_zeros(np.asarray(p, dtype=float), "f") for p in (num, den))
    if not np.isfinite(num).all() or not np.isfinite(den).all():
        raise ValueError(f"`c2d(system=...)` must have finite coefficients; '{name}' has not.")
    if len(num) > len(den):
        raise ValueError(
            f"`c2d(system=...)` must be proper; '{name}' has a numerator of degree {len(num) - 1} over a denominator "
            f"of degree {len(den) - 1}: add the poles that its differentiation has in truth."
        )
    return (num if len(num) else np.zeros(1)) / den[0], den / den[0]


def _zero_order_hold(num: Array, den: Array, h: float) -> Polynomials:
    """The transfer function behind a hold, through the companion form of the continuous one."""
    n = len(den) - 1
    padded = np.concatenate([np.zeros(n + 1 - len(num)), num])
    A, B = np.eye(n, k=-1), np.eye(n, 1)
    A[:1] = -den[1:]
    Cy = (padded[1:] - padded[0] * den[1:])[np.newaxis]
    E, G = held_map(A, B, h)
    Phi = np.eye(n) + E
    poles = np.poly(Phi) if n else np.ones(1)
    top = (np.poly(Phi - G @ Cy) if n else np.ones(1)) + (padded[0] - 1) * poles
    return np.asarray(top.real), np.asarray(poles.real)


def _bilinear(num: Array, den: Array, alpha: float) -> Polynomials:
    """Both polynomials at s = alpha (z - 1) / (z + 1), times (z + 1)^n."""
    n = len(den) - 1
    _refuse_pole(np.roots(den), alpha)

    def map_polynomial(polynomial: Array) -> Array:
        total = np.zeros(n + 1)
        for power, coefficient in enumerate(polynomial[::-1]):
            factors = np.concatenate([np.ones(power), -np.ones(n - power)])
            total += coefficient * alpha**power * np.poly(factors)
        return total

    below = map_polynomial(den)
    return map_polynomial(num) / below[0], below / below[0]


def _refuse_pole(poles: NDArray[np.number], alpha: float) -> None:
    """Refuse a pole at alpha, which s = alpha (z - 1) / (z + 1) maps to infinity."""
    if len(poles) and np.abs(poles - alpha).min() <= NEAR * alpha:
        raise DesignError(
            f"`c2d(...)` by Tustin's rule maps s = {alpha:.6g} 1/s to infinity, and the system has a pole there; take "
            "another period, or 'zoh'."
        )
