"""The time of an optimal PI law for processes like those of a batch, beside a grid search of (k, ki)."""

from __future__ import annotations

from functools import cache, partial
from statistics import median

import numpy as np

import workbench as wb
from studies.performance.measurements import Effort, Row, cpu_seconds
from studies.performance.peers import control_plant

PEAK = 1.4  # the limit of |S| and of |T|
BAR = 20.0  # ms of CPU for a process
NAME = "PI optimum of the batch, a process"
GRID = 160  # values of k, and of ki
FREQUENCIES = np.geomspace(1e-3, 1e3, 400)  # over the ultimate frequency


@cache
def processes() -> tuple[tuple[list[float], list[float], float], ...]:
    """Seven of the test batch of Astrom and Hagglund: numerator, denominator and delay in s."""
    return (
        ([1.0], [0.3, 1.0], 1.0),
        ([1.0], [20.0, 1.0], 1.0),
        ([1.0], [4.0, 4.0, 1.0], 1.0),
        ([1.0], [1.0, 4.0, 6.0, 4.0, 1.0], 0.0),
        ([1.0], [0.9, 1.0, 0.0], 0.1),
        ([-0.6, 1.0], [1.0, 3.0, 3.0, 1.0], 0.0),
        ([1.0], [0.25, 0.95, 1.7, 1.0], 1.0),
    )


def grid_search(num: list[float], den: list[float], delay: float) -> float:
    """The largest ki of a grid whose loops meet the limits; their stability is the turn of 1 + L."""
    omega = np.geomspace(1e-4, 1e4, 20_000)
    G = np.polyval(num, 1j * omega) / np.polyval(den, 1j * omega) * np.exp(-1j * omega * delay)
    first = int(np.nonzero((G.real < 0) & (np.diff(np.sign(G.imag), append=0) > 0))[0][0])
    ultimate, gain = omega[first], 1 / abs(G[first])
    s = 1j * ultimate * FREQUENCIES
    G = np.polyval(num, s) / np.polyval(den, s) * np.exp(-s * delay)
    turn, best = (1 + int(den[-1] == 0)) * np.pi / 2, 0.0
    ki = gain * ultimate * np.geomspace(1e-4, 1, GRID)[:, np.newaxis]
    for k in gain * np.linspace(0, 1, GRID):
        L = (k + ki / s) * G
        distance = np.abs(1 + L)
        good = (PEAK * distance >= 1).all(axis=1) & (np.abs(L) <= PEAK * distance).all(axis=1)
        angle = np.unwrap(np.angle(1 + L[good]), axis=1)
        stable = np.abs(angle[:, -1] - angle[:, 0] - turn) < np.pi / 2
        best = max(best, float(ki[good][stable].max(initial=0)))
    return best


def pid_rows(effort: Effort) -> tuple[Row, ...]:
    """The row of the time of a process, with the certificate, and beside it that of a grid search."""
    plants = [(control_plant(num, den), delay) for num, den, delay in processes()]
    for plant, delay in plants:
        wb.pid_design.pi_optimum(plant, PEAK, PEAK, delay)
    with wb.study.one_core():
        times = [
            [cpu_seconds(partial(wb.pid_design.pi_optimum, plant, PEAK, PEAK, delay)) for plant, delay in plants]
            for _ in range(effort.repetitions)
        ]
        found: list[float] = []
        grid = cpu_seconds(lambda: found.extend(grid_search(*process) for process in processes()))
    mine = median(sum(row) for row in times) / len(plants)
    gains = [wb.pid_design.pi_optimum(plant, PEAK, PEAK, delay).ki for plant, delay in plants]
    short = max(1 - there / here for there, here in zip(found, gains, strict=True))
    note = (
        f"CPU time, with the certificate of the margins; {len(plants)} processes of the batch. A grid of {GRID} by "
        f"{GRID} gains and {len(FREQUENCIES)} frequencies takes {grid / len(plants) / mine:.0f} times as long, and its "
        f"ki is up to {short:.1%} smaller"
    )
    return (Row(NAME, BAR, 1e3 * mine, "ms", at_most=True, note=note),)
