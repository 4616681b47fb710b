"""Margins and bandwidth as pieces: each is known at a crossover, whose frequency moves with the numbers."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.design.matrices import Complex
from workbench.design.structured_tuning.figure_pieces import FigurePiece
from workbench.design.structured_tuning.system_jets import SystemJet

POINTS, BEYOND = 400, 100.0  # of a grid of frequencies, and how far it goes beyond the poles
ROUNDS, EXACT = 30, 1e-13  # steps of Newton's method, and the relative length of the last one
HALF_POWER = 10 ** (-3 / 20)
NO_CROSSOVER = math.log(10.0)  # the excess of a limit above a figure that does not exist


@dataclass(frozen=True, eq=False)
class _LogResponse:
    """The logarithm of a gain of one channel at a frequency, with its derivatives by frequency and numbers (d,)."""

    value: complex
    by_frequency: complex
    by_numbers: Complex

    @staticmethod
    def of(jet: SystemJet, omega: float) -> _LogResponse:
        G, X, Y = jet.response(omega)
        z, n = jet.point(omega), jet.n
        turn = 1j if jet.period is None else 1j * jet.period * z
        row, column = np.append(Y[0], 1.0), np.append(X[:, 0], 1.0)
        slopes = np.einsum("i,kij,j->k", row, jet.slopes[:, : n + 1, : n + 1], column)
        g = complex(G[0, 0])
        return _LogResponse(complex(np.log(g)), complex(-turn * (Y @ X)[0, 0] / g), np.asarray(slopes / g))


def _grid(jet: SystemJet) -> Array:
    """Frequencies that go beyond the poles on both sides, in a computer up to that of Nyquist."""
    poles = np.linalg.eigvals(jet.A)
    if jet.period is not None:
        poles = np.log(np.where(poles == 0, 1e-300, poles)) / jet.period
    sizes = np.abs(poles)
    sizes = sizes[sizes > 1e-9 * sizes.max(initial=0.0)]
    low, high = (sizes.min() / BEYOND, sizes.max() * BEYOND) if sizes.size else (1e-3, 1e3)
    top = np.inf if jet.period is None else math.pi / jet.period
    return np.geomspace(min(low, top / 1e3), min(high, top), POINTS)


def _responses(jet: SystemJet, omega: Array) -> Complex:
    z = 1j * omega if jet.period is None else np.exp(1j * omega * jet.period)
    M = z[:, np.newaxis, np.newaxis] * np.eye(jet.n) - jet.A
    return np.asarray((jet.C @ np.linalg.solve(M, np.broadcast_to(jet.B, (len(omega), *jet.B.shape))) + jet.D)[:, 0, 0])


def _crossovers(
    jet: SystemJet, omega: Array, heights: Array, height: Callable[[_LogResponse], tuple[float, float]]
) -> Iterator[tuple[float, _LogResponse]]:
    """The zeros of a height, which changes its sign on the grid, by Newton's method within each interval."""
    for k in np.flatnonzero(heights[:-1] * heights[1:] < 0):
        low, high = float(omega[k]), float(omega[k + 1])
        at = low * (high / low) ** (heights[k] / (heights[k] - heights[k + 1]))
        for _ in range(ROUNDS):
            here = _LogResponse.of(jet, at)
            value, slope = height(here)
            step = -value / slope if slope else 0.0
            new = min(max(at + step, low), high)
            if abs(new - at) <= EXACT * at:
                break
            at = new
        yield at, here


def gain_crossovers(L: SystemJet) -> list[tuple[float, _LogResponse]]:
    """The frequencies at which |L| is one."""
    omega = _grid(L)
    heights = np.log(np.abs(_responses(L, omega)))
    return list(_crossovers(L, omega, heights, lambda at: (at.value.real, at.by_frequency.real)))


def phase_margin_pieces(L: SystemJet, limit: float) -> list[FigurePiece]:
    """The pieces log(limit / margin) of the phase margin in degrees."""
    pieces = []
    for omega, at in gain_crossovers(L):
        angle = math.remainder(at.value.imag + math.pi, 2 * math.pi)
        moved = at.by_numbers.imag - at.by_frequency.imag * at.by_numbers.real / at.by_frequency.real
        margin = math.degrees(abs(angle))
        gradient = -np.sign(angle) * moved / max(abs(angle), 1e-12)
        pieces.append(FigurePiece(math.log(limit / max(margin, 1e-12)), np.asarray(gradient), omega))
    return pieces


def delay_margin_pieces(L: SystemJet, limit: float) -> list[FigurePiece]:
    """The pieces log(limit / margin) of the delay margin in s."""
    pieces = []
    for omega, at in gain_crossovers(L):
        lag = max((at.value.imag + math.pi) % (2 * math.pi), 1e-12)
        drift = -at.by_numbers.real / at.by_frequency.real
        moved = at.by_numbers.imag + at.by_frequency.imag * drift
        pieces.append(FigurePiece(math.log(limit * omega / lag), np.asarray(drift / omega - moved / lag), omega))
    return pieces


def gain_margin_pieces(L: SystemJet, limit: float) -> list[FigurePiece]:
    """The pieces log(limit / factor) of the least factor by which a gain may grow or shrink."""
    omega = _grid(L)
    values = _responses(L, omega)
    heights = np.where(values.real < 0, values.imag, np.nan)

    def height(at: _LogResponse) -> tuple[float, float]:
        return math.remainder(at.value.imag - math.pi, 2 * math.pi), at.by_frequency.imag

    pieces = []
    for place, at in _crossovers(L, omega, heights, height):
        size = at.value.real
        moved = at.by_numbers.real - at.by_frequency.real * at.by_numbers.imag / at.by_frequency.imag
        gradient = -np.sign(size) * moved
        pieces.append(FigurePiece(math.log(limit) - abs(size), np.asarray(gradient), place))
    return pieces


def bandwidth_pieces(G: SystemJet, low: float, high: float) -> list[FigurePiece]:
    """The pieces log(low / bandwidth) and log(bandwidth / high), of the first fall of the gain by 3 dB."""
    omega = _grid(G)
    zero = _LogResponse.of(G, 0.0)
    level = zero.value.real + math.log(HALF_POWER)
    heights = np.log(np.abs(_responses(G, omega))) - level
    falls = _crossovers(G, omega, heights, lambda at: (at.value.real - level, at.by_frequency.real))
    first = next(iter(falls), None)
    if first is None:
        return [FigurePiece(NO_CROSSOVER, np.zeros(len(G.slopes)))] if math.isfinite(high) else []
    place, at = first
    drift = -(at.by_numbers.real - zero.by_numbers.real) / (at.by_frequency.real * place)
    pieces = []
    if low > 0:
        pieces.append(FigurePiece(math.log(low / place), np.asarray(-drift), place))
    if math.isfinite(high):
        pieces.append(FigurePiece(math.log(place / high), np.asarray(drift), place, 1))
    return pieces
