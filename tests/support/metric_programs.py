"""Metrics of a loop that settles, never settles or diverges, with the states of many runs, for tests of programs."""

import casadi as ca
import numpy as np

from workbench.arms.torque_metrics import peak_torque
from workbench.core import Entry, Layout, Ode
from workbench.engine import simulate
from workbench.engine.metrics import (
    AbstractMetric,
    effort,
    energy,
    iae,
    ise,
    itae,
    late_error,
    observer_error,
    overshoot,
    peak,
    peak_error,
    rmse,
    sampled_rmse,
    settling_time,
    step_with_metrics,
    total_variation,
    violation,
)

POWER = "tau_applied", "qd"
HORIZON, STEP, RUNS = 1.0, 1e-2, 300
ODD = np.array([np.nan, np.inf, -np.inf, 0.0, -0.0, 1.0, -1.0, 1e-300, 1e30, 2e30, HORIZON, 5e-324, 1.7e308])


def pair() -> Ode:
    """Two states x' = a x + b that are to reach a level: they settle, oscillate in steps, or leave all bounds."""
    states = Layout((Entry("plant.q", np.zeros(2), "rad"),))
    parameters = Layout(tuple(Entry(name, np.zeros(2)) for name in ("a", "b", "level")))
    t, x, p = ca.SX.sym("t"), states.symbols(), parameters.symbols()
    a, b, level = p[:2], p[2:4], p[4:]
    rate = a * x + b
    outputs = {"q": x, "q_ref": level, "e": x - level, "qd": rate, "tau_applied": b - x, "x_error": x * x}
    return Ode.of("pair", states, parameters, (t, x, p), {"plant.q": rate}, outputs)


def catalogue() -> tuple[AbstractMetric, ...]:
    return (
        *(
            rmse(),
            sampled_rmse(0.02),
            iae(),
            ise(),
            itae(),
            effort("tau_applied"),
            energy(POWER),
        ),
        *(
            observer_error("x_error"),
            peak_error(),
            late_error(0.5),
            peak("tau_applied"),
            peak_torque(),
            *violation("q", -1.0, 2.0),
        ),
        *(total_variation(0.03, "tau_applied"), total_variation(0.03, "tau_applied", 0.5)),
        *(overshoot(), settling_time()),
    )


def bits(numbers):
    """The bits of numbers, those of NaN alike."""
    return np.where(np.isnan(numbers), np.nan, numbers).view(np.uint64)


def some_runs(metrics):
    rng = np.random.default_rng(18)
    a = rng.choice([-300.0, -150.0, -30.0, -3.0, -0.1, 0.0, 2.0, 4e3, 1e6], (RUNS, 2))
    b, level = rng.choice([0.0, 1.0, -20.0], (RUNS, 2)), rng.choice([0.0, 1.0, 0.05], (RUNS, 2))
    step = step_with_metrics(pair(), metrics, STEP)
    x0 = step.states.pack({"plant.q": rng.choice([0.0, 1.0, -3.0], (RUNS, 2))})
    return simulate(step, np.hstack([a, b, level]), x0, until=HORIZON, every=STEP, arithmetic="portable")
