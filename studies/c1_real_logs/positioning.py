"""The positioning system EMPS: mass and frictions by inverse dynamics, and by output errors in its closed loop."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

import workbench as wb
from studies.c1_real_logs.logs import DRIVE, PULSES, log_path

GAIN, KP, KV = 35.15065188248547, 160.18, 243.45  # N/V, 1/s and V s/m, as the file states
PUBLISHED = {"mass": 95.1089, "viscous": 203.5034, "coulomb": 20.3935, "offset": -3.1648}
# by IDIM-LS of Janot, Gautier and Brunot (2019), as programs quote them
UNITS = {"mass": "kg", "viscous": "N s/m", "coulomb": "N", "offset": "N"}
CUTOFF, EVERY = 60.0, 4  # Hz; samples of the file for one of the fit in the loop, whose motion is below 5 Hz
SMOOTHING = 1e-3  # m/s, of the friction in the loop, whose speeds reach 0.13 m/s


@wb.block
class PositionLoop(wb.Plant):
    """A carriage under kv (kp (qg - q) - q'), whose command comes a lag later: the loop of the file in one plant."""

    M: float = wb.parameter(default=95.0, unit="kg", low=0, strict=True)
    Fv: float = wb.parameter(default=200.0, unit="N s/m", low=0)
    Fc: float = wb.parameter(default=20.0, unit="N", low=0)
    c: float = wb.parameter(default=-2.0, unit="N")
    kp: float = wb.parameter(default=KP, unit="1/s")
    kv: float = wb.parameter(default=KV, unit="V s/m")
    q: float = wb.initial(default=0.0, unit="m")
    qd: float = wb.initial(default=0.0, unit="m/s")
    vir: float = wb.initial(default=2.5, unit="V")

    inputs = wb.layout(qg="m")
    outputs = wb.layout(q="m", vir="V")

    def rate(self, t, x, u):  # type: ignore[no-untyped-def]
        """The accelerations of the carriage, and the command a sample late."""
        friction = self.Fv * x.qd + self.Fc * ca.tanh(x.qd / SMOOTHING)
        command = self.kv * (self.kp * (u.qg - x.q) - x.qd)
        return {"q": x.qd, "qd": (GAIN * x.vir - friction - self.c) / self.M, "vir": (command - x.vir) / 1e-3}


@dataclass(frozen=True)
class Estimate:
    """Numbers of the carriage with their standard errors, and what is left."""

    values: dict[str, float]
    standard_errors: dict[str, float]
    misfit: str


def read(file: str, name: str) -> wb.Dataset:
    """One file of the system."""
    units = {"qm": "m", "qg": "m", "vir": "V"}
    return wb.Dataset.from_mat(log_path(file), list(units), units=units, time="t", name=name)


def by_inverse_dynamics() -> Estimate:
    """The regression of the force on the whole first file; the second one, with pulses, is held out."""
    log = None
    for file, name in ((DRIVE, "motion"), (PULSES, "pulses")):
        one = read(file, name).experiments[0]
        columns = {"q": one["qm"], "F": GAIN * one["vir"]}
        part = wb.Dataset.of(one.t, columns, {"q": "m", "F": "N"}, name=name)
        log = part if log is None else log.with_experiments(part)
    assert log is not None
    inertia = np.array([1.0, 0.0, 0.0, 1.0, 0.0, 1.0])  # is not felt by a slide
    link = wb.arms.mechanics.SpatialLink("m", 1.0, np.zeros(3), inertia, axis=np.eye(3)[0], joint="prismatic")
    terms = wb.arms.log_regression.JointTerms(drive=False, offset=True)
    fit = wb.fit_inverse_dynamics(
        wb.arms.mechanics.SpatialArm((link,)),
        log,
        ["q"],
        ["F"],
        cutoff=CUTOFF,
        terms=terms,
        hold_out=["pulses"],
        period=1e-3,
    )
    left = {name: float(part[0]) for name, part in fit.root_mean_squares.items()}
    share = float(fit.explained_shares["pulses"][0])
    misfit = (
        f"What is left of the force is {left['motion']:.3g} N in the log of the fit and {left['pulses']:.3g} N in the "
        f"log with pulses, which was held out and of which {100 * share:.3g} % is explained."
    )
    words = {"m.m": "mass", "m.viscous": "viscous", "m.coulomb": "coulomb", "m.offset": "offset"}
    errors = fit.standard_errors
    return Estimate(
        {word: fit.values[name] for name, word in words.items()},
        {word: errors[name] for name, word in words.items()},
        misfit,
    )


def by_output_errors(has_free_gains: bool) -> Estimate:
    """Output errors of position and command in the closed loop, with the gains of the file or with gains of the fit."""
    one = read(DRIVE, "motion").experiments[0]
    rows = slice(None, None, EVERY)
    columns = {"q": one["qm"][rows], "qg": one["qg"][rows], "vir": one["vir"][rows]}
    log = wb.Dataset.of(one.t[rows], columns, {"q": "m", "qg": "m", "vir": "V"}, name="motion")
    free = ["M", "Fv", "Fc", "c", *(["kp", "kv"] if has_free_gains else []), "qd(0)", "vir(0)"]
    fit = wb.fit(wb.open_loop(PositionLoop()), log, free, hold="linear", start={"q": float(one["qm"][0])})
    words = {"M": "mass", "Fv": "viscous", "Fc": "coulomb", "c": "offset"} | ({"kv": "kv"} if has_free_gains else {})
    left, outside, errors = fit.root_mean_squares, fit.hold_out, fit.standard_errors
    misfit = (
        f"What is left of the command is {left['vir']:.2g} V, {outside['vir']:.3g} times as much on the hold-out, and "
        f"of the position {1e6 * left['q']:.2g} um. {' '.join(fit.warnings)}"
    )
    return Estimate(
        {word: fit.values[name] for name, word in words.items()},
        {word: errors[name] for name, word in words.items()},
        misfit,
    )


def estimate(way: str) -> Estimate:
    """One of three ways to the numbers."""
    match way:
        case "inverse dynamics":
            return by_inverse_dynamics()
        case "loop, stated gains":
            return by_output_errors(has_free_gains=False)
        case _:
            return by_output_errors(has_free_gains=True)
