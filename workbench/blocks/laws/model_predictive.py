from __future__ import annotations

from collections.abc import Mapping

import casadi as ca
import numpy as np

from workbench.blocks.laws.limit_cones import LimitCone, cones_of, inputs_within_limits
from workbench.blocks.laws.linear_plan import (
    about_period,
    following_plan,
    planned_inputs,
    planned_states,
    rest_beyond_limits,
    rest_memory,
)
from workbench.blocks.laws.predicted_signals import predicted_signals, predicted_units
from workbench.blocks.laws.predictive_fallback import FORMS, WARM, Fallback, PeriodVerdict, finite_columns
from workbench.blocks.laws.predictive_ports import About, disturbance_port, refuse_other_signals, safe_inputs
from workbench.blocks.laws.predictive_sweeps import PeriodAnswer, answer_of_period
from workbench.blocks.loop.contracts import AbstractController, AbstractPlant, Follows, Parts, Reads
from workbench.core import Entry, Layout, Signals, block, parameter
from workbench.core.block import Matrix, Number, Vector, option
from workbench.core.numbers import Bounds
from workbench.core.units import ANY
from workbench.core.validation.refusals import known_name, refusal, whole


@block
class ModelPredictive(AbstractController):
    """Linear model predictive control: the first input of a plan of N stages, computed anew in each period.

        minimise sum e_k'Q e_k + v_k'R v_k + e_N'P e_N,      k = 0, ..., N - 1,
        e_k+1 = A e_k + B v_k,      low <= F e_k + E v_k <= high,      u = u0 + v_0

    with e = x - x0 and v = u - u0 the deviations from a rest, and P the cost of the LQR law. A fixed number of sweeps
    solves it: see `planning.linear_mpc.splitting`, whose numbers the block holds. `ModelPredictive.of` makes the law
    of a design.

    Where no limit acts, u = u0 - K (x - x0): the law is LQR. The memory `residual` is the residual before the last
    sweep, as a share of the distance between the limits of a row. A run in which it passes `residual_bounds` in any
    period is beyond the sample of its design, and the run's warnings say so.

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
    Y
        The rows of the LQR law at all stages, one in a column (nx, N nc).
    follow
        Names of the states whose reference replaces their value in x0.
    D
        D diag(sigma)^-1 - I (N nc, N nc) of the dual matrix; None where passes over the stages are cheaper.
    gains, inverses
        Gains (N nu, nx) and inverse weights (N nu, nu) of the stages for ADMM; None for sweeps in the metric.
    rates
        True if the last nu rows limit the change of each input, and the last nu states are the inputs before.
    cones
        The second-order cones among the rows, as `LimitCone` of their places; their inputs are kept exactly.
    outputs, target, y0
        Layout of the outputs that reach their references without offset, the map (nx + nu, nd + nr) from d and
        y_ref - y0 to the rest (x_s, u_s), and the outputs (nr,) at the rest x0; None without an estimate of d. A run
        that asks for a rest beyond the limits is flagged, by the memory `rest_beyond_limits`.
    residual_bounds
        The bounds of the memory `residual`: a run that passes them is flagged among the warnings of the run.
    safe_command
        Inputs (nu,) for a period in which an estimate or a reference is not finite. None to leave such numbers to the
        run, which they end.
    fallback, residual_bound
        What the law does in a bad period, and the bound of the residual beyond which a period is bad, None for no
        bound: see `predictive_fallback`. The warnings of a run say that it had bad periods.

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
    Y: Matrix = parameter(unit=ANY, shape=("nx", "M"), is_derived=True)
    follow: tuple[str, ...] = ()
    D: Matrix = parameter(default=None, unit=ANY, shape=("M", "M"), is_derived=True)
    gains: Matrix = parameter(default=None, unit=ANY, shape=("k", "nx"), is_derived=True)
    inverses: Matrix = parameter(default=None, unit=ANY, shape=("k", "nu"), is_derived=True)
    rates: bool = False
    cones: tuple[LimitCone, ...] = ()
    outputs: Layout = Layout()
    target: Matrix = parameter(default=None, unit=ANY, shape=("ns", "nt"), is_derived=True)
    y0: Vector = parameter(default=None, unit=ANY, shape=("ny",), symbol="y_0", is_derived=True)
    residual_bounds: Bounds = Bounds()
    safe_command: Vector = parameter(default=None, unit=ANY, shape=("nu",), symbol="u_safe")
    fallback: str = option(FORMS, default=WARM)
    residual_bound: float | None = parameter(default=None, unit="1", low=0.0, strict=True, symbol="r_max")

    def __post_init__(self) -> None:
        whole("ModelPredictive(horizon=...)", self.horizon, least=1)
        whole("ModelPredictive(sweeps=...)", self.sweeps, least=1)
        for name in self.follow:
            known_name(name, self.states.names, "states that the law reads")
        self._fallback.refuse_unfit("ModelPredictive")

    @staticmethod
    def of(
        plant: AbstractPlant,
        design: object,
        follow: tuple[str, ...] = (),
        safe_command: Mapping[str, float] | None = None,
        fallback: str = WARM,
        residual_bound: float | None = None,
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
        fallback, residual_bound
            "warm", "safe_command", "last_good" or "cold", for a period in which such a number is not finite, or the
            residual passes the bound.

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
        ends = (np.asarray(own["u0"]) + own[end][: plant.inputs.size] for end in ("low", "high"))
        safe = safe_inputs("ModelPredictive.of", plant.inputs, safe_command, *ends)
        own["cones"] = cones_of(own["cones"], None if safe is None else safe - own["u0"])
        port = Layout(tuple(plant.outputs[name] for name in outputs))
        own |= {"safe_command": safe, "fallback": fallback, "residual_bound": residual_bound}
        law = ModelPredictive(plant.states, plant.inputs, **own, follow=follow, outputs=port)
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
        residual = Entry("residual", np.zeros(()), "1", bounds)
        spare = *rest_memory(self), *self._fallback.memory(self.inputs.size, self.horizon)
        return Layout((Entry("plan", np.zeros(rows), ANY), *sent, residual, *spare))

    @property
    def _fallback(self) -> Fallback:
        """The fallback, with the safe command as a deviation from the rest."""
        safe = None if self.safe_command is None else ca.SX(self.safe_command) - self.u0
        return Fallback.of(self.fallback, safe, self.residual_bound)

    # equations

    def command(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Signals:
        about = about_period(self, z, est, ref)
        return Signals(self.inputs.view(self.u0 + self._first_input(z, self._solve(z, about), about)))

    def update(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Parts:
        """The plan of the next period about its LQR answer, the inputs on their way, and the residual."""
        about = about_period(self, z, est, ref)
        answer = self._solve(z, about)
        plan, after = following_plan(self, about, answer, self._first_input(z, answer, about))
        parts = {"plan": plan}, {"residual": answer.residual}, planned_inputs(self, answer)
        following = self._fallback.following(z, self._verdict(answer, about), *parts)
        following |= rest_beyond_limits(self, about)
        if self._waiting:
            following["sent"] = after[self.states.size :]
        return following

    def signals(self, z: Parts, est: Reads, ref: Follows) -> Parts:
        """The plan: `predicted_t`, the times of its stages from now on, and the states and inputs at these stages."""
        about = about_period(self, z, est, ref)
        u = planned_inputs(self, self._solve(z, about))
        states = self.states, planned_states(self, about, u)[: self.states.size, :], self.x0
        inputs = self.inputs, ca.horzcat(u, u[:, -1]), self.u0  # the last one is held
        return predicted_signals((states, inputs), self.period or 1.0)

    @property
    def signal_units(self) -> Mapping[str, str]:
        return predicted_units(self.states, self.inputs)

    def _first_input(self, z: Parts, answer: PeriodAnswer, about: About) -> ca.SX:
        """The input of a period within its limits, and within those of its change from the input before."""
        nu, last, lqr = self.inputs.size, about.e[-self.inputs.size :], answer.lqr[: self.inputs.size, 0]

        def clip(v: ca.SX) -> ca.SX:
            return inputs_within_limits(self, v)

        v = clip(ca.if_else(answer.outside, answer.zeta[:nu], lqr))
        v = self._fallback.chosen_input(z, self._verdict(answer, about), v, clip(lqr), clip)
        return ca.fmin(ca.fmax(v, last + self.low[-nu:]), last + self.high[-nu:]) if self.rates else v

    def _verdict(self, answer: PeriodAnswer, about: About) -> PeriodVerdict:
        finite = finite_columns(ca.reshape(answer.zeta, -1, self.horizon))
        return self._fallback.verdict(about.valid, finite, answer.residual)

    def _solve(self, z: Parts, about: About) -> PeriodAnswer:
        rest = self.F @ about.at + self.E @ about.push
        return answer_of_period(self, ca.reshape(z["plan"], -1, self.horizon), about.e - about.at, rest)
