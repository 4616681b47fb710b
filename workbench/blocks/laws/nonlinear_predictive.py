from __future__ import annotations

import casadi as ca
import numpy as np

from workbench.blocks.laws.plant_stages import NonlinearPlan, PlantStages
from workbench.blocks.laws.stagewise_sweeps import (
    Iterate,
    StageRows,
    StageWeights,
    better_flags,
    choose,
    solve_stages,
)
from workbench.blocks.loop.contracts import AbstractController, AbstractPlant, Follows, Parts, Reads
from workbench.blocks.loop.environment import AbstractReference
from workbench.blocks.loop.wiring import call_block
from workbench.blocks.observers.observer_model import jacobian
from workbench.core import Entry, Layout, Signals, block, parameter
from workbench.core.block import Matrix, Number, Vector
from workbench.core.bounded_loop import bounded_loop
from workbench.core.units import ANY
from workbench.core.validation.refusals import known_name, refusal, seconds, whole

SHARES = (1.0, 0.5, 0.25, 0.0)  # of the way from the last plan to the solution of a linearised problem
LARGEST = 1e100  # an estimate beyond it, or none, is no number to plan from


@block
class NonlinearPredictive(AbstractController):
    """Nonlinear model predictive control by real-time iterations: in each period one step toward the best plan.

    The plan of N stages minimises the sum of e'Q e + v'R v over the stages and e'P e behind the last, with e and v the
    deviations of states and inputs from the reference. Its stages obey the plant's own equations, and its inputs keep
    low <= u <= high. Once a period the law

    1. rolls the last plan, shifted by a stage, from the estimate on, with its gains, and linearises the plant along it;
    2. makes a fixed number of sweeps of the linearised problem, see `stagewise_sweeps`;
    3. rolls the plant along shares of the step, with gains and limits, takes the one of least cost, and sends its first
       input.

    Where no limit acts and the plant is linear, u = u0 - K (x - x0): the law is LQR with the cost P behind N stages.
    `NonlinearPredictive.of` makes the law of a design.

    The memory `residual` is the largest change of an input by the last sweep, as a share of the distance between its
    limits, or in its unit if it has no two. `cost` is that of the plan, and `share` that of the step. An estimate that is
    no finite number is replaced by the state that the plan predicts.

    Parameters
    ----------
    model
        The plant as the law believes it to be. All its states are read, and all its inputs are driven.
    horizon, period
        The number N of stages, and their length in s, with which a computer runs the law.
    sweeps, iterations, steps
        The numbers of sweeps of a linearised problem, of linearisations in a period, and of Runge-Kutta steps in a
        stage.
    Q, R, P
        Weights of a stage, (nx, nx) and (nu, nu), and of the end, (nx, nx).
    K
        Gain (nu, nx) of the law behind the horizon, by which the plan grows by a stage.
    low, high
        Limits of the inputs, (nu,), infinite where there is none.
    limited
        Names of states and outputs with soft limits.
    row_low, row_high, row_weight
        Their limits and weights, (nr,): a violation d costs row_weight d^2 in a stage.
    x0, u0
        The rest, in the units of the plant.
    follow
        Names of the states whose reference replaces their value in x0, at all stages.
    preview
        A reference of states and inputs by name, such as a `PlannedReference`, that the plan follows stage by stage in
        the place of the rest. The loop must have the same reference.

    References
    ----------
    Diehl, Bock and Schloeder (2005), A real-time iteration scheme for nonlinear optimization in optimal feedback control,
    SIAM Journal on Control and Optimization 43. Tassa, Mansard and Todorov (2014), Control-limited differential dynamic
    programming, ICRA.

    Examples
    --------
    >>> plant = wb.CartPole()
    >>> cart = wb.linearize(wb.open_loop(plant), t=0.0, x=np.zeros(4), at_rest=True)
    >>> design = wb.nonlinear_predictive_design(cart, 0.02, np.eye(4), [[0.1]], 40, limits={"F": (-10.0, 10.0)})
    >>> law = wb.NonlinearPredictive.of(plant, design, follow=("x",))
    >>> law.reads.names, law.follows.names, law.period
    (('x', 'xd', 'phi', 'phid'), ('x',), 0.02)
    """

    model: AbstractPlant
    horizon: int
    Q: Matrix = parameter(unit=ANY, shape=("nx", "nx"))
    R: Matrix = parameter(unit=ANY, shape=("nu", "nu"))
    P: Matrix = parameter(unit=ANY, shape=("nx", "nx"))
    K: Matrix = parameter(unit=ANY, shape=("nu", "nx"))
    low: Vector = parameter(unit=ANY, shape=("nu",))
    high: Vector = parameter(unit=ANY, shape=("nu",))
    row_low: Vector = parameter(unit=ANY, shape=("nr",))
    row_high: Vector = parameter(unit=ANY, shape=("nr",))
    row_weight: Vector = parameter(unit=ANY, shape=("nr",))
    x0: Vector = parameter(unit=ANY, shape=("nx",), symbol="x_0")
    u0: Vector = parameter(unit=ANY, shape=("nu",), symbol="u_0")
    period: float
    limited: tuple[str, ...] = ()
    sweeps: int = 3
    iterations: int = 1
    steps: int = 1
    follow: tuple[str, ...] = ()
    preview: AbstractReference | None = None

    def __post_init__(self) -> None:
        for name, value in (("horizon", self.horizon), ("sweeps", self.sweeps), ("steps", self.steps)):
            whole(f"NonlinearPredictive({name}=...)", value, least=1)
        whole("NonlinearPredictive(iterations=...)", self.iterations, least=1)
        seconds("NonlinearPredictive(period=...)", self.period)
        for name in self.follow:
            known_name(name, self.model.states.names, "states of the model")
        for name in self.limited:
            known_name(name, (self.model.states + self._others).names, "states and outputs of the model")
        if self.preview is not None:
            for name in self.preview.gives.names:
                known_name(name, (self.model.states + self.model.inputs).names, "states and inputs of the model")

    @staticmethod
    def of(
        plant: AbstractPlant, design: object, follow: tuple[str, ...] = (), preview: AbstractReference | None = None
    ) -> NonlinearPredictive:
        """The law of a design for a plant. It reads an estimate of each state.

        Parameters
        ----------
        plant
            The plant, which is the model of the law.
        design
            The result of `nonlinear_predictive_design` for the linearised plant.
        follow, preview
            As of the class; one of them alone.

        Raises
        ------
        ValueError
            If `design` is no such result, or is for other states or inputs.
        LookupError
            If the plant has no signal of a name.
        """
        own = getattr(design, "law_arguments", None)
        if not isinstance(own, dict) or "row_weight" not in own:
            raise refusal("NonlinearPredictive.of(design=...)", "the result of `nonlinear_predictive_design`", design)
        for port, names in ((plant.states, own["state_names"]), (plant.inputs, own["input_names"])):
            if port.labels != names:
                raise ValueError(
                    f"`NonlinearPredictive.of(plant, design)` must get a design for the plant's own signals, "
                    f"{', '.join(port.labels)}; it is for {', '.join(names)}."
                )
        numbers = {name: value for name, value in own.items() if name not in ("state_names", "input_names")}
        return NonlinearPredictive(plant, **numbers, follow=follow, preview=preview)

    # ports

    @property
    def reads(self) -> Layout:
        return self.model.states

    @property
    def follows(self) -> Layout:
        if self.preview is not None:
            return self.preview.gives
        return Layout(tuple(self.model.states[name] for name in self.follow))

    @property
    def drives(self) -> Layout:
        return self.model.inputs

    @property
    def _others(self) -> Layout:
        """The outputs that are no states."""
        return Layout(tuple(e for e in self.model.outputs.entries if e.name not in self.model.states))

    @property
    def _counts(self) -> tuple[int, int, int]:
        return self.model.states.size, self.model.inputs.size, self.horizon

    @property
    def memory(self) -> Layout:
        """The plan in deviations from the rest, so that all begin at zero, with its gains and what it is worth."""
        nx, nu, N = self._counts
        sizes = {"plan_x": nx * N, "plan_u": nu * N, "clamps": nu * N, "gains": nu * nx * N}
        entries = tuple(Entry(name, np.zeros(size), ANY) for name, size in sizes.items())
        return Layout((*entries, *(Entry(name, np.zeros(()), ANY) for name in ("residual", "cost", "share"))))

    # equations

    def command(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Signals:
        return Signals(self.model.inputs.view(self._solve(t, z, est, ref).u[:, 0]))

    def update(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Parts:
        """The plan shifted by a stage, which the law behind the horizon adds, and what the plan was worth."""
        (nx, nu, N), plan = self._counts, self._solve(t, z, est, ref)
        r, s = self._reference(t, ca.SX(N), ref)
        last = self._weights.clip(s - self.K @ (plan.end - r))
        following = {
            "plan_x": ca.vec(ca.horzcat(plan.x[:, 1:], plan.end) - ca.repmat(ca.SX(self.x0), 1, N)),
            "plan_u": ca.vec(ca.horzcat(plan.u[:, 1:], last) - ca.repmat(ca.SX(self.u0), 1, N)),
            "clamps": ca.vec(ca.horzcat(plan.clamps[:, 1:], ca.SX.zeros(nu))),
            "gains": ca.vec(ca.horzcat(plan.gains[:, 1:], ca.vec(ca.SX(self.K)))),
            "residual": plan.residual,
            "cost": plan.cost,
            "share": plan.share,
        }
        worth = ca.fabs(plan.cost) <= LARGEST  # else the next plan begins at the rest
        return {name: ca.if_else(worth, part, 0.0) for name, part in following.items()}

    @property
    def _weights(self) -> StageWeights:
        names = ("Q", "R", "P", "low", "high", "row_low", "row_high", "row_weight")
        return StageWeights(*(ca.SX(getattr(self, name)) for name in names))

    @property
    def _stages(self) -> PlantStages:
        return PlantStages(self.model, self.period, self.steps)

    def _reference(self, t: ca.SX, k: ca.SX, ref: Follows) -> tuple[ca.SX, ca.SX]:
        """The states and inputs that are wanted at stage k of a plan at time t."""
        states, inputs = self.model.states, self.model.inputs
        wanted = {name: ref[name] for name in self.follow}
        if self.preview is not None:
            wanted = dict(call_block(self.preview, "at", self.preview.gives, t + k * self.period))
        r, s = ({**port.view(ca.SX(rest))} for port, rest in ((states, self.x0), (inputs, self.u0)))
        for name, part in wanted.items():
            (r if name in states else s)[name] = part
        return ca.densify(states.flatten(r)), ca.densify(inputs.flatten(s))

    def _rows(self, t: ca.SX, x: ca.SX) -> ca.SX:
        """The states and outputs with soft limits, (nr, 1)."""
        if not self.limited:
            return ca.SX(0, 1)
        signals = Signals(self.model.states.view(x))
        if any(name not in signals for name in self.limited):
            outputs = self.model.outputs + self.model.truths
            signals = call_block(self.model, "measure", outputs, t, signals) | signals
        return ca.densify(ca.vertcat(*(ca.vec(ca.SX(signals[name])) for name in self.limited)))

    def _solve(self, t: ca.SX, z: Parts, est: Reads, ref: Follows) -> NonlinearPlan:
        """The plan of a period."""
        nx, nu, N = self._counts
        x = ca.reshape(z["plan_x"], nx, N) + ca.repmat(ca.SX(self.x0), 1, N)
        u = ca.reshape(z["plan_u"], nu, N) + ca.repmat(ca.SX(self.u0), 1, N)
        seen = ca.densify(self.model.states.flatten({name: est[name] for name in self.model.states.names}))
        usable = ca.mmax(ca.vertcat(*(ca.if_else(ca.fabs(seen[i]) <= LARGEST, 0.0, 1.0) for i in range(nx)))) == 0
        begin = ca.if_else(usable, seen, x[:, 0])
        worth = ca.SX.zeros(3)
        plan = NonlinearPlan(x, u, ca.reshape(z["clamps"], nu, N), ca.reshape(z["gains"], nu * nx, N), begin, *worth.elements())

        def iteration(column: ca.SX, begin: ca.SX) -> tuple[ca.SX, ...]:
            return (self._iterate(t, begin, NonlinearPlan.of(column, N, nx, nu), ref).column,)

        (column,) = bounded_loop(self.iterations, iteration, plan.column, constants=(begin,))
        return NonlinearPlan.of(column, N, nx, nu)

    def _iterate(self, t: ca.SX, begin: ca.SX, last: NonlinearPlan, ref: Follows) -> NonlinearPlan:
        """The plan after one linearisation about the last one, from the state `begin` on."""
        nx, nu, _ = self._counts
        rows = self._linearise(t, begin, last, ref)
        u = rows.columns[nx : nx + nu, :]
        way = solve_stages(self._weights, rows, u, last.clamps, self._scale, self.sweeps)
        return self._roll(t, begin, way, rows, ref)

    def _linearise(self, t: ca.SX, begin: ca.SX, last: NonlinearPlan, ref: Follows) -> StageRows:
        """The problem about the last plan, rolled from the state `begin` on with its gains."""
        (nx, nu, N), weights = self._counts, self._weights

        def stage(c: ca.SX, x: ca.SX, u: ca.SX, gains: ca.SX) -> tuple[ca.SX, ...]:
            now, k = c[:nx], c[nx]
            own = weights.clip(u - ca.reshape(gains, nu, nx) @ (now - x))
            after, A, B = self._stages.after_with_slopes(t + k * self.period, now, own)
            r, s = self._reference(t, k, ref)
            y, C = jacobian(lambda v: self._rows(t + k * self.period, v), now)
            return ca.vertcat(after, k + 1), ca.veccat(now, own, A, B, r, s, y, C)

        end, columns = bounded_loop(N, stage, ca.vertcat(begin, 0.0), last.x, last.u, last.gains)
        return StageRows(columns, end[:nx] - self._reference(t, ca.SX(N), ref)[0])

    def _roll(self, t: ca.SX, begin: ca.SX, way: Iterate, rows: StageRows, ref: Follows) -> NonlinearPlan:
        """The plant along shares of the way to the solution of the linearised problem, and under the law behind the
        horizon alone; of these the one of least cost."""
        (nx, nu, N), weights, feedback = self._counts, self._weights, ca.SX(self.K)

        def stage(c: ca.SX, own: ca.SX, gains: ca.SX, column: ca.SX) -> tuple[ca.SX, ...]:
            k = c[-1]
            x, u, _, _, r, s, _, _ = StageRows.split(column, weights.sizes)
            e, v = ca.vertsplit(own, [0, nx, nx + nu])
            carries, results = list[ca.SX](), list[ca.SX]()
            for share, part in zip((*SHARES, None), ca.vertsplit(c[:-1], nx + 1), strict=True):
                now, cost = part[:nx], part[nx]
                if share is None:
                    wanted = s - feedback @ (now - r)
                else:
                    wanted = u + share * (v - u) - ca.reshape(gains, nu, nx) @ (now - x - share * e)
                taken = weights.clip(wanted)
                cost = cost + weights.stage_cost(now - r, taken - s, self._rows(t + k * self.period, now))
                carries.append(ca.vertcat(self._stages.after(t + k * self.period, now, taken), cost))
                results.append(ca.vertcat(now, taken, gains if share is not None else ca.vec(feedback)))
            return ca.vertcat(*carries, k + 1), ca.vertcat(*results)

        first = ca.vertcat(*(ca.vertcat(begin, 0.0) for _ in (*SHARES, None)), 0.0)
        ends, trials = bounded_loop(N, stage, first, ca.vertcat(way.e, way.v), way.gains, rows.columns)
        target = self._reference(t, ca.SX(N), ref)[0]
        parts = ca.vertsplit(ends[:-1], nx + 1)
        costs = [part[nx] + weights.end_cost(part[:nx] - target) for part in parts]
        flags = better_flags(costs)

        def take(none: ca.SX, trial: ca.SX, flags: ca.SX) -> tuple[ca.SX, ...]:
            return none, choose(flags, ca.vertsplit(trial, nx + nu + nu * nx))

        _, chosen = bounded_loop(N, take, ca.SX(0, 1), trials, constants=(flags,))
        x, u, gains = ca.vertsplit(chosen, [0, nx, nx + nu, nx + nu + nu * nx])
        end, cost = choose(flags, parts)[:nx], choose(flags, costs)
        share = choose(flags, [ca.SX(share) for share in (*SHARES, -1.0)])
        return NonlinearPlan(x, u, way.clamps, gains, end, way.residual, cost, share)

    @property
    def _scale(self) -> ca.SX:
        """The distances between the limits of the inputs (nu, 1), 1 where one is missing."""
        distance = ca.SX(self.high) - ca.SX(self.low)
        return ca.if_else(distance <= LARGEST, distance, 1.0)
