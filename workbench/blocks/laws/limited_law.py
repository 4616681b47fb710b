from __future__ import annotations

import casadi as ca
import numpy as np

from workbench.blocks.loop.contracts import AbstractController, Follows, Parts, Reads
from workbench.blocks.loop.linear_blocks import LinearLaw
from workbench.core import Layout, Signals, block, parameter
from workbench.core.block import Matrix, Number, Vector
from workbench.core.units import ANY
from workbench.core.validation.refusals import matrix


@block
class LimitedLaw(AbstractController):
    """A linear law with limits of its command, whose states follow the limits by a gain M:

        z' = A z + B v + M (u - w),        w = u0 + C z + D v,        u = min(max(w, low), high).

    Within the limits it is the linear law. The design of `lqg_integral` has a gain M that gives its estimator the
    limited command and unwinds its integrals. A discrete law has z+ in the place of z'.

    Parameters
    ----------
    law
        The linear law, as `LinearLaw(answer.controller)`.
    M
        The gain (nz, nu) of the anti-windup, as `answer.anti_windup`.
    low, high
        The lowest and the highest command, or None for no limit. Limits of `Instruments` must be repeated here: the law
        does not know them.

    Raises
    ------
    ValueError
        If M has another shape, or a lower limit is not below the upper one.

    References
    ----------
    Astrom and Hagglund (2006), Advanced PID Control, section 3.5. Hanus, Kinnaert and Henrotte (1987), Conditioning
    technique, a general anti-windup and bumpless transfer method, Automatica 23.

    Examples
    --------
    >>> motor = wb.DCMotor()
    >>> linear = wb.linearize(wb.open_loop(motor), 0.0, [0.0, 0.0])
    >>> answer = wb.lqg_integral(linear, Q=np.diag([1.0, 0.0, 400.0]), R=[[1.0]], Qn=np.eye(2), Rn=[[1e-3]])
    >>> law = wb.LimitedLaw(wb.LinearLaw(answer.controller), answer.anti_windup, low=-12.0, high=12.0)
    >>> law.reads.names, law.follows.names, law.drives.names
    (('omega',), ('omega',), ('v',))
    """

    law: LinearLaw
    M: Matrix = parameter(unit=ANY, shape=("nz", "nu"))
    low: Vector | None = parameter(default=None, unit=ANY, shape=("nu",), symbol="u_min")
    high: Vector | None = parameter(default=None, unit=ANY, shape=("nu",), symbol="u_max")

    def __post_init__(self) -> None:
        matrix("LimitedLaw(M=...)", self.M, self.law.memory.size, self.law.drives.size)
        if self.low is not None and self.high is not None and np.any(self.low >= self.high):
            raise ValueError(
                f"`LimitedLaw(low=..., high=...)` must leave room between them; got {self.low} and {self.high}."
            )
        object.__setattr__(self, "period", self.law.period)

    @property
    def recursion(self) -> bool:
        """True if the law is in discrete time."""
        return self.law.recursion

    @property
    def reads(self) -> Layout:
        return self.law.reads

    @property
    def follows(self) -> Layout:
        return self.law.follows

    @property
    def drives(self) -> Layout:
        return self.law.drives

    @property
    def memory(self) -> Layout:
        return self.law.memory

    def command(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Signals:
        return Signals(self.drives.view(self._limit(self._unlimited_command(t, z, est, ref))))

    def rate(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Parts:
        """The rate of each state, or its value at the next instant of a discrete law."""
        w = self._unlimited_command(t, z, est, ref)
        linear = self.memory.flatten(self.law.rate(t, z, est, ref))
        return self.memory.view(linear + ca.SX(self.M) @ (self._limit(w) - w))

    update = rate

    def run_every(self, period: float) -> LimitedLaw:
        """A copy of the law that a computer runs once in every `period` seconds; a discrete law has its own."""
        self.law.run_every(period)
        return AbstractController.run_every(self, period)

    def _unlimited_command(self, t: Number, z: Parts, est: Reads, ref: Follows) -> ca.SX:
        return self.drives.flatten(self.law.command(t, z, est, ref))

    def _limit(self, w: ca.SX) -> ca.SX:
        w = w if self.low is None else ca.fmax(w, self.low)
        return w if self.high is None else ca.fmin(w, self.high)
