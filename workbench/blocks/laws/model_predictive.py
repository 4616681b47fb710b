from __future__ import annotations

from collections.abc import Mapping

import casadi as ca
import numpy as np

from workbench.blocks.laws.limit_cones import LimitCone, cones_of, inputs_within_limits
from workbench.blocks.laws.predicted_signals import predicted_signals, predicted_units
from workbench.blocks.laws.predictive_ports import (
    DISTURBANCE,
    About,
    all_finite,
    column,
    disturbance_port,
    refuse_other_signals,
    safe_inputs,
)
from workbench.blocks.laws.predictive_sweeps import PeriodAnswer, answer_of_period
from workbench.blocks.loop.contracts import AbstractController, AbstractPlant, Follows, Parts, Reads
from workbench.core import Entry, Layout, Signals, block, parameter
from workbench.core.block import Matrix, Number, Vector
from workbench.core.bounded_loop import bounded_loop
from workbench.core.numbers import Bounds
from workbench.core.units import ANY
from workbench.core.validation.refusals import known_name, refusal, whole


@block
class ModelPredictive(AbstractController):
    """Linear model predictive control: the first input of a plan of N stages, computed anew in each period.

    The plan minimises the sum of e'Q e + v'R v over the stages, with e and v the deviations of states and inputs from
    a rest, and with the cost of the LQR law behind the last stage. It keeps low <= F e + E v <= high at each stage. A
    fixed number of sweeps solves it: see `planning.linear_mpc.splitting`, whose numbers the block holds.
    `ModelPredictive.of` makes the law of a design.

    Where no limit acts, u = u0 - K (x - x0): the law is LQR. The memory `residual` is the residual before the last
    sweep, as a share of the distance between the limits of a row, and `worst` the largest so far. A run in which it
    passes `residual_bounds` is beyond the sample of its design, and the run's warnings say so.

    Parameters
    ----------
    states
        Layout of the states x that the law reads.
    inputs
        Layout of the inputs u that it drives.
    horizon, sweeps
        The number N of stages, and the number of sweeps in a period.
    A, B
        Model e+ = A e + B v of a period, (nx, nx) and (nx, nu). Behind the states stand the inputs on their way, oldest
        first, if the inputs have a delay.
    K
        Gain of the LQR law, (nu, nx).
    S
        Inverse of R + B'P B, (nu, nu), where P is the cost of the LQR law.
    F, E
        Rows of a stage, (nc, nx) and (nc, nu); the first nu are the inputs.
    low, high
        Limits of the rows, (nc,), of size 1e30 where there is none.
    softness
        Reciprocal weights of the violation of soft rows, (nc,); 0 for a hard one.
    sigma
        Diagonal of the metric for a stage, (nc,).
    W, L
        Kept modes of the metric, (N nc, r) and (r,).
    cap
        How far a sweep may pass a limit, in distances between the limits of its row. For ADMM, the relaxation.
    x0, u0
        The rest, in the units of `states` and `inputs`.
    follow
        Names of the states whose reference replaces their value in x0.
    gains, inverses
        Gains (N nu, nx) and inverse weights (N nu, nu) of the stages for ADMM; None for sweeps in the metric.
    rates
        True if the last nu rows limit the change of each input, and the last nu states are the inputs before.
    cones
        The second-order cones among the rows, as `LimitCone` of their places; their inputs are kept exactly.
    outputs, target, y0
        Layout of the outputs that reach their references without offset, the map (nx + nu, nd + nr) from d and
        y_ref - y0 to the rest (x_s, u_s), and the outputs (nr,) at the rest x0; None without an estimate of d.
    residual_bounds
        The bounds of the memory `worst`: a run that passes them is flagged among the warnings of the run.
    safe_command
        Inputs (nu,) that the law gives in a period in which an estimate or a reference is not finite. Its memory then
        keeps its values. None to leave such numbers to the run, which they end.

    References
    ----------
    Rawlings, Mayne and Diehl (2017), Model Predictive Control, section 2.5. Becker and Fadili (2012), A quasi-Newton
    proximal splitting method.

    Examples
    --------
    >>> plant = wb.CartPole()
    >>> cart = wb.linearize(wb.open_loop(plant), t=0.0, x=np.zeros(4), at_rest=True)
    >>> Q = np.diag([10.0, 1.0, 10.0, 1.0])
    >>> design = wb.predictive_design(cart, 0.02, Q, [[0.1]], 20, limits={"F": (-3.0, 3.0)})
    >>> law = wb.ModelPredictive.of(plant, design, follow=("x",))
    >>> law.reads.names, law.follows.names, law.sweeps
    (('x', 'xd', 'phi', 'phid'), ('x',), 3)
    """

    states: Layout
    inputs: Layout
    horizon: int
    sweeps: int
    A: Matrix = parameter(unit=ANY, shape=("nx", "nx"), is_derived=True)
    B: Matrix = parameter(unit=ANY, shape=("nx", "nu"), is_derived=True)
    K: Matrix = parameter(unit=ANY, shape=("nu", "nx"), is_derived=True)
    S: Matrix = parameter(unit=ANY, shape=("nu", "nu"), is_derived=True)
    F: Matrix = parameter(unit=ANY, shape=("nc", "nx"), is_derived=True)
    E: Matrix = parameter(unit=ANY, shape=("nc", "nu"), is_derived=True)
    low: Vector = parameter(unit=ANY, shape=("nc",))
    high: Vector = parameter(unit=ANY, shape=("nc",))
    softness: Vector = parameter(unit=ANY, shape=("nc",), is_derived=True)
    sigma: Vector = parameter(unit=ANY, shape=("nc",), is_derived=True)
    W: Matrix = parameter(unit=ANY, shape=("M", "r"), is_derived=True)
    L: Vector = parameter(unit=ANY, shape=("r",), is_derived=True)
    cap: float = parameter(unit="1", is_derived=True)
    x0: Vector = parameter(unit=ANY, shape=("n",), symbol="x_0", is_derived=True)
    u0: Vector = parameter(unit=ANY, shape=("nu",), symbol="u_0", is_derived=True)
    follow: tuple[str, ...] = ()
    gains: Matrix = parameter(default=None, unit=ANY, shape=("k", "nx"), is_derived=True)
    inverses: Matrix = parameter(default=None, unit=ANY, shape=("k", "nu"), is_derived=True)
    rates: bool = False
    cones: tuple[LimitCone, ...] = ()
    outputs: Layout = Layout()
    target: Matrix = parameter(default=None, unit=ANY, shape=("ns", "nt"), is_derived=True)
    y0: Vector = parameter(default=None, unit=ANY, shape=("ny",), symbol="y_0", is_derived=True)
    residual_bounds: Bounds = Bounds()
    safe_command: Vector = parameter(default=None, unit=ANY, shape=("nu",), symbol="u_safe")

    def __post_init__(self) -> None:
        whole("ModelPredictive(horizon=...)", self.horizon, least=1)
        whole("ModelPredictive(sweeps=...)", self.sweeps, least=1)
        for name in self.follow:
            known_name(name, self.states.names, "states that the law reads")

    @staticmethod
    def of(
        plant: AbstractPlant,
        design: object,
        follow: tuple[str, ...] = (),
        safe_command: Mapping[str, float] | None = None,
    ) -> ModelPredictive:
        """The law of a design for a plant, once in its period. It reads an estimate of each state.

        Parameters
        ----------
        plant
            The plant.
        design
            The result of `predictive_design` for the linearised plant.
        follow
            Names of the states that follow a reference. The plant must rest at each of them with the same input, as a
            cart does at each position. A design with `offset_free` follows its outputs instead.
        safe_command
            Inputs by name, within their limits, for a period in which a number that the law reads is not finite.

        Raises
        ------
        ValueError
            If `design` is no such result, is for other states or inputs, or follows outputs and `follow` is given; or
            if the safe command lacks an input or passes a limit.
        LookupError
            If the plant has no state with a name of `follow`, or no such input.
        """
        own = getattr(design, "law_arguments", None)
        if not isinstance(own, dict) or "horizon" not in own:
            raise refusal("ModelPredictive.of(design=...)", "the result of `predictive_design`", design)
        own = dict(own)
        names, outputs, period = own.pop("names"), own.pop("output_names"), own.pop("period")
        refuse_other_signals("ModelPredictive.of(plant, design)", plant, names)
        if outputs and follow:
            raise refusal("ModelPredictive.of(follow=...)", f"left out, as the design follows {outputs}", follow)
        ends, safe = (np.asarray(own["u0"]) + own[end][: plant.inputs.size] for end in ("low", "high")), None
        if safe_command is not None:
            safe = safe_inputs("ModelPredictive.of", plant.inputs, safe_command, *ends)
        own["cones"] = cones_of(own["cones"], None if safe is None else safe - own["u0"])
        port = Layout(tuple(plant.outputs[name] for name in outputs))
        law = ModelPredictive(plant.states, plant.inputs, **own, follow=follow, outputs=port, safe_command=safe)
        return law.run_every(period)

    # ports

    @property
    def reads(self) -> Layout:
        disturbances = 0 if self.target is None else self.target.shape[1] - self.outputs.size
        return self.states + disturbance_port(disturbances) if disturbances else self.states

    @property
    def follows(self) -> Layout:
        return self.outputs + Layout(tuple(self.states[name] for name in self.follow))

    @property
    def drives(self) -> Layout:
        return self.inputs

    @property
    def command_limits(self) -> tuple[Vector, Vector]:
        """The limits (nu,) of the command, in the units of the inputs."""
        return self.low[: self.inputs.size] + self.u0, self.high[: self.inputs.size] + self.u0

    @property
    def _counts(self) -> tuple[int, int, int]:
        """The numbers of states of the model, of inputs, and of rows of a stage."""
        return self.A.shape[0], self.inputs.size, self.low.shape[0]

    @property
    def _waiting(self) -> int:
        """The number of inputs on their way."""
        return self._counts[0] - self.states.size

    @property
    def memory(self) -> Layout:
        rows, bounds = self.horizon * self._counts[2], self.residual_bounds
        sent = (Entry("sent", np.zeros(self._waiting), ANY),) if self._waiting else ()
        residual, worst = Entry("residual", np.zeros(()), "1"), Entry("worst", np.zeros(()), "1", bounds)
        return Layout((Entry("plan", np.zeros(rows), ANY), *sent, residual, worst))

    # equations

    def command(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Signals:
        about = self._about(z, est, ref)
        return Signals(self.inputs.view(self.u0 + self._first_input(self._solve(z, about), about)))

    def update(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Parts:
        """The plan of the next period about its LQR answer, the inputs on their way, and the residual."""
        about, nc = self._about(z, est, ref), self._counts[2]
        answer = self._solve(z, about)
        zeta = answer.zeta
        e, at, push, valid = about
        v, shifted = self._first_input(answer, about), ca.reshape(ca.vertcat(zeta[nc:], zeta[-nc:]), nc, self.horizon)
        after = self.A @ (e - at) + self.B @ (v - push)
        rows, closed, rest = self.F - self.E @ self.K, self.A - self.B @ self.K, self.F @ at + self.E @ push

        def about_lqr(e: ca.SX, row: ca.SX, outside: ca.SX) -> tuple[ca.SX, ...]:
            return ca.if_else(outside, closed @ e, e), ca.if_else(outside, row - rows @ e - rest, 0.0)

        _, plan = bounded_loop(self.horizon, about_lqr, after, shifted, constants=(answer.outside,))
        following = {"plan": ca.vec(plan), "residual": answer.residual, "worst": ca.fmax(z["worst"], answer.residual)}
        if valid is not None:
            following = {name: ca.if_else(valid, value, z[name]) for name, value in following.items()}
        if self._waiting:
            following["sent"] = (after + at)[self.states.size :]
        return following

    def signals(self, z: Parts, est: Reads, ref: Follows) -> Parts:
        """The plan: `predicted_t`, the times of its stages from now on, and the states and inputs at these stages."""
        _, nu, nc = self._counts
        about = self._about(z, est, ref)
        answer = self._solve(z, about)
        rows = ca.reshape(answer.zeta, nc, self.horizon)[:nu, :], answer.lqr[:nu, :]

        def ahead(e: ca.SX, row: ca.SX, lqr: ca.SX, outside: ca.SX) -> tuple[ca.SX, ...]:
            v = inputs_within_limits(self, ca.if_else(outside, row, lqr))
            after = self.A @ (e - about.at) + self.B @ (v - about.push) + about.at
            return after, after, v

        _, x, u = bounded_loop(self.horizon, ahead, about.e, *rows, constants=(answer.outside,))
        states = self.states, ca.horzcat(about.e, x)[: self.states.size, :], self.x0
        inputs = self.inputs, ca.horzcat(u, u[:, -1]), self.u0  # the last one is held
        return predicted_signals((states, inputs), self.period or 1.0)

    @property
    def signal_units(self) -> Mapping[str, str]:
        return predicted_units(self.states, self.inputs)

    def _about(self, z: Parts, est: Reads, ref: Follows) -> About:
        """The state, and the rest that is wanted; both at x0 where a number that is read is not finite."""
        x, waiting = column(est, self.states), self._waiting
        push = ca.SX.zeros(self.inputs.size)
        wanted = {**self.states.view(ca.SX(self.x0)), **{name: ref[name] for name in self.follow}}
        both = self.states.flatten(wanted) - self.x0
        if self.target is not None:
            both = ca.vertcat(est[DISTURBANCE], column(ref, self.outputs) - self.y0)
        valid = None if self.safe_command is None else all_finite(ca.vertcat(x, both))
        if valid is not None:
            x = ca.if_else(valid, x, ca.SX(self.x0))
            both = ca.if_else(valid, both, ca.SX.zeros(both.numel()))
        at = ca.vertcat(both, ca.SX.zeros(waiting))
        if self.target is not None:
            both = self.target @ both
            at, push = both[: self._counts[0]], both[self._counts[0] :]
        e = x - self.x0
        return About(ca.vertcat(e, z["sent"]) if waiting else e, at, push, valid)

    def _first_input(self, answer: PeriodAnswer, about: About) -> ca.SX:
        """The first input of the plan within its limits, those of its change from the input before, and its cones."""
        nu, last = self.inputs.size, about.e[-self.inputs.size :]
        v = inputs_within_limits(self, ca.if_else(answer.outside, answer.zeta[:nu], answer.lqr[:nu, 0]))
        if self.rates:
            v = ca.fmin(ca.fmax(v, last + self.low[-nu:]), last + self.high[-nu:])
        return v if about.valid is None else ca.if_else(about.valid, v, self.safe_command - self.u0)

    def _solve(self, z: Parts, about: About) -> PeriodAnswer:
        rest = self.F @ about.at + self.E @ about.push
        return answer_of_period(self, ca.reshape(z["plan"], -1, self.horizon), about.e - about.at, rest)
