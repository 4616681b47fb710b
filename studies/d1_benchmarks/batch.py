"""The test batch of Astrom and Hagglund: nine families of processes, as their books and papers print them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import workbench as wb

LAGS = (0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 1.3, 1.5, 2.0, 4.0, 6.0, 8.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0)
DELAYS = (0.01, 0.02, 0.05, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0)  # of P6 and P7; the lag is what is left to one
FORMULAS = {
    "P1": "exp(-s) / (1 + s T)",
    "P2": "exp(-s) / (1 + s T)^2",
    "P3": "1 / ((s + 1) (1 + s T)^2)",
    "P4": "1 / (s + 1)^n",
    "P5": "1 / ((1 + s) (1 + a s) (1 + a^2 s) (1 + a^3 s))",
    "P6": "exp(-s L1) / (s (1 + s T1)),  T1 + L1 = 1",
    "P7": "T exp(-s L1) / ((1 + s T) (1 + s T1)),  T1 + L1 = 1",
    "P8": "(1 - a s) / (s + 1)^3",
    "P9": "1 / ((s + 1) ((s T)^2 + 1.4 s T + 1))",
}
COUNT_IN_PRINT = 134  # as the literature says; the families as they are printed have one less


@dataclass(frozen=True)
class Process:
    """A process of the batch: num / den in descending powers of s, and a delay in s."""

    family: str
    label: str
    num: tuple[float, ...]
    den: tuple[float, ...]
    delay: float = 0.0

    @property
    def name(self) -> str:
        """The family and its parameters."""
        return f"{self.family}, {self.label}"


def batch() -> tuple[Process, ...]:
    """All processes, family by family."""
    made = [_process("P1", f"T = {T:g}", [1.0], [[T, 1.0]], 1.0) for T in (*LAGS, 1000.0)]
    made += [_process("P2", f"T = {T:g}", [1.0], 2 * [[T, 1.0]], 1.0) for T in (0.01, *LAGS)]
    made += [
        _process("P3", f"T = {T:g}", [1.0], [[1.0, 1.0], *(2 * [[T, 1.0]])])
        for T in (0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 2.0, 5.0, 10.0)
    ]
    made += [_process("P4", f"n = {n}", [1.0], n * [[1.0, 1.0]]) for n in range(3, 9)]
    made += [
        _process("P5", f"a = {a:g}", [1.0], [[a**k, 1.0] for k in range(4)])
        for a in (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9)
    ]
    made += [_process("P6", f"L1 = {L:g}", [1.0], [[1.0, 0.0], *_rest(L)], L) for L in DELAYS]
    made += [
        _process("P7", f"T = {T:g}, L1 = {L:g}", [T], [[T, 1.0], *_rest(L)], L)
        for T in (1.0, 2.0, 5.0, 10.0)
        for L in DELAYS
    ]
    made += [_process("P8", f"a = {k / 10:g}", [-k / 10, 1.0], 3 * [[1.0, 1.0]]) for k in range(1, 12)]
    made += [
        _process("P9", f"T = {k / 10:g}", [1.0], [[1.0, 1.0], [(k / 10) ** 2, 1.4 * (k / 10), 1.0]])
        for k in range(1, 11)
    ]
    return tuple(made)


def _rest(L: float) -> list[list[float]]:
    """The lag of P6 and P7, which is none for a delay of one."""
    return [[1.0 - L, 1.0]] if L < 1 else []


def _process(family: str, label: str, num: list[float], factors: list[list[float]], delay: float = 0.0) -> Process:
    den: wb.Array = np.ones(1)
    for factor in factors:
        den = np.convolve(den, factor)
    return Process(family, label, tuple(num), tuple(den.tolist()), delay)
