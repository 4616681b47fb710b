"""A stable system with a stable inverse whose magnitude follows samples: the logarithm is fitted by least squares.

The function is a gain times sections (s^2 + 2 z w s + w^2) / (s^2 + 2 y v s + v^2), and one of the first order if the
order is odd. Its parameters are the logarithms of all these numbers, so every one is positive: poles and zeros lie left
of the axis for all values of the parameters.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import linalg, optimize

from workbench.core.validation.refusals import Array

SPAN = 0.5  # how far, as a logarithm, a pole may move beyond the samples
DAMPING = -1.5, 1.5  # the range of the logarithm of the damping of a section
APART = 0.5, -0.5  # logarithms of pole over zero at which the search starts
Matrices = tuple[Array, Array, Array, Array]


@dataclass(frozen=True, eq=False)
class MagnitudeFit:
    """The fitted function: its parameters, and the root of the mean square of the error in the logarithm."""

    order: int
    p: Array
    misfit: float

    def log_magnitude(self, omega: Array) -> Array:
        """The logarithm of the magnitude at frequencies in rad/s."""
        return _log_magnitude(self.p, self.order, np.log(omega))

    def state_space(self, inverse: bool = False) -> Matrices:
        """A, B, C, D of the function or of its inverse, sections in series."""
        sign = -1.0 if inverse else 1.0
        whole = np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0)), np.full((1, 1), np.exp(sign * self.p[0]))
        zeros, poles = np.split(self.p[1:], 2)
        if inverse:
            zeros, poles = poles, zeros
        for section in range(self.order // 2):
            place = slice(2 * section, 2 * section + 2)
            whole = _series(whole, _second_order(zeros[place], poles[place]))
        if self.order % 2:
            zero, pole = float(np.exp(zeros[-1])), float(np.exp(poles[-1]))
            root = abs(zero - pole) ** 0.5
            first = np.array([[-pole]]), np.array([[root]]), np.array([[np.sign(zero - pole) * root]]), np.eye(1)
            whole = _series(whole, first)
        return whole


def fit_magnitude(omega: Array, values: Array, weights: Array, order: int) -> MagnitudeFit:
    """The function of an order nearest to positive values at frequencies, by weighted least squares of logarithms."""
    x, target = np.log(omega), np.log(values)
    weights = weights / np.sqrt(np.mean(weights**2))
    mean = float(np.average(target, weights=weights**2))
    if order == 0:
        return _fit(np.array([mean]), 0, x, target, weights)
    low, high = _bounds(order, x)

    def errors(p: Array) -> Array:
        return weights * (_log_magnitude(p, order, x) - target)

    def slopes(p: Array) -> Array:
        zeros, poles = np.split(p[1:], 2)
        columns = [np.ones((len(x), 1)), _log_slopes(zeros, order, x), -_log_slopes(poles, order, x)]
        return np.asarray(weights[:, None] * np.hstack(columns))

    best: MagnitudeFit | None = None
    for apart in APART:
        start = np.clip(_start(order, x, apart, mean), low + 1e-3, high - 1e-3)
        found = optimize.least_squares(errors, start, jac=slopes, bounds=(low, high), max_nfev=100, ftol=1e-7)
        fit = _fit(np.asarray(found.x), order, x, target, weights)
        if best is None or fit.misfit < best.misfit:
            best = fit
    assert best is not None
    return best


def _fit(p: Array, order: int, x: Array, target: Array, weights: Array) -> MagnitudeFit:
    error = weights * (_log_magnitude(p, order, x) - target)
    return MagnitudeFit(order, p, float(np.sqrt(np.mean(error**2))))


def _bounds(order: int, x: Array) -> tuple[Array, Array]:
    section = [(x[0] - SPAN, x[-1] + SPAN), DAMPING] * (order // 2) + [(x[0] - SPAN, x[-1] + SPAN)] * (order % 2)
    pairs = [(-np.inf, np.inf), *section, *section]
    return np.array([low for low, _ in pairs]), np.array([high for _, high in pairs])


def _start(order: int, x: Array, apart: float, mean: float) -> Array:
    """Zeros spread over the samples, and poles at a distance from them."""
    places = np.linspace(x[0], x[-1], order // 2 + order % 2 + 2)[1:-1]
    zeros = [number for place in places[: order // 2] for number in (place, 0.0)] + [places[-1]] * (order % 2)
    shift = [number for _ in range(order // 2) for number in (apart, 0.0)] + [apart] * (order % 2)
    return np.array([mean, *zeros, *(np.array(zeros) + np.array(shift))])


def _log_magnitude(p: Array, order: int, x: Array) -> Array:
    zeros, poles = np.split(p[1:], 2)
    return np.asarray(p[0] + _log_factors(zeros, order, x) - _log_factors(poles, order, x))


def _log_factors(numbers: Array, order: int, x: Array) -> Array:
    """The logarithm of |product of the factors| at s = j e^x."""
    total = np.zeros(len(x))
    for section in range(order // 2):
        place, damping = numbers[2 * section : 2 * section + 2]
        u = np.exp(2 * np.minimum(x, place) - 2 * np.maximum(x, place))  # the smaller square over the larger one
        total += 2 * np.maximum(x, place) + np.log((1 - u) ** 2 + 4 * np.exp(2 * damping) * u) / 2
    if order % 2:
        total += np.logaddexp(2 * x, 2 * numbers[-1]) / 2
    return total


def _log_slopes(numbers: Array, order: int, x: Array) -> Array:
    """The derivatives of the logarithm by each number, one column each."""
    slopes: Array = np.zeros((len(x), order))
    for section in range(order // 2):
        place, damping = numbers[2 * section : 2 * section + 2]
        t = x - place
        u = np.exp(-2 * np.abs(t))
        fourth = 4 * np.exp(2 * damping) * u
        size = (1 - u) ** 2 + fourth
        by_u = ((u - 1) * u + fourth / 2) / size  # half of it comes from u = e^(-2 |t|)
        slopes[:, 2 * section] = np.where(t < 0, 2 - 2 * by_u, 2 * by_u)
        slopes[:, 2 * section + 1] = fourth / size
    if order % 2:
        slopes[:, -1] = 1 / (1 + np.exp(2 * (x - numbers[-1])))
    return slopes


def _second_order(zeros: Array, poles: Array) -> Matrices:
    """(s^2 + 2 z w s + w^2) / (s^2 + 2 y v s + v^2) in states of one unit."""
    (w, z), (v, y) = np.exp(zeros), np.exp(poles)
    A = np.array([[-2 * y * v, -v], [v, 0.0]])
    C = np.array([[2 * (z * w - y * v), (w**2 - v**2) / v]])
    return A, np.array([[1.0], [0.0]]), C, np.eye(1)


def _series(first: Matrices, second: Matrices) -> Matrices:
    """The second system after the first."""
    (A1, B1, C1, D1), (A2, B2, C2, D2) = first, second
    A = linalg.block_diag(A1, A2)
    A[len(A1) :, : len(A1)] = B2 @ C1
    return A, np.vstack([B1, B2 @ D1]), np.hstack([D2 @ C1, C2]), D2 @ D1
