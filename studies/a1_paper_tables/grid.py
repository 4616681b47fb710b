"""The law as printed in the first scenario over a grid of Q and R, for each shape of (33)."""

from itertools import product

import numpy as np

from studies.paper.card import CARD
from studies.paper.laws import proposed_as_printed
from workbench.arms.laws.aosmc_rgs import SHAPES
from workbench.core.validation.refusals import Array
from workbench.engine.distributions import LogUniform
from workbench.engine.factors import Factor
from workbench.engine.metrics import AbstractMetric
from workbench.study.contract import Run, Sweep
from workbench.study.study import Results
from workbench.study.uncertainty import Listed

UNTIL = 15.0  # s
H = 2e-4  # s, below the limit of stability of (34) with the least R, 0.4 ms
LARGE = 1e3  # N m/(rad s), the upper end of the card's ranges of Q and R
# Multiples of I. With a smaller R the P of (34) falls from P(0) too fast for this step.
Q = LogUniform(next(g.low or 0.0 for g in CARD if g.name == "Q"), LARGE)
R = LogUniform(0.1, LARGE)
UNIT = np.array(list(product(np.linspace(0, 1, 6), np.linspace(0, 1, 5))))  # a power of ten apart


def sweeps(metrics: tuple[AbstractMetric, ...]) -> tuple[Sweep, ...]:
    """The grid for each shape of (33)."""
    factors = (Factor("Q", ("controller.Q",), Q, share=True), Factor("R", ("controller.R",), R, share=True))
    return tuple(
        Sweep(
            f"printed_{shape}", Run(proposed_as_printed("FS", shape), metrics, UNTIL, UNTIL, H), factors, Listed(UNIT)
        )
        for shape in SHAPES
    )


def late_errors(results: Results) -> dict[str, Array]:
    """By shape, the larger late error (N,) of both joints in rad at each point; infinite after a run has diverged."""
    errors = {}
    for shape in SHAPES:
        sample = results.sample(f"printed_{shape}")
        both = np.max([sample.score("late error", joint).value for joint in (0, 1)], axis=0)
        errors[shape] = np.where(np.isnan(sample.diverged_at) & np.isfinite(both), both, np.inf)
    return errors


def points() -> list[tuple[float, float]]:
    """Q and R of each point, multiples of I in N m/(rad s)."""
    return [(float(Q.quantile(np.array(a))), float(R.quantile(np.array(b)))) for a, b in UNIT]
