"""Fuzzy adaptive sliding mode: a rule base says how fast the switching gain learns."""

from collections.abc import Mapping

import casadi as ca
import numpy as np

from workbench.arms.arm_contracts import AbstractArmController
from workbench.arms.dynamics import AbstractArm
from workbench.arms.laws.adaptive_sliding_mode import (
    AbstractAdaptation,
    AbstractAdaptiveSlidingMode,
    AdaptiveSlidingMode,
    PlainAdaptation,
)
from workbench.arms.laws.sliding_surface import SWITCHINGS
from workbench.blocks.loop.contracts import Follows, Parts, Reads
from workbench.core import Entry, Layout, block, initial, option, parameter
from workbench.core.block import Column, Matrix, Number, Scalar, Vector
from workbench.core.units import per_second


@block
class RuleBase:
    """The rate of adaptation by fuzzy rules, from the size x = |s_i| of the sliding variable and its trend v:

        r(x, v) = sum_ab mu_a(x) nu_b(v) scale_ab / sum_ab mu_a(x) nu_b(v)
        mu_a(x) = exp(-((x - x_a) / w_x)^2 / 2),    nu_b(v) = exp(-((v - v_b) / w_v)^2 / 2)

    Rule (a, b) reads: if x is about x_a and v is about v_b, then r is scale_ab. The sets of one input share one width,
    so that beyond the last centre the last rule wins.

    Examples
    --------
    >>> from workbench.arms.laws import RuleBase
    >>> RuleBase([0.0, 1.0], 0.1, [0.0, 1.0], 0.1, np.eye(2)).strength(0.5, 0.5)
    SX(0.5)
    """

    sizes: Vector = parameter(default=(0.0, 0.5, 1.0), unit="rad/s", shape=("a",), symbol="x")
    size_width: Scalar = parameter(default=0.25, unit="rad/s", low=0, strict=True, symbol="w_x")
    trends: Vector = parameter(default=(-5.0, 0.0, 5.0), unit="rad/s^2", shape=("b",), symbol="v")
    trend_width: Scalar = parameter(default=2.5, unit="rad/s^2", low=0, strict=True, symbol="w_v")
    scale: Matrix = parameter(
        default=((0.0, 0.2, 0.5), (0.2, 1.0, 2.0), (1.0, 2.0, 4.0)), unit="", low=0, shape=("a", "b"), symbol="r"
    )

    def __post_init__(self) -> None:
        for name in ("sizes", "trends"):
            centres = getattr(self, name)
            if len(centres) == 0 or np.any(centres[1:] <= centres[:-1]):
                raise ValueError(
                    f"`RuleBase({name}=...)` must hold at least one centre, in rising order: the rules of "
                    f"`scale` follow it. Got {np.array2string(centres, separator=', ')}."
                )

    def strength(self, x: Column, v: Column) -> ca.SX:
        """r(x, v), elementwise for x and v of shape (n, 1)."""
        rows: list[ca.SX] = []
        for x_i, v_i in zip(ca.vertsplit(x), ca.vertsplit(v), strict=True):
            mu = _weights(x_i, self.sizes, self.size_width)
            nu = _weights(v_i, self.trends, self.trend_width)
            rows.append(mu.T @ self.scale @ nu)
        return ca.vertcat(*rows)


def _weights(x: ca.SX, centres: Vector, width: Scalar) -> ca.SX:
    """Gaussian memberships of a number x in sets of one width, divided by their sum, (m, 1)."""
    exponents = -(((x - centres) / width) ** 2) / 2
    mu = ca.exp(exponents - ca.mmax(exponents))  # no 0 / 0 where x is many widths from every centre
    share: ca.SX = mu / ca.sum1(mu)
    return share


@block
class FuzzyAsmc(AbstractAdaptiveSlidingMode):
    """Adaptive sliding mode whose rate of adaptation is set by a fuzzy rule base:

        s    = ed + Lambda e,                        e = q - q_ref
        tau  = M qdd_r + C qd_r + G - K o sat(s / phi),                K(0) >= 0
        K_i' = gamma r(|s_i|, v_i) |s_i|             (`adaptation`: Plain, DeadZone or Leakage)
        v_i  = (|s_i| - z_i) / lag,    z_i' = v_i,    z(0) = 0

    where r is the `rules`, v_i the trend d|s_i|/dt behind a lag, and all else as of `AdaptiveSlidingMode`, whose
    Lyapunov argument is not carried over. The paper names this rival and prints none of its rules; these are ours.

    References
    ----------
    Wang (1997), A Course in Fuzzy Systems and Control (product inference, centre-average defuzzifier).

    Examples
    --------
    >>> from workbench.arms.laws import FuzzyAsmc
    >>> law = FuzzyAsmc(wb.paper_arm(), [6.0, 6.0], 0.1, 1.0, 0.1, [1.0, 1.0])
    >>> plant, wanted = wb.Manipulator(wb.paper_arm(), q=[0.5, 0.0]), wb.Sines("q", "rad", [1.0, 0.5], [2.0, 3.0])
    >>> wb.ClosedLoop(plant, controller=law, reference=wanted).ode().states.size
    8
    """

    model: AbstractArm
    Lambda: Vector = parameter(unit="1/s", low=0, strict=True, shape=("n",), symbol="Lambda")
    phi: Scalar = parameter(unit="{position}/s", low=0, strict=True, symbol="phi")
    gamma: Scalar = parameter(unit="{force}/{position}", low=0, strict=True, symbol="gamma")
    lag: Scalar = parameter(unit="s", low=0, strict=True, symbol="T_v")
    K: Vector = initial(unit="{force}", shape=("n",), symbol="K")
    rules: RuleBase = RuleBase()
    adaptation: AbstractAdaptation = PlainAdaptation()
    saturation: str = option(SWITCHINGS, default="clip")

    def __post_init__(self) -> None:
        self.check_gains()

    @property
    def memory(self) -> Layout:
        return self.gains + Layout((Entry("s_slow", np.zeros(self.dof), per_second(self.position), symbol="z"),))

    def rate(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Parts:
        s = self._sliding_variables(est, ref).s
        v = self._trend(z, s)
        r = self.rules.strength(ca.fabs(s), v)
        return {"K": self.adaptation.rate(self.gamma * r * ca.fabs(s), s, z["K"]), "s_slow": v}

    def signals(self, z: Parts, est: Reads, ref: Follows) -> Parts:
        s = self._sliding_variables(est, ref).s
        return {"s": s, "r": self.rules.strength(ca.fabs(s), self._trend(z, s))}

    def without(self) -> Mapping[str, AbstractArmController]:
        plain = AdaptiveSlidingMode(
            self.model, self.Lambda, self.phi, self.gamma, self.K, self.adaptation, self.saturation
        )
        return {"fuzzy rules": plain, "adaptation": plain.without()["adaptation"]} | self.without_layer()

    def _trend(self, z: Parts, s: ca.SX) -> ca.SX:
        v: ca.SX = (ca.fabs(s) - z["s_slow"]) / self.lag
        return v
