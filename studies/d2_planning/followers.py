"""The loops that follow a plan in a computer, and the runs on which they are judged."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import casadi as ca
import numpy as np

import workbench as wb
from studies.d2_planning.motions import JUDGED, MOTIONS, REST, Motion, PlannedMotion

DRAWS, SEED = 160, 3720
SPREADS = (0.0, 0.05, 0.1, 0.2)  # half of the range of each number that is not known, as a share of it
USUAL = 0.05
ALONG, CAUGHT = "gains along the plan", "feedforward, caught at the end"
CONSTANT, FORWARD = "gain of the end throughout", "feedforward alone"
FOLLOWERS = {ALONG: "along", CAUGHT: "caught", CONSTANT: "constant", FORWARD: "forward"}
NONLINEAR = "nonlinear MPC along the plan"
FEW, STAGES = 64, 25  # draws and stages of the nonlinear predictive law
HARDEST = "furuta", SPREADS[-1]  # where it is run
CATCH = 0.9  # of the duration of a plan, from which on it is caught
END_ERROR = "error at the end"
PROMPT, EXACT = "without the delay", "with exact readings"
CONDITIONS = {"": "", PROMPT: "prompt", EXACT: "exact"}


def gains_of(plan: PlannedMotion, follower: str) -> wb.core.GainRecord:
    """The gains over time of a way to follow."""
    always = np.repeat(plan.K[-1:], len(plan.K), axis=0)
    caught = np.where((plan.times >= CATCH * plan.times[-1])[:, np.newaxis, np.newaxis], always, 0.0)
    K = {ALONG: plan.K, CAUGHT: caught, CONSTANT: always, FORWARD: np.zeros_like(plan.K)}
    return wb.core.GainRecord(plan.times, K[follower])


def followed_loop(motion: Motion, plan: PlannedMotion, follower: str, condition: str = "") -> wb.DigitalLoop:
    """A plan in the computer, whose command comes a period late."""
    plant = motion.plant
    exact = condition == EXACT
    noise = {name: 1e-6 if exact else value for name, value in motion.noise.items()}
    quantum = {} if exact else dict(motion.quantum)
    R = [np.full(plant.outputs[name].size, value**2) for name, value in motion.noise.items()]
    steps = [np.full(plant.outputs[name].size, value**2 / 12) for name, value in motion.quantum.items()]
    nx = plant.states.size
    observer = wb.ExtendedKalmanFilter(
        plant,
        np.diag(motion.process),
        np.diag(np.concatenate(R) + np.concatenate(steps)),
        P=1e-6 * np.eye(nx),
        period=motion.period,
        outputs=tuple(motion.noise),
    )
    reference = wb.PlannedReference(plan.motion(plant), rest_inputs=np.array(motion.rest_inputs))
    if follower == NONLINEAR:
        closed = wb.ClosedLoop(plant, observer, nonlinear_law(motion, plan, reference), reference)
    else:
        law = wb.TrajectoryFeedback(plant.states, plant.inputs, gains_of(plan, follower))
        closed = wb.ClosedLoop(plant, observer, law, reference)
    hard = np.array(motion.hard)
    limit = {name: (-hard, hard) if len(hard) > 1 else (-hard[0], hard[0]) for name in plant.inputs.names}
    instruments = wb.Instruments.of(plant, noise=noise, quantum=quantum, limit=limit)
    return wb.DigitalLoop(closed, motion.period, instruments, condition != PROMPT)


def nonlinear_law(motion: Motion, plan: PlannedMotion, reference: wb.PlannedReference) -> wb.NonlinearPredictive:
    """The nonlinear predictive law that previews the plan, with the weights of the gains along it."""
    plant, hard = motion.plant, motion.hard
    ode = wb.open_loop(plant)
    rest = wb.linearize(ode, 0.0, plan.x_ends[-1], u=np.array(motion.rest_inputs))
    limits = {label: (-end, end) for label, end in zip(plant.inputs.labels, hard, strict=True)}
    Q, R = motion.period * np.diag(motion.Q), motion.period * np.diag(motion.R)
    design = wb.nonlinear_predictive_design(rest, motion.period, Q, R, STAGES, limits=limits)
    return wb.NonlinearPredictive.of(plant, design, preview=reference)


def horizon_of(motion: Motion, plan: PlannedMotion) -> float:
    """The end of a run in s, a whole number of periods."""
    return float(np.ceil((plan.t[-1] + REST) / motion.period) * motion.period)


def metrics_of(motion: Motion, horizon: float) -> tuple[wb.metrics.AbstractMetric, ...]:
    """The root mean square error at the end, and the effort."""
    name, values = motion.goal
    goal = ca.DM(values)
    end = wb.metrics.Integral(
        END_ERROR,
        motion.unit,
        f"root mean square error over the last {JUDGED:g} s",
        lambda t, y: ca.if_else(t >= horizon - JUDGED, (y[name] - goal) ** 2, 0),
        lambda integral, until: np.sqrt(np.maximum(integral, 0) / JUDGED),
        signals=(name,),
    )
    return end, wb.effort()


def end_errors(measurement: wb.metrics.Measurement) -> wb.Array:
    """The error at the end of each run, all signals together, (N,); NaN for a run that diverged."""
    scores = measurement.scores_of(END_ERROR)
    return np.asarray(np.sqrt(np.sum([score.value**2 for score in scores], axis=0)))


def sweep_name(motion: Motion, follower: str, condition: str = "") -> str:
    """The name of a sweep."""
    key = FOLLOWERS.get(follower, "nonlinear")
    return "_".join(part for part in ("follow", motion.key, key, CONDITIONS[condition]) if part)


def factors_of(motion: Motion) -> tuple[wb.Factor, ...]:
    """The numbers that the designer does not know, and the start, which the observer does not know either."""
    most = SPREADS[-1]
    return (
        *(wb.Factor(name, (path,), wb.Uniform(1 - most, 1 + most), share=True) for name, path in motion.unknowns),
        *(
            wb.Factor(f"start of {name}", (f"plant.{name}",), wb.Uniform(at - half, at + half))
            for name, half in motion.starts
            for at in (start_of(motion.plant, name),)
        ),
    )


def start_of(plant: wb.Plant, path: str) -> float:
    """The first value of a state."""
    name, _, rest = path.partition("[")
    value = np.atleast_1d(plant.states[name].default)
    return float(value[int(rest.rstrip("]")) if rest else 0])


def spreads_of(follower: str, condition: str = "") -> tuple[float, ...]:
    """The spreads in a sweep, in their order."""
    if follower == NONLINEAR:
        return (HARDEST[1],)
    return (USUAL,) if condition else SPREADS


def sweep(motion: Motion, plan: PlannedMotion, follower: str, condition: str = "") -> wb.Sweep:
    """A plan that is followed on all draws, at all spreads or at the usual one."""
    loop, factors = followed_loop(motion, plan, follower, condition), factors_of(motion)
    drawn = wb.uncertainty.MonteCarlo(len(factors), DRAWS, SEED).points()
    varied = len(motion.unknowns)
    rows = []
    for spread in spreads_of(follower, condition):
        one = drawn[: FEW if follower == NONLINEAR else DRAWS].copy()
        one[:, :varied] = 0.5 + (one[:, :varied] - 0.5) * spread / SPREADS[-1]
        rows.append(one)
    horizon = horizon_of(motion, plan)
    run = wb.Run(loop, metrics_of(motion, horizon), horizon, h=motion.period / 2, seed=SEED)
    name = sweep_name(motion, follower, condition)
    return wb.Sweep(name, run, factors, wb.uncertainty.ListedPoints(np.vstack(rows)), common=False)


def sweeps(answers: Mapping[str, Any]) -> tuple[wb.Sweep, ...]:
    """All plans, followed in all ways."""
    plans = dict(zip(MOTIONS, answers["plans"], strict=True))
    made = [
        sweep(motion, plans[key], follower, condition)
        for key, motion in MOTIONS.items()
        for follower in FOLLOWERS
        for condition in CONDITIONS
    ]
    return (*made, sweep(MOTIONS[HARDEST[0]], plans[HARDEST[0]], NONLINEAR))
