"""The design of a predictive law for a linearised plant: its problem, and the numbers of its solver."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from workbench.core.claim import Claim
from workbench.core.numbers import Bounds
from workbench.core.validation.notebook_display import show
from workbench.core.validation.number_types import Numbers
from workbench.core.validation.refusals import finite, refusal, whole
from workbench.core.validation.signatures import check_arguments
from workbench.design.control_system import System
from workbench.design.matrices import one_thread
from workbench.planning.linear_mpc.cone_limits import ConeLimit
from workbench.planning.linear_mpc.disturbance_observer import OffsetFree
from workbench.planning.linear_mpc.dual_recursion import columns_of_sweep, recursion_numbers, tracking_gains
from workbench.planning.linear_mpc.exact_solution import ExactMpc, exact_mpc
from workbench.planning.linear_mpc.law_claims import filter_claims, law_claims
from workbench.planning.linear_mpc.limit_rows import NO_LIMIT, Pair
from workbench.planning.linear_mpc.limit_sample import limit_samples
from workbench.planning.linear_mpc.linear_problem import LinearMpc
from workbench.planning.linear_mpc.named_limits import named_limits, refuse_rest, signal_names
from workbench.planning.linear_mpc.offset_design import OutputPoint, offset_design
from workbench.planning.linear_mpc.sampled_problem import sampled_mpc
from workbench.planning.linear_mpc.splitting import ADMM, SplittingNumbers
from workbench.planning.linear_mpc.sweep_choice import SweepEvidence, choose_sweeps, method_in_words
from workbench.planning.linear_mpc.terminal_ellipsoid import terminal_set

RESIDUALS = 2.0  # times the largest residual of the sample: a run beyond it is one that the sample does not judge
ROUNDING = 1e-6
MOST_MODES = 32


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
        The constants of the solver, with its method and the number of sweeps.
    evidence
        The sample of closed loops from which they were derived, and the errors in it.
    claims
        What is proved of the exact law, with hypotheses, and what is only sampled of the law with its sweeps.
    offset, outputs
        The numbers of the disturbance observer, and the outputs that the law follows without offset; None without.
    """

    states: tuple[str, ...]
    inputs: tuple[str, ...]
    period: float
    problem: LinearMpc
    numbers: SplittingNumbers
    evidence: SweepEvidence
    claims: tuple[Claim, ...]
    offset: OffsetFree | None = None
    outputs: OutputPoint | None = None

    def __repr__(self) -> str:
        method = method_in_words(self.numbers)
        return (
            f"<PredictiveDesign: {self.problem.horizon} stages of {self.period:g} s, limits on "
            f"{', '.join(dict.fromkeys(self.problem.rows.names))}, {self.numbers.sweeps} {method}, "
            f"error {self.evidence.largest_error:.1g}, in other loops {self.evidence.other_error:.1g} (sampled, not "
            "proved)>"
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
        admm = numbers.method == ADMM
        gains = tracking_gains(self.problem, numbers.sigma[:nc]) if admm else (None, None)
        return {
            "names": (self.states, self.inputs),
            "output_names": () if self.outputs is None else self.outputs.names,
            "period": self.period,
            "horizon": self.problem.horizon,
            "sweeps": numbers.sweeps,
            "A": self.problem.A,
            "B": self.problem.B,
            "K": self.problem.K,
            "S": own.inverse,
            "F": self.problem.rows.F,
            "E": self.problem.rows.E,
            "low": np.maximum(self.problem.rows.low, -NO_LIMIT),
            "high": np.minimum(self.problem.rows.high, NO_LIMIT),
            "softness": self.problem.rows.softness,
            "sigma": numbers.sigma[:nc],
            "W": numbers.W,
            "L": numbers.L,
            "cap": numbers.cap,
            "x0": np.zeros(nx) if self.problem.x0 is None else self.problem.x0[:nx],
            "u0": np.zeros(nu) if self.problem.u0 is None else self.problem.u0,
            "Y": numbers.Y.T,
            "D": columns_of_sweep(numbers),
            "gains": gains[0],
            "inverses": gains[1],
            "rates": numbers.rates,
            "cones": self.problem.rows.cones,
            "residual_bounds": Bounds(high=RESIDUALS * self.evidence.largest_residual + ROUNDING),
            "target": None if self.offset is None else self.offset.target,
            "y0": None if self.outputs is None else self.outputs.y0,
        }

    @property
    def filter_arguments(self) -> Mapping[str, object]:
        """The terminal ellipsoid, for `SafetyFilter`; a DesignError where the problem has none."""
        ends = terminal_set(self.problem)
        return {"P": ends.P, "level": ends.level}

    @property
    def filter_claims(self) -> tuple[Claim, ...]:
        """The claims on a `SafetyFilter` of this design, with hypotheses; a DesignError as `filter_arguments`."""
        return filter_claims(terminal_set(self.problem))

    @property
    def observer_arguments(self) -> Mapping[str, object]:
        """The arguments of `OffsetFreeObserver`; empty for a design without `offset_free`."""
        own, outputs = self.offset, self.outputs
        if own is None or outputs is None:
            return {}
        nx = len(self.states)
        return {
            "names": (self.states, self.inputs),
            "output_names": outputs.readings,
            "period": self.period,
            "A": own.A,
            "B": own.B,
            "Bd": own.Bd,
            "C": own.C,
            "Cd": own.Cd,
            "L": own.L,
            "x0": np.zeros(nx) if self.problem.x0 is None else self.problem.x0[:nx],
            "u0": np.zeros(len(self.inputs)) if self.problem.u0 is None else self.problem.u0,
            "y0": outputs.readings_y0,
        }


@check_arguments
@one_thread()
def predictive_design(
    system: System,
    period: float,
    Q: Numbers,
    R: Numbers,
    horizon: int,
    *,
    limits: Mapping[str, Pair],
    rate_limits: Mapping[str, Pair] | None = None,
    cones: tuple[ConeLimit, ...] = (),
    soft_weight: Numbers | None = None,
    delay: float = 0.0,
    sweeps: int | None = None,
    modes: int | None = None,
    accuracy: float = 1e-2,
    offset_free: tuple[str, ...] = (),
) -> PredictiveDesign:
    """Design a predictive law for a linearised plant that a computer controls once in a period.

    Parameters
    ----------
    system
        The plant at its rest, as `linearize` gives it.
    period, delay
        Of the computer and of its inputs, in s.
    Q, R, horizon
        Weights of a period, (nx, nx) semidefinite and (nu, nu) positive definite, and the number of stages.
    limits, rate_limits, cones
        Pairs (low, high) of states, else outputs, and inputs by name; and of the change of an input in a period; and
        hard limits |lateral - centre| <= slope axial + offset of inputs, or of states.
    soft_weight
        Weight w of a violation s of a limit of a state or an output, w s^2; by default these limits are hard.
    sweeps, modes, accuracy
        Numbers of sweeps and of kept modes; by default the cheapest metric, or ADMM, that errs by at most `accuracy`
        spans of an input along a sample of loops of the exact law, and in the cost of these and others: not proved.
    offset_free
        Names of outputs that reach references under a constant disturbance or a wrong gain, by `OffsetFreeObserver`.

    Raises
    ------
    ValueError, LookupError, DesignError
        If an argument is out of its range, limits cross or exclude the rest, or the plant has no signal of a name; if
        no gain stabilises the plant, no number of sweeps is accurate enough, or a disturbance cannot be observed.

    Examples
    --------
    >>> cart = wb.linearize(wb.open_loop(wb.CartPole()), t=0.0, x=np.zeros(4), at_rest=True)
    >>> design = wb.predictive_design(cart, 0.02, np.eye(4), [[0.1]], 20, limits={"F": (-3.0, 3.0)})
    >>> design.numbers.sweeps, design.evidence.largest_error < 1e-2
    (3, True)
    """
    names = signal_names(system, Q, R)
    ends = named_limits(system, names, limits, rate_limits or {}, soft_weight, cones)
    refuse_rest(problem := sampled_mpc(system, period, Q, R, horizon, ends, delay=delay))
    follows = offset_design(system, problem, float(period), float(delay), offset_free) if offset_free else (None, None)
    chosen = _sweeps(problem, len(names[0]), accuracy, sweeps, modes)
    return PredictiveDesign(*names, float(period), problem, *chosen, law_claims(problem, *chosen), *follows)


def _sweeps(
    problem: LinearMpc, plant_states: int, accuracy: float, sweeps: int | None, modes: int | None
) -> tuple[SplittingNumbers, SweepEvidence]:
    """The constants of the law, and the sample from which they follow."""
    wanted = finite("predictive_design(accuracy=...)", accuracy, low=1e-9, high=0.5)
    count = None if sweeps is None else whole("predictive_design(sweeps=...)", sweeps, 1, 10_000, " of sweeps")
    exact = exact_mpc(problem)
    if modes is not None and problem.rows.cones:
        raise refusal("predictive_design(modes=...)", "left out where a limit is a cone, which takes ADMM", modes)
    if modes is not None:
        modes = whole("predictive_design(modes=...)", modes, 0, min(MOST_MODES, len(exact.numbers.low)), " of modes")
    return choose_sweeps(exact, limit_samples(exact, plant_states), wanted, count, modes)
