"""The predictive law of the comparison: with the method, modes and sweeps of its design, and with many sweeps."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

import workbench as wb
from studies.d2_planning.own_laws import TargetPredictive
from studies.d2_planning.problems import PROBLEMS, Knobs, Pair, Problem, linear_model, target_of, weights

MODES, MANY_SWEEPS = 8, 40  # of all candidates of a tuning, which so have one graph and are nearly exact
LEVEL = "level"  # of the limits for which a design derives its sweeps; the usual one if it is not said


@dataclass(frozen=True)
class DesignRecord:
    """The numbers that a design of a predictive law derives from its sample of closed loops of the exact law.

    Errors are in spans of the inputs. `excess` is the largest relative excess of the cost of a loop, `trials` the
    number of candidates that were refused before. `training_cost` is the mean cost in the training runs, and
    `converged_cost` that of the same weights with many sweeps.
    """

    method: str
    sweeps: int
    residual_bound: float
    largest_error: float
    rms_error: float
    other_error: float
    other_loops: int
    moves: int
    loops: int
    active_share: float
    excess: float
    trials: int
    training_cost: float
    converged_cost: float


def design_of(problem: Problem, knobs: Knobs) -> wb.planning.PredictiveDesign:
    """The design for the weights of some knobs, at the level of the limits among them."""
    own = PROBLEMS[problem.key].with_limits(knobs[LEVEL]) if LEVEL in knobs else problem
    return _design(problem.key, own.low, own.high, knobs["inputs"], knobs["rates"])


@cache
def _design(key: str, low: Pair, high: Pair, inputs: float, rates: float) -> wb.planning.PredictiveDesign:
    problem = PROBLEMS[key]
    Q, R = weights(problem, {"inputs": inputs, "rates": rates})
    limits = dict(zip(problem.plant.inputs.labels, zip(low, high, strict=True), strict=True))
    linear = wb.linearize(wb.open_loop(problem.plant), 0.0, np.array(problem.x0), u=np.array(problem.u0), at_rest=True)
    return wb.predictive_design(linear, problem.period, Q, R, problem.stages, limits=limits)


def predictive_law(problem: Problem, knobs: Knobs) -> TargetPredictive:
    """The predictive law with what its design derives."""
    law = wb.ModelPredictive.of(problem.plant, design_of(problem, knobs))
    return about_target(problem, law)


def about_target(problem: Problem, law: wb.ModelPredictive) -> TargetPredictive:
    """A law in deviations from the rest of a reference and a disturbance."""
    n, m = problem.plant.states.size, problem.plant.inputs.size
    return TargetPredictive(target_of(problem), replace(law, x0=np.zeros(n), u0=np.zeros(m))).run_every(problem.period)


def converged_law(problem: Problem, knobs: Knobs) -> TargetPredictive:
    """The same with so many sweeps that more would change nothing, and as many kept modes for all knobs."""
    model, plant = linear_model(problem.key), problem.plant
    ends = (np.array(problem.low) - problem.u0, np.array(problem.high) - problem.u0)
    limits = wb.planning.MpcLimits(inputs=ends)
    own = wb.planning.mpc_problem(model.A, model.B, *weights(problem, knobs), problem.stages, limits)
    numbers = wb.planning.splitting_numbers(own, sweeps=MANY_SWEEPS, modes=MODES)
    law = wb.ModelPredictive(
        plant.states,
        plant.inputs,
        own.horizon,
        numbers.sweeps,
        A=own.A,
        B=own.B,
        K=np.asarray(own.K),
        S=wb.planning.recursion_numbers(own).inverse,
        F=own.rows.F,
        E=own.rows.E,
        low=own.rows.low,
        high=own.rows.high,
        softness=own.rows.softness,
        sigma=numbers.sigma[: own.rows.count],
        W=numbers.W,
        L=numbers.L,
        cap=numbers.cap,
        x0=np.zeros(plant.states.size),
        u0=np.zeros(plant.inputs.size),
        Y=numbers.Y.T,
    )
    return about_target(problem, law)


def design_record(problem: Problem, knobs: Knobs, training_cost: float, converged_cost: float) -> DesignRecord:
    """The numbers that the design of a law derives, beside its costs in the training runs."""
    design = design_of(problem, knobs)
    numbers, own = design.numbers, design.evidence
    modes = len(numbers.L)
    return DesignRecord(
        f"metric, {modes} modes" if numbers.method == "metric" else "ADMM",
        numbers.sweeps,
        float(wb.ModelPredictive.of(problem.plant, design).residual_bounds.high),
        own.largest_error,
        own.rms_error,
        own.other_error,
        own.other_loops,
        own.moves,
        own.loops,
        own.active_share,
        own.cost_excess,
        own.trials,
        training_cost,
        converged_cost,
    )
