"""The fits whose live pages stand in the gallery: a log, made here with noise, and the numbers that it tells."""

from typing import Any, NamedTuple

import numpy as np

import workbench as wb

PERIOD, COUNT = 0.02, 500  # s between two samples, and their number
TRUE = wb.DCMotor(J=0.014, b=0.08, K=0.5, R=1.2, L=0.5)
NOISE = {"omega": 0.3, "i": 0.1}


class FittedLog(NamedTuple):
    """A fit with its title and a plain line."""

    title: str
    line: str
    fit: Any


def motor_log() -> wb.Dataset:
    """The voltage of a motor in random steps, its speed and its current, with noise."""
    rng = np.random.default_rng(3)
    t, v = PERIOD * np.arange(COUNT), np.repeat(rng.choice([-6.0, 6.0], COUNT // 20), 20)
    motor = wb.open_loop(TRUE)
    run = wb.identification.simulate_log(motor, wb.Dataset.of(t, {"v": v}, {"v": "V"}), [*NOISE])
    readings = {name: run[name] + sigma * rng.standard_normal(COUNT) for name, sigma in NOISE.items()}
    return wb.Dataset.of(t, {"v": v, **readings}, {"v": "V", "omega": "rad/s", "i": "A"}, name="motor")


def of_logs() -> list[FittedLog]:
    """The fits of the gallery."""
    fit = wb.fit(wb.open_loop(wb.DCMotor(K=0.3)), motor_log(), ["J", "b", "K", "R", "L"])
    return [FittedLog("A DC motor from its log", "Five numbers, from ten seconds of voltage, speed and current.", fit)]
