from collections.abc import Mapping
from typing import ClassVar

import casadi as ca

from workbench.arms.arm_contracts import AbstractArmController
from workbench.blocks.loop.contracts import Follows, Parts, Reads
from workbench.blocks.loop.wiring import prefix_names, strip_prefix
from workbench.core import Layout, Signals, block
from workbench.core.block import Number


@block
class DisturbanceCompensation(AbstractArmController):
    """A law with the estimated disturbance added to its torque, for M qdd + C qd + G + D = tau:

        tau = tau_law + D_hat

    D_hat is that of the loop's observer, zero of one that estimates none; a law that has it already is refused.

    References
    ----------
    Chen et al. (2016), Disturbance-observer-based control and related methods: an overview, IEEE TIE 63(2).

    Examples
    --------
    >>> from workbench.arms.laws import DisturbanceCompensation
    >>> from workbench.arms.observers import OracleFilter, PrintedFilter, StateAndDisturbanceObserver
    >>> law = DisturbanceCompensation(wb.SlidingMode(wb.paper_arm(), [6.0, 6.0], [40.0, 20.0], 0.1))
    >>> plant, wanted = wb.Manipulator(wb.paper_arm(), q=[0.5, 0.0]), wb.Sines("q", "rad", [1.0, 0.5], [2.0, 3.0])
    >>> filters = OracleFilter(2, 20.0), PrintedFilter(2, 20.0)
    >>> true, printed = (StateAndDisturbanceObserver(wb.ArmFullState(2), each) for each in filters)
    >>> [wb.ClosedLoop(plant, observer, law, wanted).ode().states.size for observer in (true, printed)]
    [6, 8]
    """

    estimates: ClassVar[tuple[str, ...]] = ("q", "qd", "d")

    law: AbstractArmController

    def __post_init__(self) -> None:
        n = self.dof
        d = ca.SX.sym("d_hat", n)
        t, z = ca.SX.sym("t"), self.law.memory.view(self.law.memory.symbols())
        est = Signals(q=ca.SX.sym("q_hat", n), qd=ca.SX.sym("qd_hat", n), d=d)
        ref = Signals(q=ca.SX.sym("q_ref", n), qd=ca.SX.sym("qd_ref", n), qdd=ca.SX.sym("qdd_ref", n))
        sampled = self.law.run_every(1.0)  # for laws that only a computer can run
        if ca.depends_on(ca.SX(sampled.torque(t, z, est, ref)), d):
            raise ValueError(
                "`DisturbanceCompensation(law=...)` must be a law whose torque is free of D_hat, which is added here "
                f"and must not count twice; that of `{type(self.law).__name__}` has it: take the law as it is."
            )

    @property
    def dof(self) -> int:
        return self.law.dof

    @property
    def units(self) -> tuple[str, ...]:
        return self.law.units

    @property
    def memory(self) -> Layout:
        return self.law.memory.with_prefix("law.")

    def torque(self, t: Number, z: Parts, est: Reads, ref: Follows) -> ca.SX:
        return self._law.torque(t, strip_prefix("law", z), est, ref) + est.d

    def rate(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Parts:
        return prefix_names({"law": self._law.rate(t, strip_prefix("law", z), est, ref)})

    def signals(self, z: Parts, est: Reads, ref: Follows) -> Parts:
        return self._law.signals(strip_prefix("law", z), est, ref)

    @property
    def method(self) -> str:
        return self.law.method

    def advance(self, t: Number, z: Parts, est: Reads, ref: Follows, period: float) -> Parts:
        return prefix_names({"law": self._law.advance(t, strip_prefix("law", z), est, ref, period)})

    def without(self) -> Mapping[str, AbstractArmController]:
        less = self.law.without()
        return {"disturbance compensation": self.law} | {
            name: DisturbanceCompensation(law) for name, law in less.items()
        }

    @property
    def _law(self) -> AbstractArmController:
        return self.law if self.period is None else self.law.run_every(self.period)
