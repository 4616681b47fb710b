"""The time of an H-infinity controller with the proof of its norm, beside that of python-control with slycot."""

from __future__ import annotations

from functools import partial
from statistics import median

import numpy as np

import workbench as wb
from studies.performance.measurements import Effort, Row, cpu_seconds
from studies.performance.peers import control_hinfsyn, has_slycot

BAR = 0.5  # times as fast as slycot: no more than twice its time, with a certificate that slycot does not have
NAME = "H-infinity controller, python-control with slycot"
ORDER = 20
SEEDS = (0, 4, 7)  # of twelve plants, three of those that slycot finishes in a second; others take it minutes


def random_plant(seed: int) -> wb.synthesis.GeneralizedPlant:
    """A plant with full direct terms and some unstable modes."""
    rng = np.random.default_rng(seed)
    nu, ny = (int(k) for k in rng.integers(1, 3, 2))
    nw, nz, draw, n = ny + int(rng.integers(0, 3)), nu + int(rng.integers(0, 3)), rng.standard_normal, ORDER
    A = draw((n, n)) / np.sqrt(n) - rng.uniform(0.2, 1.3) * np.eye(n)
    return wb.synthesis.GeneralizedPlant(
        A, draw((n, nw)), draw((n, nu)), draw((nz, n)), draw((ny, n)), 0.3 * draw((nz, nw)), draw((nz, nu)),
        draw((ny, nw)), 0.3 * draw((ny, nu)),
    )  # fmt: skip


def synthesis_rows(effort: Effort) -> tuple[Row, ...]:
    """The row of the ratio of both times, in turns; the reason where slycot is not installed."""
    if not has_slycot():
        return (Row(NAME, BAR, note="slycot is not installed"),)
    plants = [random_plant(seed) for seed in SEEDS]
    with wb.study.one_core():
        ratios, times = [], []
        for _ in range(effort.repetitions):
            for plant in plants:
                mine = cpu_seconds(partial(wb.hinf_controller, plant))
                theirs = cpu_seconds(partial(control_hinfsyn, plant))
                times.append(mine)
                ratios.append(theirs / mine)
    note = (
        f"CPU time of {len(plants)} random plants of order {ORDER}, in turns; ours takes {median(times):.2f} s, with "
        "the proof of the norm"
    )
    return (Row(NAME, BAR, median(ratios), note=note),)
