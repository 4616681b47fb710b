"""The margins of many rows at once: peaks by Hamiltonian eigenvalues from level to level, crossovers in the same way.

A gain |G(j omega)| meets a level where the Hamiltonian matrix of that level has an imaginary eigenvalue. So a level
that no gain meets bounds the peak from above, whatever the grid; the largest gain that was seen bounds it from below.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array
from workbench.design.frequency.bilinear_loops import on_axis
from workbench.design.linear_loop.frequency_answers import CutModels, feedback
from workbench.design.linear_loop.loop_model import LoopModel
from workbench.design.matrices import EPS, Complex, one_thread

Mask = np.ndarray[tuple[int, ...], np.dtype[np.bool_]]
Places = np.ndarray[tuple[int, ...], np.dtype[np.intp]]

GAP = 1e-7  # relative, of a peak and the level above it
NEAR_AXIS = 1e-6  # real part of an eigenvalue over its size, up to which it is looked at
SPLIT = 16.0  # times the distance by which the rounding of large entries parts two eigenvalues: one within is looked at
STIFF = 1e4  # a system with rates so many times the frequency of its peak: its eigenvalues do not place the peak well
CLIMBS, FIRST_CLIMB = 60, 0.05  # steps to the top from there, and the first of them relative to the frequency
ROUNDS = 30  # levels, or steps of Newton
ROWS = 256  # at once
ON_LEVEL = 1e-9  # relative distance of a gain from one, at a crossover


@dataclass(frozen=True, eq=False)
@show
class RowMargins:
    """The margins of N rows at each of the `channels`, while the loop is closed at the others; NaN in unstable rows.

    `Ms` is the peak of |S|, reached at `Ms_frequency` in rad/s; factors (2 + d) / (2 - d) with complex |d| below
    `disk_margin` keep the loop stable, and so do losses of phase below `phase_margin` in degrees, and delays below
    `delay_margin` in s. Each is (N, number of channels). `disk_margin_of_all` (N,) is a lower bound of the disk margin
    of all channels at once, by the largest singular value. `error` is the relative gap between a peak, which was seen,
    and a level above it that the Hamiltonian matrix of no row meets.
    """

    channels: tuple[str, ...]
    Ms: Array
    Ms_frequency: Array
    disk_margin: Array
    phase_margin: Array
    delay_margin: Array
    disk_margin_of_all: Array
    error: float

    @property
    def worst(self) -> int:
        """The row with the largest Ms at any channel."""
        return int(np.nanargmax(self.Ms.max(axis=1)))


def row_margins(call: str, models: CutModels, names: Sequence[str], stable: Mask) -> RowMargins:
    """The margins of the rows that are stable (N,)."""
    opened, N = models.open_drives(call), len(stable)
    shape = (N, len(names))
    Ms, places, disk, phase, delay = (np.full(shape, np.nan) for _ in range(5))
    rows, drives = np.flatnonzero(stable), range(len(models.delays))
    with one_thread(), np.errstate(all="ignore"):
        for k, i in enumerate(models.channels):
            L = _some(opened.closed_at([j for j in drives if j != i]).part([i], [0]).negative(), rows)
            Ms[rows, k], places[rows, k] = largest_gains(feedback(L, "S"))
            disk[rows, k] = 1 / largest_gains(_centred_sensitivity(feedback(L, "S")))[0]
            phase[rows, k], delay[rows, k] = phase_margins(L)
        every = np.full(N, np.nan)
        every[rows] = disk[rows, 0]
        if len(names) > 1:
            every[rows] = 1 / largest_gains(_centred_sensitivity(feedback(_some(models.kind(call, "L"), rows), "S")))[0]
    return RowMargins(tuple(names), Ms, places, disk, phase, delay, every, GAP)


def _some(model: LoopModel, rows: Places) -> LoopModel:
    return replace(model, A=model.A[rows], B=model.B[rows], Cy=model.Cy[rows], D=model.D[rows])


def _centred_sensitivity(S: LoopModel) -> LoopModel:
    """S - I / 2, half of S - T, whose largest gain is the inverse of the disk margin."""
    return replace(S, D=S.D - np.eye(S.D.shape[-1]) / 2)


def largest_gains(model: LoopModel) -> tuple[Array, Array]:
    """The peak (N,) of the largest singular value of stable rows, and its frequency (N,) in rad/s."""
    G, N = _Axis.of(model), len(model.A)
    ends = np.array([0.0, np.inf])
    poles = np.linalg.eigvals(G.A) if G.A.shape[1] else np.zeros((N, 0))
    first = np.concatenate([np.tile(ends, (N, 1)), np.abs(poles), np.abs(poles.imag)], axis=1)
    gain, place = G.best(np.arange(N), first)
    seeking = np.arange(N)
    for _ in range(ROUNDS):
        level = gain[seeking] * (1 + GAP)
        meets = G.meetings(seeking, level)
        middles = np.sqrt(meets[:, 1:] * meets[:, :-1])
        new, at = G.best(
            seeking, np.concatenate([meets, np.where(meets[:, :-1] > 0, middles, meets[:, 1:] / 2)], axis=1)
        )
        higher = new > level
        gain[seeking[higher]], place[seeking[higher]] = new[higher], at[higher]
        seeking = seeking[higher]
        if not seeking.size:
            break
    gain[seeking] = np.nan  # no level above it was found
    stiff = np.isfinite(place) & (place > 0) & (np.abs(G.A).max(axis=(1, 2), initial=0.0) > STIFF * place)
    gain[stiff], place[stiff] = _climb(G, np.flatnonzero(stiff), place[stiff])
    return gain, G.frequency(place)


def _climb(G: _Axis, rows: Places, v: Array) -> tuple[Array, Array]:
    """The tops near points v (n,) of the axis, by steps that are halved where neither side is higher."""
    step, gain = np.full(len(rows), FIRST_CLIMB), np.full(len(rows), np.nan)
    for _ in range(CLIMBS if len(rows) else 0):
        gain, at = G.best(rows, np.stack([v, v / (1 + step), v * (1 + step)], axis=1))
        step = np.where(at == v, step / 2, step)
        v = at
    return gain, v


def phase_margins(L: LoopModel) -> tuple[Array, Array]:
    """The least phase margin (N,) in degrees over all gain crossovers, and the delay margin (N,) in s."""
    G, N = _Axis.of(L), len(L.A)
    rows = np.arange(N)
    v = G.meetings(rows, np.ones(N))
    for _ in range(ROUNDS):  # Newton's method on log |L|, as an eigenvalue is not known to the last digits
        values, slopes = G.values(rows, v)
        step = np.log(np.abs(values)) / (slopes / values).real
        step = np.where(np.isfinite(step), step, 0.0)
        if not (np.abs(step) > 1e-14 * v).any():
            break
        v = np.abs(v - np.clip(step, -v / 2, v / 2))
    values, _ = G.values(rows, v)
    found = (np.abs(np.abs(values) - 1) < ON_LEVEL) & np.isfinite(v) & (v > 0)
    angle = np.angle(-values)
    phase = np.where(found, np.degrees(np.abs(angle)), np.inf).min(axis=1, initial=np.inf)
    lag = np.where(found, (angle % (2 * math.pi)) / G.frequency(v), np.inf).min(axis=1, initial=np.inf)
    beyond = np.abs(L.D[:, 0, 0]) > 1 if L.period is None else np.zeros(N, dtype=bool)
    missed = ~found.any(axis=1) & _falls_through_one(G)
    return np.where(missed, np.nan, phase), np.where(missed, np.nan, np.where(beyond, 0.0, lag))


def _falls_through_one(G: _Axis) -> Mask:
    """True for each row whose gain is above one at low frequencies and below one at infinity: it crosses one."""
    rates = np.abs(np.linalg.eigvals(G.A)) if G.A.shape[1] else np.ones((len(G.A), 1))
    slowest = np.where(rates > 0, rates, np.inf).min(axis=1)
    low, _ = G.values(np.arange(len(G.A)), 1e-3 * np.where(np.isfinite(slowest), slowest, 1.0)[:, np.newaxis])
    return np.asarray((np.abs(low[:, 0]) > 1) & (np.abs(G.D[:, 0, 0]) < 1))


@dataclass(frozen=True, eq=False)
class _Axis:
    """N rows on the imaginary axis: those of a computer by z = (1 + v) / (1 - v), with v = j tan(omega h / 2)."""

    A: Array
    B: Array
    C: Array
    D: Array
    period: float | None

    @staticmethod
    def of(model: LoopModel) -> _Axis:
        A, B, C, D, h = model.A, model.B, model.Cy, model.D, model.period
        if h is None:
            return _Axis(A, B, C, D, None)
        return _Axis(*on_axis(A, B, C, D), h)

    def frequency(self, v: Array) -> Array:
        """The frequencies in rad/s."""
        return v if self.period is None else 2 / self.period * np.arctan(v)

    def values(self, rows: Places, v: Array) -> tuple[Complex, Complex]:
        """The values (N, m) of one channel at points v (N, m) of the axis, and their derivatives by v."""
        N = len(rows)
        finite = np.where(np.isfinite(v), v, 0.0)
        M = _shifted_matrices(finite, self.A[rows][:, np.newaxis])
        x = _solve_rows(
            M, np.broadcast_to(self.B[rows][:, np.newaxis].astype(complex), (N, v.shape[1], *self.B.shape[1:]))
        )
        C = self.C[rows][:, np.newaxis]
        values = (C @ x)[..., 0, 0] + self.D[rows][:, :, 0]
        return np.where(np.isfinite(v), values, self.D[rows][:, :, 0]), -1j * (C @ _solve_rows(M, x))[..., 0, 0]

    def best(self, rows: Places, v: Array) -> tuple[Array, Array]:
        """The largest singular value (N,) at points v (N, m), where NaN is no point, and the point."""
        gains = np.full(v.shape, -np.inf)
        for first in range(0, len(rows), ROWS):
            some = slice(first, first + ROWS)
            i, k = np.nonzero(np.isfinite(v[some]))
            own = rows[some][i]
            G = (
                self.C[own] @ _solve_rows(_shifted_matrices(v[some][i, k], self.A[own]), self.B[own].astype(complex))
                + self.D[own]
            )
            gains[some][i, k] = _largest(G)
        infinite = np.isinf(v)
        gains[infinite] = np.broadcast_to(_largest(self.D[rows])[:, np.newaxis], v.shape)[infinite]
        gains = np.where(np.isnan(gains), -np.inf, gains)
        place = gains.argmax(axis=1)
        each = np.arange(len(rows))
        return gains[each, place], v[each, place]

    def meetings(self, rows: Places, level: Array) -> Array:
        """The points of the axis (N, m) at which a singular value may be at the level (N,), rising; then NaN."""
        n, found = self.A.shape[-1], np.full((len(rows), 2 * self.A.shape[-1] + 1), np.nan)
        for first in range(0, len(rows), ROWS):
            some = slice(first, first + ROWS)
            A, B, C, D = (M[rows[some]] for M in (self.A, self.B, self.C, self.D))
            scale = level[some][:, np.newaxis, np.newaxis]
            B, D = B / scale, D / scale
            R = np.linalg.inv(np.eye(D.shape[-1]) - D.swapaxes(1, 2) @ D)
            inner = A + B @ R @ D.swapaxes(1, 2) @ C
            high = B @ R @ B.swapaxes(1, 2)
            low = -C.swapaxes(1, 2) @ (np.eye(C.shape[1]) + D @ R @ D.swapaxes(1, 2)) @ C
            H = np.concatenate(
                [np.concatenate([inner, high], axis=2), np.concatenate([low, -inner.swapaxes(1, 2)], axis=2)], axis=1
            )
            sound = np.isfinite(H).all(axis=(1, 2))
            values = np.linalg.eigvals(np.where(sound[:, np.newaxis, np.newaxis], H, 0.0))
            sizes = np.abs(values)
            apart = np.sqrt(EPS * np.abs(H).max(axis=(1, 2), initial=0.0)[:, np.newaxis] * sizes)
            close = np.abs(values.real) <= np.maximum(NEAR_AXIS * sizes, SPLIT * apart)
            near = close & (values.imag >= 0) & sound[:, np.newaxis]
            found[some, : 2 * n] = np.sort(np.where(near, values.imag, np.nan), axis=1)
        return found[:, : max(2, int(np.isfinite(found).sum(axis=1).max(initial=0)))]


def _shifted_matrices(v: Array, A: Array) -> Complex:
    """The matrices j v I - A, which are singular where a pole lies on the axis."""
    return np.asarray(1j * v[..., np.newaxis, np.newaxis] * np.eye(A.shape[-1]) - A)


def _largest(G: Array | Complex) -> Array:
    return np.asarray(np.abs(G[:, 0, 0]) if G.shape[1:] == (1, 1) else np.linalg.svd(G, compute_uv=False)[:, 0])


def _solve_rows(M: Complex, right: Complex) -> Complex:
    """The solutions of many systems; infinite where one is exactly singular."""
    try:
        return np.asarray(np.linalg.solve(M, right))
    except np.linalg.LinAlgError:
        singular = np.abs(np.linalg.det(M)) == 0
        eye = np.eye(M.shape[-1])
        solution = np.linalg.solve(np.where(singular[..., np.newaxis, np.newaxis], eye, M), right)
        return np.where(singular[..., np.newaxis, np.newaxis], np.inf, solution)
