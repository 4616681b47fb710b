from __future__ import annotations

import casadi as ca
import numpy as np

from workbench.blocks.laws.active_rows import active_sums, any_of, solve_small_system
from workbench.blocks.loop.contracts import AbstractController, AbstractPlant, Follows, Parts, Reads
from workbench.core import Entry, Layout, Signals, block, parameter
from workbench.core.block import Matrix, Number, Vector
from workbench.core.bounded_loop import bounded_loop
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
    sweep, as a share of the distance between the limits of a row. A run in which it grows large has not followed its
    plan.

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
        Limits of the rows, (nc,), infinite where there is none.
    softness
        Reciprocal weights of the violation of soft rows, (nc,); 0 for a hard one.
    sigma
        Diagonal of the metric for a stage, (nc,).
    W, L
        Kept modes of the metric, (N nc, r) and (r,).
    cap
        The most that a sweep changes a row, in distances between its limits.
    x0, u0
        The rest, in the units of `states` and `inputs`.
    follow
        Names of the states whose reference replaces their value in x0.

    References
    ----------
    Rawlings, Mayne and Diehl (2017), Model Predictive Control, section 2.5. Becker and Fadili (2012), A quasi-Newton
    proximal splitting method.

    Examples
    --------
    >>> plant = wb.CartPole()
    >>> cart = wb.linearize(wb.open_loop(plant), t=0.0, x=np.zeros(4), at_rest=True)
    >>> design = wb.predictive_design(cart, 0.02, np.eye(4), [[0.1]], 20, limits={"F": (-3.0, 3.0)})
    >>> law = wb.ModelPredictive.of(plant, design, follow=("x",))
    >>> law.reads.names, law.follows.names, law.sweeps
    (('x', 'xd', 'phi', 'phid'), ('x',), 4)
    """

    states: Layout
    inputs: Layout
    horizon: int
    sweeps: int
    A: Matrix = parameter(unit=ANY, shape=("nx", "nx"))
    B: Matrix = parameter(unit=ANY, shape=("nx", "nu"))
    K: Matrix = parameter(unit=ANY, shape=("nu", "nx"))
    S: Matrix = parameter(unit=ANY, shape=("nu", "nu"))
    F: Matrix = parameter(unit=ANY, shape=("nc", "nx"))
    E: Matrix = parameter(unit=ANY, shape=("nc", "nu"))
    low: Vector = parameter(unit=ANY, shape=("nc",))
    high: Vector = parameter(unit=ANY, shape=("nc",))
    softness: Vector = parameter(unit=ANY, shape=("nc",))
    sigma: Vector = parameter(unit=ANY, shape=("nc",))
    W: Matrix = parameter(unit=ANY, shape=("M", "r"))
    L: Vector = parameter(unit=ANY, shape=("r",))
    cap: float = parameter(unit="1")
    x0: Vector = parameter(unit=ANY, shape=("n",), symbol="x_0")
    u0: Vector = parameter(unit=ANY, shape=("nu",), symbol="u_0")
    follow: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        whole("ModelPredictive(horizon=...)", self.horizon, least=1)
        whole("ModelPredictive(sweeps=...)", self.sweeps, least=1)
        for name in self.follow:
            known_name(name, self.states.names, "states that the law reads")

    @staticmethod
    def of(plant: AbstractPlant, design: object, follow: tuple[str, ...] = ()) -> ModelPredictive:
        """The law of a design for a plant, once in its period. It reads an estimate of each state.

        Parameters
        ----------
        plant
            The plant.
        design
            The result of `predictive_design` for the linearised plant.
        follow
            Names of the states that follow a reference. The plant must rest at each of them with the same input, as a
            cart does at each position.

        Raises
        ------
        ValueError
            If `design` is no such result, or is for other states or inputs.
        LookupError
            If the plant has no state with a name of `follow`.
        """
        own = getattr(design, "law_arguments", None)
        if not isinstance(own, dict) or "horizon" not in own:
            raise refusal("ModelPredictive.of(design=...)", "the result of `predictive_design`", design)
        for port, names in ((plant.states, own["state_names"]), (plant.inputs, own["input_names"])):
            if port.labels != names:
                raise ValueError(
                    f"`ModelPredictive.of(plant, design)` must get a design for the plant's own signals, "
                    f"{', '.join(port.labels)}; it is for {', '.join(names)}."
                )
        numbers = {name: value for name, value in own.items() if name not in ("state_names", "input_names", "period")}
        law = ModelPredictive(plant.states, plant.inputs, **numbers, follow=follow)
        return law.run_every(own["period"])

    # ports

    @property
    def reads(self) -> Layout:
        return self.states

    @property
    def follows(self) -> Layout:
        return Layout(tuple(self.states[name] for name in self.follow))

    @property
    def drives(self) -> Layout:
        return self.inputs

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
        rows = self.horizon * self._counts[2]
        sent = (Entry("sent", np.zeros(self._waiting), ANY),) if self._waiting else ()
        return Layout((Entry("plan", np.zeros(rows), ANY), *sent, Entry("residual", np.zeros(()), "1")))

    # equations

    def command(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Signals:
        zeta, _ = self._solve(z, est, ref)
        return Signals(self.inputs.view(self.u0 + self._first_input(zeta)))

    def update(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Parts:
        """The plan of the next period about its LQR answer, the inputs on their way, and the residual."""
        nc = self._counts[2]
        zeta, residual = self._solve(z, est, ref)
        v, shifted = self._first_input(zeta), ca.reshape(ca.vertcat(zeta[nc:], zeta[-nc:]), nc, self.horizon)
        at = self._rest(ref)
        after = self.A @ self._deviation(z, est, at) + self.B @ v
        rows, closed = self.F - self.E @ self.K, self.A - self.B @ self.K

        def about_lqr(e: ca.SX, row: ca.SX) -> tuple[ca.SX, ...]:
            return closed @ e, row - rows @ e - self.F @ at

        _, plan = bounded_loop(self.horizon, about_lqr, after - at, shifted)
        following: dict[str, ca.SX] = {"plan": ca.vec(plan), "residual": residual}
        if self._waiting:
            following["sent"] = after[self.states.size :]
        return following

    def _rest(self, ref: Follows) -> ca.SX:
        """The rest that is wanted, as a deviation (nx, 1) from x0; its input is u0."""
        wanted = {**self.states.view(ca.SX(self.x0)), **{name: ref[name] for name in self.follow}}
        return ca.vertcat(self.states.flatten(wanted) - self.x0, ca.SX.zeros(self._waiting))

    def _deviation(self, z: Parts, est: Reads, at: ca.SX) -> ca.SX:
        """The state of the model (nx, 1), as a deviation from x0 and u0."""
        x = self.states.flatten(est) - self.x0
        return ca.vertcat(x, z["sent"]) if self._waiting else x

    def _first_input(self, zeta: ca.SX) -> ca.SX:
        nu = self.inputs.size
        return ca.fmin(ca.fmax(zeta[:nu], self.low[:nu]), self.high[:nu])

    def _solve(self, z: Parts, est: Reads, ref: Follows) -> tuple[ca.SX, ca.SX]:
        """zeta (N nc, 1) of the rows after the sweeps, and the residual before the last one."""
        nc, at = self._counts[2], self._rest(ref)
        rows, closed = self.F - self.E @ self.K, self.A - self.B @ self.K

        def start(e: ca.SX, own: ca.SX) -> tuple[ca.SX, ...]:
            answer = rows @ e + self.F @ at
            return closed @ e, answer, own + answer

        plan = ca.reshape(z["plan"], nc, self.horizon)
        _, answer, zeta = bounded_loop(self.horizon, start, self._deviation(z, est, at) - at, plan)

        def sweep(both: ca.SX, lqr: ca.SX) -> tuple[ca.SX, ...]:
            return (ca.vertcat(*self._sweep(ca.reshape(both[:-1], nc, self.horizon), lqr)),)

        (both,) = bounded_loop(self.sweeps, sweep, ca.vertcat(ca.vec(zeta), 0.0), constants=(answer,))
        return both[:-1], both[-1]

    def _sweep(self, zeta: ca.SX, answer: ca.SX) -> tuple[ca.SX, ca.SX]:
        """The next zeta (N nc, 1), and the residual of the one that came."""
        r, modes = self.L.shape[0], self._modes_by_stage
        some_act, moves, bounded, acts = self._back(zeta)
        gap, residual = self._forth(moves, bounded, answer, some_act)
        change, largest = gap, residual
        if r:
            sums = active_sums(gap, acts, modes)
            t = ca.if_else(some_act, solve_small_system(ca.SX(self.L), sums), 0.0)

            def without_modes(most: ca.SX, own: ca.SX, W: ca.SX, t: ca.SX, some: ca.SX) -> tuple[ca.SX, ...]:
                step = own - ca.if_else(some, ca.reshape(W, own.numel(), r) @ t, 0.0)
                return ca.fmax(most, ca.mmax(ca.fabs(step) * self._shares)), step

            largest, change = bounded_loop(self.horizon, without_modes, ca.SX(0.0), gap, modes, constants=(t, some_act))
        scale = ca.fmin(1.0, self.cap / ca.fmax(largest, self.cap))

        def take(none: ca.SX, own: ca.SX, step: ca.SX, share: ca.SX) -> tuple[ca.SX, ...]:
            return none, own + step * share

        _, following = bounded_loop(self.horizon, take, ca.SX(0, 1), zeta, change, constants=(scale,))
        return ca.vec(following), residual

    def _back(self, zeta: ca.SX) -> tuple[ca.SX, ...]:
        """1 if a row acts, else 0; the moves d, the bounded rows v, and 1 / sigma of rows that act, by stage.

        Behind the last stage at which a row acts, p and d are zero: no machine needs to compute them.
        """
        nx, rows, closed = self._counts[0], self.F - self.E @ self.K, self.A - self.B @ self.K

        def back(c: ca.SX, own: ca.SX) -> tuple[ca.SX, ...]:
            p, above = c[:nx], c[nx]
            v = ca.fmin(ca.fmax(own, self.low), self.high)
            acts = ca.if_else(own == v, 0.0, 1 / self.sigma)
            some = ca.if_else(any_of(own != v), 1.0, above)
            force = (own - v) / self.sigma
            d = ca.if_else(some, self.S @ (self.B.T @ p + self.E.T @ force), 0.0)
            before = ca.if_else(some, closed.T @ p + rows.T @ force, p)
            return ca.vertcat(before, some), d, v + self.softness * force, acts

        first, *by_stage = bounded_loop(self.horizon, back, ca.SX.zeros(nx + 1), zeta, backward=True)
        return first[nx], *by_stage

    def _forth(self, moves: ca.SX, bounded: ca.SX, answer: ca.SX, some_act: ca.SX) -> tuple[ca.SX, ca.SX]:
        """The gap of each row, (nc, N), and the largest one as a share of the distance between its limits."""
        nx, rows, closed = self._counts[0], self.F - self.E @ self.K, self.A - self.B @ self.K

        def forth(c: ca.SX, d: ca.SX, own: ca.SX, lqr: ca.SX, some: ca.SX) -> tuple[ca.SX, ...]:
            e, largest = c[:nx], c[nx]
            gap = lqr - ca.if_else(some, rows @ e + self.E @ d, 0.0) - own
            after = ca.if_else(some, closed @ e + self.B @ d, e)
            return ca.vertcat(after, ca.fmax(largest, ca.mmax(ca.fabs(gap) * self._shares))), gap

        start = ca.SX.zeros(nx + 1)
        end, gap = bounded_loop(self.horizon, forth, start, moves, bounded, answer, constants=(some_act,))
        return gap, end[nx]

    @property
    def _shares(self) -> ca.SX:
        """1 / (high - low) of the rows (nc, 1), zero where a limit is missing."""
        return ca.SX(1.0) / (ca.SX(self.high) - ca.SX(self.low))

    @property
    def _modes_by_stage(self) -> ca.SX:
        """W with the numbers of a stage in a column, (nc r, N)."""
        nc, W = self._counts[2], ca.SX(self.W)
        return ca.horzcat(*(ca.vec(W[k * nc : (k + 1) * nc, :]) for k in range(self.horizon)))
