"""The settings of b3 by name, and their weights, gains and compensators written down anew."""

import control
import numpy as np

from studies.b3_any_plant.loops import LQG
from studies.b3_any_plant.settings import EASY, HARD, SENSOR, SETTINGS

BY_NAME = {setting.name: setting for setting in SETTINGS}


def rows(setting):
    """Weights and intensities as the docstring of a setting words them."""
    Q, R = (np.diag(np.array(sizes) ** -2.0) for sizes in (setting.states, setting.inputs))
    W = setting.push**2 * setting.period * np.eye(len(setting.inputs))
    V = np.diag([setting.noise[name] ** 2 * setting.period for name in setting.plant.outputs.names])
    return Q, R, W, V


def pid_of(Kp, Ki, Kd=0.0, N=100.0):
    """Kp + Ki / s + Kd s / (1 + s / N)."""
    s = control.tf("s")
    return control.ss(Kp + Ki / s + (Kd * s / (1 + s / N) if Kd else 0))


def pd_of(setting, N=100.0):
    """The gains of the regulator, velocities by a filtered derivative."""
    names, ny = setting.plant.states.names, setting.model.noutputs
    K = dict(zip(names, setting.design.regulator.K.T, strict=True))
    Kp, Kd = (np.column_stack([K[name + rate] for name in setting.plant.outputs.names]) for rate in ("", "d"))
    return control.ss(-N * np.eye(ny), N * np.eye(ny), -N * Kd, Kp + N * Kd)


def tank_of(gains, times):
    return control.append(*(pid_of(SENSOR * k, SENSOR * k / T) for k, T in zip(gains, times, strict=True)))


def compensator(setting, law):
    """u = -C y of a law, written down anew."""
    A, B, C = setting.model.A, setting.model.B, setting.model.C
    K, L = setting.design.regulator.K, setting.design.estimator.K
    if law == LQG:
        return control.ss(A - B @ K - L @ C, L, K, 0)
    return {
        "DC motor": lambda: pid_of(15.0, 40.0),
        EASY: lambda: tank_of((3.0, 2.7), (30.0, 40.0)),
        HARD: lambda: tank_of((1.5, -0.12), (110.0, 220.0)),
        "two masses": lambda: control.ss(control.tf([0.7, 0.2], [1, 1.4, 1.5])),
        "buck converter": lambda: pid_of(0.05, 200.0, 2e-5, 1e5),
        "stirred tank": lambda: pid_of(5.0, 0.03),
    }.get(setting.name, lambda: pd_of(setting))()
