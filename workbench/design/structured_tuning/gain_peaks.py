"""The peaks of the gain of a system, found by levels that a Hamiltonian matrix meets, with their gradients."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.design.frequency.bilinear_loops import on_axis
from workbench.design.structured_tuning.figure_pieces import MOST_PIECES, FigurePiece
from workbench.design.structured_tuning.system_jets import SystemJet

GAP = 1e-9  # relative, of a peak and the level above it
NEAR_AXIS = 1e-6  # of an eigenvalue that is looked at, its real part over its size
ROUNDS = 30
SECANT, FARTHEST = 1e-6, 1e-3  # relative, of the points of a secant, and of the change by it
CLOSE = 0.02  # relative, of singular values between which pieces are made
ROOT = math.sqrt(2.0)
FINE = 9  # points in each bracket of a peak
SHRINKS = 4  # of a bracket, each to a quarter
LEVELS = 1.0, 0.1, 0.003  # shares of the width below the peak, at which intervals are sought


def gain_pieces(jet: SystemJet, width: float) -> list[FigurePiece]:
    """The peaks of the largest singular values of a stable system that are above (1 - width) of the largest one."""
    axis = _Axis.of(jet)
    peak, place = axis.peak()
    if not np.isfinite(peak) or peak == 0:
        return [FigurePiece(peak if peak == peak else math.inf, np.zeros(len(jet.slopes)), 0.0)]
    if not width:
        return list(_at_frequency(jet, axis.frequency(place), math.inf))
    places = [place, *axis.local_peaks(peak, width)]
    found: list[FigurePiece] = []
    slow = 1e-3 * float(np.abs(np.linalg.eigvals(axis.A)).min(initial=np.inf))
    every = np.array(sorted(set(places)))
    for v in every[np.argsort(-axis.gains(every), kind="stable")]:
        omega = axis.frequency(v)
        if any(abs(omega - one.place) <= 1e-4 * max(omega, one.place, slow) for one in found if one.rank == 0):
            continue
        found += _at_frequency(jet, omega, (1 - width) * peak)
        if len(found) >= MOST_PIECES:
            break
    return found


def _at_frequency(jet: SystemJet, omega: float, least: float) -> Iterator[FigurePiece]:
    G, X, Y = jet.response(omega)
    U, sigma, V = np.linalg.svd(G, full_matrices=False)
    for rank in range(len(sigma)):
        if rank and sigma[rank] < least:
            break
        matrix = jet.cell_slopes(X, Y, U[:, rank].conj(), V[rank].conj())
        yield FigurePiece(float(sigma[rank]), jet.pull(matrix), float(omega), rank)
        if rank and sigma[rank] >= (1 - CLOSE) * sigma[0]:
            for turn, phase in enumerate((1, 1j, -1, -1j)):  # between singular values that meet
                u, v = (U[:, 0] + phase * U[:, rank]) / ROOT, (V[0].conj() + phase * V[rank].conj()) / ROOT
                matrix, value = jet.cell_slopes(X, Y, u.conj(), v), (sigma[0] + sigma[rank]) / 2
                yield FigurePiece(float(value), jet.pull(matrix), float(omega), 10 * rank + turn)


@dataclass(frozen=True, eq=False)
class _Axis:
    """A stable system on the imaginary axis; a sampled one by z = (1 + s) / (1 - s), with s = j tan(omega h / 2)."""

    A: Array
    B: Array
    C: Array
    D: Array
    period: float | None

    @staticmethod
    def of(jet: SystemJet) -> _Axis:
        A, B, C, D, h = jet.A, jet.B, jet.C, jet.D, jet.period
        if h is None:
            return _Axis(A, B, C, D, None)
        return _Axis(*on_axis(A, B, C, D), h)

    def frequency(self, v: float) -> float:
        """The frequency in rad/s of a point j v."""
        return float(v) if self.period is None else float(2 / self.period * np.arctan(v))

    def gain(self, v: float) -> float:
        """The largest singular value at a point j v."""
        return float(self.gains(np.array([v]))[0])

    def gains(self, v: Array) -> Array:
        """The largest singular values at points j v (m,); that of D at infinity."""
        gains, finite = np.empty(len(v)), np.isfinite(v)
        if finite.any():
            M = 1j * v[finite, np.newaxis, np.newaxis] * np.eye(len(self.A)) - self.A
            G = self.C @ np.linalg.solve(M, np.broadcast_to(self.B, (len(M), *self.B.shape))) + self.D
            gains[finite] = np.linalg.svd(G, compute_uv=False)[:, 0]
        if not finite.all():
            gains[~finite] = np.linalg.norm(self.D, 2)
        return gains

    def peak(self) -> tuple[float, float]:
        """The largest gain and its point, by levels that the eigenvalues of a Hamiltonian matrix meet or do not."""
        poles = np.linalg.eigvals(self.A) if len(self.A) else np.zeros(0)
        v = np.unique(np.concatenate([[0.0, np.inf], np.abs(poles), np.abs(poles.imag)]))
        gains = self.gains(v)
        best, place = float(gains.max()), float(v[gains.argmax()])
        for _ in range(ROUNDS):
            meets = self.meetings(best * (1 + GAP))
            if not len(meets):
                break
            middles = np.sqrt(meets[1:] * meets[:-1])
            v = np.unique(np.concatenate([meets, middles, (meets[1:] + meets[:-1]) / 2]))
            gains = self.gains(v)
            if not gains.max() > best * (1 + GAP):
                break
            best, place = float(gains.max()), float(v[gains.argmax()])
        return self._stationary(best, place)

    def _stationary(self, best: float, place: float) -> tuple[float, float]:
        """The peak where the slope of the gain is zero, by a secant, as a level knows a place to half the digits."""
        if not 0 < place < math.inf:
            return best, place
        ahead = place * (1 + SECANT)
        here, there = self._slope(place), self._slope(ahead)
        new = place - here * (ahead - place) / (there - here) if there != here else place
        if not abs(new - place) <= FARTHEST * place:
            return best, place
        gain = self.gain(new)
        return (gain, float(new)) if gain >= best * (1 - GAP) else (best, place)

    def _slope(self, v: float) -> float:
        """The derivative of the largest singular value by v."""
        R = np.linalg.inv(1j * v * np.eye(len(self.A)) - self.A)
        X, Y = R @ self.B, self.C @ R
        U, _, V = np.linalg.svd(self.C @ X + self.D)
        return float((U[:, 0].conj() @ (-1j * (Y @ X)) @ V[0].conj()).real)

    def meetings(self, level: float) -> Array:
        """The points of the axis at which a singular value may be at the level, rising."""
        if not level > 0 or not len(self.A):
            return np.zeros(0)
        B, D = self.B / level, self.D / level
        try:
            R = np.linalg.inv(np.eye(D.shape[1]) - D.T @ D)
        except np.linalg.LinAlgError:
            return np.zeros(0)
        inner = self.A + B @ R @ D.T @ self.C
        low = -self.C.T @ (np.eye(len(self.C)) + D @ R @ D.T) @ self.C
        H = np.block([[inner, B @ R @ B.T], [low, -inner.T]])
        if not np.isfinite(H).all():
            return np.zeros(0)
        values = np.linalg.eigvals(H)
        near = (np.abs(values.real) <= NEAR_AXIS * np.abs(values)) & (values.imag >= 0)
        return np.sort(values.imag[near])

    def local_peaks(self, peak: float, width: float) -> Iterator[float]:
        """The local maxima above (1 - width) of the peak, which the intervals above some levels show."""
        poles = np.linalg.eigvals(self.A)
        marks = [np.array([0.0]), np.abs(poles), np.abs(poles.imag)]
        marks += [self.meetings((1 - share * width) * peak) for share in LEVELS]
        v = np.unique(np.concatenate(marks))
        v = v[np.concatenate([[True], np.diff(v) > 1e-9 * v[1:]])]
        v = np.unique(np.concatenate([v, (v[1:] + v[:-1]) / 2, np.sqrt(v[1:] * v[:-1]), [2 * v[-1]]]))
        gains = self.gains(v)
        if self.gain(math.inf) > (1 - width) * peak:
            yield math.inf
        padded = np.concatenate([[-np.inf], gains, [-np.inf]])
        tops = np.flatnonzero((padded[1:-1] > padded[:-2]) & (padded[1:-1] >= padded[2:]))
        tops = tops[gains[tops] > (1 - width) * peak]
        if len(tops):
            yield from self._refined(v[np.maximum(tops - 1, 0)], v[np.minimum(tops + 1, len(v) - 1)])

    def _refined(self, low: Array, high: Array) -> Iterator[float]:
        """The maxima within brackets (m,), which shrink together and end with a parabola."""
        share, each = np.linspace(0, 1, FINE), np.arange(len(low))
        for _ in range(SHRINKS):
            points = low[:, np.newaxis] + (high - low)[:, np.newaxis] * share
            gains = self.gains(points.ravel()).reshape(points.shape)
            best = np.clip(gains.argmax(axis=1), 1, FINE - 2)
            low, high = points[each, best - 1], points[each, best + 1]
        a, b, c = gains[each, best - 1], gains[each, best], gains[each, best + 1]
        with np.errstate(divide="ignore", invalid="ignore"):
            shift = np.nan_to_num((a - c) / (2 * (a - 2 * b + c)))
        yield from (points[each, best] + np.clip(shift, -1, 1) * (high - low) / 2).tolist()
