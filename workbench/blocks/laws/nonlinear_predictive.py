from __future__ import annotations

from collections.abc import Mapping
from functools import partial

import casadi as ca
import numpy as np

from workbench.blocks.laws.plan_checks import refuse_unfit_plan
from workbench.blocks.laws.plan_disturbances import disturbances_of, with_disturbances
from workbench.blocks.laws.plan_iterations import LARGEST, NonlinearPlan, PeriodProblem, SolvedPeriod
from workbench.blocks.laws.plan_targets import WINDOW, PlanTargets
from workbench.blocks.laws.plant_stages import PlantStages
from workbench.blocks.laws.predicted_signals import predicted_signals, predicted_units
from workbench.blocks.laws.predictive_fallback import FORMS, WARM, Fallback, PeriodVerdict
from workbench.blocks.laws.predictive_ports import all_finite, column, refuse_other_signals, safe_inputs
from workbench.blocks.laws.queued_stages import QueuedStages
from workbench.blocks.laws.stagewise_sweeps import StageWeights
from workbench.blocks.loop.contracts import AbstractController, AbstractPlant, Follows, Parts, Reads
from workbench.blocks.loop.environment import AbstractReference
from workbench.core import Entry, Layout, Signals, block, parameter
from workbench.core.block import Matrix, Number, Vector, option
from workbench.core.bounded_loop import bounded_loop
from workbench.core.units import ANY
from workbench.core.validation.refusals import refusal, seconds, whole


@block
class NonlinearPredictive(AbstractController):
    """Nonlinear model predictive control by real-time iterations: in each period one step toward the best plan.

    The plan of N stages minimises the sum of e'Q e + v'R v over the stages and e'P e behind the last, with e and v the
    deviations of states and inputs from the reference. Its stages obey the plant's own equations, and its inputs keep
    low <= u <= high. Once a period the law

    1. rolls the last plan, shifted by a stage, from the estimate on, with its gains, and linearises the plant along it;
    2. makes a fixed number of sweeps of the linearised problem, see `stagewise_sweeps`;
    3. rolls the plant along shares of the step, with gains and limits, and sends the first input of the cheapest.

    Where no limit acts and the plant is linear, u = u0 - K (x - x0): the law is LQR with the cost P behind N stages.
    `NonlinearPredictive.of` makes the law of a design.

    The memory `residual` is the largest change of an input by the last sweep, as a share of the distance between its
    limits, or in its unit if it has no two. `cost` is that of the plan. `share` is that of the way to
    the solution of the linearised problem, 0 for the last plan and -1 for the law behind the horizon.

    Parameters
    ----------
    model
        The plant as the law believes it to be, or its `InputDisturbances`: all states are read, all inputs driven.
    horizon, period
        The number N of stages, and their length in s, with which a computer runs the law.
    sweeps, iterations, steps
        Numbers of sweeps of a linearised problem, of linearisations in a period, and of Runge-Kutta steps in a stage.
    Q, R, P
        Weights of a stage, (nx, nx) and (nu, nu), and of the end, (nz, nz).
    K
        Gain (nu, nz) of the law behind the horizon, by which the plan grows by a stage.
    low, high
        Limits of the inputs, (nu,), of size 1e30 where there is none.
    row_names
        Labels of states and outputs with soft limits.
    row_low, row_high, row_weight
        Their limits and weights, (nr,): a violation d costs row_weight d^2 in a stage. None without such limits.
    rate_low, rate_high
        Limits of the change of each input in a period, (nu,), None without.
    delay
        The number of periods until an input acts. Behind the nx states of the model stand, in nz states, the inputs on
        their way, oldest first; with limits of changes without a delay, the inputs before.
    x0, u0
        The rest, in the units of the plant.
    follow
        Names of the states whose reference replaces their value in x0, at all stages.
    preview
        A reference of states and inputs by name, such as a `PlannedReference`, that the plan follows stage by stage in
        the place of the rest. The loop must have the same reference. Signals that the plant has not are left out.
    safe_command
        Inputs (nu,) for a period in which a number that the law reads is not finite, or no plan has a finite cost. None
        to leave such numbers to the run, which they end.
    fallback, residual_bound
        "warm", "safe_command", "last_good" or "cold", for what the law does in a period in which such a number is not
        finite or the residual passes its bound: see `predictive_fallback`. A run with such a period is flagged.

    References
    ----------
    Diehl, Bock and Schloeder (2005), A real-time iteration scheme for nonlinear optimization in optimal feedback
    control, SIAM Journal on Control and Optimization 43. Tassa, Mansard and Todorov (2014), Control-limited
    differential dynamic programming, ICRA.

    Examples
    --------
    >>> plant = wb.CartPole()
    >>> cart = wb.linearize(wb.open_loop(plant), t=0.0, x=np.zeros(4), at_rest=True)
    >>> design = wb.nonlinear_predictive_design(cart, 0.02, np.eye(4), [[0.1]], 20, limits={"F": (-10.0, 10.0)})
    >>> law = wb.NonlinearPredictive.of(plant, design, follow=("x",))
    >>> law.reads.names, law.follows.names, law.period
    (('x', 'xd', 'phi', 'phid'), ('x',), 0.02)
    """

    model: AbstractPlant
    horizon: int
    Q: Matrix = parameter(unit=ANY, shape=("nx", "nx"))
    R: Matrix = parameter(unit=ANY, shape=("nu", "nu"))
    P: Matrix = parameter(unit=ANY, shape=("nz", "nz"))
    K: Matrix = parameter(unit=ANY, shape=("nu", "nz"))
    low: Vector = parameter(unit=ANY, shape=("nu",))
    high: Vector = parameter(unit=ANY, shape=("nu",))
    x0: Vector = parameter(unit=ANY, shape=("nx",), symbol="x_0")
    u0: Vector = parameter(unit=ANY, shape=("nu",), symbol="u_0")
    period: float
    row_names: tuple[str, ...] = ()
    row_low: Vector | None = parameter(default=None, unit=ANY, shape=("nr",))
    row_high: Vector | None = parameter(default=None, unit=ANY, shape=("nr",))
    row_weight: Vector | None = parameter(default=None, unit=ANY, shape=("nr",))
    rate_low: Vector | None = parameter(default=None, unit=ANY, shape=("nu",))
    rate_high: Vector | None = parameter(default=None, unit=ANY, shape=("nu",))
    delay: int = 0
    sweeps: int = 3
    iterations: int = 1
    steps: int = 1
    follow: tuple[str, ...] = ()
    preview: AbstractReference | None = None
    safe_command: Vector | None = parameter(default=None, unit=ANY, shape=("nu",), symbol="u_safe")
    fallback: str = option(FORMS, default=WARM)
    residual_bound: float | None = parameter(default=None, unit=ANY, low=0.0, strict=True, symbol="r_max")

    def __post_init__(self) -> None:
        for name in ("horizon", "sweeps", "iterations", "steps"):
            whole(f"NonlinearPredictive({name}=...)", getattr(self, name), least=1)
        whole("NonlinearPredictive(delay=...)", self.delay, least=0)
        seconds("NonlinearPredictive(period=...)", self.period)
        names = self.follow, self.row_names
        refuse_unfit_plan("NonlinearPredictive", self.model, *names, self.preview)
        self._fallback.refuse_unfit("NonlinearPredictive")

    @staticmethod
    def of(
        plant: AbstractPlant,
        design: object,
        follow: tuple[str, ...] = (),
        preview: AbstractReference | None = None,
        safe_command: Mapping[str, float] | None = None,
        fallback: str = WARM,
        residual_bound: float | None = None,
    ) -> NonlinearPredictive:
        """The law of a design for a plant, once in its period. It reads an estimate of each state.

        Parameters
        ----------
        plant
            The plant, which is the model of the law.
        design
            The result of `nonlinear_predictive_design` for the linearised plant.
        follow, preview, fallback, residual_bound
            As of the class; a reference is followed or previewed.
        safe_command
            Inputs by name, within their limits, for a period in which a number that the law reads is not finite.

        Raises
        ------
        ValueError
            If `design` is no such result, or is for other states or inputs; if the preview has a signal of another
            shape or unit, or an end; or if the safe command lacks an input or passes a limit.
        LookupError
            If the plant has no signal of a name.
        """
        own = getattr(design, "law_arguments", None)
        if not isinstance(own, dict) or "row_weight" not in own:
            raise refusal("NonlinearPredictive.of(design=...)", "the result of `nonlinear_predictive_design`", design)
        own = dict(own)
        refuse_other_signals("NonlinearPredictive.of(plant, design)", plant, own.pop("names"), disturbances_of(plant))
        ends = (np.asarray(own[end], dtype=float) for end in ("low", "high"))
        safe = safe_inputs("NonlinearPredictive.of", plant.inputs, safe_command, *ends)
        own |= {"safe_command": safe, "fallback": fallback, "residual_bound": residual_bound}
        own |= with_disturbances(own, plant)
        return NonlinearPredictive(plant, **own, follow=follow, preview=preview)

    # ports

    @property
    def reads(self) -> Layout:
        return self.model.states

    @property
    def follows(self) -> Layout:
        if self.preview is not None:
            own = self.model.states + self.model.inputs
            return Layout(tuple(entry for entry in self.preview.gives.entries if entry.name in own))
        return Layout(tuple(self.model.states[name] for name in self.follow))

    @property
    def drives(self) -> Layout:
        return self.model.inputs

    @property
    def _counts(self) -> tuple[int, int, int]:
        """The numbers of states, with the last inputs, of inputs, and of stages."""
        return self.model.states.size + self._waiting, self.model.inputs.size, self.horizon

    @property
    def _waiting(self) -> int:
        """The number of entries of the last inputs."""
        return max(self.delay, 0 if self.rate_low is None else 1) * self.model.inputs.size

    @property
    def memory(self) -> Layout:
        """The plan in deviations from the rest, so that all begin at zero, with its gains and what it is worth."""
        nx, nu, N = self._counts
        sizes = {"plan_x": nx * N, "plan_u": nu * N, "clamps": nu * N, "gains": nu * nx * N}
        plan = [Entry(name, np.zeros(size), ANY) for name, size in sizes.items()]
        worth = [Entry(name, np.zeros(()), ANY) for name in ("residual", "cost", "share")]
        sent = [Entry("sent", np.zeros(self._waiting), ANY)] if self._waiting else []
        spare = *sent, *self._fallback.memory(nu, N)
        return Layout((*plan, *worth, *spare, *self._targets.memory(N)))

    # equations

    def command(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Signals:
        return Signals(self.model.inputs.view(self._sent(z, self._solve(t, z, est, ref))))

    def _sent(self, z: Parts, one: SolvedPeriod) -> ca.SX:
        u = self._fallback.chosen_input(z, self._verdict(one), one.input, one.behind_horizon, one.clip)
        return u if self.rate_low is None else one.clip(u)

    def update(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Parts:
        """The plan shifted by a stage, which the law behind the horizon adds, and what the plan was worth."""
        one = self._solve(t, z, est, ref)
        plan, inputs = one.plan, one.plan.u + ca.repmat(ca.SX(self.u0), 1, self.horizon)
        worth = {"residual": plan.residual, "cost": plan.cost, "share": plan.share}
        following = self._fallback.following(z, self._verdict(one), one.next_plan, worth, inputs)
        if self._waiting:
            following["sent"] = ca.vertcat(z["sent"], self._sent(z, one) - self.u0)[inputs.shape[0] :]
        if WINDOW in z:
            following[WINDOW] = self._targets.next_window(t, z[WINDOW], self.horizon)
        return following

    @property
    def _fallback(self) -> Fallback:
        return Fallback.of(self.fallback, self.safe_command, self.residual_bound)

    def _verdict(self, one: SolvedPeriod) -> PeriodVerdict:
        return self._fallback.verdict(one.readable, ca.fabs(one.plan.cost) <= LARGEST, one.plan.residual)

    @property
    def _targets(self) -> PlanTargets:
        rest, last = (self.x0, self.u0), self._waiting // self.model.inputs.size
        return PlanTargets(self.model, rest, self.follows, self.preview, self.period, self.delay, last)

    @property
    def _weights(self) -> StageWeights:
        names = ("R", "P", "low", "high", "row_low", "row_high", "row_weight", "rate_low", "rate_high")
        none, Q = ca.SX(0, 1), ca.diagcat(ca.SX(self.Q), ca.SX.zeros(self._waiting, self._waiting))
        return StageWeights(Q, *(none if getattr(self, n) is None else ca.SX(getattr(self, n)) for n in names))

    def signals(self, z: Parts, est: Reads, ref: Follows) -> Parts:
        """The plan of the period before from now on: `predicted_t`, and the states and inputs at these times."""
        (nx, nu, N), model = self._counts, self.model
        states = model.states, ca.reshape(z["plan_x"], nx, N)[: model.states.size, :], self.x0
        inputs = model.inputs, ca.reshape(z["plan_u"], nu, N), self.u0
        return predicted_signals((states, inputs), self.period)

    @property
    def signal_units(self) -> Mapping[str, str]:
        return predicted_units(self.model.states, self.model.inputs)

    def _problem(self, t: ca.SX, z: Parts, ref: Follows) -> PeriodProblem:
        """The problem of a period."""
        nx, nu, N = self.model.states.size, self.model.inputs.size, self.horizon
        targets, u0 = self._targets, ca.SX(self.u0)

        def target(k: ca.SX, own: ca.SX) -> tuple[ca.SX, ca.SX]:
            return targets.at(t + k * self.period, own, ref)

        rest = ca.vertcat(ca.SX(self.x0), *[u0] * (self._waiting // nu)), u0, ca.SX(self.K)
        stages = QueuedStages(PlantStages(self.model, self.period, self.steps), nx, self._waiting, self.delay > 0)
        rows = partial(stages.rows, self.row_names)
        window = ca.reshape(z[WINDOW], -1, N + 1) if WINDOW in z else ca.SX(0, N + 1)
        d = slice(nx - disturbances_of(self.model).size, nx)
        return PeriodProblem(stages, self._weights, *rest, N, self.sweeps, t, target, window, rows, d)

    def _solve(self, t: ca.SX, z: Parts, est: Reads, ref: Follows) -> SolvedPeriod:
        """The plan of a period; one from the rest where a number that the law reads is not finite."""
        nx, nu, N = self._counts
        begin, readable = ca.densify(column(est, self.model.states)), None
        if self.safe_command is not None:
            readable = all_finite(ca.vertcat(begin, column(ref, self.follows)))
            begin = ca.if_else(readable, begin, ca.SX(self.x0))
            rest = self.model.states.view(ca.SX(self.x0)) | self.model.inputs.view(ca.SX(self.u0))
            ref = Signals({name: ca.if_else(readable, ref[name], rest[name]) for name in self.follows.names})
        if self._waiting:
            begin = ca.vertcat(begin, z["sent"] + ca.repmat(ca.SX(self.u0), self._waiting // nu, 1))
        x, u = ca.reshape(z["plan_x"], nx, N), ca.reshape(z["plan_u"], nu, N)
        parts = ca.reshape(z["clamps"], nu, N), ca.reshape(z["gains"], nu * nx, N), begin, *[ca.SX(0.0)] * 3
        problem, last = self._problem(t, z, ref), NonlinearPlan(x, u, *parts)

        def iteration(numbers: ca.SX, begin: ca.SX) -> tuple[ca.SX, ...]:
            return (problem.iterate(begin, NonlinearPlan.of(numbers, N, nx, nu)).column,)

        (numbers,) = bounded_loop(self.iterations, iteration, last.column, constants=(begin,))
        return SolvedPeriod(problem, begin, NonlinearPlan.of(numbers, N, nx, nu), readable)
