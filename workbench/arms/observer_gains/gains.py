"""The gains L1, L2 of a state observer of Luenberger's structure, and the region where arm and estimate may be."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.core.validation.refusals import Array, describe, finite, positive, whole
from workbench.core.validation.signatures import check_arguments
from workbench.design.matrices import square

MOST_SHARE = 1e6  # of speeds and torques
MOST_JOINTS, MOST_GAIN = 1000, 1e100


@dataclass(frozen=True, eq=False)
@check_arguments
class Gains:
    """L1 (n, n) in 1/s and L2 (n, n) in 1/s^2 of

        q_hat'  = qd_hat + L1 (q - q_hat)
        qd_hat' = f(q_hat, qd_hat, tau) + L2 (q - q_hat),    f = M^-1 (tau - C qd - G).

    All eigenvalues of [[-L1, I], [-L2, 0]] must have a negative real part: the error decays where the model adds
    nothing.

    Raises
    ------
    ValueError
        If L1 or L2 is not square and finite, they differ in size, or have the wrong sign.
    """

    L1: Array
    L2: Array

    def __post_init__(self) -> None:
        L1, L2 = (square("Gains(L1, L2)", name, getattr(self, name)) for name in ("L1", "L2"))
        if L1.shape != L2.shape:
            raise ValueError(f"`Gains(L1, L2)` must be of one size, a row a joint; got {L1.shape} and {L2.shape}.")
        for name, L in (("L1", L1), ("L2", L2)):
            L.flags.writeable = False
            object.__setattr__(self, name, L)
        slowest = max(np.linalg.eigvals(self.error_matrix()), key=lambda s: float(s.real))
        if slowest.real >= 0:
            raise ValueError(
                "`Gains(L1, L2)` must have the sign that lets the error decay where the model adds nothing to it, as "
                f"positive definite ones do; with these [[-L1, I], [-L2, 0]] has the eigenvalue {slowest:.4g} 1/s."
            )

    @property
    def joints(self) -> int:
        """The number of joints n."""
        return len(self.L1)

    @property
    def L(self) -> Array:
        """L = [L1; L2], (2n, n)."""
        return np.vstack([self.L1, self.L2])

    @check_arguments
    def error_matrix(self, J: Array | None = None) -> Array:
        """A = [[-L1, I], [-L2, 0] + J], (..., 2n, 2n), with J = [df/dq, df/dqd], (..., n, 2n), or none."""
        n = self.joints
        if J is not None and J.shape[-2:] != (n, 2 * n):
            raise ValueError(f"`error_matrix(J=...)` must have shape (..., {n}, {2 * n}); got {J.shape}.")
        lower = np.hstack([-self.L2, np.zeros((n, n))])
        lower = lower if J is None else lower + J
        upper = np.broadcast_to(np.hstack([-self.L1, np.eye(n)]), lower.shape)
        return np.concatenate([upper, lower], axis=-2)


@dataclass(frozen=True, eq=False)
@check_arguments
class Region:
    """low <= q <= high, |qd| <= speed, |tau| <= torque, joint by joint; any position where `low` and `high` are None.

    The speed, in rad/s, is that of the arm and of its estimate, the torque in N m, the positions in rad, (n,) each.

    Raises
    ------
    ValueError
        If they are no vectors of one length, a number is not finite or negative, or a box is none.
    """

    speed: Array
    torque: Array
    low: Array | None = None
    high: Array | None = None

    def __post_init__(self) -> None:
        given = {name: getattr(self, name) for name in ("speed", "torque", "low", "high")}
        if (given["low"] is None) != (given["high"] is None):
            raise ValueError("`Region(low=..., high=...)` must give both sides of the box of positions, or none.")
        for name, value in given.items():
            if value is not None:
                object.__setattr__(self, name, _vector(name, value, np.size(self.speed)))
        for name in ("speed", "torque"):
            if (getattr(self, name) < 0).any():
                size = describe(getattr(self, name).tolist())
                raise ValueError(f"`Region({name}=...)` bounds a size, so it must not be negative; got {size}.")
        if self.low is not None and self.high is not None and not (self.low < self.high).all():
            low, high = (describe(end.tolist()) for end in (self.low, self.high))
            raise ValueError(f"`Region(low=..., high=...)` must be a box, low < high; got {low} and {high}.")

    @property
    def joints(self) -> int:
        """The number of joints n."""
        return len(self.speed)

    @property
    def box(self) -> tuple[Array, Array]:
        """Both sides of the positions, (n,) each; a whole turn for any position."""
        if self.low is None or self.high is None:
            return np.full(self.joints, -np.pi), np.full(self.joints, np.pi)
        return self.low, self.high

    @check_arguments
    def scale(self, share: float) -> Region:
        """The region with its speeds and torques times a share, and its positions as they are."""
        share = finite("scaled(share=...)", share, low=0, high=MOST_SHARE)
        return Region(share * self.speed, share * self.torque, self.low, self.high)


def _vector(name: str, values: Array, size: int) -> Array:
    value = values.copy()
    if value.shape != (size,) or not size or not np.isfinite(value).all():
        must = "one finite number a joint, as `speed` does"
        raise ValueError(f"`Region({name}=...)` must hold {must}; got {describe(value.tolist())}.")
    value.flags.writeable = False
    return value


@check_arguments
def by_poles(joints: int, first: float | complex, second: float | complex) -> Gains:
    """L1 = -(s1 + s2) I, L2 = s1 s2 I: where the model adds nothing, each joint has the poles s1 and s2, in 1/s.

    Raises
    ------
    ValueError
        If the poles do not decay, or are no pair of a real polynomial, or `joints` is no positive whole number.

    Examples
    --------
    >>> from workbench.arms.observer_gains import by_poles
    >>> by_poles(2, -40.0, -40.0).L2
    array([[1600.,    0.],
           [   0., 1600.]])
    """
    identity = _identity("by_poles", joints)
    total, product = complex(first + second), complex(first * second)
    size = np.hypot(abs(first), abs(second))
    if not size < MOST_GAIN or abs(total.imag) > 1e-12 * size or abs(product.imag) > 1e-12 * size**2:
        raise ValueError(f"`by_poles(...)` needs two real poles or a conjugate pair; got {first} and {second}.")
    if max(complex(first).real, complex(second).real) >= 0:
        raise ValueError(f"`by_poles(...)` needs poles with a negative real part, in 1/s; got {first} and {second}.")
    return Gains(-total.real * identity, product.real * identity)


@check_arguments
def high_gain(joints: int, a1: float, a2: float, epsilon: float) -> Gains:
    """L1 = a1 / epsilon I, L2 = a2 / epsilon^2 I: the poles are the roots of s^2 + a1 s + a2 over epsilon, in s.

    All three are positive numbers.

    References
    ----------
    Khalil (2017), High-Gain Observers in Nonlinear Feedback Control, section 2.2.

    Examples
    --------
    >>> from workbench.arms.dynamics import Dynamics
    >>> from workbench.arms.observer_gains import high_gain, kalman
    >>> arm = Dynamics.of(wb.robot("planar-1r"))
    >>> kalman(arm, [0.1], [0.0], [0.0], np.eye(1), np.eye(1)).L1.round(3)
    array([[0.261]])
    >>> high_gain(2, 2.0, 1.0, 0.1).L1
    array([[20.,  0.],
           [ 0., 20.]])
    """
    for name, value, unit in (("a1", a1, ""), ("a2", a2, ""), ("epsilon", epsilon, " of seconds")):
        positive(f"high_gain({name}=...)", value, unit)
    identity = _identity("high_gain", joints)
    sizes = a1 / epsilon, a2 / epsilon / epsilon
    if not max(sizes) < MOST_GAIN:
        raise ValueError(f"`high_gain(a1, a2, epsilon)` must give gains below {MOST_GAIN:g}; got {sizes}.")
    return Gains(sizes[0] * identity, sizes[1] * identity)


def _identity(call: str, joints: object) -> Array:
    return np.eye(whole(f"{call}(joints=...)", joints, most=MOST_JOINTS, of=" of joints"))
