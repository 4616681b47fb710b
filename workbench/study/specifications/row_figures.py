"""The figures of many draws of a loop at once, as computed on a grid: good enough to find the worst, and no proof.

What is found is looked at again by `point_figures`, whose bounds are proved.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.design.linear_loop import LinearLoop, LinearRows
from workbench.design.linear_loop.loop_model import LoopModel
from workbench.design.matrices import Complex
from workbench.study.specifications.loop_systems import noise_signals

FREQUENCIES, BEYOND = 300, 30.0  # of the grid, and by how much it goes beyond the poles
SAMPLES, CONSTANTS, LONGEST = 800, 8.0, 4000  # of a step answer, time constants of it, and periods in a computer
SETTLING_BAND, RISE_LEVELS = 0.02, (0.1, 0.9)  # of the final value
HALF_POWER = 10 ** (-3 / 20)
TIME_FIGURES = ("overshoot", "settling_time", "rise_time")


@dataclass(frozen=True, eq=False)
class RowGrid:
    """The frequencies (m,) in rad/s and the answer by which draws of a loop are compared."""

    omega: Array
    answer: tuple[str, str] | None

    @staticmethod
    def of(linear: LinearLoop, answer: tuple[str, str] | None) -> RowGrid:
        """A grid that goes beyond the poles of the loop on both sides, in a computer up to Nyquist's frequency."""
        sizes = np.array([abs(pole.frequency) for pole in linear.poles])
        sizes = sizes[np.isfinite(sizes) & (sizes > 1e-9 * sizes.max(initial=0.0))]
        low, high = (sizes.min() / BEYOND, sizes.max() * BEYOND) if sizes.size else (1e-2, 1e2)
        if linear.period is not None:
            high = min(high, math.pi / linear.period)
        return RowGrid(np.geomspace(min(low, high / 100), high, FREQUENCIES), answer)


def row_figures(rows: LinearRows, names: Sequence[str], grid: RowGrid, linear: LinearLoop) -> dict[str, Array]:
    """The figures (N,) by name: NaN in rows that are flagged; those of rows that are not stable have no meaning."""
    found: dict[str, Array] = {}
    peaks = {"Ms": "S", "Mt": "T"}
    for name in names:
        if name in peaks:
            found[name] = _largest(rows.response(grid.omega, peaks[name]).values)
    if {"damping", "decay"} & set(names):
        found |= _of_poles(rows)
    if "disk_margin" in names:
        T = rows.response(grid.omega, "T").values
        found["disk_margin"] = 1 / _largest(np.eye(T.shape[-1]) / 2 - T)
    if {"gain_margin", "phase_margin", "delay_margin"} & set(names):
        found |= _margins(grid.omega, rows, linear)
    if "noise_gain" in names:
        found["noise_gain"] = _largest(rows.response(grid.omega, "closed", *noise_signals(linear)).values)
    if {"bandwidth", *TIME_FIGURES} & set(names):
        found |= _of_answer(rows, names, grid)
    return {name: found[name] for name in names}


def _largest(values: Complex) -> Array:
    """The largest singular value (N,) over frequencies of answers (N, m, ny, nu); NaN where one is no number."""
    if values.shape[2:] == (1, 1):
        return np.asarray(np.abs(values).max(axis=(1, 2, 3)))
    flat, sound = values.reshape(-1, *values.shape[2:]), np.asarray(np.isfinite(values).all(axis=(2, 3)))
    sizes = np.linalg.norm(np.where(sound.reshape(-1, 1, 1), flat, 0.0), 2, axis=(-2, -1)).reshape(sound.shape)
    return np.where(sound.all(axis=1), sizes.max(axis=1), np.nan)


def _of_poles(rows: LinearRows) -> dict[str, Array]:
    poles, period = rows.poles, rows.models.closed_model.period
    if period is not None:
        with np.errstate(divide="ignore"):
            poles = np.asarray(np.log(poles) / (period * rows.models.closed_model.count), dtype=complex)
    size = np.abs(poles)
    with np.errstate(invalid="ignore", divide="ignore"):
        damping = np.where(np.isinf(size), 1.0, -poles.real / size)
    return {"decay": (-poles.real).min(axis=1), "damping": damping.min(axis=1)}


def _margins(omega: Array, rows: LinearRows, linear: LinearLoop) -> dict[str, Array]:
    """The least margins over all channels, each with the loop closed at the others, by straight lines on the grid."""
    models, least = rows.models, dict[str, Array]()
    for place in range(len(models.channels)):
        L = _channel(models.open_model, rows, place, omega)
        for name, value in _channel_margins(omega, L).items():
            least[name] = np.fmin(least[name], value) if name in least else value
    return least


def _channel(opened: LoopModel | None, rows: LinearRows, place: int, omega: Array) -> Complex:
    """L (N, m) of one channel; the delays are those of the loop."""
    models = rows.models
    if models.delays.any() or opened is None:  # of a single channel
        return rows.response(omega, "L").values[:, :, 0, 0]
    drive = models.channels[place]
    others = [k for k in range(len(models.delays)) if k != drive]
    own = models.open_drives("row_figures").closed_at(others).part([drive], [0])
    return -own.response(omega)[:, :, 0, 0]


def _channel_margins(omega: Array, L: Complex) -> dict[str, Array]:
    size, phase = np.log(np.abs(L)), np.unwrap(np.angle(L), axis=1)
    crossings = size[:, :-1] * size[:, 1:] < 0
    with np.errstate(invalid="ignore", divide="ignore"):
        part = np.where(crossings, size[:, :-1] / (size[:, :-1] - size[:, 1:]), 0.0)
        at = phase[:, :-1] + part * np.diff(phase, axis=1)
        place = np.exp(np.log(omega[:-1]) + part * np.diff(np.log(omega)))
        lag = np.mod(at + math.pi, 2 * math.pi)  # what may be lost until the phase is -180 degrees
        near = np.minimum(lag, 2 * math.pi - lag)
        least = np.where(crossings, np.degrees(near), np.inf).min(axis=1)
        delay = np.where(crossings, lag / place, np.inf).min(axis=1)
        turns = (phase + math.pi) / (2 * math.pi)
        real = np.floor(turns[:, :-1]) != np.floor(turns[:, 1:])
        share = np.where(real, (np.maximum(*(np.floor(t) for t in (turns[:, :-1], turns[:, 1:]))) - turns[:, :-1]), 0.0)
        share = np.where(real, share / np.diff(turns, axis=1), 0.0)
        gain = np.abs(size[:, :-1] + share * np.diff(size, axis=1))
        factor = np.exp(np.where(real, gain, np.inf).min(axis=1))
    lost = ~np.isfinite(L).all(axis=1)
    values = {"phase_margin": least, "delay_margin": delay, "gain_margin": factor}
    return {name: np.where(lost, np.nan, value) for name, value in values.items()}


def _of_answer(rows: LinearRows, names: Sequence[str], grid: RowGrid) -> dict[str, Array]:
    kind, signals = ("closed", grid.answer) if grid.answer else ("T", (None, None))
    found: dict[str, Array] = {}
    if "bandwidth" in names:
        gain = np.abs(rows.response(grid.omega, kind, *signals).values[:, :, 0, 0])
        found["bandwidth"] = _first_below(grid.omega, gain / gain[:, :1])
    if set(TIME_FIGURES) & set(names):
        own = [None if name is None else (name,) for name in signals]
        found |= _of_step(rows, rows.models.select_model("row_figures", kind, *own))
    return found


def _first_below(omega: Array, share: Array) -> Array:
    """The first frequency (N,) at which a share (N, m) of the gain at zero falls below 3 dB."""
    below = share < HALF_POWER
    k = np.maximum(below.argmax(axis=1), 1)
    i = np.arange(len(share))
    with np.errstate(invalid="ignore", divide="ignore"):
        high, low = np.log(share[i, k - 1] / HALF_POWER), np.log(share[i, k] / HALF_POWER)
        at = np.exp(np.log(omega[k - 1]) + high / (high - low) * np.log(omega[k] / omega[k - 1]))
    return np.where(np.isnan(share).any(axis=1), np.nan, np.where(below.any(axis=1), at, np.inf))


def _of_step(rows: LinearRows, model: LoopModel) -> dict[str, Array]:
    """Overshoot in %, settling and rise time in s (N,) of the step of one answer."""
    decay = _of_poles(rows)["decay"]
    slowest = np.nanmin(np.where(rows.stable, decay, np.nan)) if rows.stable.any() else 1.0
    end = CONSTANTS / slowest
    if model.period is not None:
        steps, h = int(min(max(end / model.period, 10), LONGEST)), model.period
        A, B = model.A, model.B
    else:
        steps, h = SAMPLES, end / SAMPLES
        A, B = _sampled(model.A, model.B, h)
    x, y = np.zeros((*A.shape[:2], 1)), np.empty((len(A), steps + 1))
    with np.errstate(all="ignore"):
        for k in range(steps + 1):
            y[:, k] = (model.Cy @ x + model.D)[:, 0, 0]
            x = A @ x + B
        stable = model.A if model.period is None else model.A - np.eye(A.shape[1])
        final = np.full(len(A), np.nan)
        for i in np.flatnonzero(np.isfinite(stable).all(axis=(1, 2)) & rows.stable):
            final[i] = (model.D[i] - model.Cy[i] @ np.linalg.pinv(stable[i]) @ model.B[i])[0, 0]
        share = y / final[:, np.newaxis]
    t = np.asarray(h * np.arange(steps + 1), dtype=float)
    outside = np.abs(share - 1) > SETTLING_BAND
    last = steps - outside[:, ::-1].argmax(axis=1)
    settled = np.where(outside.any(axis=1), t[np.minimum(last + 1, steps)], 0.0)
    rise = [_first_above(t, np.asarray(share, dtype=float), level) for level in RISE_LEVELS]
    found = {"overshoot": np.maximum(0.0, 100 * (share.max(axis=1) - 1)), "settling_time": settled}
    found["rise_time"] = rise[1] - rise[0]
    lost = np.isnan(share).any(axis=1)
    return {name: np.where(lost, np.nan, value) for name, value in found.items()}


def _first_above(t: Array, share: Array, level: float) -> Array:
    """The first time (N,) at which a response reaches a level, on the line between two samples."""
    k = np.maximum((share >= level).argmax(axis=1), 1)  # of one that begins above it the clipped part is zero
    i = np.arange(len(share))
    with np.errstate(invalid="ignore", divide="ignore"):
        part = np.clip((level - share[i, k - 1]) / (share[i, k] - share[i, k - 1]), 0, 1)
    return np.asarray(t[k - 1] + part * (t[k] - t[k - 1]))


def _sampled(A: Array, B: Array, h: float) -> tuple[Array, Array]:
    """The matrices of the held input over steps h of each row that is finite."""
    import scipy.linalg

    n, nu = A.shape[1], B.shape[2]
    whole = np.zeros((len(A), n + nu, n + nu))
    whole[:, :n, :n], whole[:, :n, n:] = np.nan_to_num(A) * h, np.nan_to_num(B) * h
    moved = scipy.linalg.expm(whole)
    return moved[:, :n, :n], moved[:, :n, n:]
