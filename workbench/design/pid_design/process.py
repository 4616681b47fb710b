"""A process num/den exp(-s delay) with one input and one output, its inverse on the axis, and frequencies for it."""

from __future__ import annotations

import cmath
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.design.control_system import System
from workbench.design.frequency.axis_loop import whole_coefficients
from workbench.design.frequency.half_planes import is_hurwitz
from workbench.design.frequency.integer_polynomials import primitive, quotient
from workbench.design.frequency.polynomial_ratios import lowest_terms
from workbench.design.matrices import Complex, DesignError

TURN = 0.14  # the most that the logarithm of numerator or denominator changes from one frequency to the next
STEP = 0.25  # the same of the logarithm of the frequency
LOWEST, HIGHEST = 1e-3, 20.0  # the ends of the frequencies, over the slowest and the fastest root
AT_REST = 1e-8  # a first frequency, over the slowest root, that stands for zero
TURNS = 12.0  # rad of the delay that are looked at first
DAMPING = 1e-6  # roots nearer to the axis count as this near, in the choice of frequencies


@dataclass(frozen=True, eq=False)
class Process:
    """The process num/den exp(-s delay), highest power first, in lowest terms."""

    num: Array
    den: Array
    delay: float

    @staticmethod
    def of(call: str, plant: System, delay: float) -> Process:
        """The process of a system in continuous time with one channel, whose hidden modes are stable."""
        if plant.isdtime(strict=True):
            raise ValueError(
                f"`{call}`: the plant must be in continuous time, as the law is; '{plant.name}' has the period "
                f"{plant.dt:g} s. Design for the continuous plant, with half a period more delay."
            )
        numerator, denominator = whole_coefficients(call, plant, "plant")
        if not denominator or not any(numerator):
            zero = "denominator" if not denominator else "numerator"
            raise ValueError(f"`{call}`: the {zero} of the plant must not be zero, or no gain has an effect.")
        if len(numerator) > len(denominator):
            raise ValueError(
                f"`{call}`: the plant must be proper; its numerator has degree {len(numerator) - 1}, its denominator "
                f"{len(denominator) - 1}. Add the poles that the hardware has."
            )
        N, D = lowest_terms(numerator, denominator)
        if not is_hurwitz(quotient(primitive(denominator), primitive(D))):
            raise DesignError(
                f"`{call}`: the plant has a mode that is not stable and that its input does not move or its output "
                "does not show, so that no controller stabilises it. Add an actuator or a sensor."
            )
        size = max(map(abs, (*N, *D)))
        num, den = (np.array([float(Fraction(c, size)) for c in reversed(p)]) for p in (N, D))
        return Process(num, den, delay)

    @property
    def relative_degree(self) -> int:
        """The number of poles minus the number of zeros."""
        return len(self.den) - len(self.num)

    @cached_property
    def roots(self) -> tuple[Complex, Complex]:
        """The zeros and the poles."""
        return np.roots(self.num).astype(complex), np.roots(self.den).astype(complex)

    @property
    def gain_limit(self) -> float:
        """The process at infinity, without its delay."""
        return float(self.num[0] / self.den[0]) if self.relative_degree == 0 else 0.0

    def mirror(self) -> Process:
        """The same process with the other sign of its gain."""
        return Process(-self.num, self.den, self.delay)

    def inverse(self, omega: Array) -> Complex:
        """1 / G at some frequencies."""
        s = 1j * omega
        inverse: Complex = np.polyval(self.den, s) / np.polyval(self.num, s) * np.exp(s * self.delay)
        return inverse

    def inverse_slopes(self, omega: float) -> tuple[complex, complex, complex]:
        """1 / G at one frequency, with its first and second derivative by the frequency."""
        s = 1j * omega
        (n, n1, n2), (d, d1, d2) = ([_value(p, s) for p in part] for part in self._slopes)
        h = d / n
        h1 = (d1 - h * n1) / n
        h2 = (d2 - 2 * h1 * n1 - h * n2) / n
        late, turn = self.delay, cmath.exp(s * self.delay)
        return h * turn, 1j * (h1 + late * h) * turn, -(h2 + 2 * late * h1 + late**2 * h) * turn

    @cached_property
    def _slopes(self) -> tuple[list[list[float]], list[list[float]]]:
        num, den = ([p, np.polyder(p), np.polyder(p, 2)] for p in (self.num, self.den))
        return [p.tolist() for p in num], [p.tolist() for p in den]

    def frequencies(self, fineness: float = 1.0, reach: float = 1.0, corner: float = 0.0) -> Array:
        """Frequencies between which the process changes little; `reach` times as far up as is usual.

        `corner` is the frequency of a filter of the law, 0 for none.
        """
        zeros, poles = self.roots
        roots = np.concatenate([zeros, poles])
        sizes = [size for size in np.abs(roots) if size > 1e-12 * max(np.abs(roots).max(initial=0), 1e-300)]
        late = [1 / self.delay] if self.delay else []
        slowest = min([*sizes, *late], default=1.0)
        fastest = HIGHEST * max(max(sizes, default=slowest), corner)
        fastest = TURNS * late[0] if late else fastest
        ends = np.log(LOWEST * slowest), np.log(fastest * reach)
        places = np.linspace(*ends, int(20 * (ends[1] - ends[0])) + 2)
        near = [np.log(abs(r.imag)) + side * width for r in roots if abs(r.imag) > 0 for side, width in _sides(r)]
        places = np.unique(np.concatenate([places, near])) if near else places
        places = places[(places >= ends[0]) & (places <= ends[1])]
        omega = np.exp((places[1:] + places[:-1]) / 2)
        density = np.maximum(1 / STEP, (self._change(omega, roots) + self.delay * omega) / TURN) * fineness
        total = np.concatenate([[0.0], np.cumsum(density * np.diff(places))])
        picked = np.interp(np.linspace(0, total[-1], int(total[-1]) + 2), total, places)
        return np.concatenate([[AT_REST * slowest], np.exp(picked)])

    @cached_property
    def axis_poles(self) -> list[tuple[float, float]]:
        """Frequencies of undamped poles, each with a 1/|G| below which frequencies do not resolve the process."""
        sizes = {float(abs(r.imag)) for r in self.roots[1] if abs(r.real) < DAMPING * abs(r.imag)}
        near = {size: self.inverse(size * (1 + np.array([-5, 5]) * DAMPING)) for size in sizes}
        return [(size, float(np.abs(inverse).max())) for size, inverse in near.items()]

    def later_frequencies(self, last: float, corner: float = 0.0) -> Array:
        """Frequencies beyond the last one, up to where the process only falls, with its resonances."""
        roots = np.concatenate(self.roots)
        end = HIGHEST * max(float(np.abs(roots).max(initial=0)), corner)
        if end <= last:
            return np.zeros(0)
        grid = np.geomspace(last, end, int(30 * np.log(end / last)) + 2)
        resonances = np.abs(roots[np.abs(roots.real) < 0.3 * np.abs(roots.imag)].imag)
        return np.unique(np.concatenate([grid, resonances[resonances > last]]))

    @staticmethod
    def _change(omega: Array, roots: Complex) -> Array:
        """The change of the factors of the process with the logarithm of the frequency."""
        distance = np.maximum(np.abs(1j * omega[:, np.newaxis] - roots), DAMPING * omega[:, np.newaxis])
        return np.asarray((omega[:, np.newaxis] / distance).sum(axis=1))


def _sides(root: complex) -> list[tuple[int, float]]:
    """Distances from a resonance, in the logarithm of the frequency, at which its factor is looked at."""
    width = max(abs(root.real / root.imag), DAMPING)
    if width > 0.1:
        return []
    steps = width * np.geomspace(0.1, 1 / width, int(6 * np.log(10 / width)))
    return [(0, 0.0), *((side, float(step)) for step in steps for side in (-1, 1))]


def _value(polynomial: list[float], s: complex) -> complex:
    total = 0j
    for c in polynomial:
        total = total * s + c
    return total
