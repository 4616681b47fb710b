"""The linear part of a loop that switches: s = W u, where u = -f(s), in continuous time or sampled."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import eig, eigvals, expm

from workbench.design.certificates import Refused
from workbench.design.matrices import square
from workbench.validation.refusals import Array, described, finite, seconds, vector
from workbench.validation.signatures import door

FASTEST = 1e100  # a frequency in rad/s
ROUNDING = 1e-6  # a threefold integrator has computed poles as far from zero as the cube root of rounding
Complexes = np.ndarray[Any, np.dtype[np.complex128]]


@dataclass(frozen=True, eq=False)
@door
class LinearPart:
    """W = c (zeta I - A)^-1 b with one input and one output, and what its frequency response is made of.

    Attributes
    ----------
    A, b, c
        (nx, nx), (nx,), (nx,): x' = A x + b u without a period, x+ = A x + b u with one; s = c x.
    period
        0 in continuous time, else the sampling period in s: zeta is s or z = exp(s period).
    delay
        A dead time in s before u acts; in continuous time alone, as a period holds delays among its states.

    Raises
    ------
    ValueError
        If a number is not finite, a shape is wrong, a pole is unstable, or u drives s the wrong way.
    """

    A: Array
    b: Array
    c: Array
    period: float = 0.0
    delay: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "A", square("LinearPart(A, b, c)", "A", self.A))
        for name in ("b", "c"):
            value = vector(f"LinearPart({name}=...)", getattr(self, name), len(self.A), "states")
            if not np.isfinite(value).all():
                raise ValueError(f"`LinearPart({name}=...)` must be finite; got {value.tolist()}.")
            object.__setattr__(self, name, value)
        for name in ("period", "delay"):
            if (value := getattr(self, name)) != 0:
                object.__setattr__(self, name, seconds(f"LinearPart({name}=...)", value))
        if self.period and self.delay:
            raise ValueError("`LinearPart(delay=...)` is for continuous time; `held(..., delay=True)` waits a period.")
        self._check_poles()
        self._check_sign()

    @staticmethod
    @door
    def of(system: Any, delay: float = 0.0) -> LinearPart:
        """The linear part from a `StateSpace` or `TransferFunction` of python-control, from u to s.

        Raises
        ------
        Refused
            If its states cannot be found from its polynomials, which are too badly conditioned.
        ValueError
            If it has not one input and one output, feeds u through to s, has a period that is not
            said, or cannot be a `LinearPart`.
        """
        import control

        if isinstance(system, LinearPart):
            return system
        if not isinstance(system, control.StateSpace | control.TransferFunction):
            raise ValueError(
                "`LinearPart.of(system)` must be a `StateSpace` or a `TransferFunction` of python-control, from the "
                f"switched torque to s; got {type(system).__name__}."
            )
        if (system.ninputs, system.noutputs) != (1, 1):
            raise ValueError(
                f"`LinearPart.of(system)` must have one input and one output, as one switch closes one loop; got "
                f"{system.ninputs} and {system.noutputs}."
            )
        system = _in_states(system)
        if system.dt is True:
            raise ValueError("`LinearPart.of(system)` is discrete without a period; give it its `dt` in s.")
        if np.any(system.D):
            raise ValueError(
                f"`LinearPart.of(system)` must be strictly proper, as s would jump with u; got D = {system.D[0, 0]:g}."
            )
        A, b, c = np.array(system.A), np.array(system.B)[:, 0], np.array(system.C)[0]
        return LinearPart(A, b, c, float(system.dt or 0.0), delay)

    @door
    def held(self, period: float, *, delay: bool = False) -> LinearPart:
        """The same, sampled: s is read at k period and u held; with `delay`, from the next instant on.

        Raises
        ------
        ValueError
            If the period is no positive finite number, or this part is sampled or has a dead time already.
        """
        period = seconds("held(period=...)", period)
        if self.period or self.delay:
            raise ValueError("`held(period)` is for a part in continuous time without a dead time; this one is not.")
        A, b = flow(self.A, self.b, period)
        c = self.c
        if delay:
            nx = len(c)
            A = np.block([[A, b[:, np.newaxis]], [np.zeros((1, nx + 1))]])
            b, c = np.append(np.zeros(nx), 1.0), np.append(c, 0.0)
        return LinearPart(A, b, c, period)

    @door
    def response(self, w: Array | float) -> tuple[Complexes, Complexes]:
        """W and dW/ds at s = j w, where w is (N,) in rad/s.

        Raises
        ------
        ValueError
            If w is no such vector, or W is infinite at one of its frequencies.
        """
        w = np.atleast_1d(w)
        if w.ndim != 1 or not (np.abs(w) < FASTEST).all():
            raise ValueError(f"`response(w=...)` must be a vector of finite frequencies in rad/s; got {described(w)}.")
        s = 1j * w
        zeta, rate = (np.exp(s * self.period), self.period) if self.period else (s, 1.0)
        resolvent = zeta[:, np.newaxis, np.newaxis] * np.eye(len(self.c)) - self.A
        with np.errstate(all="ignore"):  # what is infinite is refused below
            try:
                x = np.linalg.solve(resolvent, np.broadcast_to(self.b, (len(s), len(self.c)))[:, :, np.newaxis])
                y = np.linalg.solve(resolvent, x)
            except np.linalg.LinAlgError:
                y = np.full((1, 1, 1), np.inf)
        if not np.isfinite(y).all():
            raise ValueError("`response(w=...)` has a pole of W among its frequencies, or one too near to it.")
        W, dW = (self.c @ x)[:, 0], -(self.c @ y)[:, 0] * (rate * zeta if self.period else rate)
        wait = np.exp(-s * self.delay)
        return W * wait, (dW - self.delay * W) * wait

    @door
    def integrator(self, w: float) -> tuple[complex, complex]:
        """I and dI/ds at s = j w: 1/s in continuous time, explicit Euler in a computer."""
        finite("integrator(w=...)", w, " of rad/s, beyond zero", low=1 / FASTEST, high=FASTEST)
        if not self.period:
            return 1 / (1j * w), 1 / w**2 + 0j
        z = np.exp(1j * w * self.period)
        return complex(self.period / (z - 1)), complex(-(self.period**2) * z / (z - 1) ** 2)

    @property
    def poles(self) -> Complexes:
        """Those of A."""
        return np.asarray(np.linalg.eigvals(self.A), dtype=complex)

    @property
    def corners(self) -> Complexes:
        """Poles and zeros, (m,) in 1/s, by the logarithm in a sampled-data loop: where the phase of W turns."""
        nx = len(self.c)
        pencil, mass = np.zeros((nx + 1, nx + 1)), np.diag(np.append(np.ones(nx), 0.0))
        pencil[:nx, :nx], pencil[:nx, nx], pencil[nx, :nx] = self.A, self.b, self.c
        with np.errstate(divide="ignore", invalid="ignore"):  # the zeros at infinity
            zeros = eigvals(pencil, mass)
        found = np.concatenate([self.poles, zeros[np.isfinite(zeros)]])
        found = found[np.abs(found) > 1e-9]
        return np.asarray(np.log(found) / self.period if self.period else found, dtype=complex)

    @door
    def closed(self, gain: float) -> float:
        """How fast u = -gain s brings s to rest, in 1/s: the negative of the slowest pole's growth.

        Raises
        ------
        ValueError
            If there is a dead time, which has no finite number of poles.
        """
        if self.delay:
            raise ValueError("`closed(gain)` has infinitely many poles where there is a dead time.")
        finite("closed(gain=...)", gain, low=-FASTEST, high=FASTEST)
        poles = np.linalg.eigvals(self.A - gain * np.outer(self.b, self.c))
        if self.period:
            return float(-np.log(np.abs(poles).max()) / self.period)
        return float(-poles.real.max())

    def _check_poles(self) -> None:
        poles = self.poles
        size = np.abs(poles) - 1 if self.period else poles.real
        worst = int(np.argmax(size))
        if size[worst] > _moved(self.A)[worst]:
            raise ValueError(
                f"`LinearPart(A=...)` must have no unstable pole, as no oscillation about zero is to be trusted then; "
                f"got the pole {complex(np.round(poles[worst], 12)):.6g}. Cut the loop where the rest is stable."
            )

    def _check_sign(self) -> None:
        """The first answer of s to a pulse of u must be positive."""
        x, size = self.b, np.linalg.norm(self.c) * np.linalg.norm(self.b)
        for _ in range(len(self.c)):
            first = float(self.c @ x)
            if abs(first) > 1e-9 * size:
                break
            x, size = self.A @ x, size * max(np.linalg.norm(self.A), np.finfo(float).tiny)
        if not first > 0:
            why = "s does not answer to u" if abs(first) <= 1e-9 * size else f"the first answer is {first:.6g}"
            raise ValueError(
                f"`LinearPart(b, c)` must answer to u with the sign of u, so that u = -f(s) drives s to zero: {why}. "
                "Change the sign of the gain or of s."
            )


def _in_states(system: Any) -> Any:
    """The system as a `StateSpace`, or a refusal where SciPy warns of what it makes of the polynomials."""
    import control
    from scipy.signal import BadCoefficients

    with warnings.catch_warnings():
        warnings.simplefilter("error", BadCoefficients)
        try:
            return control.ss(system)
        except BadCoefficients:
            raise Refused(
                "`LinearPart.of(system)` must be a transfer function whose polynomials can be trusted; the leading "
                "coefficients of this one nearly vanish beside the others. Give it as a `StateSpace`, or choose "
                "another unit of time."
            ) from None


def _moved(A: Array) -> Array:
    """How far rounding may have moved each pole of A: no farther than a threefold one, (nx,)."""
    values, left, right = (np.asarray(part) for part in eig(A, left=True))
    cosines = np.abs(np.einsum("ik,ik->k", left.conj(), right))
    first = 100 * np.finfo(float).eps * np.linalg.norm(A, 2) / np.maximum(cosines, np.finfo(float).tiny)
    return np.asarray(np.minimum(first, ROUNDING * np.abs(values).max()))


def flow(A: Array, b: Array, t: float) -> tuple[Array, Array]:
    """x(t) = Phi x(0) + Gamma u for a constant u: Phi (nx, nx) and Gamma (nx,)."""
    nx = len(b)
    M = np.zeros((nx + 1, nx + 1))
    M[:nx, :nx], M[:nx, nx] = A * t, b * t
    E = np.asarray(expm(M), dtype=float)
    return E[:nx, :nx], E[:nx, nx]
