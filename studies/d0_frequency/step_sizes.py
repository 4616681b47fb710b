"""The settling times of loops that start off their rest by more and more, beside those of their linear parts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm

import workbench as wb
from studies.d0_frequency.loops import AtPose, linear, loop_at_rest, start_states
from studies.paper.card import LAWS
from studies.paper.comparison import PROPOSED_STEP, STEPS
from studies.paper.linearization import LEVEL

SIZES = (1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 1e-1, 3e-1, 1.0)  # rad, by which both joints start off
BAND = 0.05  # of the size
UNTIL = 10.0  # s
SIZE_POSES = (LEVEL, "extended")
ITEMS = tuple(AtPose(law, pose) for law in LAWS for pose in SIZE_POSES)
INSTANT = 1e-3  # s, between two looks at the linear answer
HALF = 0.5  # of the step of a1, at which a1 takes its values


@dataclass(frozen=True, eq=False)
class Settling:
    """Settling times of the slower joint in s: of the linear part, and of the nonlinear runs by size (sizes,).

    Infinite if a joint does not settle within the run; `error` (sizes,) is that of the runs by half the step.
    """

    prediction: float
    runs: wb.Array
    error: wb.Array

    def valid(self, tolerance: float) -> float:
        """The largest size in rad up to which all runs are within a share of the prediction; 0 if none is."""
        good = np.abs(self.runs / self.prediction - 1) <= tolerance
        count = len(good) if good.all() else int(np.argmin(good))
        return (0.0, *SIZES)[count]


def settling(one: AtPose) -> Settling:
    """The settling times of a law at a pose."""
    equation = loop_at_rest(one).ode()
    h = HALF * STEPS.get(one.law, PROPOSED_STEP)
    x = start_states(equation, one, np.array(SIZES))
    found = wb.measure(equation, [wb.settling_time("q", BAND)], x0=x, until=h * round(UNTIL / h), h=h, every=UNTIL)
    pairs = [(score.value, score.error) for score in found.scores_of("settling time of q")]
    values, errors = (np.array([pair[i] for pair in pairs]) for i in (0, 1))
    slower = np.argmax(values, axis=0)
    runs, error = (np.take_along_axis(part, slower[np.newaxis], 0)[0] for part in (values, errors))
    return Settling(predict_settling(one), runs, error)


def predict_settling(one: AtPose) -> float:
    """The settling time of the linear part in s, which is the same for all sizes."""
    loop = linear(one)
    system, layout = loop.system("closed", outputs=("q",)), loop.states
    x = np.zeros(layout.size)
    for name in ("plant.q", "observer.state.q_hat"):
        if name in layout:
            x[layout.slice(name)] = 1.0
    A, C = np.asarray(system.A), np.asarray(system.C)
    step, outside = expm(A * INSTANT), 0.0
    for k in range(round(UNTIL / INSTANT)):
        if (np.abs(C @ x) > BAND).any():
            outside = (k + 1) * INSTANT
        x = step @ x
    return outside if outside < UNTIL else float("inf")


def settlings(results: wb.Results) -> Mapping[AtPose, Settling]:
    """The settling times of each law at each pose."""
    return dict(zip(ITEMS, results.work("step_sizes"), strict=True))
