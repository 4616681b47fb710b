"""The growth of a switching gain: by the size of s, and in the robust forms that keep it from drifting."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

import casadi as ca
import numpy as np

from workbench.controllers.sliding_surface import SURFACE_PULLS_THE_ERROR, AbstractSlidingMode
from workbench.core import AbstractArm, Entry, Layout, block, parameter
from workbench.core.block import Column, Scalar, Vector
from workbench.core.claim import Claim
from workbench.core.numbers import Bounds
from workbench.validation.signatures import door

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

    @door
    def check(self, dof: int) -> None:
        """Refuse, with a `ValueError`, to serve a law of that many joints."""
        del dof


@block
class Plain(AbstractAdaptation):
    """K_i' = gamma |s_i|: the gain never falls.

    Inside a boundary layer s does not vanish, so the gain never stops growing either.
    """

    def rate(self, growth: Column, s: Column, K: Column) -> ca.SX:
        """K' = growth."""
        return growth


@block
class Frozen(AbstractAdaptation):
    """K_i' = 0: the gain stays constant, for comparison with a law that adapts."""

    def rate(self, growth: Column, s: Column, K: Column) -> ca.SX:
        """K' = 0."""
        return ca.SX.zeros(K.shape)


@block
class DeadZone(AbstractAdaptation):
    """K_i' = gamma |s_i| where |s_i| > width, 0 elsewhere: no adaptation to the error that a boundary layer leaves.

    K' jumps at |s_i| = width. The gain stops growing once s stays within the zone, so `width` is
    best no smaller than the boundary layer.
    """

    width: Scalar = parameter(unit="rad/s", low=0, strict=True, symbol="epsilon")

    def rate(self, growth: Column, s: Column, K: Column) -> ca.SX:
        """K' = growth outside the zone, 0 within."""
        return ca.if_else(ca.fabs(s) > self.width, growth, 0)


@block
class Leakage(AbstractAdaptation):
    """K_i' = gamma |s_i| - sigma (K_i - level_i): the gain decays to its level where |s_i| is small.

    Where |s_i| <= c a gain that starts there stays below level_i + gamma c / sigma. `level` is meant to be K(0).

    Parameters
    ----------
    level
        (n,), what the gains return to.

    References
    ----------
    Ioannou and Sun (1996), Robust Adaptive Control, chapter 8 (leakage, or sigma-modification).
    """

    sigma: Scalar = parameter(unit="1/s", low=0, strict=True, symbol="sigma")
    level: Vector = parameter(unit="N m", low=0, shape=("n",), symbol="K^*")

    def rate(self, growth: Column, s: Column, K: Column) -> ca.SX:
        """K' = growth - sigma (K - level)."""
        rate: ca.SX = growth - self.sigma * (K - self.level)
        return rate

    def check(self, dof: int) -> None:
        """Refuse a law that has not one gain for each level."""
        if len(self.level) != dof:
            raise ValueError(
                f"`Leakage(level=...)` must hold one number for each of the {dof} gains it leaks to; "
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
        """The gains as a state that starts at K(0)."""
        return Layout((Entry("K", self.K, self.force, Bounds(low=0), "K"),))

    @property
    def memory(self) -> Layout:
        """The gains."""
        return self.gains
