"""The double pendulum in metal: each excitation held out in turn, beside the published models on the same samples."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import workbench as wb
from studies.c1_real_logs.logs import EXCITATIONS, MODELS, POOR_LOGS, PUBLISHED_MODELS, log_path, name_of

CUTOFF = 8.0  # Hz: the torques swing at up to 4 Hz, and what lies above is vibration of the frame
DELAYS = (0.0, 0.005, 0.01, 0.015)  # s, of which each fold takes the one with the least error on its own four logs
POSITIONS, TORQUES = ("pos1", "pos2"), ("tau1", "tau2")
UNITS = {"pos1": "rad", "pos2": "rad", "tau1": "N m", "tau2": "N m"}
MEASURED = {"pos_meas1": "pos1", "pos_meas2": "pos2", "tau_meas1": "tau1", "tau_meas2": "tau2"}
TERMS = wb.arms.log_regression.JointTerms(smoothing=0.02, least_speed=0.05)
SHOWN = 400  # samples of a log in a picture
STEEP = 100.0  # s/rad, of the arctangent in the friction of the published models, quoted from memory


@dataclass(frozen=True)
class Trace:
    """Torques over time on a log that was held out, thinned: t (M,) in s, the others (M, 2) in N m."""

    t: wb.Array
    samples: wb.Array
    ours: wb.Array
    rival: wb.Array  # of model 2.0


@dataclass(frozen=True)
class Fold:
    """An excitation that was held out: errors of shoulder and elbow in N m."""

    name: str
    delay: float
    condition: float
    distance: float
    ours: tuple[float, float]
    biases: tuple[float, float]  # the means of the model less the measured torque
    roughness: float  # what the filter takes from the shoulder's torque, root mean square in N m
    published_errors: tuple[tuple[float, float], ...]  # in the order of MODELS
    numbers: dict[str, tuple[float, float]]  # estimates with their standard errors
    trace: Trace

    def beaten(self, joint: int) -> int:
        """The number of published models whose error of a joint is larger."""
        return sum(self.ours[joint] < errors[joint] for errors in self.published_errors)


def pendulum_arm(first: float, second: float) -> wb.arms.mechanics.PlanarArm:
    """An arm of the lengths; its masses do not count in a regression."""
    link = wb.arms.mechanics.Link
    return wb.arms.mechanics.PlanarArm((link(1.0, first, first / 2), link(1.0, second, second / 2)))


def read_log(path: str, name: str, names: dict[str, str] | None = None) -> wb.Dataset:
    """A log of the machine at a path; `names` has other names of its columns."""
    return wb.Dataset.from_csv(path, list(UNITS), names=names, units=UNITS, time="time", name=name)


def read(files: tuple[str, ...]) -> wb.Dataset:
    """The logs of some files as one dataset."""
    names = MEASURED if files[0] in POOR_LOGS else None
    logs = [
        wb.Dataset.from_csv(log_path(file), list(UNITS), names=names, units=UNITS, time="time", name=name_of(file))
        for file in files
    ]
    together = logs[0]
    for log in logs[1:]:
        together = together.with_experiments(log)
    return together


def published_torque(model: str, motion: wb.arms.log_regression.PreparedMotion) -> wb.Array:
    """The torques (N, 2) of a published model along a motion, by the equations of its authors' program."""
    p, (q, qd, qdd) = PUBLISHED_MODELS[model], (motion.q, motion.qd, motion.qdd)
    gear, rotor, l1 = p["gr"], p["Ir"], p["l1"]
    c2, s2 = np.cos(q[:, 1]), np.sin(q[:, 1])
    h, low = p["m2"] * l1 * p["r2"], p["g"] * p["m2"] * p["r2"] * np.sin(q.sum(axis=1))
    first = p["I1"] + p["m2"] * l1**2 + p["I2"] + 2 * h * c2 + (gear**2 + 1) * rotor
    cross = p["I2"] + h * c2 - gear * rotor
    tau1 = first * qdd[:, 0] + cross * qdd[:, 1] - h * s2 * (2 * qd[:, 0] * qd[:, 1] + qd[:, 1] ** 2)
    tau1 += p["g"] * (p["m1"] * p["r1"] + p["m2"] * l1) * np.sin(q[:, 0]) + low
    tau2 = cross * qdd[:, 0] + (p["I2"] + gear**2 * rotor) * qdd[:, 1] + h * s2 * qd[:, 0] ** 2 + low
    friction = [p[f"b{i + 1}"] * qd[:, i] + p[f"cf{i + 1}"] * np.arctan(STEEP * qd[:, i]) for i in range(2)]
    return np.column_stack([tau1, tau2]) + np.column_stack(friction)


def fold(held_out: str) -> Fold:
    """One excitation held out, and the fit on the other four."""
    log, arm, name = read(EXCITATIONS), pendulum_arm(0.3, 0.2), name_of(held_out)
    fits = {
        delay: wb.fit_inverse_dynamics(
            arm, log, POSITIONS, TORQUES, cutoff=CUTOFF, terms=TERMS, hold_out=[name], delay=delay, even_if_refused=True
        )
        for delay in DELAYS
    }
    delay = min(fits, key=lambda one: float(np.sum(np.log(fits[one].regression.sigma))))
    fit = fits[delay]
    if fit.reasons_to_refuse or fit.bodies is None:
        raise ValueError(f"The fit without {name} is refused: {' '.join(fit.reasons_to_refuse)}")
    motions = [fit.held_out[0], fits[0.0].held_out[0]]  # a published model has the better of our delay and of none
    weighs = motions[0].weighs & motions[1].weighs
    published = []
    for model in MODELS:
        pairs = [np.sqrt(np.mean((published_torque(model, one) - one.tau)[weighs] ** 2, axis=0)) for one in motions]
        first, second = np.min(pairs, axis=0)
        published.append((float(first), float(second)))
    left = (fit.torque(motions[0]) - motions[0].tau)[weighs]
    ours, biases = np.sqrt(np.mean(left**2, axis=0)), left.mean(axis=0)
    roughness = float(np.sqrt(np.mean((motions[0].tau - motions[0].filtered_tau)[weighs, 0] ** 2)))
    errors_of = fit.standard_errors
    numbers = {key: (value, errors_of[key]) for key, value in fit.values.items()}
    pair, means = (float(ours[0]), float(ours[1])), (float(biases[0]), float(biases[1]))
    trace = trace_of(fit, motions[0])
    return Fold(
        name, delay, fit.condition, fit.bodies.distance, pair, means, roughness, tuple(published), numbers, trace
    )


def trace_of(fit: wb.arms.log_regression.InverseDynamicsFit, motion: wb.arms.log_regression.PreparedMotion) -> Trace:
    """The torques of a motion where the filter has settled, thinned to some SHOWN samples."""
    rows = np.flatnonzero(motion.weighs)
    rows = rows[:: max(1, len(rows) // SHOWN)]
    return Trace(motion.t[rows], motion.tau[rows], fit.torque(motion)[rows], published_torque("2.0", motion)[rows])


def refusal_of(file: str) -> str:
    """The sentence by which the regression refuses one log of the design C.1 alone."""
    try:
        wb.fit_inverse_dynamics(pendulum_arm(0.2, 0.3), read((file,)), POSITIONS, TORQUES, cutoff=CUTOFF, terms=TERMS)
    except ValueError as refused:
        return str(refused)
    return "accepted"
