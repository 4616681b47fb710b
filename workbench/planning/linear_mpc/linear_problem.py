"""The problem that a linear predictive controller solves every period, checked once."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from workbench.core.validation.notebook_display import show
from workbench.core.validation.number_types import Numbers
from workbench.core.validation.refusals import Array, whole
from workbench.core.validation.signatures import check_arguments
from workbench.design.matrices import definite, matrix, semidefinite, square
from workbench.design.riccati import lqr
from workbench.planning.linear_mpc.array_doors import finite_vector
from workbench.planning.linear_mpc.limit_rows import RATE, LimitRows, MpcLimits, Pair, bounds, limit_rows

LONGEST_HORIZON = 1000


@dataclass(frozen=True, eq=False)
@show
class LinearMpc:
    """The problem min sum_{k<N} (x_k'Q x_k + u_k'R u_k) + x_N'P x_N + soft terms, x_{k+1} = A x_k + B u_k, within rows.

    `mpc_problem` makes one from matrices and limits.

    Parameters
    ----------
    A, B
        (nx, nx) and (nx, nu).
    Q, R, P
        Weights of the states, (nx, nx), the inputs, (nu, nu), and the last state, (nx, nx).
    horizon
        The number N of stages.
    rows
        The limits of a stage.
    K
        (nu, nx), the gain of u = -K x, whose cost is x'P x without limits; None if P was given.
    x0, u0
        (nx,) and (nu,), the rest about which x and u are deviations; None for zero. The rows are for deviations.
    """

    A: Array
    B: Array
    Q: Array
    R: Array
    P: Array
    horizon: int
    rows: LimitRows
    K: Array | None = None
    x0: Array | None = None
    u0: Array | None = None

    def __repr__(self) -> str:
        nx, nu = self.B.shape
        limits = ", ".join(dict.fromkeys(self.rows.names))
        return f"<LinearMpc: {nx} states, {nu} inputs, horizon {self.horizon}, limits on {limits}>"

    @property
    def low(self) -> Array:
        """The lower bounds of all stages, (N nc,)."""
        return np.tile(self.rows.low, self.horizon)

    @property
    def high(self) -> Array:
        """The upper bounds of all stages, (N nc,)."""
        return np.tile(self.rows.high, self.horizon)

    def about(self, x0: Numbers, u0: Numbers) -> LinearMpc:
        """The problem of deviations from a rest x0 (nx,), u0 (nu,): its limits are moved by the rest."""
        nx, nu = self.B.shape
        x0 = finite_vector("LinearMpc.about(x0=...)", x0, nx, "states")
        u0 = finite_vector("LinearMpc.about(u0=...)", u0, nu, "inputs")
        return replace(self, rows=self.rows.about(x0, u0), x0=x0, u0=u0)


@check_arguments
def mpc_problem(
    A: Numbers,
    B: Numbers,
    Q: Numbers,
    R: Numbers,
    horizon: int,
    limits: MpcLimits,
    *,
    P: Numbers | None = None,
    delay: int = 0,
    names: tuple[tuple[str, ...], tuple[str, ...]] = ((), ()),
) -> LinearMpc:
    """The problem of linear predictive control for x+ = A x + B u with limits.

    Parameters
    ----------
    A, B
        (nx, nx) and (nx, nu).
    Q, R
        Weights, (nx, nx) positive semidefinite and (nu, nu) positive definite.
    horizon
        The number N of stages, above the delay.
    P
        The weight of the last state, (nx, nx) positive semidefinite. By default it is the cost of the LQR law without
        limits, from the certified Riccati solver: then the law equals LQR where no limit acts.
    delay
        The whole number of periods until an input acts; the state is then (x_k, u_{k-delay}, ..., u_{k-1}).
    names
        Names of states and of inputs, for messages.

    Raises
    ------
    ValueError, DesignError
        If a matrix, a bound or the horizon does not fit, or if no gain stabilises A, B.

    References
    ----------
    Rawlings, Mayne and Diehl (2017), Model Predictive Control, sections 1.3 and 2.5.

    Examples
    --------
    >>> from workbench.planning.linear_mpc import MpcLimits, mpc_problem
    >>> mpc_problem([[1.0, 0.1], [0.0, 1.0]], [[0.0], [0.1]], np.eye(2), [[0.1]], 20, MpcLimits(inputs=(-1.0, 1.0)))
    <LinearMpc: 2 states, 1 inputs, horizon 20, limits on u[0]>
    """
    matrices = with_delay(*_matrices(A, B, Q, R), whole("mpc_problem(delay=...)", delay, least=0))
    must = "above the delay, as no input of it would act otherwise"
    N = whole("mpc_problem(horizon=...)", horizon, delay + 1, LONGEST_HORIZON, " of stages", must)
    P = None if P is None else semidefinite("mpc_problem(P=...)", "P", P, len(matrices[0]))
    return _problem(*matrices, P, N, limits, names)


def _problem(
    A: Array,
    B: Array,
    Q: Array,
    R: Array,
    P: Array | None,
    horizon: int,
    limits: MpcLimits,
    names: tuple[tuple[str, ...], tuple[str, ...]],
) -> LinearMpc:
    nx, nu = B.shape
    K, cost = regulator(A, B, Q, R) if P is None else (None, P)
    states, inputs = _names(names[0], nx, "x"), _names(names[1], nu, "u")
    limits = replace(limits, states=_padded(limits.states, nx), outputs=_wide(limits.outputs, nx))
    problem = LinearMpc(A, B, Q, R, cost, horizon, limit_rows(A, B, limits, states, inputs), K)
    return problem if limits.rates is None else _with_rates(problem, limits.rates, inputs)


def regulator(A: Array, B: Array, Q: Array, R: Array) -> tuple[Array, Array]:
    """The gain K and the cost P of u = -K x, from the certified solver."""
    answer = lqr(A, B, Q, R, discrete=True)
    return np.array(answer.K, dtype=float), np.array(answer.X, dtype=float)


def _matrices(A: Numbers, B: Numbers, Q: Numbers, R: Numbers) -> tuple[Array, Array, Array, Array]:
    a = square("mpc_problem(A=...)", "A", A)
    b = matrix("mpc_problem(B=...)", "B", B, rows=len(a))
    return a, b, semidefinite("mpc_problem(Q=...)", "Q", Q, len(a)), definite("mpc_problem(R=...)", "R", R, b.shape[1])


def with_delay(A: Array, B: Array, Q: Array, R: Array, delay: int) -> tuple[Array, Array, Array, Array]:
    """The matrices with the inputs on their way as states, oldest first."""
    for _ in range(delay):
        nx, nu = B.shape
        last = A.shape[0] - nx
        A = np.block([[A, B], [np.zeros((nu, nx + last + nu))]])
        B = np.vstack([np.zeros((nx, nu)), np.eye(nu)])
        Q = np.block([[Q, np.zeros((len(Q), nu))], [np.zeros((nu, len(Q) + nu))]])
    return A, B, Q, R


def _names(names: tuple[str, ...], n: int, letter: str) -> tuple[str, ...]:
    own = tuple(f"{letter}[{i}]" for i in range(n))
    if len(names) > n:
        raise ValueError(f"`mpc_problem(names=...)` must have at most {n} names; got {len(names)}.")
    return tuple(names) + own[len(names) :]


def _padded(limits: Pair | None, nx: int) -> Pair | None:
    """Limits on the states of a plant, without limits on the inputs that are on their way."""
    if limits is None or not isinstance(limits, tuple | list) or len(limits) != 2:
        return limits
    ends = [np.asarray(end, dtype=float) for end in limits]
    grown = [
        np.r_[end, np.full(nx - len(end), sign * np.inf)] if end.ndim == 1 and len(end) < nx else end
        for end, sign in zip(ends, (-1, 1), strict=True)
    ]
    return grown[0], grown[1]


def _wide(outputs: tuple[Numbers, Pair] | None, nx: int) -> tuple[Numbers, Pair] | None:
    if outputs is None:
        return None
    C = matrix("MpcLimits(outputs=...)", "C", outputs[0])
    return np.hstack([C, np.zeros((len(C), max(nx - C.shape[1], 0)))]), outputs[1]


def _with_rates(problem: LinearMpc, limits: Pair, input_names: tuple[str, ...]) -> LinearMpc:
    """The problem with the last input as a state, and rows u_k - u_{k-1}."""
    nx, nu = problem.B.shape
    names = tuple(RATE + name for name in input_names)
    low, high = bounds("MpcLimits(rates=...)", limits, names)
    old, wide = problem.rows, np.zeros((problem.rows.count, nu))
    if any(cone.inputs for cone in old.cones):
        raise ValueError(
            "`MpcLimits(rates=..., cones=...)` must not have both limits of changes and cones of inputs, as a command "
            "is moved into one of them only. Leave out one."
        )
    rows = LimitRows(
        np.block([[old.F, wide], [np.zeros((nu, nx)), -np.eye(nu)]]),
        np.vstack([old.E, np.eye(nu)]),
        np.r_[old.low, low],
        np.r_[old.high, high],
        np.r_[old.softness, np.zeros(nu)],
        old.names + names,
        old.cones,
    )
    corner = np.zeros((nu, nu))
    return LinearMpc(
        np.block([[problem.A, np.zeros((nx, nu))], [np.zeros((nu, nx + nu))]]),
        np.vstack([problem.B, np.eye(nu)]),
        np.block([[problem.Q, np.zeros((nx, nu))], [np.zeros((nu, nx)), corner]]),
        problem.R,
        np.block([[problem.P, np.zeros((nx, nu))], [np.zeros((nu, nx)), corner]]),
        problem.horizon,
        rows,
        None if problem.K is None else np.hstack([problem.K, np.zeros((nu, nu))]),
    )
