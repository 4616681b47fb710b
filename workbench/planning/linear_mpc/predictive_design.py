"""The design of a predictive law for a linearised plant: its problem, and the numbers of its solver."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from workbench.core.validation.notebook_display import show
from workbench.core.validation.number_types import Numbers
from workbench.core.validation.refusals import Array, known_name, refusal
from workbench.core.validation.signatures import check_arguments
from workbench.design.control_system import System
from workbench.design.matrices import DesignError, definite, semidefinite
from workbench.planning.linear_mpc.dual_recursion import recursion_numbers
from workbench.planning.linear_mpc.exact_solution import ExactMpc, exact_mpc
from workbench.planning.linear_mpc.limit_rows import MpcLimits, Pair, bounds
from workbench.planning.linear_mpc.linear_problem import LinearMpc
from workbench.planning.linear_mpc.sampled_problem import sampled_mpc
from workbench.planning.linear_mpc.splitting import SplittingNumbers
from workbench.planning.linear_mpc.splitting_metric import splitting_numbers


@dataclass(frozen=True, eq=False)
@show
class PredictiveDesign:
    """A predictive law as it is designed: `ModelPredictive.of(plant, design)` makes the law.

    Parameters
    ----------
    states, inputs
        The names of the plant's states and inputs.
    period
        The period of the computer in s.
    problem
        The problem that is solved in each period, in deviations from the rest.
    numbers
        The constants of the solver, with the number of sweeps and how much a sweep reduces an error.
    """

    states: tuple[str, ...]
    inputs: tuple[str, ...]
    period: float
    problem: LinearMpc
    numbers: SplittingNumbers

    def __repr__(self) -> str:
        n = self.numbers
        proof = "proved" if n.is_proved else "not proved"
        return (
            f"<PredictiveDesign: {self.problem.horizon} stages of {self.period:g} s, limits on "
            f"{', '.join(self.problem.rows.names)}, {n.sweeps} sweeps, contraction {n.contraction:.2g} ({proof})>"
        )

    @cached_property
    def exact(self) -> ExactMpc:
        """The exact solver of the same problem, outside the graph."""
        return exact_mpc(self.problem)

    @property
    def law_arguments(self) -> Mapping[str, object]:
        """The arguments of `ModelPredictive`."""
        own, numbers, nc = recursion_numbers(self.problem), self.numbers, self.problem.rows.count
        nx, nu = len(self.states), len(self.inputs)
        return {
            "state_names": self.states,
            "input_names": self.inputs,
            "period": self.period,
            "horizon": self.problem.horizon,
            "sweeps": numbers.sweeps,
            "A": self.problem.A,
            "B": self.problem.B,
            "K": self.problem.K,
            "S": own.inverse,
            "F": self.problem.rows.F,
            "E": self.problem.rows.E,
            "low": self.problem.rows.low,
            "high": self.problem.rows.high,
            "softness": self.problem.rows.softness,
            "sigma": numbers.sigma[:nc],
            "W": numbers.W,
            "L": numbers.L,
            "cap": numbers.cap,
            "x0": np.zeros(nx) if self.problem.x0 is None else self.problem.x0[:nx],
            "u0": np.zeros(nu) if self.problem.u0 is None else self.problem.u0,
        }


@check_arguments
def predictive_design(
    system: System,
    period: float,
    Q: Numbers,
    R: Numbers,
    horizon: int,
    *,
    limits: Mapping[str, Pair],
    rate_limits: Mapping[str, Pair] | None = None,
    soft_weight: Numbers | None = None,
    delay: float = 0.0,
    sweeps: int | None = None,
    modes: int | None = None,
) -> PredictiveDesign:
    """Design a predictive law for a linearised plant that a computer controls once in a period.

    Parameters
    ----------
    system
        The plant at its rest, as `linearize` gives it.
    period, delay
        Of the computer and of its inputs, in s.
    Q, R, horizon
        Weights of the states, (nx, nx) positive semidefinite, and inputs, (nu, nu) positive definite, for a period; and
        the number of stages.
    limits, rate_limits
        Pairs (low, high) of states and inputs by name, in the units of the plant, and of the change of an input.
    soft_weight
        The weight w of a violation s of a limit of a state, w s^2. By default these limits are hard.
    sweeps
        The number of sweeps in a period. By default it follows from how much a sweep reduces an error.
    modes
        The number of kept modes of the metric. By default it follows from the problem. Designs with equal numbers of
        stages, sweeps and modes are laws of the same size, as a `DesignKnob` needs them.

    Raises
    ------
    ValueError, LookupError
        If an argument is out of its range, limits cross or exclude the rest, or the plant has no signal of a name.
    DesignError
        If no gain stabilises the plant, or no number of sweeps is proved to suffice.

    Examples
    --------
    >>> cart = wb.linearize(wb.open_loop(wb.CartPole()), t=0.0, x=np.zeros(4), at_rest=True)
    >>> wb.predictive_design(cart, 0.02, np.eye(4), [[0.1]], 20, limits={"F": (-3.0, 3.0)})
    <PredictiveDesign: 20 stages of 0.02 s, limits on F, 4 sweeps, contraction 0.25 (proved)>
    """
    names = _names(system, Q, R)
    ends = _limits(names, limits, rate_limits or {}, soft_weight)
    problem = sampled_mpc(system, period, Q, R, horizon, ends, delay=delay)
    _refuse_rest(problem)
    numbers = splitting_numbers(problem, sweeps=sweeps, modes=modes)
    if sweeps is None and not numbers.is_proved:
        raise DesignError(
            "`predictive_design(limits=...)`: no number of sweeps is proved to suffice for hard limits on states, or "
            "for limits on inputs and their rates together, as their rows depend on each other. Make limits on states "
            "soft by `soft_weight`, leave out limits on rates, or give `sweeps` and judge runs by their `residual`."
        )
    return PredictiveDesign(*names, float(period), problem, numbers)


def _names(system: System, Q: Numbers, R: Numbers) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """The names of states and inputs of a linear system; another object and unfit weights are refused."""
    if not hasattr(system, "state_labels"):
        raise refusal("predictive_design(system)", "a linear plant, as `linearize` returns it", system)
    states, inputs = tuple(system.state_labels), tuple(system.input_labels)
    semidefinite("predictive_design(Q=...)", "Q", Q, len(states))
    definite("predictive_design(R=...)", "R", R, len(inputs))
    return states, inputs


def _refuse_rest(problem: LinearMpc) -> None:
    """Refuse limits that exclude the rest, about which the law plans."""
    for name, low, high in zip(problem.rows.names, problem.rows.low, problem.rows.high, strict=True):
        if not low <= 0.0 <= high:
            raise ValueError(
                f"`predictive_design(limits=...)` must leave the rest of the plant inside; that of '{name}' lies "
                f"{low if low > 0 else -high:.4g} outside. Take another rest, or widen the limit."
            )


def _limits(
    names: tuple[tuple[str, ...], tuple[str, ...]],
    limits: Mapping[str, Pair],
    rate_limits: Mapping[str, Pair],
    soft_weight: Numbers | None,
) -> MpcLimits:
    """The limits of a problem from those by name."""
    states, inputs = names
    if not limits and not rate_limits:
        raise refusal("predictive_design(limits=...)", "a limit at least, else take `lqr`", limits)
    for name in limits:
        known_name(name, (*states, *inputs), "states and inputs of the plant")
    for name in rate_limits:
        known_name(name, inputs, "inputs of the plant")
    return MpcLimits(
        inputs=_ends(inputs, limits),
        states=_ends(states, limits),
        rates=_ends(inputs, rate_limits),
        soft_weight=soft_weight,
    )


def _ends(names: tuple[str, ...], limits: Mapping[str, Pair]) -> tuple[Array, Array] | None:
    """The two ends of the limits of some signals, infinite where there are none; None without any."""
    if not any(name in limits for name in names):
        return None
    for name in (name for name in names if name in limits):
        bounds(f"predictive_design(limits={{{name!r}: ...}})", limits[name], (name,))
    pairs = [limits.get(name, (-np.inf, np.inf)) for name in names]
    low, high = (np.array([pair[i] for pair in pairs], dtype=float) for i in (0, 1))
    return low, high
