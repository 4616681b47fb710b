"""One-step prediction errors of a polynomial model and their exact gradients, with unknown initial values removed.

Outputs may be missing. Without C an error needs the last na + nd outputs alone: errors that need a missing one are left
out. With C the missing outputs are unknown numbers, on which the errors depend linearly, e = e0 + H m. The likelihood
of the outputs that are there is that of a Kalman filter; it has the sum of squares at the best m, and det(H' H), by
which the errors are scaled: e det(H' H)^(1 / 2n) for n outputs.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.signal import lfilter

from workbench.core.validation.refusals import Array, Integers
from workbench.identification.datasets.experiment import Marks
from workbench.identification.linear_models.polynomial_structure import Polynomials, PolynomialStructure

RANK = 1e-9  # of the largest singular value: a smaller one is of an initial value that the errors do not tell


@dataclass(frozen=True, eq=False)
class Record:
    """The samples of one experiment at a constant period: y (N,) and u (nu, N).

    `counts` (N,) is True for the outputs that are there, None if all are; y is 0 where one is missing.
    """

    y: Array
    u: Array
    counts: Marks | None = None

    @property
    def gaps(self) -> Integers:
        """The places of the missing outputs."""
        return np.zeros(0, dtype=int) if self.counts is None else np.flatnonzero(~self.counts)

    def interpolate(self) -> Record:
        """The record with straight lines in place of missing outputs, for the start of a search."""
        if self.counts is None:
            return self
        there = np.flatnonzero(self.counts)
        return Record(np.interp(np.arange(len(self.y)), there, self.y[there]), self.u)


def record_of(y: Array, u: Array) -> Record:
    """The record of outputs y (N,), of which some may be NaN, and inputs u (nu, N)."""
    good = np.isfinite(y)
    return Record(y, u) if good.all() else Record(np.where(good, y, 0.0), u, good)


@dataclass(frozen=True, eq=False)
class Errors:
    """Prediction errors e (N,) of all records in a row, their gradients J (N, size), and the constant of the output.

    With missing outputs and a C, e and J are scaled by `scale`, and e holds `basis` (N, m) orthonormal directions less.
    """

    e: Array
    J: Array
    constant: float = 0.0
    scale: float = 1.0
    basis: Array | None = None


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
        """The number of prediction errors that count."""
        rows = self.rows
        if rows is not None:
            return int(rows.sum())
        return sum(len(record.y) - len(record.gaps) for record in self.records)

    @cached_property
    def has_gaps(self) -> bool:
        """True if outputs are missing."""
        return any(len(record.gaps) for record in self.records)

    @cached_property
    def rows(self) -> Marks | None:
        """The errors that do not need a missing output (N,); None if all count, or if missing outputs are estimated."""
        if not self.has_gaps or self.structure.nc:
            return None
        kept = []
        for record in self.records:
            gone = np.zeros(len(record.y), dtype=bool)
            for delay in range(self.structure.na + self.structure.nd + 1):
                gone[(places := record.gaps + delay)[places < len(gone)]] = True
            kept.append(~gone)
        return np.concatenate(kept)

    def on_grid(self, values: Array, empty: float) -> Array:
        """Values (n, ...) of the errors that count at their places among all samples (N, ...)."""
        if self.rows is None:
            return values
        whole = np.full((len(self.rows), *values.shape[1:]), empty)
        whole[self.rows] = values
        return whole

    def residuals(self, e: Array) -> list[Array]:
        """Errors that count by record, (N,) each; NaN where an output is missing, or is needed and missing."""
        return np.split(self.on_grid(e, np.nan), np.cumsum([len(record.y) for record in self.records])[:-1])

    @property
    def nuisances(self) -> int:
        """The number of initial values and constants that are removed."""
        return self.structure.transients * len(self.records) * self.initial + self.constant

    def errors(self, theta: Array, gradients: bool = True) -> Errors:
        """The errors and, if wanted, their gradients at parameters theta (size,)."""
        model = self.structure.polynomials(theta)
        parts = [_Signals(self.structure, model, record) for record in self.records]
        e, rows = np.concatenate([part.e for part in parts]), self.rows
        basis = self._basis(model, parts)
        gaps = Gaps(self.structure, model, self.records) if self.has_gaps and rows is None else None
        if rows is not None:
            e, basis = e[rows], basis[rows]
        elif gaps is not None:
            basis = np.hstack([basis, gaps.H])
        values = np.zeros(basis.shape[1])
        U = basis
        if basis.shape[1]:
            scale = np.linalg.norm(basis, axis=0)
            U, s, V = np.linalg.svd(basis / np.where(scale > 0, scale, 1), full_matrices=False)
            seen = s > RANK * s[0]
            U = U[:, seen]
            values = V[seen].T @ ((U.T @ e) / s[seen]) / np.where(scale > 0, scale, 1)
            e = e - basis @ values
        kappa = float(values[self.nuisances - 1]) if self.constant else 0.0
        scale = 1.0 if gaps is None else float(np.exp(gaps.log_determinant / (2 * self.samples)))
        if not gradients:
            return Errors(scale * e, np.zeros((len(e), 0)), kappa, scale)
        if gaps is not None:
            parts = [_Signals(self.structure, model, record) for record in gaps.fill(-values[self.nuisances :])]
        J = self._gradients(model, parts, self.on_grid(e, 0.0), values, kappa)
        J = J if rows is None else J[rows]
        J = J - U @ (U.T @ J) if basis.shape[1] else J
        if gaps is None:
            return Errors(e, J, kappa)
        J = J + np.outer(e, gaps.slopes()) / (2 * self.samples)
        return Errors(scale * e, scale * J, kappa, scale, U)

    def _basis(self, model: Polynomials, parts: list[_Signals]) -> Array:
        """The effects (N, n) of the initial values of each record, and of the constant."""
        count, columns = self.structure.transients if self.initial else 0, []
        below = _product(model.C, *model.F)
        at = 0
        for part in parts:
            size = len(part.record.y)
            block = np.zeros((sum(len(one.record.y) for one in parts), count))
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


def _shifted(signal: Array, delays: range | Integers) -> Array:
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


class Gaps:
    """The effects H (N, m) of the m missing outputs of all records on the errors, and the logarithm of det(H' H)."""

    def __init__(self, structure: PolynomialStructure, model: Polynomials, records: tuple[Record, ...]) -> None:
        self.structure, self.model, self.records = structure, model, records
        self.sizes = [len(record.y) for record in records]
        self.H = self._of_impulse(_product(model.A, model.D), model.C)
        self._triangle: Array = np.linalg.qr(self.H)[1]

    @property
    def log_determinant(self) -> float:
        """The logarithm of det(H' H)."""
        return 2 * float(np.sum(np.log(np.abs(np.diag(self._triangle)))))

    def _of_impulse(self, above: Array, below: Array) -> Array:
        """The responses (N, m) of above / below to an impulse at each missing output."""
        columns, at = [], 0
        for record, size in zip(self.records, self.sizes, strict=True):
            block = np.zeros((sum(self.sizes), len(record.gaps)))
            impulse = np.zeros(size)
            impulse[0] = 1.0
            block[at : at + size] = _shifted(lfilter(above, below, impulse), record.gaps)
            columns.append(block)
            at += size
        return np.hstack(columns)

    def fill(self, values: Array) -> list[Record]:
        """The records with these values (m,) in place of the missing outputs."""
        parts = np.split(values, np.cumsum([len(record.gaps) for record in self.records])[:-1])
        made = []
        for record, part in zip(self.records, parts, strict=True):
            y = record.y.copy()
            y[record.gaps] = part
            made.append(replace(record, y=y))
        return made

    def slopes(self) -> Array:
        """The gradient (size,) of the logarithm of det(H' H): 2 tr (H' H)^-1 H' dH."""
        held, model, made = self.structure, self.model, np.zeros(self.structure.size)
        P = np.linalg.solve(self._triangle, np.linalg.solve(self._triangle.T, self.H.T)).T
        moved = {
            "a": (held.na, self._of_impulse(model.D, model.C)),
            "c": (held.nc, -self._of_impulse(_product(model.A, model.D), _product(model.C, model.C))),
            "d": (held.nd, self._of_impulse(model.A, model.C)),
        }
        ends = np.cumsum(self.sizes)
        for letter, (order, columns) in moved.items():
            for delay in range(1, order + 1):
                later = np.zeros_like(columns)
                later[delay:] = columns[:-delay]
                for end in ends[:-1]:  # an impulse of one record is not seen in the next
                    later[end : end + delay] = 0.0
                made[held.places(letter)][delay - 1] = 2 * float(np.sum(P * later))
        return made
