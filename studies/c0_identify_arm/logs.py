"""Logs of the arm: what its computer reads and commands, under the law of the paper and in a designed experiment."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

import workbench as wb
from studies.c0_identify_arm.arm import (
    BASE,
    FREE,
    PERIOD,
    START,
    SUBSTEPS,
    Conditions,
    Numbers,
    arm_of,
    instruments,
    plant_of,
    proposed_loop,
)
from studies.c0_identify_arm.own_laws import PlayedTorque
from studies.paper.laws import SINES

LAW_LOG, DESIGNED_LOG = "AOSMC-RGS", "designed"
EVERY = 0.05  # s between the instants of a design, with straight lines between them
HARMONICS = 4
LIMITS = {"q": (-1.2, 1.2), "qd": (-4.0, 4.0), "tau[0]": (-35.0, 35.0), "tau[1]": (-12.0, 12.0)}


@dataclass(frozen=True)
class Excitation:
    """Torques of both joints as a constant and sines: a design, and what it promises."""

    constant: wb.Array  # (2,)
    amplitudes: wb.Array  # (2, k)
    frequencies: wb.Array  # (k,), in rad/s
    phases: wb.Array  # (2, k)
    errors: tuple[float, ...]  # expected standard errors, in the order of `FREE`
    plain: tuple[tuple[str, float], ...]  # by plain excitation, how much longer its intervals are in the mean
    active_limits: tuple[str, ...]
    margins: tuple[tuple[str, float], ...]
    warnings: tuple[str, ...]


def design(numbers: Numbers) -> Excitation:
    """The torques that tell most about an arm with these numbers, within limits."""
    noise = BASE.sigma * np.sqrt(PERIOD / EVERY)  # as the log has more samples than the design
    plan = wb.design_experiment(
        wb.open_loop(plant_of(numbers)),
        FREE,
        ["tau"],
        ["q"],
        noise={"q": float(noise)},
        limits=LIMITS,
        until=BASE.span,
        every=EVERY,
        harmonics=HARMONICS,
        hold="linear",
        starts=1,
    )
    constants, amplitudes, frequencies, phases = zip(*(plan.sines(f"tau[{j}]") for j in (0, 1)), strict=True)
    return Excitation(
        np.array(constants),
        np.array(amplitudes),
        frequencies[0],
        np.array(phases),
        tuple(plan.standard_errors.values()),
        tuple(plan.mean_ratios.items()),
        plan.active_limits,
        tuple(plan.certificate.margins.items()),
        plan.warnings,
    )


def law_loop(case: Conditions) -> wb.SampledSystem:
    """The law of the paper, which believes in the paper's arm, on the arm of some conditions."""
    plant = plant_of(case.truth, case.push, start=case.pose or START)
    loop = proposed_loop(plant)
    if case.pose:
        loop = replace(loop, reference=wb.Constant("q", "rad", case.pose))
    return loop.digital(PERIOD, instruments(plant, case.noise), delay=case.late)


def played_loop(case: Conditions, plan: Excitation) -> wb.SampledSystem:
    """The arm of some conditions under the torques of a design."""
    plant = plant_of(case.truth, case.push)
    law = PlayedTorque(arm_of(case.truth), plan.constant, plan.amplitudes, plan.frequencies, plan.phases)
    observer = wb.arms.observers.Luenberger(arm_of(case.truth), np.eye(2), np.eye(2), (0.0, 0.0), (0.0, 0.0))
    loop = wb.ClosedLoop(plant, observer, law, SINES)
    return loop.digital(PERIOD, instruments(plant, case.noise), delay=case.late)


def record(loop: wb.SampledSystem, name: str, case: Conditions, seed: int) -> wb.Dataset:
    """The readings of the encoders and the torques that the computer of a loop commands."""
    rows = wb.record(loop, until=case.span, substeps=SUBSTEPS, seed=seed)
    tau = rows["u.tau"]
    if case.late:  # the log has the command when it is sent, a period before it acts
        tau = np.vstack([tau[1:], tau[-1:]])
    return wb.Dataset.of(rows.t, {"q": rows["y.q"], "tau": tau}, {"q": "rad", "tau": "N m"}, name=name)


def largest_motion(log: wb.Dataset) -> tuple[float, float, float, float]:
    """The largest positions in rad and torques in N m of a log, joint by joint."""
    q, tau = (np.abs(log[name]).max(axis=0) for name in ("q", "tau"))
    return float(q[0]), float(q[1]), float(tau[0]), float(tau[1])


def limit_of(name: str) -> float:
    """The limit of the size of a position, velocity or torque, such as `qd[1]`."""
    return float(LIMITS[name if name in LIMITS else name.partition("[")[0]][1])
