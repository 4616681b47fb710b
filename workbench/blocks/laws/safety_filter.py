from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import casadi as ca
import numpy as np

from workbench.blocks.laws.limit_cones import LimitCone, inputs_within_limits
from workbench.blocks.laws.model_predictive import ModelPredictive
from workbench.blocks.laws.predictive_ports import column
from workbench.blocks.laws.predictive_sweeps import admm_sweep, metric_sweep
from workbench.blocks.laws.safe_plans import is_safe_plan, largest_safe_share
from workbench.blocks.loop.contracts import AbstractController, AbstractPlant, Follows, Parts, Reads
from workbench.blocks.loop.wiring import prefix_names, strip_prefix
from workbench.core import Entry, Layout, Signals, block, parameter
from workbench.core.block import Matrix, Number, Vector
from workbench.core.bounded_loop import bounded_loop
from workbench.core.units import ANY
from workbench.core.validation.refusals import finite, refusal

NOMINAL, BETWEEN, UNPROVED = 0.0, 1.0, 2.0  # values of the memory `choice`


class FilterAnswer(NamedTuple):
    """The input (nu, 1) about the rest, the choice, the next backup plan (nu, N), and the next memory of the sweeps."""

    v: ca.SX
    choice: ca.SX
    backup: ca.SX
    plan: ca.SX
    residual: ca.SX


@block
class SafetyFilter(AbstractController):
    """A predictive safety filter: the command of another law where it is safe, else a safe one near to it.

    A plan is safe if it keeps all limits of the linear model for N stages and ends where x'P x <= level, in which the
    LQR law u = u0 - K (x - x0) keeps them forever. In each period the filter takes the first of these that exists:

    - the command u_n of the law, with the LQR law behind it;
    - the farthest safe plan on the way from the plan of the period before, without its first stage, to the plan
      u = -K x + d of least (d_0 - d_n)'S (d_0 - d_n) + d_1'S d_1 + ..., d_n = u_n + K x. A fixed number of sweeps finds
      it, within limits that are narrower by `margin`, and each input is moved into its limits.

    So without disturbances the limits are kept forever if one plan was safe, however many sweeps are made: see
    `PredictiveDesign.filter_claims`. The memory `choice` is 0 and 1 for these, and 2 where neither is safe: the plan of
    the sweeps is then taken as it is. `SafetyFilter.of` makes the filter of a design.

    Parameters
    ----------
    planner
        The predictive law of the design, with the narrower limits.
    law
        The law whose command is filtered. None for a command that comes as a reference of the plant's inputs.
    P, level
        The terminal ellipsoid x'P x <= level, (nx, nx) and a number.
    low, high
        The limits of the rows, (nc,), as `planner` has them, but not narrower.
    cones
        The cones among the rows, not narrower.

    References
    ----------
    Wabersich and Zeilinger (2021), A predictive safety filter for learning-based control of constrained nonlinear
    dynamical systems, Automatica 129.

    Examples
    --------
    >>> plant = wb.CartPole()
    >>> cart = wb.linearize(wb.open_loop(plant), t=0.0, x=np.zeros(4), at_rest=True)
    >>> limits = {"F": (-3.0, 3.0), "x": (-0.5, 0.5)}
    >>> design = wb.predictive_design(cart, 0.02, np.eye(4), [[0.1]], 20, limits=limits, soft_weight=1e4)
    >>> wb.SafetyFilter.of(plant, design).follows.names
    ('F',)
    """

    planner: ModelPredictive
    law: AbstractController | None
    P: Matrix = parameter(unit=ANY, shape=("nx", "nx"), is_derived=True)
    level: float = parameter(unit=ANY, low=0, is_derived=True)
    low: Vector = parameter(unit=ANY, shape=("nc",))
    high: Vector = parameter(unit=ANY, shape=("nc",))
    cones: tuple[LimitCone, ...] = ()

    @staticmethod
    def of(
        plant: AbstractPlant, design: object, law: AbstractController | None = None, margin: float = 0.01
    ) -> SafetyFilter:
        """The safety filter of a design for a plant, once in its period. It reads an estimate of each state.

        Parameters
        ----------
        plant
            The plant.
        design
            The result of `predictive_design` with limits of inputs, states or outputs, without `delay`, `rate_limits`
            and `offset_free`.
        law
            The law whose command is filtered; by default the command is a reference of the plant's inputs.
        margin
            By how much limits of states are narrower for the plan of the sweeps, as a share of their distance from the
            rest. A plan whose sweeps are not done is then more often safe.

        Raises
        ------
        ValueError
            If `design` is no such result, or the law drives other signals than the plant's inputs or has another
            period.
        DesignError
            If the design has no terminal ellipsoid, as that of limits of changes.
        """
        own = getattr(design, "filter_arguments", None)
        if not isinstance(own, Mapping):
            raise refusal("SafetyFilter.of(design=...)", "the result of `predictive_design`", design)
        share = 1 - finite("SafetyFilter.of(margin=...)", margin, low=0.0, high=0.9)
        planner = ModelPredictive.of(plant, design)
        if planner.target is not None or planner.A.shape[0] > plant.states.size:
            raise refusal("SafetyFilter.of(design=...)", "a design without `delay` and `offset_free`", design)
        if law is not None and law.drives.labels != plant.inputs.labels:
            raise refusal(
                "SafetyFilter.of(law=...)", f"a law that drives {', '.join(plant.inputs.labels)}", law.drives.labels
            )
        if law is not None and law.period not in (None, planner.period):
            raise refusal("SafetyFilter.of(law=...)", f"a law without a period, or of {planner.period:g} s", law.period)
        narrow = np.r_[np.ones(plant.inputs.size), np.full(len(planner.low) - plant.inputs.size, share)]
        cones = tuple(
            cone if cone.inputs else replace(cone, offset=cone.offset - (1 - share) * abs(cone.offset))
            for cone in planner.cones
        )
        inner = replace(planner, low=planner.low * narrow, high=planner.high * narrow, cones=cones)
        made = SafetyFilter(inner, law, **own, low=planner.low, high=planner.high, cones=planner.cones)
        period = planner.period
        assert period is not None  # as each design has one
        return made.run_every(period)

    # ports

    @property
    def reads(self) -> Layout:
        own = self.planner.states
        more = () if self.law is None else tuple(e for e in self.law.reads.entries if e.name not in own)
        return own + Layout(more)

    @property
    def follows(self) -> Layout:
        return self.planner.inputs if self.law is None else self.law.follows

    @property
    def drives(self) -> Layout:
        return self.planner.inputs

    @property
    def memory(self) -> Layout:
        N, nc, nu = self.planner.horizon, self.low.shape[0], self.drives.size
        own = Layout(
            (
                Entry("plan", np.zeros(N * nc), ANY),
                Entry("backup", np.zeros(N * nu), ANY),
                Entry("choice", np.zeros(()), "1"),
                Entry("residual", np.zeros(()), "1"),
            )
        )
        return own if self.law is None else own + self.law.memory.with_prefix("law.")

    @property
    def command_limits(self) -> tuple[Vector, Vector]:
        """The limits (nu,) of the command, in the units of the inputs."""
        nu, u0 = self.drives.size, self.planner.u0
        return self.low[:nu] + u0, self.high[:nu] + u0

    @property
    def K(self) -> Matrix:
        """The gain of the LQR law, (nu, nx)."""
        return self.planner.K

    # equations

    def command(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Signals:
        nominal = self._nominal(t, z, est, ref)
        answer = self._answer(z, est, nominal)
        u = ca.if_else(answer.choice == NOMINAL, nominal, self.planner.u0 + answer.v)
        return Signals(self.drives.view(u))

    def update(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Parts:
        """The plans of the next period, the choice, the residual, and the memory of the law."""
        answer = self._answer(z, est, self._nominal(t, z, est, ref))
        following = {
            "plan": ca.vec(answer.plan),
            "backup": ca.vec(answer.backup),
            "choice": answer.choice,
            "residual": answer.residual,
        }
        if self.law is None:
            return following
        assert self.period is not None
        after = self._held.advance(t, *self._of_law(z, est, ref), self.period)
        return following | prefix_names({"law": after})

    @property
    def _held(self) -> AbstractController:
        """The law in the period of the filter."""
        assert self.law is not None
        return self.law if self.period is None else self.law.run_every(self.period)

    def _of_law(self, z: Parts, est: Reads, ref: Follows) -> tuple[Signals, Signals, Signals]:
        assert self.law is not None
        names = self.law.reads.names
        return Signals(strip_prefix("law", z)), Signals({name: est[name] for name in names}), Signals(dict(ref))

    def _nominal(self, t: Number, z: Parts, est: Reads, ref: Follows) -> ca.SX:
        """The command (nu, 1) of the law, or of the reference."""
        signals = ref if self.law is None else self._held.command(t, *self._of_law(z, est, ref))
        return column(signals, self.drives)

    def _answer(self, z: Parts, est: Reads, nominal: ca.SX) -> FilterAnswer:
        """The first safe input of the three, and what the next period needs."""
        own, N, nu = self.planner, self.planner.horizon, self.drives.size
        e = column(est, own.states) - own.x0
        first = nominal - own.u0 + own.K @ e
        alone = ca.horzcat(first, ca.SX.zeros(nu, N - 1))
        is_nominal_safe = is_safe_plan(self, e, alone)
        rows, closed = own.F - own.E @ own.K, own.A - own.B @ own.K
        nc, kept = self.low.shape[0], ca.reshape(z["plan"], -1, N)

        def start(c: ca.SX, d: ca.SX, memory: ca.SX) -> tuple[ca.SX, ...]:
            base = rows @ c + own.E @ d
            return closed @ c + own.B @ d, base, memory + base

        one = metric_sweep if own.gains is None else admm_sweep

        def sweep(both: ca.SX, base: ca.SX, safe: ca.SX) -> tuple[ca.SX, ...]:
            after = ca.vertcat(*one(own, ca.reshape(both[:-1], nc, N), base))
            return (ca.if_else(ca.logic_not(safe), after, both),)

        _, base, zeta = bounded_loop(N, start, e, alone, kept)
        begun = ca.vertcat(ca.vec(zeta), 0.0)
        (both,) = bounded_loop(own.sweeps, sweep, begun, constants=(base, is_nominal_safe))
        zeta = ca.reshape(both[:-1], nc, N)

        def ahead(c: ca.SX, row: ca.SX) -> tuple[ca.SX, ...]:
            v = inputs_within_limits(self, row)
            return own.A @ c + own.B @ v, v + own.K @ c

        _, planned = bounded_loop(N, ahead, e, zeta[:nu, :])
        backup = ca.reshape(z["backup"], nu, N)
        share, is_safe = largest_safe_share(self, e, backup, planned)
        between = backup + (planned - backup) * share
        choice = ca.if_else(is_nominal_safe, NOMINAL, ca.if_else(is_safe, BETWEEN, UNPROVED))
        d = ca.if_else(is_nominal_safe, alone, ca.if_else(is_safe, between, planned))
        v = inputs_within_limits(self, d[:, 0] - own.K @ e)
        # Not shifted by a stage: what the filter corrects begins at the first stage again.
        plan = ca.if_else(is_nominal_safe, ca.SX.zeros(nc, N), zeta - base)
        following = ca.horzcat(d[:, 1:], ca.SX.zeros(nu, 1))
        return FilterAnswer(v, choice, following, plan, both[-1])
