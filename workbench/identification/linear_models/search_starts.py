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
    held, records = predictor.structure, predictor.records
    arx = arx_of(held, records)
    yield "ARX", _stable(held, _of_arx(held, arx))
    if not (held.nc or held.nd or any(held.nf)):
        return
    A, B = long_arx(held, records)
    noise = tuple(_difference(A, B, record) for record in records)
    yield "Hannan-Rissanen", _stable(held, _hannan_rissanen(held, records, noise))
    if any(held.nf):
        theta = _stable(held, _of_long_arx(held, A, B))
        yield "long ARX", theta
        for _ in range(ROUNDS):
            theta = _stable(held, _steiglitz_mcbride(held, records, noise, theta))
        yield "Steiglitz-McBride", theta
        if held.nc and held.nd:
            yield from _with_shared_root(held, records, noise, theta)
    yield from _random(predictor, count, generator)


def _with_shared_root(
    held: PolynomialStructure, records: tuple[Record, ...], noise: tuple[Array, ...], theta: Array
) -> Iterator[tuple[str, Array]]:
    """Noise models of one order less, times a factor that C and D have in common."""
    less = replace(held, nc=held.nc - 1, nd=held.nd - 1)
    smaller = np.zeros(less.size)
    for letter, i in (("a", 0), *((letter, i) for letter in "bf" for i in range(held.nu))):
        smaller[less.places(letter, i)] = theta[held.places(letter, i)]
    if less.nc or less.nd:
        smaller = _stable(less, _noise_model(less, records, noise, smaller))
    model = less.polynomials(smaller)
    for root in SHARED:
        renewed = theta.copy()
        for letter, polynomial in (("c", model.C), ("d", model.D)):
            renewed[held.places(letter)] = np.convolve(polynomial, [1.0, -root])[1:]
        yield "shared root", renewed


def _random(predictor: Predictor, count: int, generator: np.random.Generator) -> Iterator[tuple[str, Array]]:
    held = predictor.structure
    if not count:
        return
    draws = []
    for _ in range(DRAWS):
        theta = np.zeros(held.size)
        for letter, i, order in (
            ("a", 0, held.na),
            ("c", 0, held.nc),
            ("d", 0, held.nd),
            *(("f", i, nf) for i, nf in enumerate(held.nf)),
        ):
            theta[held.places(letter, i)] = _random_polynomial(order, generator)[1:]
        linear = [held.places("b", i) for i in range(held.nu)] + [held.places("a")]
        columns = np.concatenate([np.arange(held.size)[part] for part in linear])
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


def arx_of(held: PolynomialStructure, records: tuple[Record, ...]) -> tuple[Array, list[Array]]:
    """A and B by linear least squares, with the orders of A or F, and those of B, behind the first samples."""
    order = max(held.na, *held.nf, held.nd, 0)
    return _least_squares(records, order, held.nk, held.nb)


def long_arx(held: PolynomialStructure, records: tuple[Record, ...]) -> tuple[Array, list[Array]]:
    """A long ARX model: an order that the samples can carry."""
    samples = sum(len(record.y) for record in records)
    order = int(np.clip(samples // (10 * (1 + held.nu)), held.longest, LONGEST))
    return _least_squares(records, order, held.nk, (order,) * held.nu)


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


def _of_arx(held: PolynomialStructure, arx: tuple[Array, list[Array]]) -> Array:
    """The parameters with A, or F and D, of an ARX model."""
    A, B = arx
    theta = np.zeros(held.size)
    for i in range(held.nu):
        theta[held.places("b", i)] = B[i][held.nk[i] : held.nk[i] + held.nb[i]]
        theta[held.places("f", i)] = A[1 : 1 + held.nf[i]] if not held.na else 0.0
    if held.na:
        theta[held.places("a")] = A[1 : 1 + held.na]
    elif held.nd:
        theta[held.places("d")] = A[1 : 1 + held.nd]
    return theta


def _hannan_rissanen(held: PolynomialStructure, records: tuple[Record, ...], noise: tuple[Array, ...]) -> Array:
    """A, B and C by a regression on y, u and the residuals of the long model; F and D are A where there is no A."""
    order, rows, targets = max(held.na, *held.nf, held.nd, 0), [], []
    for record, e in zip(records, noise, strict=True):
        parts = [-regressors(record.y, range(1, order + 1))]
        parts += [regressors(u, range(k, k + b)) for u, k, b in zip(record.u, held.nk, held.nb, strict=True)]
        parts.append(regressors(e, range(1, held.nc + 1)))
        rows.append(np.hstack(parts))
        targets.append(record.y - e)
    solution = np.linalg.lstsq(np.vstack(rows), np.concatenate(targets), rcond=1e-12)[0]
    A = np.concatenate([[1.0], solution[:order]])
    numerators = np.split(solution[order : order + sum(held.nb)], np.cumsum(held.nb)[:-1])
    B = [np.concatenate([np.zeros(k), b]) for b, k in zip(numerators, held.nk, strict=True)]
    theta = _of_arx(held, (A, B))
    theta[held.places("c")] = solution[order + sum(held.nb) :]
    return theta


def _of_long_arx(held: PolynomialStructure, A: Array, B: list[Array]) -> Array:
    """F and B from F B_long = B A_long, C and D from C A_long = D, each by linear least squares."""
    theta = np.zeros(held.size)
    for i in range(held.nu):
        size = len(A) + held.longest
        target = np.concatenate([B[i], np.zeros(size)])[:size]
        columns = np.hstack(
            [
                -regressors(target, range(1, held.nf[i] + 1)),
                regressors(np.concatenate([A, np.zeros(size)])[:size], range(held.nk[i], held.nk[i] + held.nb[i])),
            ]
        )
        solution = np.linalg.lstsq(columns, target, rcond=1e-12)[0]
        theta[held.places("f", i)], theta[held.places("b", i)] = np.split(solution, [held.nf[i]])
    size = len(A) + held.nc
    target = np.concatenate([A, np.zeros(held.nc)])
    columns = np.hstack([-regressors(target, range(1, held.nc + 1)), np.eye(size)[:, 1 : 1 + max(held.nd, held.na)]])
    solution = np.linalg.lstsq(columns, target - np.eye(size)[0], rcond=1e-12)[0]
    theta[held.places("c")] = solution[: held.nc]
    letter, order = ("d", held.nd) if held.nd else ("a", held.na)
    theta[held.places(letter)] = solution[held.nc : held.nc + order]
    return theta


def _steiglitz_mcbride(
    held: PolynomialStructure, records: tuple[Record, ...], noise: tuple[Array, ...], theta: Array
) -> Array:
    """One round: F and B by least squares on signals behind D / (C F) and A, then C and D on v and the noise."""
    model, renewed = held.polynomials(theta), theta.copy()
    for i in range(held.nu):
        rows, targets = [], []
        for record in records:
            others = [lfilter(B, F, u) for B, F, u in zip(model.B, model.F, record.u, strict=True)]
            own = lfilter(model.A, [1.0], record.y) - sum(others) + others[i]
            below = np.convolve(model.C, model.F[i])
            y, u = lfilter(model.D, below, own), lfilter(model.D, below, record.u[i])
            delays = range(held.nk[i], held.nk[i] + held.nb[i])
            rows.append(np.hstack([-regressors(y, range(1, held.nf[i] + 1)), regressors(u, delays)]))
            targets.append(y)
        solution = np.linalg.lstsq(np.vstack(rows), np.concatenate(targets), rcond=1e-12)[0]
        renewed[held.places("f", i)], renewed[held.places("b", i)] = np.split(solution, [held.nf[i]])
    renewed = _stable(held, renewed)
    return _noise_model(held, records, noise, renewed) if held.nc or held.nd else renewed


def _noise_model(
    held: PolynomialStructure, records: tuple[Record, ...], noise: tuple[Array, ...], theta: Array
) -> Array:
    """C and D from D v = C e, with v the misfit of A, B and F, and e the residuals of the long model."""
    model, renewed, rows, targets = held.polynomials(theta), theta.copy(), [], []
    for record, e in zip(records, noise, strict=True):
        parts = zip(model.B, model.F, record.u, strict=True)
        v = lfilter(model.A, [1.0], record.y) - sum(lfilter(B, F, u) for B, F, u in parts)
        rows.append(np.hstack([regressors(e, range(1, held.nc + 1)), -regressors(v, range(1, held.nd + 1))]))
        targets.append(v - e)
    solution = np.linalg.lstsq(np.vstack(rows), np.concatenate(targets), rcond=1e-12)[0]
    renewed[held.places("c")], renewed[held.places("d")] = np.split(solution, [held.nc])
    return renewed


def _stable(held: PolynomialStructure, theta: Array) -> Array:
    """The parameters with the roots of C, D and F inside the unit circle."""
    renewed = np.nan_to_num(theta, nan=0.0, posinf=0.0, neginf=0.0)
    for letter, i in (("c", 0), ("d", 0), *(("f", i) for i in range(held.nu))):
        places = held.places(letter, i)
        renewed[places] = reflect(np.concatenate([[1.0], renewed[places]]), SAFE)[1:]
    return renewed
