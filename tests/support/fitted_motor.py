"""A log of a motor whose numbers are known, with noise, and its fit."""

import numpy as np

import workbench as wb

MOTOR = wb.open_loop(wb.DCMotor())
T = np.linspace(0.0, 3.0, 121)
V = 12.0 * np.sign(np.sin(5.0 * T) + 0.1)


def motor_log(seed=0, noise=0.05):
    """The log of the voltage, the speed and the current."""
    wish = wb.Dataset.of(T, {"v": V}, {"v": "V"})
    run = wb.identification.simulate_log(MOTOR, wish, ["omega", "i"])
    e = noise * np.random.default_rng(seed).standard_normal((121, 2))
    signals = {"v": V, "omega": run["omega"] + e[:, 0], "i": run["i"] + e[:, 1]}
    return wb.Dataset.of(T, signals, {"v": "V", "omega": "rad/s", "i": "A"})


def motor_fit():
    """The fit of three of its numbers."""
    return wb.fit(MOTOR, motor_log(), ["J", "b", "R"])
