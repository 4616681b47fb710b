"""Starts of a search for the parameters of a polynomial model, of which the first ones need no start themselves.

A long ARX model is fitted first; it is consistent in open and in closed loop (Ljung 1999, section 10.4). Its residuals
stand for the noise e in linear regressions for C and D, and its ratio B/A gives B and F. From there some steps of
Steiglitz and McBride, prefiltered by the noise model, lead on. Noise models have false minima whose C and D nearly
share a root, so further starts share one. The other starts have roots at random.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from scipy.signal import lfilter

from workbench.core.validation.refusals import Array
from workbench.identification.linear_models.gauss_newton import squares_at
from workbench.identification.linear_models.polynomial_structure import PolynomialStructure, reflect
from workbench.identification.linear_models.prediction_errors import Predictor, Record

LONGEST = 40  # order of the long ARX model
SAFE = 0.98  # the largest absolute root of a start
ROUNDS = 6  # of Steiglitz's and McBride's filter
DRAWS = 40  # random starts, whose sums of squares are compared before any search
SHARED = (-0.95, -0.7, -0.3, 0.3, 0.7, 0.95)  # roots that C and D of a start have in common


def starts_of(predictor: Predictor, count: int, generator: np.random.Generator) -> Iterator[tuple[str, Array]]:
    """Starts by name: of regressions, and the best `count` of many with random roots."""
    structure, records = predictor.structure, predictor.records
    arx = arx_of(structure, records)
    yield "ARX", _stable(structure, _of_arx(structure, arx))
    if not (structure.nc or structure.nd or any(structure.nf)):
        return
    A, B = long_arx(structure, records)
    noise = tuple(_difference(A, B, record) for record in records)
    yield "Hannan-Rissanen", _stable(structure, _hannan_rissanen(structure, records, noise))
    if any(structure.nf):
        theta = _stable(structure, _of_long_arx(structure, A, B))
        yield "long ARX", theta
        for _ in range(ROUNDS):
            theta = _stable(structure, _steiglitz_mcbride(structure, records, noise, theta))
        yield "Steiglitz-McBride", theta
        if structure.nc and structure.nd:
            yield from _with_shared_root(structure, records, noise, theta)
    yield from _random(predictor, count, generator)


def _with_shared_root(
    structure: PolynomialStructure, records: tuple[Record, ...], noise: tuple[Array, ...], theta: Array
) -> Iterator[tuple[str, Array]]:
    """Noise models of one order less, times a factor that C and D have in common."""
    less = replace(structure, nc=structure.nc - 1, nd=structure.nd - 1)
    smaller = np.zeros(less.size)
    for letter, i in (("a", 0), *((letter, i) for letter in "bf" for i in range(structure.nu))):
        smaller[less.places(letter, i)] = theta[structure.places(letter, i)]
    if less.nc or less.nd:
        smaller = _stable(less, _noise_model(less, records, noise, smaller))
    model = less.polynomials(smaller)
    for root in SHARED:
        renewed = theta.copy()
        for letter, polynomial in (("c", model.C), ("d", model.D)):
            renewed[structure.places(letter)] = np.convolve(polynomial, [1.0, -root])[1:]
        yield "shared root", renewed


def _random(predictor: Predictor, count: int, generator: np.random.Generator) -> Iterator[tuple[str, Array]]:
    structure = predictor.structure
    if not count:
        return
    draws = []
    for _ in range(DRAWS):
        theta = np.zeros(structure.size)
        for letter, i, order in (
            ("a", 0, structure.na),
            ("c", 0, structure.nc),
            ("d", 0, structure.nd),
            *(("f", i, nf) for i, nf in enumerate(structure.nf)),
        ):
            theta[structure.places(letter, i)] = _random_polynomial(order, generator)[1:]
        linear = [structure.places("b", i) for i in range(structure.nu)] + [structure.places("a")]
        columns = np.concatenate([np.arange(structure.size)[part] for part in linear])
        start = theta.copy()
        start[columns] = 0.0
        at = predictor.errors(start)
        # e is linear in A and B at fixed C, D and F
        start[columns] = np.linalg.lstsq(at.J[:, columns], -at.e, rcond=None)[0]
        draws.append((squares_at(predictor, start), start))
    draws.sort(key=lambda draw: draw[0])
    yield from (("random roots", theta) for squares, theta in draws[:count] if np.isfinite(squares))


def _random_polynomial(order: int, generator: np.random.Generator) -> Array:
    """A monic polynomial with stable roots, pairs and real ones at random."""
    polynomial, left = np.ones(1), order
    while left:
        radius = SAFE * generator.uniform(0.05, 1) ** 0.5
        if left >= 2 and generator.random() < 0.5:
            polynomial = np.convolve(polynomial, [1.0, -2 * radius * np.cos(generator.uniform(0, np.pi)), radius**2])
            left -= 2
        else:
            polynomial = np.convolve(polynomial, [1.0, radius * generator.choice([-1.0, 1.0])])
            left -= 1
    return polynomial


def regressors(signal: Array, delays: range) -> Array:
    """The signal (N,) behind each of some delays, (N, len(delays)), at rest before its first sample."""
    columns = np.zeros((len(signal), len(delays)))
    for column, delay in zip(columns.T, delays, strict=True):
        column[delay:] = signal[: max(len(signal) - delay, 0)]
    return columns


def arx_of(structure: PolynomialStructure, records: tuple[Record, ...]) -> tuple[Array, list[Array]]:
    """A and B by linear least squares, with the orders of A or F, and those of B, behind the first samples."""
    order = max(structure.na, *structure.nf, structure.nd, 0)
    return _least_squares(records, order, structure.nk, structure.nb)


def long_arx(structure: PolynomialStructure, records: tuple[Record, ...]) -> tuple[Array, list[Array]]:
    """A long ARX model: an order that the samples can carry."""
    samples = sum(len(record.y) for record in records)
    order = int(np.clip(samples // (10 * (1 + structure.nu)), structure.longest, LONGEST))
    return _least_squares(records, order, structure.nk, (order,) * structure.nu)


def _least_squares(
    records: tuple[Record, ...], order: int, nk: tuple[int, ...], nb: tuple[int, ...]
) -> tuple[Array, list[Array]]:
    rows, targets = [], []
    first = max(order, *(b + k for b, k in zip(nb, nk, strict=True)), 0)
    for record in records:
        parts = [-regressors(record.y, range(1, order + 1))]
        parts += [regressors(u, range(k, k + b)) for u, k, b in zip(record.u, nk, nb, strict=True)]
        skip = min(first, len(record.y) // 2)
        rows.append(np.hstack(parts)[skip:])
        targets.append(record.y[skip:])
    theta = np.linalg.lstsq(np.vstack(rows), np.concatenate(targets), rcond=1e-12)[0]
    numerators = np.split(theta[order:], np.cumsum(nb)[:-1])
    pairs = zip(numerators, nk, strict=True)
    return np.concatenate([[1.0], theta[:order]]), [np.concatenate([np.zeros(k), b]) for b, k in pairs]


def _difference(A: Array, B: list[Array], record: Record) -> Array:
    """A y - sum B_i u_i, whose first samples, which miss what was before, count as zero."""
    e = lfilter(A, [1.0], record.y) - sum(lfilter(b, [1.0], u) for b, u in zip(B, record.u, strict=True))
    e[: min(len(A) - 1, len(e) // 2)] = 0.0
    return np.asarray(e)


def _of_arx(structure: PolynomialStructure, arx: tuple[Array, list[Array]]) -> Array:
    """The parameters with A, or F and D, of an ARX model."""
    A, B = arx
    theta = np.zeros(structure.size)
    for i in range(structure.nu):
        theta[structure.places("b", i)] = B[i][structure.nk[i] : structure.nk[i] + structure.nb[i]]
        theta[structure.places("f", i)] = A[1 : 1 + structure.nf[i]] if not structure.na else 0.0
    if structure.na:
        theta[structure.places("a")] = A[1 : 1 + structure.na]
    elif structure.nd:
        theta[structure.places("d")] = A[1 : 1 + structure.nd]
    return theta


def _hannan_rissanen(structure: PolynomialStructure, records: tuple[Record, ...], noise: tuple[Array, ...]) -> Array:
    """A, B and C by a regression on y, u and the residuals of the long model; F and D are A where there is no A."""
    order, rows, targets = max(structure.na, *structure.nf, structure.nd, 0), [], []
    for record, e in zip(records, noise, strict=True):
        parts = [-regressors(record.y, range(1, order + 1))]
        parts += [regressors(u, range(k, k + b)) for u, k, b in zip(record.u, structure.nk, structure.nb, strict=True)]
        parts.append(regressors(e, range(1, structure.nc + 1)))
        rows.append(np.hstack(parts))
        targets.append(record.y - e)
    solution = np.linalg.lstsq(np.vstack(rows), np.concatenate(targets), rcond=1e-12)[0]
    A = np.concatenate([[1.0], solution[:order]])
    numerators = np.split(solution[order : order + sum(structure.nb)], np.cumsum(structure.nb)[:-1])
    B = [np.concatenate([np.zeros(k), b]) for b, k in zip(numerators, structure.nk, strict=True)]
    theta = _of_arx(structure, (A, B))
    theta[structure.places("c")] = solution[order + sum(structure.nb) :]
    return theta


def _of_long_arx(structure: PolynomialStructure, A: Array, B: list[Array]) -> Array:
    """F and B from F B_long = B A_long, C and D from C A_long = D, each by linear least squares."""
    theta = np.zeros(structure.size)
    for i, (nb, nf, nk) in enumerate(zip(structure.nb, structure.nf, structure.nk, strict=True)):
        size = len(A) + structure.longest
        above, below = (np.concatenate([part, np.zeros(size)])[:size] for part in (B[i], A))
        columns = np.hstack([-regressors(above, range(1, nf + 1)), regressors(below, range(nk, nk + nb))])
        solution = np.linalg.lstsq(columns, above, rcond=1e-12)[0]
        theta[structure.places("f", i)], theta[structure.places("b", i)] = np.split(solution, [nf])
    nc, order = structure.nc, structure.nd or structure.na
    below, units = np.concatenate([A, np.zeros(nc)]), np.eye(len(A) + nc)
    columns = np.hstack([-regressors(below, range(1, nc + 1)), units[:, 1 : 1 + order]])
    solution = np.linalg.lstsq(columns, below - units[0], rcond=1e-12)[0]
    theta[structure.places("c")] = solution[:nc]
    theta[structure.places("d" if structure.nd else "a")] = solution[nc:]
    return theta


def _steiglitz_mcbride(
    structure: PolynomialStructure, records: tuple[Record, ...], noise: tuple[Array, ...], theta: Array
) -> Array:
    """One round: F and B by least squares on signals behind D / (C F) and A, then C and D on v and the noise."""
    model, renewed = structure.polynomials(theta), theta.copy()
    for i in range(structure.nu):
        rows, targets = [], []
        for record in records:
            others = [lfilter(B, F, u) for B, F, u in zip(model.B, model.F, record.u, strict=True)]
            own = lfilter(model.A, [1.0], record.y) - sum(others) + others[i]
            below = np.convolve(model.C, model.F[i])
            y, u = lfilter(model.D, below, own), lfilter(model.D, below, record.u[i])
            delays = range(structure.nk[i], structure.nk[i] + structure.nb[i])
            rows.append(np.hstack([-regressors(y, range(1, structure.nf[i] + 1)), regressors(u, delays)]))
            targets.append(y)
        solution = np.linalg.lstsq(np.vstack(rows), np.concatenate(targets), rcond=1e-12)[0]
        renewed[structure.places("f", i)], renewed[structure.places("b", i)] = np.split(solution, [structure.nf[i]])
    renewed = _stable(structure, renewed)
    return _noise_model(structure, records, noise, renewed) if structure.nc or structure.nd else renewed


def _noise_model(
    structure: PolynomialStructure, records: tuple[Record, ...], noise: tuple[Array, ...], theta: Array
) -> Array:
    """C and D from D v = C e, with v the misfit of A, B and F, and e the residuals of the long model."""
    model, renewed, rows, targets = structure.polynomials(theta), theta.copy(), [], []
    for record, e in zip(records, noise, strict=True):
        parts = zip(model.B, model.F, record.u, strict=True)
        v = lfilter(model.A, [1.0], record.y) - sum(lfilter(B, F, u) for B, F, u in parts)
        rows.append(np.hstack([regressors(e, range(1, structure.nc + 1)), -regressors(v, range(1, structure.nd + 1))]))
        targets.append(v - e)
    solution = np.linalg.lstsq(np.vstack(rows), np.concatenate(targets), rcond=1e-12)[0]
    renewed[structure.places("c")], renewed[structure.places("d")] = np.split(solution, [structure.nc])
    return renewed


def _stable(structure: PolynomialStructure, theta: Array) -> Array:
    """The parameters with the roots of C, D and F inside the unit circle."""
    renewed = np.nan_to_num(theta, nan=0.0, posinf=0.0, neginf=0.0)
    for letter, i in (("c", 0), ("d", 0), *(("f", i) for i in range(structure.nu))):
        places = structure.places(letter, i)
        renewed[places] = reflect(np.concatenate([[1.0], renewed[places]]), SAFE)[1:]
    return renewed
