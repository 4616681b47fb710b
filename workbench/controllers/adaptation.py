"""How a switching gain learns: growth by the size of s, and the robust forms that keep it from drifting.

Each form takes what the gain would grow by, `growth` = gamma |s|, and says what it does grow by.
"""

from __future__ import annotations

from abc import ABC, abstractmethod

import casadi as ca

from workbench.core import block, parameter
from workbench.core.block import Column, Scalar, Vector


class AbstractAdaptation(ABC):
    """A rule K' = rate(growth, s, K) for the gains K (n, 1)."""

    @abstractmethod
    def rate(self, growth: Column, s: Column, K: Column) -> ca.SX:
        """K', (n, 1), in N m/s; `growth` (n, 1) in N m/s, `s` (n, 1) in rad/s, `K` (n, 1) in N m."""

    @abstractmethod
    def check(self, dof: int) -> None:
        """Refuse, with a `ValueError`, to serve a law of that many joints."""


@block
class Plain(AbstractAdaptation):
    """K_i' = gamma |s_i|: the gain never falls.

    Inside a boundary layer s does not vanish, so the gain never stops growing either.
    """

    def rate(self, growth: Column, s: Column, K: Column) -> ca.SX:
        """The growth."""
        del s, K
        return growth

    def check(self, dof: int) -> None:
        """Any number of joints will do."""
        del dof


@block
class Frozen(AbstractAdaptation):
    """K_i' = 0: the gain stays what it was, to see what learning is worth."""

    def rate(self, growth: Column, s: Column, K: Column) -> ca.SX:
        """Nothing."""
        del growth, s
        return ca.SX.zeros(K.shape)

    def check(self, dof: int) -> None:
        """Any number of joints will do."""
        del dof


@block
class DeadZone(AbstractAdaptation):
    """K_i' = gamma |s_i| where |s_i| > width, 0 elsewhere: no learning from what the layer leaves over.

    K' jumps at |s_i| = width. The gain stops growing once s stays within the zone, so `width` is
    best no smaller than the boundary layer.
    """

    width: Scalar = parameter(unit="rad/s", low=0, strict=True, symbol="epsilon")

    def rate(self, growth: Column, s: Column, K: Column) -> ca.SX:
        """The growth outside the zone."""
        del K
        return ca.if_else(ca.fabs(s) > self.width, growth, 0)

    def check(self, dof: int) -> None:
        """Any number of joints will do."""
        del dof


@block
class Leakage(AbstractAdaptation):
    """K_i' = gamma |s_i| - sigma (K_i - level_i): what is not needed is forgotten.

    Where |s_i| <= c a gain that starts there stays below level_i + gamma c / sigma. `level` is meant to be K(0), and
    is a parameter of its own because the equation needs it after the start.

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
        """The growth less the leak."""
        del s
        rate: ca.SX = growth - self.sigma * (K - self.level)
        return rate

    def check(self, dof: int) -> None:
        """One level for each joint."""
        if len(self.level) != dof:
            raise ValueError(
                f"`Leakage(level=...)` must hold one number for each of the {dof} gains it leaks to; "
                f"got {len(self.level)}."
            )
