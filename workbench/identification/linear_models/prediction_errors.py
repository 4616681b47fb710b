"""One-step prediction errors of a polynomial model and their exact gradients, with unknown initial values removed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from workbench.core.validation.refusals import Array
from workbench.identification.linear_models.polynomial_structure import Polynomials, PolynomialStructure

RANK = 1e-9  # of the largest singular value: a smaller one is of an initial value that the errors do not tell


@dataclass(frozen=True, eq=False)
class Record:
    """The samples of one experiment at a constant period: y (N,) and u (nu, N)."""

    y: Array
    u: Array


@dataclass(frozen=True, eq=False)
class Errors:
    """Prediction errors e (N,) of all records in a row, their gradients J (N, size), and the constant of the output."""

    e: Array
    J: Array
    constant: float = 0.0


@dataclass(frozen=True)
class Predictor:
    """The prediction errors of a structure over records, as a function of its parameters.

    With `initial`, each record has unknown initial values; with `constant`, A y has an unknown constant. Both enter e
    linearly. They are removed by an orthogonal projection, and so are their effects on the gradients (Kaufman 1975).
    """

    structure: PolynomialStructure
    records: tuple[Record, ...]
    initial: bool = True
    constant: bool = False

    @property
    def samples(self) -> int:
        """The number of prediction errors."""
        return sum(len(record.y) for record in self.records)

    @property
    def nuisances(self) -> int:
        """The number of initial values and constants that are removed."""
        return self.structure.transients * len(self.records) * self.initial + self.constant

    def errors(self, theta: Array, gradients: bool = True) -> Errors:
        """The errors and, if wanted, their gradients at parameters theta (size,)."""
        model = self.structure.polynomials(theta)
        parts = [_Signals(self.structure, model, record) for record in self.records]
        e = np.concatenate([part.e for part in parts])
        basis = self._basis(model, parts)
        values = np.zeros(basis.shape[1])
        U = basis
        if basis.shape[1]:
            scale = np.linalg.norm(basis, axis=0)
            U, s, V = np.linalg.svd(basis / np.where(scale > 0, scale, 1), full_matrices=False)
            seen = s > RANK * s[0]
            U = U[:, seen]
            values = V[seen].T @ ((U.T @ e) / s[seen]) / np.where(scale > 0, scale, 1)
            e = e - basis @ values
        kappa = float(values[-1]) if self.constant else 0.0
        if not gradients:
            return Errors(e, np.zeros((len(e), 0)), kappa)
        J = self._gradients(model, parts, e, values, kappa)
        return Errors(e, J - U @ (U.T @ J) if basis.shape[1] else J, kappa)

    def _basis(self, model: Polynomials, parts: list[_Signals]) -> Array:
        """The effects (N, n) of the initial values of each record, and of the constant."""
        count, columns = self.structure.transients if self.initial else 0, []
        below = _product(model.C, *model.F)
        at = 0
        for part in parts:
            size = len(part.record.y)
            block = np.zeros((self.samples, count))
            if count:
                impulse = np.zeros(size)
                impulse[0] = 1.0
                block[at : at + size] = _shifted(lfilter([1.0], below, impulse), range(count))
            columns.append(block)
            at += size
        if self.constant:
            ones = [lfilter(model.D, model.C, np.ones(len(part.record.y))) for part in parts]
            columns.append(np.concatenate(ones)[:, np.newaxis])
        return np.hstack(columns)

    def _gradients(self, model: Polynomials, parts: list[_Signals], e: Array, values: Array, kappa: float) -> Array:
        count, rows, at = self.structure.transients if self.initial else 0, [], 0
        for k, part in enumerate(parts):
            size = len(part.record.y)
            transient = np.zeros(size)
            if count:
                impulses = np.zeros(size)
                wanted = values[k * count : (k + 1) * count]
                impulses[: min(count, size)] = wanted[:size]
                transient = lfilter([1.0], _product(model.C, *model.F), impulses)
            rows.append(part.gradients(e[at : at + size], transient, kappa))
            at += size
        return np.vstack(rows)


class _Signals:
    """The signals inside a predictor at rest: w_i = B_i/F_i u_i, v = A y - sum w_i, e = D/C v."""

    def __init__(self, structure: PolynomialStructure, model: Polynomials, record: Record) -> None:
        self.structure, self.model, self.record = structure, model, record
        self.w = [lfilter(B, F, u) for B, F, u in zip(model.B, model.F, record.u, strict=True)]
        self.v = lfilter(model.A, [1.0], record.y) - sum(self.w)
        self.e = np.asarray(lfilter(model.D, model.C, self.v))

    def gradients(self, e: Array, transient: Array, kappa: float) -> Array:
        """The gradients (N, size) of e at fixed initial values, whose effect on e is `transient`."""
        held, model = self.structure, self.model
        J = np.empty((len(e), held.size))
        if held.na:
            J[:, held.places("a")] = _shifted(lfilter(model.D, model.C, self.record.y), range(1, held.na + 1))
        for i in range(held.nu):
            below = _product(model.C, model.F[i])
            delays = range(held.nk[i], held.nk[i] + held.nb[i])
            J[:, held.places("b", i)] = -_shifted(lfilter(model.D, below, self.record.u[i]), delays)
            if held.nf[i]:
                moved = lfilter(model.D, below, self.w[i]) + lfilter([1.0], model.F[i], transient)
                J[:, held.places("f", i)] = _shifted(moved, range(1, held.nf[i] + 1))
        if held.nc:
            J[:, held.places("c")] = -_shifted(lfilter([1.0], model.C, e), range(1, held.nc + 1))
        if held.nd:
            J[:, held.places("d")] = _shifted(lfilter([1.0], model.C, self.v - kappa), range(1, held.nd + 1))
        return J


def _shifted(signal: Array, delays: range) -> Array:
    """The signal (N,) behind each of some delays, (N, len(delays)), at rest before its first sample."""
    columns = np.zeros((len(signal), len(delays)))
    for column, delay in zip(columns.T, delays, strict=True):
        column[delay:] = signal[: max(len(signal) - delay, 0)]
    return columns


def _product(*polynomials: Array) -> Array:
    total = np.ones(1)
    for polynomial in polynomials:
        total = np.convolve(total, polynomial)
    return total
