"""The positioning system EMPS: mass and frictions by inverse dynamics, and by output errors in its closed loop."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

import workbench as wb
from studies.c1_real_logs.logs import DRIVE, PULSES, log_path
from studies.c1_real_logs.thin_summary import thin_out

GAIN, KP, KV = 35.15065188248547, 160.18, 243.45  # N/V, 1/s and V s/m, as the file states
PUBLISHED = {"mass": 95.1089, "viscous": 203.5034, "coulomb": 20.3935, "offset": -3.1648}
# by IDIM-LS, as the authors' program Simulation_EMPS has them
UNITS = {"mass": "kg", "viscous": "N s/m", "coulomb": "N", "offset": "N"}
CUTOFF = 60.0  # Hz
PERIOD = 1e-3  # s, of the controller
SHOWN = 25  # samples of the log for one in a picture
WAYS = ("inverse dynamics", "loop, delays as published", "loop, delays fitted")


@wb.block
class PositionLoop(wb.Plant):
    """A carriage under the published controller, in continuous time, with the delays of its computer.

        vir = kv (kp (qg - q) - v),    v: q' as it was a time `late` ago,    M q'' = G (vir, held) + G push - friction

    The controller takes the half sum of two readings and its backward difference, so that its speed is one period
    late. Its command is held for a period, and so is half a period late in the mean. The first delay is a Pade
    approximation of first order, the second one a lag.
    """

    M: float = wb.parameter(default=95.0, unit="kg", low=0, strict=True)
    Fv: float = wb.parameter(default=200.0, unit="N s/m", low=0)
    Fc: float = wb.parameter(default=20.0, unit="N", low=0)
    c: float = wb.parameter(default=-2.0, unit="N")
    slow: float = wb.parameter(default=1e-3, unit="m/s", low=1e-4)
    kp: float = wb.parameter(default=KP, unit="1/s")
    kv: float = wb.parameter(default=KV, unit="V s/m")
    late: float = wb.parameter(default=PERIOD, unit="s", low=0, strict=True)
    hold: float = wb.parameter(default=PERIOD / 2, unit="s", low=0, strict=True)
    q: float = wb.initial(default=0.0, unit="m")
    qd: float = wb.initial(default=0.0, unit="m/s")
    both: float = wb.initial(default=0.0, unit="m/s")
    vir: float = wb.initial(default=2.5, unit="V")

    inputs = wb.layout(qg="m", push="V")
    outputs = wb.layout(q="m", vir="V")

    def rate(self, t, x, u):  # type: ignore[no-untyped-def]
        """The acceleration of the carriage, twice the speed through a lag, and the command as it is held."""
        friction = self.Fv * x.qd + self.Fc * ca.tanh(x.qd / self.slow)
        command = self.kv * (self.kp * (u.qg - x.q) - (x.both - x.qd)) + u.push
        return {
            "q": x.qd,
            "qd": (GAIN * x.vir - friction - self.c) / self.M,
            "both": (2 * x.qd - x.both) / (self.late / 2),
            "vir": (command - x.vir) / self.hold,
        }


@dataclass(frozen=True)
class Estimate:
    """Numbers of the carriage with their standard errors, and what is left."""

    values: dict[str, float]
    standard_errors: dict[str, float]
    misfit: str
    fit: wb.identification.FitSummary | None = None  # of an output error
    law: tuple[float, float] = (np.nan, np.nan)  # V between logged command and controller, and with no sample late


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
        f"The error of the force is {left['motion']:.3g} N in the log of the fit and {left['pulses']:.3g} N in the log "
        f"with pulses, which was held out and of which {100 * share:.3g} % is explained."
    )
    words = {"m.m": "mass", "m.viscous": "viscous", "m.coulomb": "coulomb", "m.offset": "offset"}
    errors = fit.standard_errors
    return Estimate(
        {word: fit.values[name] for name, word in words.items()},
        {word: errors[name] for name, word in words.items()},
        misfit,
    )


def loop_log(file: str, name: str) -> wb.Dataset:
    """Reference, position and force of a file; at a sample the held command is the mean of both of its values."""
    one = read(file, name).experiments[0]
    held = (one["vir"] + np.append(one["vir"][:1], one["vir"][:-1])) / 2
    columns, units = {"q": one["qm"], "qg": one["qg"], "vir": held}, {"q": "m", "qg": "m", "vir": "V"}
    if file == PULSES:
        push = wb.Dataset.from_mat(log_path(file), ["pulses_N"], units={"pulses_N": "V"}, time="t").experiments[0]
        columns, units = {**columns, "push": push["pulses_N"]}, {**units, "push": "V"}
    return wb.Dataset.of(one.t, columns, units, name=name)


def controller_errors() -> tuple[float, float]:
    """The errors in V of the published controller, on logged readings, against the logged command, and if not late."""
    one = read(DRIVE, "motion").experiments[0]
    q, qg, vir = (np.asarray(one[name]) for name in ("qm", "qg", "vir"))
    late, now = (q[2:-1] - q[:-3]) / (2 * PERIOD), (q[3:] - q[1:-2]) / (2 * PERIOD)  # of samples 2 to N - 2
    errors = [KV * (KP * (qg - q)[2:-1] - speed) - vir[2:-1] for speed in (late, now)]
    return float(np.sqrt(np.mean(errors[0] ** 2))), float(np.sqrt(np.mean(errors[1] ** 2)))


def by_output_errors(has_free_delays: bool) -> Estimate:
    """Output errors of position and force in the closed loop that the reference drives, on all samples of a file."""
    log, system = loop_log(DRIVE, "motion"), wb.open_loop(PositionLoop())
    first = log.experiments[0]
    speed = float(first["q"][10] - first["q"][0]) / (10 * PERIOD)
    start = {"q": float(first["q"][0]), "qd": speed, "both": 2 * speed, "push": 0.0}
    free = ["M", "Fv", "Fc", "c", "slow", *(["late", "hold"] if has_free_delays else []), "qd(0)", "vir(0)"]
    fit = wb.fit(system, log, free, hold="linear", start=start, hold_out=0.0)
    words = {"M": "mass", "Fv": "viscous", "Fc": "coulomb", "c": "offset", "slow": "slow"}
    words |= {"late": "late", "hold": "hold"} if has_free_delays else {}
    values = {name.removesuffix("(0)"): value for name, value in fit.values.items()}
    other, starts = loop_log(PULSES, "pulses"), {**start, **values}
    del starts["push"]
    again = wb.fit(system, other, ["qd(0)", "vir(0)"], hold="linear", start=starts, hold_out=0.0)
    left, outside, errors = fit.root_mean_squares, again.root_mean_squares, fit.standard_errors
    sizes = [f"{one['vir']:.2g} V and {1e6 * one['q']:.2g} \N{MICRO SIGN}m" for one in (left, outside)]
    misfit = (
        f"The errors of command and position are {sizes[0]}. On the log with pulses, which was held out but for two "
        f"initial states, they are {sizes[1]}."
    )
    return Estimate(
        {word: fit.values[name] for name, word in words.items()},
        {word: errors[name] for name, word in words.items()},
        misfit,
        None if has_free_delays else thin_out(fit, SHOWN),
        controller_errors(),
    )


def estimate(way: str) -> Estimate:
    """One of three ways to the numbers."""
    if way == WAYS[0]:
        return by_inverse_dynamics()
    return by_output_errors(has_free_delays=way == WAYS[2])
