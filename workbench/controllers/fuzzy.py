"""A fuzzy rule base in closed form: Gaussian sets, products of memberships, a weighted average."""

from __future__ import annotations

import casadi as ca
import numpy as np

from workbench.core import block, parameter
from workbench.core.block import Column, Matrix, Scalar, Vector


@block
class RuleBase:
    """How strongly to learn, from the size x = |s_i| of the sliding variable and its trend v:

        r(x, v) = sum_ab mu_a(x) nu_b(v) scale_ab / sum_ab mu_a(x) nu_b(v)
        mu_a(x) = exp(-((x - x_a) / w_x)^2 / 2),    nu_b(v) = exp(-((v - v_b) / w_v)^2 / 2)

    Rule (a, b) reads: if x is about x_a and v is about v_b, then r is scale_ab. r always lies between the
    smallest and the largest consequent. The sets of one input share one width, so that beyond the
    last centre the last rule wins (with unequal widths the widest set would, wherever its centre).

    Parameters
    ----------
    sizes, trends
        (a,) and (b,), the centres of the sets of x and of v.
    scale
        (a, b), the consequents; each row one size, each column one trend.
    """

    sizes: Vector = parameter(default=(0.0, 0.5, 1.0), unit="rad/s", shape=("a",), symbol="x")
    size_width: Scalar = parameter(default=0.25, unit="rad/s", low=0, strict=True, symbol="w_x")
    trends: Vector = parameter(default=(-5.0, 0.0, 5.0), unit="rad/s^2", shape=("b",), symbol="v")
    trend_width: Scalar = parameter(default=2.5, unit="rad/s^2", low=0, strict=True, symbol="w_v")
    scale: Matrix = parameter(
        default=((0.0, 0.2, 0.5), (0.2, 1.0, 2.0), (1.0, 2.0, 4.0)),
        unit="",
        low=0,
        shape=("a", "b"),
        symbol="r",
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
            mu = weights(x_i, self.sizes, self.size_width)
            nu = weights(v_i, self.trends, self.trend_width)
            rows.append(mu.T @ self.scale @ nu)
        return ca.vertcat(*rows)


def weights(x: ca.SX, centres: Vector, width: Scalar) -> ca.SX:
    """Gaussian memberships of a number x in sets of one width, divided by their sum, (m, 1).

    The largest exponent is taken out of all of them, which changes nothing but keeps 0 / 0 away
    where x is many widths from every centre.
    """
    exponents = -(((x - centres) / width) ** 2) / 2
    mu = ca.exp(exponents - ca.mmax(exponents))
    share: ca.SX = mu / ca.sum1(mu)
    return share
