"""The structure A y = sum B_i/F_i q^-nk_i u_i + C/D e: its orders, its parameters by name, and its polynomials."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array, refusal
from workbench.core.validation.signatures import check_arguments

Complex = NDArray[np.complex128]


@dataclass(frozen=True)
@show
@check_arguments
class PolynomialStructure:
    """The orders of A(q) y = sum_i B_i(q) / F_i(q) q^-nk_i u_i + C(q) / D(q) e, one output and nu inputs.

    A, C, D and F_i are monic in q^-1, as A = 1 + a1 q^-1 + ... + a_na q^-na; B_i = b1 + b2 q^-1 + ... has nb_i numbers.

    Parameters
    ----------
    na, nc, nd
        The orders of A, C and D.
    nb, nf, nk
        (nu,), for each input the numbers of B, the order of F, and the delay of the input in periods.

    Raises
    ------
    ValueError
        If an order is negative, the orders of the inputs differ in number, or there is nothing to estimate.

    References
    ----------
    Ljung (1999), System Identification, 2nd edition, section 4.2.
    """

    na: int = 0
    nb: tuple[int, ...] = (1,)
    nc: int = 0
    nd: int = 0
    nf: tuple[int, ...] = (0,)
    nk: tuple[int, ...] = (1,)

    def __post_init__(self) -> None:
        orders = (self.na, self.nc, self.nd, *self.nb, *self.nf, *self.nk)
        if min(orders) < 0:
            raise ValueError(f"`PolynomialStructure(...)` must have orders that are not negative; got {orders}.")
        if not len(self.nb) == len(self.nf) == len(self.nk):
            raise ValueError(
                "`PolynomialStructure(nb, nf, nk)` must have one order for each input; got "
                f"{len(self.nb)}, {len(self.nf)} and {len(self.nk)}."
            )
        if any(numerator == 0 for numerator in self.nb):
            raise ValueError(f"`PolynomialStructure(nb=...)` must be positive for each input; got {self.nb}.")
        if self.size == 0:
            raise ValueError("`PolynomialStructure(...)` must have at least one parameter; all its orders are 0.")

    @property
    def nu(self) -> int:
        """The number of inputs."""
        return len(self.nb)

    @property
    def size(self) -> int:
        """The number of parameters."""
        return self.na + sum(self.nb) + self.nc + self.nd + sum(self.nf)

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the parameters, as a1, b1, c1, d1, f1; of several inputs, b1[0] and f1[0] are of the first."""
        several = self.nu > 1
        return tuple(
            f"{letter}{k + 1}{f'[{i}]' if several and letter in 'bf' else ''}"
            for letter, i, count in self._parts()
            for k in range(count)
        )

    def _parts(self) -> Iterator[tuple[str, int, int]]:
        yield "a", 0, self.na
        yield from (("b", i, count) for i, count in enumerate(self.nb))
        yield "c", 0, self.nc
        yield "d", 0, self.nd
        yield from (("f", i, count) for i, count in enumerate(self.nf))

    @check_arguments
    def places(self, letter: str, i: int = 0) -> slice:
        """The places of the numbers of a polynomial, of input i for B and F, among the parameters."""
        at = 0
        for other, j, count in self._parts():
            if (other, j) == (letter, i):
                return slice(at, at + count)
            at += count
        raise LookupError(f"There is no polynomial '{letter}' of input {i} in this structure.")

    @check_arguments
    def polynomials(self, theta: Array) -> Polynomials:
        """The polynomials of parameters theta (size,), each in rising powers of q^-1, B with its delay."""
        if theta.shape != (self.size,):
            raise refusal("PolynomialStructure.polynomials(theta=...)", f"of shape ({self.size},)", theta)

        def monic(letter: str, i: int = 0) -> Array:
            return np.concatenate([[1.0], theta[self.places(letter, i)]])

        inputs = range(self.nu)
        return Polynomials(
            A=monic("a"),
            B=tuple(np.concatenate([np.zeros(self.nk[i]), theta[self.places("b", i)]]) for i in inputs),
            C=monic("c"),
            D=monic("d"),
            F=tuple(monic("f", i) for i in inputs),
        )

    @property
    def transients(self) -> int:
        """The number of initial values of the predictor: its order as one difference equation in e, y and u."""
        F = sum(self.nf)
        of_inputs = (nb + nk - 1 + self.nd + F - nf for nb, nk, nf in zip(self.nb, self.nk, self.nf, strict=True))
        return max(self.nc + F, self.na + self.nd + F, *of_inputs, 0)

    @property
    def longest(self) -> int:
        """The highest order of a polynomial, delays included."""
        return max(self.na, self.nc, self.nd, *self.nf, *(b + k for b, k in zip(self.nb, self.nk, strict=True)), 1)

    @property
    def kind(self) -> str:
        """The name of the structure: ARX, ARMAX, output error, Box-Jenkins, or polynomial for any other."""
        forks = any(self.nf)
        if not (forks or self.nd):
            return "ARMAX" if self.nc else "ARX" if self.na else "FIR"
        if not self.na and forks:
            return "Box-Jenkins" if self.nc or self.nd else "output error"
        return "polynomial"


@dataclass(frozen=True, eq=False)
@show
class Polynomials:
    """The polynomials of a model in rising powers of q^-1; B and F have one for each input, B with its delay."""

    A: Array
    B: tuple[Array, ...]
    C: Array
    D: Array
    F: tuple[Array, ...]

    def radius(self) -> float:
        """The largest absolute root in z of C, D and all F, which the predictor and the noise model need below 1."""
        return max(largest_root(polynomial) for polynomial in (self.C, self.D, *self.F))


def largest_root(polynomial: Array) -> float:
    """The largest absolute root in z of a polynomial in q^-1, 0 if it has none."""
    if len(polynomial) <= 1 or not np.any(polynomial[1:]):
        return 0.0
    if len(polynomial) == 2:
        return abs(float(polynomial[1] / polynomial[0]))
    return float(np.abs(np.roots(polynomial)).max(initial=0.0))


def reflect(polynomial: Array, radius: float) -> Array:
    """A monic polynomial with each root outside `radius` moved to its mirror in the unit circle, or to `radius`."""
    if largest_root(polynomial) <= radius:
        return polynomial
    roots = np.roots(polynomial)
    outside = np.abs(roots) > 1
    roots[outside] = 1 / np.conj(roots[outside])
    return _of_roots(roots.astype(complex), len(polynomial), radius)


def clip(polynomial: Array, radius: float) -> Array:
    """A monic polynomial with each root outside `radius` moved to it."""
    if largest_root(polynomial) <= radius:
        return polynomial
    return _of_roots(np.roots(polynomial).astype(complex), len(polynomial), radius)


def _of_roots(roots: Complex, size: int, radius: float) -> Array:
    sizes = np.abs(roots)
    near = np.where(sizes > radius, roots * (radius / np.maximum(sizes, radius)), roots)
    polynomial = np.atleast_1d(np.real(np.poly(near)))
    return np.concatenate([polynomial, np.zeros(size - len(polynomial))])
