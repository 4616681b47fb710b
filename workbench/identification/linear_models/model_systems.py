"""Polynomials of a model as matrices, as responses over frequency with their covariance, and as outputs over time."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from workbench.core.validation.refusals import Array
from workbench.identification.datasets.experiment import Marks
from workbench.identification.linear_models.polynomial_structure import Polynomials, PolynomialStructure

Complex = NDArray[np.complex128]
Matrices = tuple[Array, Array, Array, Array]


def observer_form(den: Array, numerators: list[Array]) -> Matrices:
    """A, B, Cy, D of y = sum num_i / den u_i, polynomials in rising powers of q^-1, den monic: the observer form."""
    order = max(len(den) - 1, *(len(num) - 1 for num in numerators))
    below = np.concatenate([den, np.zeros(order + 1 - len(den))])
    above = np.array([np.concatenate([num, np.zeros(order + 1 - len(num))]) for num in numerators])
    A = np.eye(order, k=1)
    A[:, :1] = -below[1:, np.newaxis]
    B = above[:, 1:].T - np.outer(below[1:], above[:, 0])
    return A, B, np.eye(1, order), above[:, :1].T.copy()


def model_matrices(structure: PolynomialStructure, model: Polynomials) -> Matrices:
    """A, B, Cy, D from the inputs to the output, without the noise: sum B_i / (A F_i)."""
    inputs = range(structure.nu)
    if not any(structure.nf):
        return observer_form(model.A, list(model.B))
    if structure.na == 0 or structure.nu == 1:
        parts = [observer_form(np.convolve(model.A, model.F[i]), [model.B[i]]) for i in inputs]
        sizes = np.cumsum([0, *(len(part[0]) for part in parts)])
        A, B = np.zeros((sizes[-1], sizes[-1])), np.zeros((sizes[-1], structure.nu))
        for i, part in enumerate(parts):
            rows = slice(sizes[i], sizes[i + 1])
            A[rows, rows], B[rows, i : i + 1] = part[0], part[1]
        return A, B, np.hstack([part[2] for part in parts]), np.hstack([part[3] for part in parts])
    den, numerators = model.A, []
    for i in inputs:
        den = np.convolve(den, model.F[i])
        others = model.B[i]
        for j in inputs:
            others = np.convolve(others, model.F[j]) if j != i else others
        numerators.append(others)
    return observer_form(den, numerators)


def evaluate(polynomial: Array, z: Complex) -> Complex:
    """A polynomial in rising powers of q^-1 at points z (m,)."""
    return np.asarray(np.polyval(polynomial[::-1], 1 / z), dtype=complex)


def response_and_gradient(structure: PolynomialStructure, theta: Array, i: int, z: Complex) -> tuple[Complex, Complex]:
    """The response (m,) from input i at points z, and its gradient (m, size) by the parameters."""
    model = structure.polynomials(theta)
    A, F, B = evaluate(model.A, z), evaluate(model.F[i], z), evaluate(model.B[i], z)
    G = B / (A * F)
    slope = np.zeros((len(z), structure.size), dtype=complex)

    def powers(first: int, count: int) -> Complex:
        return np.asarray(z[:, np.newaxis] ** -np.arange(first, first + count, dtype=float))

    slope[:, structure.places("a")] = -(G / A)[:, np.newaxis] * powers(1, structure.na)
    slope[:, structure.places("b", i)] = powers(structure.nk[i], structure.nb[i]) / (A * F)[:, np.newaxis]
    slope[:, structure.places("f", i)] = -(G / F)[:, np.newaxis] * powers(1, structure.nf[i])
    return G, slope


def response_covariance(slope: Complex, covariance: Array) -> Array:
    """The covariance (m, 2, 2) of real and imaginary part, by the gradient (m, size) and that of the parameters."""
    both = np.stack([slope.real, slope.imag], axis=1)
    return np.asarray(both @ covariance @ both.transpose(0, 2, 1))


def simulate_record(
    structure: PolynomialStructure, model: Polynomials, u: Array, y: Array, counts: Marks | None = None
) -> Array:
    """The output (N,) for inputs u (nu, N) without noise, from the initial values that fit y (N,) best.

    `counts` (N,) is False where y is missing.
    """
    output = sum(lfilter(B, np.convolve(model.A, F), part) for B, F, part in zip(model.B, model.F, u, strict=True))
    below = model.A
    for F in model.F:
        below = np.convolve(below, F)
    order = len(below) - 1
    known = zip(model.B, model.F, strict=True)
    count = max(order, *(len(B) - 1 + order - (len(model.A) + len(F) - 2) for B, F in known))
    if not count:
        return np.asarray(output)
    impulse = np.zeros(len(y))
    impulse[0] = 1.0
    free = lfilter([1.0], below, impulse)
    columns = np.zeros((len(y), count))
    for column, delay in zip(columns.T, range(count), strict=True):
        column[delay:] = free[: len(y) - delay]
    if not np.isfinite(columns).all() or not np.isfinite(output).all():
        return np.full(len(y), np.nan)
    scale = np.linalg.norm(columns, axis=0)
    there = slice(None) if counts is None else counts
    values = np.linalg.lstsq((columns / scale)[there], (y - output)[there], rcond=1e-10)[0]
    return np.asarray(output + columns @ (values / scale))
