"""The four tanks at both settings of their valves: how fast the levels settle, and what the zero at P+ fixes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

import workbench as wb
from studies.b3_any_plant.loops import BAND, LAWS, PID, PLACED, SUBSTEPS, loop, placed_gains
from studies.b3_any_plant.settings import EASY, HARD, SETTINGS, Setting

FACTORS = (0.4, 1.0, 2.0, 4.0)  # of the poles of the placed design
SIDES = (EASY, HARD)
TANKS = tuple((name, law, 1.0) for name in SIDES for law in LAWS)
TANKS += tuple((HARD, PLACED, factor) for factor in FACTORS)
STEP = 1.0  # cm, of the reference of h_1
EVERY = 0.25  # s


@dataclass(frozen=True)
class Levels:
    """One run of the four tanks in continuous time, and the loop at rest.

    `settling` are the times in s from which on h_1, and h_2, stay within the band about their rest, `farthest` the
    largest distance of h_2 from its rest in cm, `voltages` the lowest and the highest, `decay` that of the slowest
    mode in 1/s, `disk` the disk margin, and `fixed_integral` the weighted integral of both levels in cm s, by the run.
    """

    settling: tuple[float, float]
    farthest: float
    voltages: tuple[float, float]
    decay: float
    disk: float
    fixed_integral: float


def tank(name: str) -> Setting:
    """The setting of that name."""
    return next(setting for setting in SETTINGS if setting.name == name)


def design_loop(setting: Setting, law: str, factor: float) -> wb.ClosedLoop:
    """The loop of the tanks under a law; of the placed design with poles `factor` times as far."""
    closed = loop(setting, law)
    if law != PLACED or factor == 1.0:
        return closed
    K, L = placed_gains(setting, factor)
    regulator = wb.StateFeedback.of(
        setting.plant, K, setting.point.x, setting.point.u, follow=setting.plant.outputs.names
    )
    observer: Any = closed.observer
    return replace(closed, observer=replace(observer, L=L), controller=regulator)


def levels(item: tuple[str, str, float]) -> Levels:
    """The tanks of a setting under a law, from the start of the study."""
    name, law, factor = item
    setting = tank(name)
    closed = design_loop(setting, law, factor)
    t, off, volts = course(setting, closed)
    opened = opened_at_rest(setting, closed)
    return Levels(
        settling_times(t, off, BAND * np.abs(off[0]).max()),
        float(np.abs(off[:, 1]).max()),
        (float(volts.min()), float(volts.max())),
        float(-wb.linear.sensitivity(opened).poles().real.max()),
        wb.linear.disk_margin(opened).alpha,
        fixed_integral(setting, t, off),
    )


def step_settling(name: str) -> tuple[float, float]:
    """The settling times under the published PI controllers, of a step of the reference of h_1 from rest."""
    setting = tank(name)
    rest = {key: float(np.squeeze(part)) for key, part in setting.open.states.unpack(setting.point.x).items()}
    plant: Any = setting.plant
    setting = replace(setting, plant=replace(plant, **rest))
    wanted = setting.operating_outputs
    step = wb.Step("h_1", "cm", wanted["h_1"] + STEP, start=wanted["h_1"])
    closed = replace(
        loop(setting, PID), reference=wb.CombinedReference((step, wb.Constant("h_2", "cm", [wanted["h_2"]])))
    )
    t, off, _ = course(setting, closed)
    return settling_times(t, off - np.array([STEP, 0.0]), BAND * STEP)


def course(setting: Setting, closed_loop: wb.ClosedLoop) -> tuple[wb.Array, wb.Array, wb.Array]:
    """The times, both levels minus those at rest, and both voltages of a run."""
    out = wb.simulate(wb.rk4(closed_loop.ode(), setting.period / SUBSTEPS), until=setting.until, every=EVERY)
    rest = [setting.operating_outputs[name] for name in setting.plant.outputs.names]
    both = np.stack([out[name][0].ravel() for name in setting.plant.outputs.names], axis=1)
    volts = np.stack([out[name][0].ravel() for name in setting.plant.inputs.names], axis=1)
    return np.asarray(out.t), both - rest, volts


def settling_times(t: wb.Array, off: wb.Array, band: float) -> tuple[float, float]:
    """The time from which on each column stays within the band; infinite where it does not."""
    outside = (np.flatnonzero(np.abs(column) > band) for column in off.T)
    ends = (0 if not rows.size else rows[-1] + 1 for rows in outside)
    first, second = (float(t[row]) if row < len(t) else np.inf for row in ends)
    return first, second


def opened_at_rest(setting: Setting, closed_loop: wb.ClosedLoop) -> object:
    """The loop gain at the voltages about the rest, a `StateSpace` of python-control."""
    ode, whole = closed_loop.cut(setting.name), closed_loop.ode()
    wanted = {f"plant.{name}": part for name, part in setting.open.states.unpack(setting.point.x).items()}
    at_rest = whole.states.unpack(wb.linear.operating_point(whole, wanted).x)
    return wb.linear.broken_loop(ode, 0.0, np.concatenate([np.ravel(at_rest[name]) for name in ode.states.names]))


def zero_of(setting: Setting) -> tuple[float, wb.Array]:
    """The rightmost zero z in 1/s, and the unit vector psi with psi' G(z) = 0."""
    z, model = float(setting.model.zeros().real.max()), setting.model
    psi = np.linalg.svd(model.C @ np.linalg.solve(z * np.eye(len(model.A)) - model.A, model.B))[0][:, -1]
    return z, np.asarray(psi * np.sign(psi[1]))


def fixed_integral(setting: Setting, t: wb.Array, off: wb.Array) -> float:
    """psi' times the integral of both levels weighted by exp(-z t): for z > 0 no law changes it in the linear model."""
    z, psi = zero_of(setting)
    return float(np.trapezoid(off @ psi * np.exp(-z * t), t)) if z > 0 else 0.0


def predicted_integral(setting: Setting) -> float:
    """The same integral, from the start alone: psi' C (z I - A)^-1 (x(0) - x_0)."""
    (z, psi), model = zero_of(setting), setting.model
    off = setting.open.states.default - setting.point.x
    return float(psi @ model.C @ np.linalg.solve(z * np.eye(len(model.A)) - model.A, off))


def least_swing(setting: Setting, until: float) -> float:
    """The least that |psi' y| in cm reaches, y the levels minus their rest, if they are at rest from `until` [s] on."""
    z, _ = zero_of(setting)
    return abs(predicted_integral(setting)) * z / -float(np.expm1(-z * until))
