"""All roots of a polynomial with whole coefficients and their multiplicities, each proved to the digits of a double."""

from __future__ import annotations

import cmath
import math
from itertools import pairwise

import numpy as np

from workbench.design.frequency.integer_polynomials import Polynomial, derivative, square_free_factors
from workbench.design.matrices import Complex, DesignError

STEPS = 80  # of Aberth's iteration, of which some ten are taken
WORKING_BITS = (128, 512, 2048)  # of a root beyond its leading digit
CLOSE = 2.0**-60  # the radius of a proved disk, relative to the root
ROUNDING = 1.001  # more than the rounding of a product of a thousand doubles
Point = tuple[int, int]


def complex_roots(p: Polynomial) -> tuple[Complex, list[int]]:
    """The roots of a polynomial, repeated ones as often as they occur, and the multiplicity of each.

    Multiplicities are those of the square-free factors, which are exact; a root is real, or zero, exactly if its
    imaginary part, or all of it, is returned as zero.

    Raises
    ------
    DesignError
        If two different roots are too near to each other to be proved apart.
    """
    values: list[complex] = []
    multiplicities: list[int] = []
    for factor, multiplicity in square_free_factors(p):
        for root in _simple_roots(factor):
            values += [root] * multiplicity
            multiplicities += [multiplicity] * multiplicity
    order = sorted(range(len(values)), key=lambda i: (values[i].real, values[i].imag))
    return np.array([values[i] for i in order], dtype=complex), [multiplicities[i] for i in order]


def _simple_roots(p: Polynomial) -> list[complex]:
    """The roots of a polynomial of which none is repeated."""
    if p[0] == 0:
        return [0j, *_simple_roots(p[1:])]
    if len(p) == 1:
        return []
    smallest = min(_hull_radii(p))
    for bits in WORKING_BITS:
        places = bits + max(0, -math.floor(smallest))  # binary digits behind the point
        disks = _aberth(p, places, CLOSE)
        if disks is not None:
            return [_double(z, places) for z, _ in disks]
    raise DesignError(
        f"the roots of a polynomial of degree {len(p) - 1} could not be proved apart: some agree in their first "
        f"{WORKING_BITS[-1]} binary digits and yet differ. Round the numbers of the system."
    )


def root_disks(p: Polynomial, bits: int) -> tuple[list[tuple[Point, float]], int]:
    """Disjoint disks about the roots of a polynomial without repeated ones and not zero at 0, as sharp as so many bits.

    A centre is in units of 2^-places, which is returned beside the disks; the radius is a double. A root is real
    exactly if the imaginary part of its centre is zero.

    Raises
    ------
    DesignError
        If the roots cannot be told apart.
    """
    smallest = min(_hull_radii(p), default=0.0)
    for extra in (128, 1024):
        places = bits + extra + max(0, -math.floor(smallest))
        disks = _aberth(p, places, 2.0**-bits)
        if disks is not None:
            return disks, places
    raise DesignError(
        f"the poles of a system with {len(p) - 1} of them could not be told apart in {bits} binary digits; round the "
        "numbers of the system."
    )


def _logarithm(a: int) -> float:
    """The binary logarithm of |a|, of any size."""
    spare = max(0, abs(a).bit_length() - 64)
    return math.log2(abs(a) >> spare) + spare


def _hull_radii(p: Polynomial) -> list[float]:
    """The binary logarithm of a likely modulus of each root: slopes of the upper hull of log |a_i| (Bini)."""
    hull: list[tuple[int, float]] = []
    for i, a in enumerate(p):
        if a == 0:
            continue
        point = (i, _logarithm(a))
        while len(hull) > 1 and _slope(hull[-2], hull[-1]) <= _slope(hull[-1], point):
            hull.pop()
        hull.append(point)
    return [-_slope(a, b) for a, b in pairwise(hull) for _ in range(b[0] - a[0])]


def _slope(a: tuple[int, float], b: tuple[int, float]) -> float:
    return (b[1] - a[1]) / (b[0] - a[0])


def _aberth(p: Polynomial, places: int, close: float) -> list[tuple[Point, float]] | None:
    """Disks by the iteration of Ehrlich and Aberth on numbers with so many binary places; None if it is in doubt.

    Values of p are exact and the corrections doubles, so each step gains up to fifteen digits.
    """
    slope, n = derivative(p), len(p) - 1
    points = [
        _point(
            2.0 ** (radius - math.floor(radius)) * cmath.exp(1j * (0.7 + 2 * math.pi * i / n)),
            math.floor(radius) + places,
        )
        for i, radius in enumerate(_hull_radii(p))
    ]
    for _ in range(STEPS):
        largest = 0.0
        for i, z in enumerate(points):
            step = _correction(p, slope, points, i, places)
            if step is None:
                return None
            size = abs(_double(z, places))
            largest = max(largest, abs(step) / size if size else math.inf)
            moved = _point(step, places)
            points[i] = (z[0] - moved[0], z[1] - moved[1])
        if largest < close / 1024:
            break
    return _prove_disks(p, points, places, close)


def _point(z: complex, places: int) -> Point:
    """A complex number in units of 2^-places."""
    return _shift(z.real, places), _shift(z.imag, places)


def _shift(x: float, places: int) -> int:
    mantissa, exponent = math.frexp(x)
    whole, move = int(mantissa * 2**53), exponent - 53 + places
    return whole << move if move >= 0 else whole >> -move


def _double(z: Point, places: int) -> complex:
    """The nearest complex double of a number in units of 2^-places."""
    return complex(z[0] / (1 << places), z[1] / (1 << places))


def _value(p: Polynomial, z: Point, places: int) -> Point:
    """The value of p at a point times 2^(places n), exactly."""
    real = imag = 0
    for i, a in enumerate(reversed(p)):
        real, imag = real * z[0] - imag * z[1] + (a << places * i), real * z[1] + imag * z[0]
    return real, imag


def _ratio(a: Point, b: Point, exponent: int) -> complex:
    """The quotient a / b times 2^exponent, as doubles."""
    (u, e), (v, f) = _leading_digits(a), _leading_digits(b)
    quotient, power = u / v, max(-1000, min(1000, e - f + exponent))
    return complex(math.ldexp(quotient.real, power), math.ldexp(quotient.imag, power))


def _leading_digits(a: Point) -> tuple[complex, int]:
    spare = max(0, max(abs(a[0]), abs(a[1])).bit_length() - 64)
    return complex(a[0] >> spare, a[1] >> spare), spare


def _correction(p: Polynomial, slope: Polynomial, points: list[Point], i: int, places: int) -> complex | None:
    """The step of Aberth for a point; None if two points coincide."""
    z = points[i]
    value, rise = _value(p, z, places), _value(slope, z, places)
    if value == (0, 0):
        return 0j
    total = 0j
    for j, other in enumerate(points):
        if j != i:
            apart = _ratio((z[0] - other[0], z[1] - other[1]), (1, 0), -places) if z != other else 0j
            if apart == 0:
                return None
            total += 1 / apart
    if rise == (0, 0):
        return -1 / total if total else None
    newton = _ratio(value, rise, -places)
    rest = 1 - newton * total
    return newton / rest if rest else newton


def _prove_disks(p: Polynomial, points: list[Point], places: int, close: float) -> list[tuple[Point, float]] | None:
    """The points and radii of disks about them that are small, disjoint, and so hold one root each.

    The disk about z_i has the radius n |p(z_i) / (a_n prod (z_i - z_j))| (Smith 1970). A disk that reaches the real
    axis is moved onto it: if it then holds one root, the root is real, as its conjugate lies in it too.
    """
    doubles = [_double(z, places) for z in points]
    radii = _radii(p, points, places)
    if radii is None:
        return None
    snapped = [(z[0], 0) if abs(d.imag) <= r else z for z, d, r in zip(points, doubles, radii, strict=True)]
    if snapped != points:
        radii = _radii(p, snapped, places)
        if radii is None:
            return None
    n = len(points)
    doubles = [_double(z, places) for z in snapped]
    for i in range(n):
        if not radii[i] <= close * abs(doubles[i]):
            return None
        for j in range(i):
            apart = _ratio((snapped[i][0] - snapped[j][0], snapped[i][1] - snapped[j][1]), (1, 0), -places)
            if not radii[i] + radii[j] < abs(apart):
                return None
    return list(zip(snapped, radii, strict=True))


def _radii(p: Polynomial, points: list[Point], places: int) -> list[float] | None:
    """The radius of the disk about each point; None if two points coincide."""
    n, radii = len(points), []
    for i, z in enumerate(points):
        real, imag = p[-1], 0
        for j, other in enumerate(points):
            if j != i:
                u, v = z[0] - other[0], z[1] - other[1]
                real, imag = real * u - imag * v, real * v + imag * u
        if (real, imag) == (0, 0):
            return None
        # p(z) is in units of 2^-(places n), the product in units of 2^-(places (n - 1))
        radii.append(ROUNDING * n * abs(_ratio(_value(p, z, places), (real, imag), -places)))
    return radii
