"""The design of a nonlinear predictive law: weights, limits by name, and the cost and the law behind the horizon."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from workbench.core.point import OperatingPoint
from workbench.core.validation.notebook_display import show
from workbench.core.validation.number_types import Numbers
from workbench.core.validation.refusals import Array, known_name, positive, refusal, seconds, whole
from workbench.core.validation.signatures import check_arguments
from workbench.design.control_system import System
from workbench.design.matrices import DesignError, definite, semidefinite
from workbench.design.riccati.regulators import is_system
from workbench.planning.linear_mpc.limit_rows import NO_LIMIT, Pair, bounds
from workbench.planning.linear_mpc.linear_problem import regulator

MOST = 1000  # stages, sweeps, linearisations or steps


@dataclass(frozen=True, eq=False)
class StageLimits:
    """The limits of a stage, 1e30 for none: hard ones of inputs, (nu,), and soft ones of signals by name."""

    low: Array
    high: Array
    limited: tuple[str, ...]
    row_low: Array | None
    row_high: Array | None
    row_weight: Array | None


@dataclass(frozen=True, eq=False)
@show
class NonlinearPredictiveDesign:
    """A nonlinear predictive law as it is designed: `NonlinearPredictive.of(plant, design)` makes the law.

    Parameters
    ----------
    states, inputs
        The names of the plant's states and inputs.
    period, horizon
        The period of the computer in s, and the number N of stages.
    sweeps, iterations, steps
        The numbers of sweeps of a linearised problem, of linearisations in a period, and of Runge-Kutta steps in a
        stage.
    Q, R, P
        The weights of a stage, (nx, nx) and (nu, nu), and of the end, (nx, nx).
    K
        (nu, nx), the gain of the law behind the horizon, whose cost is e'P e without limits unless P was given.
    A, B
        (nx, nx) and (nx, nu), the Jacobians of a stage at the rest.
    limits
        The limits of a stage.
    x0, u0
        (nx,) and (nu,), the rest.
    """

    states: tuple[str, ...]
    inputs: tuple[str, ...]
    period: float
    horizon: int
    sweeps: int
    iterations: int
    steps: int
    Q: Array
    R: Array
    P: Array
    K: Array
    A: Array
    B: Array
    limits: StageLimits
    x0: Array
    u0: Array

    def __repr__(self) -> str:
        own = self.limits
        limits = zip(self.inputs, own.low, own.high, strict=True)
        hard = ", ".join(name for name, low, high in limits if low > -NO_LIMIT or high < NO_LIMIT) or "none"
        soft = f", soft on {', '.join(own.limited)}" if own.limited else ""
        return (
            f"<NonlinearPredictiveDesign: {self.horizon} stages of {self.period:g} s, limits on {hard}{soft}, "
            f"{self.sweeps} sweeps, {self.iterations} linearisation{'s' if self.iterations > 1 else ''} a period>"
        )

    @property
    def law_arguments(self) -> Mapping[str, object]:
        """The arguments of `NonlinearPredictive`."""
        names = ("horizon", "period", "sweeps", "iterations", "steps", "Q", "R", "P", "K", "x0", "u0")
        own = {name: getattr(self, name) for name in names} | vars(self.limits)
        return {"names": (self.states, self.inputs), **own}


@check_arguments
def nonlinear_predictive_design(
    system: System,
    period: float,
    Q: Numbers,
    R: Numbers,
    horizon: int,
    *,
    limits: Mapping[str, Pair] | None = None,
    soft_weight: float | Mapping[str, float] | None = None,
    P: Numbers | None = None,
    sweeps: int = 3,
    iterations: int = 1,
    steps: int = 1,
) -> NonlinearPredictiveDesign:
    """Design a nonlinear predictive law for a plant that a computer controls once in a period.

    Parameters
    ----------
    system
        The plant linearised at the rest behind the horizon, as `linearize` gives it.
    period
        Of the computer in s. A stage of the plan is a period.
    Q, R, horizon
        Weights of the states, (nx, nx) positive semidefinite, and inputs, (nu, nu) positive definite, for a period; and
        the number of stages.
    limits
        Pairs (low, high) by name, in the units of the plant: of inputs, which are kept, and of states and outputs,
        which are soft.
    soft_weight
        The weight w of a violation d of a soft limit, w d^2 in a stage; one number, or one by name.
    P
        Weight of the end, (nx, nx) positive semidefinite. By default it is the cost of the LQR law at the rest, from
        the certified Riccati solver.
    sweeps, iterations, steps
        The numbers of sweeps of a linearised problem, of linearisations in a period, and of Runge-Kutta steps in a
        stage.

    Raises
    ------
    ValueError, LookupError
        If an argument is out of its range, limits cross, exclude the rest or have no weight, or the plant has no signal
        of a name.
    DesignError
        If the system is sampled already, or no gain stabilises it at the rest.

    References
    ----------
    Rawlings, Mayne and Diehl (2017), Model Predictive Control, sections 2.5 and 8.9.

    Examples
    --------
    >>> cart = wb.linearize(wb.open_loop(wb.CartPole()), t=0.0, x=np.zeros(4), at_rest=True)
    >>> wb.nonlinear_predictive_design(cart, 0.02, np.eye(4), [[0.1]], 40, limits={"F": (-10.0, 10.0)})
    <NonlinearPredictiveDesign: 40 stages of 0.02 s, limits on F, 3 sweeps, 1 linearisation a period>
    """
    call, h = "nonlinear_predictive_design", seconds("nonlinear_predictive_design(period=...)", period)
    if not is_system(system) or not hasattr(system, "state_labels"):
        raise refusal(f"{call}(system)", "a linear plant, as `linearize` returns it", system)
    if system.dt:
        raise DesignError(f"`{call}(system)` must be in continuous time, as the law integrates the plant itself.")
    states, inputs = tuple(system.state_labels), tuple(system.input_labels)
    nx, nu = len(states), len(inputs)
    q, r = semidefinite(f"{call}(Q=...)", "Q", Q, nx), definite(f"{call}(R=...)", "R", R, nu)
    counts = {"horizon": horizon, "sweeps": sweeps, "iterations": iterations, "steps": steps}
    N, S, M, n = (whole(f"{call}({name}=...)", value, least=1, most=MOST) for name, value in counts.items())
    A, B = stage_slopes(np.asarray(system.A), np.asarray(system.B), h, n)
    K, end = _behind_horizon(call, A, B, q, r, P)
    point = getattr(system, "point", None)
    x0, u0 = (point.x0, point.u0) if isinstance(point, OperatingPoint) else (np.zeros(nx), np.zeros(nu))
    outputs = tuple(name for name in system.output_labels if name not in states)
    own = _limits(call, limits or {}, (states, inputs, outputs), np.asarray(u0), soft_weight)
    return NonlinearPredictiveDesign(states, inputs, h, N, S, M, n, q, r, end, K, A, B, own, x0, u0)


def _behind_horizon(call: str, A: Array, B: Array, Q: Array, R: Array, P: Numbers | None) -> tuple[Array, Array]:
    """The gain and the cost of the law behind the horizon."""
    if P is None:
        return regulator(A, B, Q, R)
    end = semidefinite(f"{call}(P=...)", "P", P, len(A))
    return np.asarray(np.linalg.solve(R + B.T @ end @ B, B.T @ end @ A), dtype=float), end


def stage_slopes(A: Array, B: Array, period: float, steps: int) -> tuple[Array, Array]:
    """The Jacobians of classical Runge-Kutta steps of a period at a rest, where the rate has the Jacobians A and B."""
    n, h = len(A), period / steps
    move, push = np.eye(n), np.zeros((n, n))
    for order in (4, 3, 2, 1):  # of the Taylor polynomials I + h A + ... and h (I + h A / 2 + ...)
        push = np.eye(n) + h * A @ push / (order + 1) if order < 4 else np.eye(n)
        move = np.eye(n) + h * A @ move / order
    one, own = move, h * push @ B
    A_all, B_all = one, own
    for _ in range(steps - 1):
        A_all, B_all = one @ A_all, one @ B_all + own
    return A_all, B_all


def _limits(
    call: str,
    limits: Mapping[str, Pair],
    names: tuple[tuple[str, ...], tuple[str, ...], tuple[str, ...]],
    u0: Array,
    soft_weight: float | Mapping[str, float] | None,
) -> StageLimits:
    """The limits of a stage, from those by name."""
    states, inputs, outputs = names
    low, high = np.full(len(inputs), -NO_LIMIT), np.full(len(inputs), NO_LIMIT)
    soft, rows = list[str](), list[tuple[float, float, float]]()
    for name, value in limits.items():
        known_name(name, (*states, *inputs, *outputs), "states, inputs and outputs of the plant")
        a, b = (
            float(np.clip(end[0], -NO_LIMIT, NO_LIMIT))
            for end in bounds(f"{call}(limits={{{name!r}: ...}})", value, (name,))
        )
        if name in inputs:
            i = inputs.index(name)
            low[i], high[i] = a, b
            if not a <= u0[i] <= b:
                raise ValueError(
                    f"`{call}(limits=...)` must leave the rest of the plant inside; '{name}' rests at {u0[i]:.4g}. "
                    "Take another rest, or widen the limit."
                )
            continue
        weight = soft_weight.get(name) if isinstance(soft_weight, Mapping) else soft_weight
        if weight is None:
            raise ValueError(
                f"`{call}(soft_weight=...)` must have a weight for the limit of '{name}', as limits of states and "
                "outputs are soft: give the cost of a violation by one unit."
            )
        soft.append(name)
        rows.append((a, b, positive(f"{call}(soft_weight=...)", weight)))
    if not rows:
        return StageLimits(low, high, (), None, None, None)
    row_low, row_high, row_weight = (np.array(end, dtype=float) for end in zip(*rows, strict=True))
    return StageLimits(low, high, tuple(soft), row_low, row_high, row_weight)
