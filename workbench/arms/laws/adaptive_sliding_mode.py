"""Adaptive sliding mode, whose switching gain learns its own size, and the forms of its adaptation."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import ClassVar

import casadi as ca
import numpy as np

from workbench.arms.arm_contracts import AbstractArmController
from workbench.arms.dynamics import AbstractArm
from workbench.arms.laws.sliding_mode import SlidingMode
from workbench.arms.laws.sliding_surface import SURFACE_PULLS_THE_ERROR, SWITCHINGS, AbstractSlidingMode, matrices
from workbench.blocks.loop.contracts import Follows, Parts, Reads
from workbench.core import Entry, Layout, block, initial, option, parameter
from workbench.core.block import Column, Number, Scalar, Vector
from workbench.core.claim import Claim
from workbench.core.numbers import Bounds
from workbench.core.validation.signatures import check_arguments

GAINS_STAY_POSITIVE = Claim(
    "no gain turns negative",
    "K_i >= 0 at all times, from K_i(0) >= 0.",
    "Plestan et al. (2010)",
    margin=lambda y: y["K"],
)


class AbstractAdaptation(ABC):
    """A rule K' = rate(growth, s, K) for the gains K (n, 1), where growth = gamma |s| is that of the plain form."""

    @abstractmethod
    def rate(self, growth: Column, s: Column, K: Column) -> ca.SX:
        """K', (n, 1), in N m/s; `growth` (n, 1) in N m/s, `s` (n, 1) in rad/s, `K` (n, 1) in N m."""

    @check_arguments
    def check(self, dof: int) -> None:
        """Refuse, with a `ValueError`, to serve a law of that many joints."""
        del dof


@block
class PlainAdaptation(AbstractAdaptation):
    """K_i' = gamma |s_i|: the gain never falls, and grows without end inside a boundary layer.

    Examples
    --------
    >>> from workbench.arms.laws import PlainAdaptation
    >>> PlainAdaptation().rate([0.05, 0.3], [1.0, 1.0], [2.0, 2.0])
    SX([0.05, 0.3])
    """

    def rate(self, growth: Column, s: Column, K: Column) -> ca.SX:
        return growth


@block
class NoAdaptation(AbstractAdaptation):
    """K_i' = 0: the gain stays constant, for comparison with a law that adapts.

    Examples
    --------
    >>> from workbench.arms.laws import NoAdaptation
    >>> NoAdaptation().rate([0.05, 0.3], [1.0, 1.0], [2.0, 2.0])
    SX(@1=0, [@1, @1])
    """

    def rate(self, growth: Column, s: Column, K: Column) -> ca.SX:
        return ca.SX.zeros(K.shape)


@block
class DeadZoneAdaptation(AbstractAdaptation):
    """K_i' = gamma |s_i| where |s_i| > width, best no smaller than the boundary layer, and 0 elsewhere.

    Examples
    --------
    >>> from workbench.arms.laws import DeadZoneAdaptation
    >>> DeadZoneAdaptation(0.1).rate([0.05, 0.3], [1.0, 1.0], [2.0, 2.0])
    SX([0.05, 0.3])
    """

    width: Scalar = parameter(unit="rad/s", low=0, strict=True, symbol="epsilon")

    def rate(self, growth: Column, s: Column, K: Column) -> ca.SX:
        return ca.if_else(ca.fabs(s) > self.width, growth, 0)


@block
class LeakageAdaptation(AbstractAdaptation):
    """K_i' = gamma |s_i| - sigma (K_i - level_i): the gain decays to its level where |s_i| is small.

    Where |s_i| <= c a gain that starts there stays below level_i + gamma c / sigma. `level` is meant to be K(0).

    References
    ----------
    Ioannou and Sun (1996), Robust Adaptive Control, chapter 8 (leakage, or sigma-modification).
    """

    sigma: Scalar = parameter(unit="1/s", low=0, strict=True, symbol="sigma")
    level: Vector = parameter(unit="N m", low=0, shape=("n",), symbol="K^*")

    def rate(self, growth: Column, s: Column, K: Column) -> ca.SX:
        rate: ca.SX = growth - self.sigma * (K - self.level)
        return rate

    def check(self, dof: int) -> None:
        if len(self.level) != dof:
            raise ValueError(
                f"`LeakageAdaptation(level=...)` must hold one number for each of the {dof} gains it leaks to; "
                f"got {len(self.level)}."
            )


class AbstractAdaptiveSlidingMode(AbstractSlidingMode):
    """A sliding law whose switching gains K (n,) are states, which grow by a form of adaptation."""

    claims: ClassVar[tuple[Claim, ...]] = (SURFACE_PULLS_THE_ERROR, GAINS_STAY_POSITIVE)

    model: AbstractArm
    gamma: Scalar
    K: Vector
    adaptation: AbstractAdaptation

    def check_gains(self) -> None:
        """Refuse a K(0) below zero, and a form of adaptation for another number of joints."""
        if np.any(self.K < 0):
            raise ValueError(
                f"`{type(self).__name__}(K=...)` must not be negative: K_i sat(s_i / phi) with K_i < 0 drives s_i "
                f"away from zero. Got {np.array2string(self.K, separator=', ')}."
            )
        self.adaptation.check(self.dof)

    @property
    def gains(self) -> Layout:
        return Layout((Entry("K", self.K, self.force, Bounds(low=0), "K"),))

    @property
    def memory(self) -> Layout:
        return self.gains

    @check_arguments
    def torque(self, t: Number, z: Parts, est: Reads, ref: Follows) -> ca.SX:
        M, C, G = matrices(self.model, est)
        _, _, s, qd_r, qdd_r = self._sliding_variables(est, ref)
        return M @ qdd_r + C @ qd_r + G - self._switching_torque(z["K"], s, M)


@block
class AdaptiveSlidingMode(AbstractAdaptiveSlidingMode):
    """Computed torque on a sliding surface, with a switching gain that learns its own size:

        s    = ed + Lambda e,                   e = q - q_ref
        tau  = M qdd_r + C qd_r + G - K o sat(s / phi),                K(0) >= 0
        K_i' = gamma |s_i|                      (`adaptation`: Plain, DeadZone or Leakage)

    where o multiplies joint by joint, qd_r = qd_ref - Lambda e, qdd_r = qdd_ref - Lambda ed, and M, C, G are those of
    `model`: the arm as the designer believes it to be, not the arm that is simulated.

    With sign for sat and |D_i| <= K_i*, V = s^T M s / 2 + sum (K_i - K_i*)^2 / (2 gamma) does not grow in the plain
    form.

    References
    ----------
    Slotine and Li (1991), Applied Nonlinear Control, chapter 9 (s and qd_r for manipulators).
    Plestan et al. (2010), New methodologies for adaptive sliding mode control, Int. J. Control 83(9).

    Examples
    --------
    >>> from workbench.arms.laws import AdaptiveSlidingMode, LeakageAdaptation
    >>> leakage = LeakageAdaptation(0.1, [1.0, 1.0])
    >>> law = AdaptiveSlidingMode(wb.paper_arm(), [6.0, 6.0], 0.1, 2.0, [20.0, 10.0], leakage, "tanh")
    >>> plant, wanted = wb.Manipulator(wb.paper_arm(), q=[0.5, 0.0]), wb.Sines("q", "rad", [1.0, 0.5], [2.0, 3.0])
    >>> wb.ClosedLoop(plant, controller=law, reference=wanted).ode().states.size
    6
    """

    model: AbstractArm
    Lambda: Vector = parameter(unit="1/s", low=0, strict=True, shape=("n",), symbol="Lambda")
    phi: Scalar = parameter(unit="{position}/s", low=0, strict=True, symbol="phi")
    gamma: Scalar = parameter(unit="{force}/{position}", low=0, strict=True, symbol="gamma")
    K: Vector = initial(unit="{force}", shape=("n",), symbol="K")
    adaptation: AbstractAdaptation = PlainAdaptation()
    saturation: str = option(SWITCHINGS, default="clip")

    def __post_init__(self) -> None:
        self.check_gains()

    def rate(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Parts:
        s = self._sliding_variables(est, ref).s
        return {"K": self.adaptation.rate(self.gamma * ca.fabs(s), s, z["K"])}

    def without(self) -> Mapping[str, AbstractArmController]:
        still = SlidingMode(self.model, self.Lambda, self.K, self.phi, self.saturation)
        return {"adaptation": still} | self.without_layer()
