"""Shapes of inputs: signals of one period that are linear in their coefficients."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.identification.datasets.experiment import Marks


@dataclass(frozen=True, eq=False)
class InputShape:
    """Signals u(t) = basis c at N samples, all of one period; `names` are those of the nb columns.

    The first columns of harmonics are a constant, then a sine and a cosine of each harmonic (Swevers et al. 1997,
    equation 9, for positions). The columns of steps are the levels in their order.
    """

    basis: Array  # (N, nb)
    names: tuple[str, ...]
    constant: Array  # (nb,), the coefficients of the signal 1
    weights: Array  # (nb,), spread of the coefficients of a random signal
    is_free: Marks  # (nb,), false for a constant that stays as it is

    def draw(self, count: int, inputs: int, generator: np.random.Generator) -> Array:
        """Coefficients (count, inputs, nb) of random signals."""
        return np.asarray(generator.standard_normal((count, inputs, len(self.names))) * self.weights)

    def nearest(self, signals: Array) -> Array:
        """Coefficients (nu, nb) of the signal of this shape that is nearest to signals (N, nu), by least squares."""
        return np.asarray(np.where(self.is_free, np.linalg.lstsq(self.basis, signals, rcond=None)[0].T, 0.0))


def harmonics(t: Array, period: float, orders: Sequence[int]) -> InputShape:
    """A constant, which is free if 0 is among the orders, and sines and cosines of multiples of 2 pi / period."""
    is_free, orders = 0 in orders, [order for order in orders if order]
    angles = [2 * np.pi * order / period * t for order in orders]
    columns = [np.ones_like(t), *(part for angle in angles for part in (np.sin(angle), np.cos(angle)))]
    names = ["constant", *(f"{part} {order}" for order in orders for part in ("sine", "cosine"))]
    size = len(names)
    spread = np.append(0.0, np.repeat(1 / np.sqrt(np.arange(1, len(orders) + 1)), 2))
    return InputShape(np.column_stack(columns), tuple(names), np.eye(size)[0], spread, np.arange(size) >= (not is_free))


def levels(t: Array, period: float, count: int) -> InputShape:
    """Steps of equal length, `count` in a period, each with a level of its own."""
    part = np.floor((t / period) * count + 1e-9).astype(int) % count  # a sample at a jump has the new level
    names = tuple(f"level {i + 1}" for i in range(count))
    return InputShape(np.eye(count)[part], names, np.ones(count), np.ones(count), np.ones(count, dtype=bool))


def random_steps(t: Array, until: float, count: int, generator: np.random.Generator) -> Array:
    """The signal (N,) of random signs that change at most `count` times."""
    part = np.minimum((t / until * count + 1e-9).astype(int), count - 1)
    return np.asarray(generator.choice([-1.0, 1.0], count)[part])


def chirp(t: Array, until: float, first: float, last: float, phase: float) -> Array:
    """The signal (N,) of amplitude 1 whose frequency in Hz goes from `first` to `last` in equal ratios."""
    rate = np.log(last / first) / until
    angle = 2 * np.pi * first * (np.expm1(rate * t) / rate if rate else t)
    return np.asarray(np.sin(angle + phase))
