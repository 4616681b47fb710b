"""The least peaks of W S and W T that any stabilising controller reaches, by interpolation in the right half-plane.

S is 1 at each zero and 0 at each pole of the plant there, and T the other way round. Let M be the triangular matrix
with these points z_i on its diagonal, M + M* = b b* and |b_i|^2 = 2 Re z_i. The least norm of a function that takes the
values of H at the points, with derivatives at multiple ones, is ||H(M)||. The matrix of Pick is ||.||^2 I - H(M) H(M)*
in these coordinates, so neither multiple points nor near ones cost digits.

References
----------
Pick (1916), Math. Annalen 77; Nevanlinna (1919). Sarason (1967), Generalized interpolation in H-infinity, Trans. Amer.
Math. Soc. 127. Doyle, Francis, Tannenbaum (1992), Feedback Control Theory, chapter 9.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from workbench.core.validation.notebook_display import show
from workbench.core.validation.number_types import Numbers
from workbench.core.validation.refusals import Array, as_array, describe
from workbench.core.validation.signatures import check_arguments
from workbench.design.frequency.complex_roots import complex_roots
from workbench.design.frequency.integer_polynomials import common_divisor
from workbench.design.matrices import Complex, DesignError, pole_text

if TYPE_CHECKING:
    import control

ON_AXIS = 1e-13  # relative to the modulus: a root that is nearer lies on the imaginary axis


@dataclass(frozen=True, eq=False)
@show
class LeastPeak:
    """The infimum `gamma` of ||W S||, or ||W T||, over all stabilising controllers, and what sets it.

    `interpolation` is the bound from the `zeros` and `poles` of the plant in the right half-plane, in 1/s. `boundary`
    is the bound from the imaginary axis and infinity: from zeros there for S, from poles for T. gamma is the larger
    one.
    """

    gamma: float
    interpolation: float
    boundary: float
    zeros: Complex
    poles: Complex


@dataclass(frozen=True)
class _Ratio:
    """A ratio of polynomials, highest power first, with its zeros and poles."""

    num: Array
    den: Array
    zeros: Complex
    poles: Complex

    def at(self, s: complex) -> float:
        """The modulus at a point; infinity at a pole, and at infinity the limit."""
        if math.isinf(abs(s)):
            return abs(self.num[0] / self.den[0]) if len(self.num) == len(self.den) else 0.0
        below = abs(np.polyval(self.den, s))
        return math.inf if below == 0 else float(abs(np.polyval(self.num, s)) / below)


@check_arguments
def least_sensitivity(num: Numbers, den: Numbers, weight: control.TransferFunction | float | None = None) -> LeastPeak:
    """The least ||W S|| of the plant num / den over all stabilising controllers, with S = 1 / (1 + G K).

    Without a weight it is the least peak Ms. A plant with one zero z and one pole p there has |z + p| / |z - p|.

    Parameters
    ----------
    num, den
        The coefficients of the plant, highest power first, proper.
    weight
        A stable and proper W of one channel; None stands for 1. Its zeros may lie anywhere.

    Raises
    ------
    ValueError
        If the plant or the weight is not proper or not finite, or the weight is not stable.
    DesignError
        If an unstable pole of the plant is cancelled by a zero, as no controller stabilises then.

    Examples
    --------
    >>> round(wb.least_sensitivity([1.0, -4.0], [1.0, -1.0]).gamma, 12)
    1.666666666667
    """
    call = "least_sensitivity(num, den)"
    plant, W = _plant(call, num, den), _weight(call, weight)
    return _least(call, plant, W, plant.zeros, plant.poles, len(plant.num) < len(plant.den), sensitivity=True)


@check_arguments
def least_complementary_sensitivity(
    num: Numbers, den: Numbers, weight: control.TransferFunction | float | None = None
) -> LeastPeak:
    """The least ||W T|| of the plant num / den over all stabilising controllers, with T = G K / (1 + G K).

    Arguments and refusals are those of `least_sensitivity`. For a stable plant it is zero, with K = 0.

    Examples
    --------
    >>> round(wb.synthesis.least_complementary_sensitivity([1.0, -4.0], [1.0, -1.0]).gamma, 12)
    1.666666666667
    """
    call = "least_complementary_sensitivity(num, den)"
    plant, W = _plant(call, num, den), _weight(call, weight)
    return _least(call, plant, W, plant.poles, plant.zeros, False, sensitivity=False)


def _least(
    call: str, plant: _Ratio, W: _Ratio, ones: Complex, nulls: Complex, at_infinity: bool, sensitivity: bool
) -> LeastPeak:
    """The least norm of W F, with a stable F that is 1 at `ones` and 0 at `nulls`."""
    right = [_right(roots) for roots in (ones, nulls)]
    on_axis = [complex(root) for root in ones if _is_on_axis(root)] + ([complex(math.inf)] if at_infinity else [])
    boundary = max((W.at(point) for point in on_axis), default=0.0)
    if math.isinf(boundary):
        raise DesignError(
            f"`{call}`: the weight has a pole on the imaginary axis where the plant keeps W S or W T from being zero, "
            "so the norm is infinite. Shift that pole to the left."
        )
    interpolation = _interpolation(W, *right)
    zeros, poles = right if sensitivity else right[::-1]
    return LeastPeak(max(interpolation, boundary), interpolation, boundary, zeros, poles)


def _interpolation(W: _Ratio, points: Complex, nulls: Complex) -> float:
    """||H(M)|| for H = W / (the Blaschke product of the nulls), with the zeros of W turned to the left."""
    if not len(points):
        return 0.0
    n = len(points)
    one = np.eye(n)
    b = np.sqrt(2 * points.real)
    M = np.tril(np.outer(b, b), -1) + np.diag(points)
    H = one * complex(W.num[0] / W.den[0])
    for zero in W.zeros:
        H = H @ (M - (complex(-zero.real, zero.imag) if zero.real > 0 else zero) * one)
    for pole in W.poles:
        H = np.linalg.solve(M - pole * one, H)
    for null in nulls:
        H = np.linalg.solve(M - null * one, (M + np.conj(null) * one) @ H)
    return float(np.linalg.norm(H, 2))


def _right(roots: Complex) -> Complex:
    """The roots right of the imaginary axis."""
    return np.array([root for root in roots if root.real > 0 and not _is_on_axis(root)], dtype=complex)


def _is_on_axis(root: complex) -> bool:
    return abs(root.real) <= ON_AXIS * abs(root)


def _plant(call: str, num: Numbers, den: Numbers) -> _Ratio:
    """The plant, of which nothing right of the axis or on it cancels."""
    plant = _ratio(call, "the plant", num, den)
    shared = complex_roots(common_divisor(_whole(plant.num), _whole(plant.den)))[0]
    for root in shared:
        if root.real >= 0 or _is_on_axis(root):
            raise DesignError(
                f"`{call}`: the plant is not stabilisable: its unstable pole {pole_text(complex(root))} is cancelled "
                "by a zero, so no controller moves it. Leave both out if they are not there in truth."
            )
    return plant


def _weight(call: str, weight: object) -> _Ratio:
    """A stable and proper weight of one channel."""
    if weight is None or isinstance(weight, float | int):
        return _ratio(call, "weight", [1.0 if weight is None else float(weight)], [1.0])
    import control  # takes seconds

    if not isinstance(weight, control.TransferFunction) or not weight.issiso() or weight.dt:
        raise ValueError(
            f"`{call}`: weight must be a continuous `TransferFunction` of one channel, a number or None; got "
            f"{describe(weight)}."
        )
    W = _ratio(call, "weight", weight.num[0][0], weight.den[0][0])
    for pole in W.poles:
        if pole.real > 0 and not _is_on_axis(pole):
            raise ValueError(
                f"`{call}`: weight must be stable, as W S and W T must be; it has the pole {pole_text(complex(pole))}."
            )
    return W


def _ratio(call: str, what: str, num: object, den: object) -> _Ratio:
    """A proper ratio of polynomials with finite coefficients."""
    parts = []
    for name, value in (("num", num), ("den", den)):
        array = as_array(value)
        if array is None or array.ndim != 1 or not array.size or not np.isfinite(array).all() or not array.any():
            raise ValueError(
                f"`{call}`: {name} of {what} must be finite coefficients, highest power first, not all zero; got "
                f"{describe(value)}."
            )
        parts.append(np.trim_zeros(array, "f"))
    if len(parts[0]) > len(parts[1]):
        raise ValueError(
            f"`{call}`: {what} must be proper; its numerator has degree {len(parts[0]) - 1}, its denominator "
            f"{len(parts[1]) - 1}. Add the poles that it has in truth."
        )
    zeros, poles = (np.asarray(complex_roots(_whole(part))[0], dtype=complex) for part in parts)
    return _Ratio(parts[0], parts[1], zeros, poles)


def _whole(coefficients: Array) -> list[int]:
    """A whole multiple of a polynomial, lowest power first."""
    fractions = [Fraction(float(c)) for c in coefficients[::-1]]
    denominator = math.lcm(*(f.denominator for f in fractions))
    return [int(f * denominator) for f in fractions]
