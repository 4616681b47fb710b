"""The linear part of a switching loop, s = W u with u = -f(s), and the cut that separates it from the switch."""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import casadi as ca
import numpy as np
from scipy.linalg import eig, eigvals
from scipy.signal import BadCoefficients

from workbench.core import Ode, StepMap
from workbench.core.validation.number_types import Numbers
from workbench.core.validation.refusals import (
    Array,
    describe,
    finite,
    known_name,
    positive,
    refusal,
    require,
    seconds,
    vector,
)
from workbench.core.validation.signatures import check_arguments
from workbench.design.control_system import System
from workbench.design.matrices import Complex, DesignError, square

FASTEST = 1e100  # a frequency in rad/s
ROUNDING = 1e-6  # a threefold integrator has computed poles as far from zero as the cube root of rounding
REST = 1e-8  # how far from rest a state may be, by the rate at which the linear loop would move it
INSTANTS = (0, 1009)  # at which a rest is asked for; nothing may depend on time


@dataclass(frozen=True, eq=False)
@check_arguments
class LinearPart:
    """The linear part W = c (zeta I - A)^-1 b from u to s = c x: x' = A x + b u, or x+ = A x + b u with a period.

    A is (nx, nx), b and c (nx,); the period in s is 0 in continuous time; zeta is s or z = exp(s period).

    Raises
    ------
    ValueError
        If a number is not finite, a shape is wrong, a pole is unstable, or u drives s the wrong way.
    """

    A: Array
    b: Array
    c: Array
    period: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "A", square("LinearPart(A, b, c)", "A", self.A))
        for name in ("b", "c"):
            value = vector(f"LinearPart({name}=...)", getattr(self, name), len(self.A), "states")
            if not np.isfinite(value).all():
                raise ValueError(f"`LinearPart({name}=...)` must be finite; got {value.tolist()}.")
            object.__setattr__(self, name, value)
        if self.period != 0:
            object.__setattr__(self, "period", seconds("LinearPart(period=...)", self.period))
        self._check_poles()
        self._check_sign()

    @staticmethod
    @check_arguments
    def of(system: System) -> LinearPart:
        """The linear part from a `StateSpace` or `TransferFunction` of python-control, from u to s.

        Raises
        ------
        DesignError
            If the states cannot be found from its polynomials.
        ValueError
            If it has not one input and one output, feeds u through to s, or cannot be a `LinearPart`.
        """
        import control

        if isinstance(system, LinearPart):
            return system
        linear = isinstance(system, control.StateSpace | control.TransferFunction)
        if not linear or not system.issiso() or system.dt is True:
            must = "a `StateSpace` or `TransferFunction` of python-control with one input and one output, and its `dt`"
            raise refusal("LinearPart.of(system)", must, system)
        with warnings.catch_warnings():
            warnings.simplefilter("error", BadCoefficients)
            try:
                states = control.ss(system)
            except BadCoefficients:
                raise DesignError(
                    "`LinearPart.of(system)` must be a transfer function whose polynomials can be trusted; the leading "
                    "coefficients of this one nearly vanish beside the others. Give it as a `StateSpace`."
                ) from None
        if np.any(states.D):
            raise ValueError(
                f"`LinearPart.of(system)` must be strictly proper, as s would jump with u; got D = {states.D[0, 0]:g}."
            )
        return LinearPart(states.A, states.B[:, 0], states.C[0], float(states.dt or 0.0))

    @check_arguments
    def response(self, w: Array | float) -> tuple[Complex, Complex]:
        """W and dW/ds at s = j w for w (N,) in rad/s; a `ValueError` for other frequencies, or at a pole of W."""
        w = np.atleast_1d(w)
        if w.ndim != 1 or not (np.abs(w) < FASTEST).all():
            raise ValueError(f"`response(w=...)` must be a vector of finite frequencies in rad/s; got {describe(w)}.")
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
        return np.asarray(W, dtype=complex), np.asarray(dW, dtype=complex)

    @property
    def poles(self) -> Complex:
        """The eigenvalues of A."""
        return np.asarray(np.linalg.eigvals(self.A), dtype=complex)

    @property
    def corners(self) -> Complex:
        """The poles and zeros of W, (m,) in 1/s, where its phase turns; by the logarithm in a sampled-data loop."""
        nx = len(self.c)
        pencil, mass = np.zeros((nx + 1, nx + 1)), np.diag(np.append(np.ones(nx), 0.0))
        pencil[:nx, :nx], pencil[:nx, nx], pencil[nx, :nx] = self.A, self.b, self.c
        with np.errstate(divide="ignore", invalid="ignore"):  # the zeros at infinity
            zeros = eigvals(pencil, mass)
        found = np.concatenate([self.poles, zeros[np.isfinite(zeros)]])
        found = found[np.abs(found) > 1e-9]
        return np.asarray(np.log(found) / self.period if self.period else found, dtype=complex)

    @check_arguments
    def decay_rate(self, gain: float) -> float:
        """The rate at which u = -gain s brings s to rest, in 1/s: the negative of the slowest pole's growth."""
        finite("closed(gain=...)", gain, low=-FASTEST, high=FASTEST)
        poles = np.linalg.eigvals(self.A - gain * np.outer(self.b, self.c))
        if self.period:
            return float(-np.log(np.abs(poles).max()) / self.period)
        return float(-poles.real.max())

    def _check_poles(self) -> None:
        poles = self.poles
        size = np.abs(poles) - 1 if self.period else poles.real
        worst = int(np.argmax(size))
        if size[worst] > _pole_doubts(self.A)[worst]:
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


def _pole_doubts(A: Array) -> Array:
    """The distance that rounding may have moved each pole of A, no farther than a threefold one: (nx,)."""
    values, left, right = (np.asarray(part) for part in eig(A, left=True))
    cosines = np.abs(np.einsum("ik,ik->k", left.conj(), right))
    first = 100 * np.finfo(float).eps * np.linalg.norm(A, 2) / np.maximum(cosines, np.finfo(float).tiny)
    return np.asarray(np.minimum(first, ROUNDING * np.abs(values).max()))


@check_arguments
def linear_part_of(
    loop: Ode | StepMap,
    x: Numbers,
    p: Numbers | None = None,
    *,
    gain: str = "controller.K[0]",
    variable: str = "s[0]",
    width: str = "controller.phi",
) -> LinearPart:
    """The linear part W of a loop at rest whose law has a switched term -K sat(s / phi), from that term to s; exact.

    Within the layer the linear loop is A(K) = A(0) - (K / phi) b c, so two Jacobians of the whole loop give W. A
    `StepMap` of a sampled loop keeps its hold and its delay. The loop must have a smooth or clipped layer, even if the
    relay is to be studied.

    Parameters
    ----------
    x, p
        The state (nx,) at rest with s = 0, and the parameters (np,). A sampled loop's held states settle by themselves.
    gain, variable, width
        The labels of K, s and phi in the loop: K and phi are parameters, and s is an output.

    Raises
    ------
    DesignError
        If the loop does not rest at the state, the gain has no effect, or its effect is not that of -K sat(s / phi).
    ValueError
        If x or p has a wrong size, or W cannot be a `LinearPart`.
    LookupError
        If the loop has no such label.
    """
    if not isinstance(loop, StepMap):
        advice = ": a loop becomes one by its method `ode()`, or a `StepMap` by `jacobian_samples(...)`"
        require("linear_part_of(loop=...)", loop, Ode, advice)
    point = vector("linear_part_of(x=...)", x, loop.states.size, "states")
    row = (
        loop.parameters.default if p is None else vector("linear_part_of(p=...)", p, loop.parameters.size, "parameters")
    )
    place, phi = _label(loop.parameters.labels, gain), float(row[_label(loop.parameters.labels, width)])
    after, A, C = _functions(loop)
    off, on = row.copy(), row.copy()
    off[place], on[place] = 0.0, positive(f"linear_part_of(width='{width}')", phi)
    if isinstance(loop, StepMap):
        for _ in range(3):  # what a computer holds is brought up to date
            point = np.array(after(INSTANTS[0], point, off)).ravel()
    loose, tight = (np.array(A(INSTANTS[0], point, values)) for values in (off, on))
    c = np.array(C(INSTANTS[0], point, off))[_label(loop.outputs.labels, variable)]
    _check_rest(after, A, point, off, isinstance(loop, StepMap))
    b = _input_column(loose - tight, c, f"linear_part_of(gain='{gain}', variable='{variable}', width='{width}')")
    return LinearPart(loose, b, c, loop.h if isinstance(loop, StepMap) else 0.0)


def _input_column(step: Array, c: Array, call: str) -> Array:
    """The b of b c = A(0) - A(phi), or a refusal where that is no such product."""
    if not np.any(c) or not np.any(step):
        raise DesignError(
            f"`{call}` must close a linear loop, and has no effect at this state: a "
            "law with saturation='sign' has no derivative. Cut the loop of the same law with 'clip'."
        )
    b: Array = step @ c / (c @ c)
    if np.abs(step - np.outer(b, c)).max() > 1e-9 * np.abs(step).max():
        raise DesignError(
            f"`{call}` must be a term -K sat(s / phi) with these "
            "three; what the gain multiplies here is not this s alone."
        )
    return b


def _functions(loop: Ode | StepMap) -> tuple[ca.Function, ca.Function, ca.Function]:
    """The state's rate, or the state that follows, its Jacobian and that of the outputs, each of (t or k, x, p)."""
    if isinstance(loop, Ode):
        return loop.f, loop.A, loop.Cy
    rule = loop.rule
    symbols = [rule.k, rule.x, rule.p]
    noiseless = ca.substitute(
        ca.vertcat(rule.next, rule.without_crossings(rule.output)),
        ca.vertcat(rule.t, rule.h, rule.w),
        ca.vertcat(rule.k * loop.h, loop.h, ca.SX.zeros(rule.w.numel())),
    )
    after, output = ca.vertsplit(noiseless, [0, loop.states.size, noiseless.numel()])
    return (
        ca.Function("after", symbols, [after]),
        ca.Function("A", symbols, [ca.densify(ca.jacobian(after, rule.x))]),
        ca.Function("Cy", symbols, [ca.densify(ca.jacobian(output, rule.x))]),
    )


def _check_rest(after: ca.Function, A: ca.Function, x: Array, p: Array, recursion: bool) -> None:
    for t in INSTANTS:
        moved = np.array(after(t, x, p)).ravel() - (x if recursion else 0.0)
        scale = max(1.0, float(np.abs(np.array(A(t, x, p))).max())) * max(1.0, float(np.abs(x).max()))
        if not np.abs(moved).max() <= REST * scale:
            i = int(np.argmax(np.abs(moved)))
            raise DesignError(
                f"`linear_part_of(x=...)` must be a rest of the loop, about which it chatters; state {i} moves by "
                f"{moved[i]:.3g} {'in one period' if recursion else 'a second'}. Hold the reference, set the drives "
                "to what rest needs."
            )


def _label(labels: tuple[str, ...], name: str) -> int:
    return labels.index(known_name(name, labels, "labels of this loop"))
