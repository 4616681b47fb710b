"""Gains of a state observer for a wanted rate, for noise of a stated size, or for the least noise of a proved rate."""

from __future__ import annotations

from typing import Any

import numpy as np

from workbench.core import Dynamics
from workbench.design.matrices import Refused
from workbench.design.observer_gains.decay_certificate import RateCertificate, check
from workbench.design.observer_gains.gains import Gains, Region
from workbench.design.observer_gains.matrix_inequalities import least_noise, lyapunov_matrix, require_solvers
from workbench.design.observer_gains.mismatch import Mismatch
from workbench.design.riccati import lqe
from workbench.validation.refusals import Array, positive, require, vector, whole
from workbench.validation.signatures import door

# The least double pole is found to this factor, and sought up to so many times the rate.
FINE, FARTHEST = 1.05, 1000.0

MOST_JOINTS, MOST_GAIN = 1000, 1e100


@door
def by_poles(joints: int, first: float | complex, second: float | complex) -> Gains:
    """L1 = -(s1 + s2) I, L2 = s1 s2 I: where the model adds nothing, each joint has the poles s1 and s2, in 1/s.

    Raises
    ------
    ValueError
        If the poles do not decay, or are no pair of a real polynomial, or `joints` is no positive whole number.
    """
    identity = _identity("by_poles", joints)
    total, product = complex(first + second), complex(first * second)
    size = np.hypot(abs(first), abs(second))
    if not size < MOST_GAIN or abs(total.imag) > 1e-12 * size or abs(product.imag) > 1e-12 * size**2:
        raise ValueError(f"`by_poles(...)` needs two real poles or a conjugate pair; got {first} and {second}.")
    if max(complex(first).real, complex(second).real) >= 0:
        raise ValueError(f"`by_poles(...)` needs poles with a negative real part, in 1/s; got {first} and {second}.")
    return Gains(-total.real * identity, product.real * identity)


@door
def high_gain(joints: int, a1: float, a2: float, epsilon: float) -> Gains:
    """L1 = a1 / epsilon I, L2 = a2 / epsilon^2 I: the poles are the roots of s^2 + a1 s + a2 over epsilon, in s.

    All three are positive numbers.

    References
    ----------
    Khalil (2017), High-Gain Observers in Nonlinear Feedback Control, section 2.2.
    """
    for name, value, unit in (("a1", a1, ""), ("a2", a2, ""), ("epsilon", epsilon, " of seconds")):
        positive(f"high_gain({name}=...)", value, unit)
    identity = _identity("high_gain", joints)
    sizes = a1 / epsilon, a2 / epsilon / epsilon
    if not max(sizes) < MOST_GAIN:
        raise ValueError(f"`high_gain(a1, a2, epsilon)` must give gains below {MOST_GAIN:g}; got {sizes}.")
    return Gains(sizes[0] * identity, sizes[1] * identity)


def _identity(call: str, joints: Any) -> Array:
    return np.eye(whole(f"{call}(joints=...)", joints, most=MOST_JOINTS, of=" of joints"))


@door
def kalman(dynamics: Dynamics, q: Any, qd: Any, tau: Any, Qn: Any, Rn: Any) -> Gains:
    """The steady Kalman gain of the arm linearised at a state, for accelerations and measurements with white noise.

    Parameters
    ----------
    q, qd, tau
        (n,), the state and torque.
    Qn, Rn
        (n, n), the spectral densities of the accelerations that the model lacks, in (rad/s^2)^2 s, and of the noise of
        the positions, in rad^2 s.

    Raises
    ------
    ValueError
        If a vector or matrix is not of its shape, or Rn is not definite.
    """
    n = dynamics.dof
    state = [vector(f"kalman({name}=...)", x, n, "joints")[None] for name, x in (("q", q), ("qd", qd), ("tau", tau))]
    A = np.vstack([np.eye(n, 2 * n, n), Mismatch.of(dynamics).at(*state)[0]])
    L = lqe(A, np.eye(2 * n)[:, n:], np.eye(n, 2 * n), Qn, Rn).K
    return Gains(L[:n], L[n:])


@door
def by_lmi(dynamics: Dynamics, region: Region, rate: float) -> RateCertificate:
    """The gains with the least bound of noise of all that share one P for a rate in a region (extra `lmi`).

    Raises
    ------
    Refused
        If there are none, the proof fails, or the extra is not installed.
    """
    positive("by_lmi(rate=...)", rate, " of 1/s")
    mismatch = Mismatch.of(dynamics)
    gains, P = least_noise(mismatch, region, rate)
    return check(mismatch, gains, region, P, rate)


@door
def least_double_pole(dynamics: Dynamics, region: Region, rate: float) -> RateCertificate:
    """L1 = 2 p I, L2 = p^2 I with the least p, to some percent, that is certified a rate in a region (extra `lmi`).

    Raises
    ------
    Refused
        If no p up to a thousand times the rate is, or the extra is not installed.
    """
    require_solvers("least_double_pole")
    mismatch, low = Mismatch.of(dynamics), positive("least_double_pole(rate=...)", rate, " of 1/s")
    p = low
    while not _proposed(mismatch, region, rate, p):
        low, p = p, 2 * p
    while p > FINE * low:
        middle = float(np.sqrt(low * p))
        low, p = (low, middle) if _proposed(mismatch, region, rate, middle) else (middle, p)
    while True:
        gains = by_poles(mismatch.joints, -p, -p)
        try:
            return check(mismatch, gains, region, lyapunov_matrix(mismatch, gains, region, rate), rate)
        except Refused:
            p = _bounded(FINE * p, rate)


def _proposed(mismatch: Mismatch, region: Region, rate: float, p: float) -> bool:
    """True if a P is found for the double pole -p."""
    try:
        lyapunov_matrix(mismatch, by_poles(mismatch.joints, -_bounded(p, rate), -p), region, rate)
    except Refused:
        return False
    return True


def _bounded(p: float, rate: float) -> float:
    if p > FARTHEST * rate:
        raise ValueError(f"No double pole up to {FARTHEST:g} times the rate of {rate:g} 1/s is certified there.")
    return p


@door
def certify(dynamics: Dynamics, gains: Gains, region: Region, rate: float) -> RateCertificate:
    """A certificate that the error of given gains decays at a rate in a region; refusals are those of `by_lmi`."""
    require("certify(region=...)", region, Region)
    positive("certify(rate=...)", rate, " of 1/s")
    mismatch = Mismatch.of(dynamics)
    return check(mismatch, gains, region, lyapunov_matrix(mismatch, gains, region, rate), rate)
