"""The linear laws of this study about the rest of a reference: clipped, with integrals, governed and predictive."""

from __future__ import annotations

from copy import copy

import casadi as ca
import numpy as np

import workbench as wb
from studies.d2_planning.target import ANY, Target


@wb.block
class ClippedRegulator(wb.Controller):
    """The LQR law about the rest of a reference, with a clipped command:

        u = clip(u_s - K (x_hat - x_s)).

    Its observer knows the clipped command, so there is nothing to wind up.
    """

    target: Target
    K: wb.Array = wb.parameter(unit=ANY, shape=("nu", "nx"))

    @property
    def reads(self) -> wb.Layout:
        """The states and d."""
        return self.target.reads

    @property
    def follows(self) -> wb.Layout:
        """The outputs that follow a reference."""
        return self.target.outputs

    @property
    def drives(self) -> wb.Layout:
        """The inputs."""
        return self.target.inputs

    def command(self, t, z, est, ref):  # type: ignore[no-untyped-def]
        """The clipped command."""
        r = self.follows.flatten(ref)
        u = self.target.input(est, r) - self.K @ self.target.error(est, r)
        return wb.Signals(self.drives.view(self.target.limit(u)))


@wb.block
class IntegralRegulator(wb.Controller):
    """The LQR law with integrals of the errors, a clipped command, and back-calculation by a gain M:

        w = u_s(r) - K (x_hat - x_s) - Ki z,      u = clip(w),      z+ = z + (C x_hat - r) + M (u - w).

    It does not use the estimate of d. With M = 0 the integrals wind up.
    """

    target: Target
    K: wb.Array = wb.parameter(unit=ANY, shape=("nu", "nx"))
    Ki: wb.Array = wb.parameter(unit=ANY, shape=("nu", "nr"))
    M: wb.Array = wb.parameter(unit=ANY, shape=("nr", "nu"))
    C: wb.Array = wb.parameter(unit=ANY, shape=("nr", "nx"))
    period: float = 1.0

    @property
    def reads(self) -> wb.Layout:
        """The states; the estimate of d is not used."""
        return self.target.states

    @property
    def follows(self) -> wb.Layout:
        """The outputs that follow a reference."""
        return self.target.outputs

    @property
    def drives(self) -> wb.Layout:
        """The inputs."""
        return self.target.inputs

    @property
    def memory(self) -> wb.Layout:
        """The sums of the errors."""
        return wb.Layout((wb.core.Entry("z", np.zeros(self.follows.size), ANY),))

    def _free(self, z: wb.Signals, est: wb.Signals, ref: wb.Signals) -> tuple[ca.SX, ca.SX]:
        """The command without limits, and the error of the state."""
        r = self.follows.flatten(ref)
        e = self.target.error(est, r)
        w: ca.SX = self.target.disturbance_free_input(r) - self.K @ e - self.Ki @ z["z"]
        return w, e

    def command(self, t, z, est, ref):  # type: ignore[no-untyped-def]
        """The clipped command."""
        return wb.Signals(self.drives.view(self.target.limit(self._free(z, est, ref)[0])))

    def update(self, t, z, est, ref):  # type: ignore[no-untyped-def]
        """The sums of the next period."""
        w, e = self._free(z, est, ref)
        return {"z": z["z"] + ca.SX(self.C) @ e + ca.SX(self.M) @ (self.target.limit(w) - w)}


@wb.block
class GovernedRegulator(wb.Controller):
    """A scalar reference governor before the LQR law: the law follows v, which moves toward r as far as is allowed:

        v+ = v + kappa (r - v),   0 <= kappa <= 1 the largest with   low <= u_s - K Ac^k (x_hat - x_s) <= high,

    for k = 0, ..., N, with x_s and u_s of v+. The rows of Phi are K Ac^k. `margin` is a share of the limits' distance
    that is kept free at both ends. If no kappa is allowed, v stays, and the command is clipped.

    References: Gilbert and Tan (1991); Garone, Di Cairano and Kolmanovsky (2017), section 3.
    """

    target: Target
    K: wb.Array = wb.parameter(unit=ANY, shape=("nu", "nx"))
    C: wb.Array = wb.parameter(unit=ANY, shape=("nr", "nx"))
    Phi: wb.Array = wb.parameter(unit=ANY, shape=("M", "nx"))
    margin: float = wb.parameter(unit="1", low=0)
    period: float = 1.0

    @property
    def reads(self) -> wb.Layout:
        """The states and d."""
        return self.target.reads

    @property
    def follows(self) -> wb.Layout:
        """The outputs that follow a reference."""
        return self.target.outputs

    @property
    def drives(self) -> wb.Layout:
        """The inputs."""
        return self.target.inputs

    @property
    def memory(self) -> wb.Layout:
        """The reference v that is followed, and 1 once there is one."""
        v = wb.core.Entry("v", np.zeros(self.follows.size), ANY)
        return wb.Layout((v, wb.core.Entry("begun", np.zeros(()), "1")))

    def _governed(self, z: wb.Signals, est: wb.Signals, ref: wb.Signals) -> ca.SX:
        """The reference v of this period."""
        r, own = self.follows.flatten(ref), self.target
        x = own.states.flatten({n: est[n] for n in own.states.names})
        begin = own.r0 + ca.SX(self.C) @ (x - own.x0)
        v = ca.if_else(z["begun"] > 0.5, z["v"], begin)
        count = self.Phi.shape[0] // self.drives.size
        room = self.margin * (ca.SX(own.high) - ca.SX(own.low))
        high, low = (ca.repmat(end, count, 1) for end in (ca.SX(own.high) - room, ca.SX(own.low) + room))
        Phi = ca.SX(self.Phi)
        at = ca.repmat(own.input(est, v), count, 1) - Phi @ own.error(est, v)
        slope = (ca.repmat(ca.SX(own.G), count, 1) + Phi @ ca.SX(own.X)) @ (r - v)
        small = ca.fabs(slope) < 1e-12
        most = ca.if_else(slope > 0, high - at, low - at) / ca.if_else(small, 1.0, slope)
        kappa = ca.fmin(ca.fmax(ca.mmin(ca.if_else(small, 1.0, most)), 0.0), 1.0)
        following: ca.SX = v + kappa * (r - v)
        return following

    def command(self, t, z, est, ref):  # type: ignore[no-untyped-def]
        """The command of the LQR law that follows v."""
        v, own = self._governed(z, est, ref), self.target
        return wb.Signals(self.drives.view(own.limit(own.input(est, v) - self.K @ own.error(est, v))))

    def update(self, t, z, est, ref):  # type: ignore[no-untyped-def]
        """The reference that was followed."""
        return {"v": self._governed(z, est, ref), "begun": ca.SX(1.0)}


@wb.block
class TargetPredictive(wb.Controller):
    """The predictive law of the workbench about the rest of a reference and a disturbance, whose limits move with it.

    The plan of `law` is for deviations from x_s and u_s, and its limits are low - u_s and high - u_s.
    """

    target: Target
    law: wb.ModelPredictive
    period: float = 1.0

    @property
    def reads(self) -> wb.Layout:
        """The states and d."""
        return self.target.reads

    @property
    def follows(self) -> wb.Layout:
        """The outputs that follow a reference."""
        return self.target.outputs

    @property
    def drives(self) -> wb.Layout:
        """The inputs."""
        return self.target.inputs

    @property
    def memory(self) -> wb.Layout:
        """That of the predictive law."""
        return self.law.memory

    def _about_rest(self, est: wb.Signals, ref: wb.Signals) -> tuple[wb.ModelPredictive, wb.Signals, ca.SX]:
        """The law with the limits about the rest, the error of the state, and the input of the rest."""
        r, own = self.follows.flatten(ref), self.target
        u_s = own.input(est, r)
        law = copy(self.law)  # of symbols: `replace` takes numbers alone
        object.__setattr__(law, "low", ca.SX(own.low) - u_s)
        object.__setattr__(law, "high", ca.SX(own.high) - u_s)
        return law, wb.Signals(own.states.view(own.error(est, r))), u_s

    def command(self, t, z, est, ref):  # type: ignore[no-untyped-def]
        """The first input of the plan."""
        law, e, u_s = self._about_rest(est, ref)
        own = law.command(t, z, e, wb.Signals())
        return wb.Signals(self.drives.view(self.drives.flatten(own) + u_s))

    def update(self, t, z, est, ref):  # type: ignore[no-untyped-def]
        """The plan of the next period."""
        law, e, _ = self._about_rest(est, ref)
        return law.update(t, z, e, wb.Signals())
