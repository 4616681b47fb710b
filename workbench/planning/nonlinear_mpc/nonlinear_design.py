"""The design of a nonlinear predictive law: weights, limits by name, and the cost and the law behind the horizon."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

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
from workbench.planning.linear_mpc.linear_problem import regulator, with_delay
from workbench.planning.nonlinear_mpc.input_limits import rate_ends, whole_periods

CALL = "nonlinear_predictive_design"
Names = tuple[tuple[str, ...], tuple[str, ...], tuple[str, ...]]
MOST = 1000  # stages, sweeps, linearisations or steps


@dataclass(frozen=True, eq=False)
class StageLimits:
    """The limits of a stage, 1e30 for none: hard ones of inputs and their changes, (nu,), and soft ones by name."""

    low: Array
    high: Array
    row_names: tuple[str, ...]
    row_low: Array | None
    row_high: Array | None
    row_weight: Array | None
    rate_low: Array | None = None
    rate_high: Array | None = None


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
        The weights of a stage, (nx, nx) and (nu, nu), and of the end, (nz, nz).
    K
        (nu, nz), the gain of the law behind the horizon, whose cost is e'P e without limits unless P was given.
    A, B
        (nx, nx) and (nx, nu), the Jacobians of a stage at the rest.
    limits
        The limits of a stage.
    x0, u0
        (nx,) and (nu,), the rest.
    delay
        The number of periods until an input acts. The nz states are those of the plant and the inputs on their way; or
        the inputs before, with limits of their changes and no delay.
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
    delay: int = 0

    def __repr__(self) -> str:
        own = self.limits
        limits = zip(self.inputs, own.low, own.high, strict=True)
        hard = ", ".join(name for name, low, high in limits if low > -NO_LIMIT or high < NO_LIMIT) or "none"
        soft = f", soft on {', '.join(own.row_names)}" if own.row_names else ""
        if own.rate_low is not None and own.rate_high is not None:
            ends = zip(self.inputs, own.rate_low, own.rate_high, strict=True)
            changes = ", ".join(name for name, low, high in ends if low > -NO_LIMIT or high < NO_LIMIT)
            soft = f", on changes of {changes}{soft}"
        soft += f", inputs {self.delay} period{'s' if self.delay > 1 else ''} late" if self.delay else ""
        return (
            f"<NonlinearPredictiveDesign: {self.horizon} stages of {self.period:g} s, limits on {hard}{soft}, "
            f"{self.sweeps} sweeps, {self.iterations} linearisation{'s' if self.iterations > 1 else ''} a period>"
        )

    @property
    def law_arguments(self) -> Mapping[str, object]:
        """The arguments of `NonlinearPredictive`."""
        names = ("horizon", "period", "sweeps", "iterations", "steps", "Q", "R", "P", "K", "x0", "u0", "delay")
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
    rate_limits: Mapping[str, Pair] | None = None,
    soft_weight: float | Mapping[str, float] | None = None,
    delay: float = 0.0,
    P: Numbers | None = None,
    sweeps: int = 3,
    iterations: int = 1,
    steps: int = 1,
) -> NonlinearPredictiveDesign:
    """Design a nonlinear predictive law for a plant that a computer controls once in a period.

    Parameters
    ----------
    system, period, delay
        The plant linearised at the rest behind the horizon, the period, and the delay of inputs, whole periods, in s.
    Q, R, P, horizon
        Weights of a stage, (nx, nx) semidefinite and (nu, nu) definite, and of the end, (nz, nz), by default the cost
        of LQR, with nz = nx + nu delay / period; and the number of stages, each of a period.
    limits, soft_weight
        Pairs (low, high) by name, in the units of the plant: of inputs, which are kept, and of states and outputs,
        which are soft. A violation d of a soft limit costs w d^2 in a stage; w is one number, or one by name.
    rate_limits
        Pairs of the change of an input in a period, by name, which are kept.
    sweeps, iterations, steps
        Numbers of sweeps of a linearised problem, of linearisations in a period, and of Runge-Kutta steps in a stage.

    Raises
    ------
    ValueError, LookupError, DesignError
        If an argument is out of its range, limits cross, exclude the rest or have no weight, or no signal has a name;
        if the system is sampled already, or no gain stabilises it.

    Examples
    --------
    >>> cart = wb.linearize(wb.open_loop(wb.CartPole()), t=0.0, x=np.zeros(4), at_rest=True)
    >>> wb.nonlinear_predictive_design(cart, 0.02, np.eye(4), [[0.1]], 40, limits={"F": (-10.0, 10.0)})
    <NonlinearPredictiveDesign: 40 stages of 0.02 s, limits on F, 3 sweeps, 1 linearisation a period>
    """
    plant = _plant_and_weights(system, period, Q, R)
    counts = {"horizon": horizon, "sweeps": sweeps, "iterations": iterations, "steps": steps}
    return _design(system, plant, counts, (limits or {}, rate_limits or {}, soft_weight), delay, P)


def _design(
    system: System,
    plant: tuple[float, Names, Array, Array],
    counts: Mapping[str, int],
    named: tuple[Mapping[str, Pair], Mapping[str, Pair], float | Mapping[str, float] | None],
    delay: float,
    P: Numbers | None,
) -> NonlinearPredictiveDesign:
    h, names, q, r = plant
    N, S, M, n = (whole(f"{CALL}({name}=...)", value, least=1, most=MOST) for name, value in counts.items())
    late, (limits, rate_limits, soft_weight) = whole_periods(delay, h, N), named
    A, B = stage_slopes(np.asarray(system.A), np.asarray(system.B), h, n)
    K, end = _behind_horizon(*with_delay(A, B, q, r, late), P)
    rates = rate_ends(rate_limits, names[1])
    if rates is not None and not late:  # the inputs before are states without weight
        K, end = np.pad(K, ((0, 0), (0, len(r)))), np.pad(end, (0, len(r)))
    point = getattr(system, "point", None)
    x0, u0 = (point.x0, point.u0) if isinstance(point, OperatingPoint) else (np.zeros(len(A)), np.zeros(len(r)))
    own = _limits(limits, names, np.asarray(u0), soft_weight)
    if rates is not None:
        own = replace(own, rate_low=rates[0], rate_high=rates[1])
    return NonlinearPredictiveDesign(*names[:2], h, N, S, M, n, q, r, end, K, A, B, own, x0, u0, late)


def _plant_and_weights(system: System, period: float, Q: Numbers, R: Numbers) -> tuple[float, Names, Array, Array]:
    """The period, the names of states, inputs and other outputs of a linear plant, and its weights."""
    h = seconds(f"{CALL}(period=...)", period)
    if not is_system(system) or not hasattr(system, "state_labels"):
        raise refusal(f"{CALL}(system)", "a linear plant, as `linearize` returns it", system)
    if system.dt:
        raise DesignError(f"`{CALL}(system)` must be in continuous time, as the law integrates the plant itself.")
    states, inputs = tuple(system.state_labels), tuple(system.input_labels)
    outputs = tuple(name for name in system.output_labels if name not in states)
    q, r = semidefinite(f"{CALL}(Q=...)", "Q", Q, len(states)), definite(f"{CALL}(R=...)", "R", R, len(inputs))
    return h, (states, inputs, outputs), q, r


def _behind_horizon(A: Array, B: Array, Q: Array, R: Array, P: Numbers | None) -> tuple[Array, Array]:
    """The gain and the cost of the law behind the horizon."""
    if P is None:
        return regulator(A, B, Q, R)
    end = semidefinite(f"{CALL}(P=...)", "P", P, len(A))
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
    limits: Mapping[str, Pair],
    names: Names,
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
            for end in bounds(f"{CALL}(limits={{{name!r}: ...}})", value, (name,))
        )
        if name in inputs:
            i = inputs.index(name)
            low[i], high[i] = a, b
            if not a <= u0[i] <= b:
                raise ValueError(
                    f"`{CALL}(limits=...)` must leave the rest of the plant inside; '{name}' rests at {u0[i]:.4g}. "
                    "Take another rest, or widen the limit."
                )
            continue
        weight = soft_weight.get(name) if isinstance(soft_weight, Mapping) else soft_weight
        if weight is None:
            raise ValueError(
                f"`{CALL}(soft_weight=...)` must have a weight for the limit of '{name}', as limits of states and "
                "outputs are soft: give the cost of a violation by one unit."
            )
        soft.append(name)
        rows.append((a, b, positive(f"{CALL}(soft_weight=...)", weight)))
    if not rows:
        return StageLimits(low, high, (), None, None, None)
    row_low, row_high, row_weight = (np.array(end, dtype=float) for end in zip(*rows, strict=True))
    return StageLimits(low, high, tuple(soft), row_low, row_high, row_weight)
