"""The law as printed in the first scenario over a grid of Q and R, for each shape of (33)."""

from itertools import product

import numpy as np

import workbench as wb
from studies.paper.card import CARD
from studies.paper.laws import proposed_as_printed

UNTIL = 15.0  # s
H = 2e-4  # s, below the limit of stability of (34) with the least R, 0.4 ms
LARGE = 1e3  # N m/(rad s), the upper end of the card's ranges of Q and R
# Multiples of I. With a smaller R the P of (34) falls from P(0) too fast for this step.
Q = wb.LogUniform(next(g.low or 0.0 for g in CARD if g.name == "Q"), LARGE)
R = wb.LogUniform(0.1, LARGE)
UNIT = np.array(list(product(np.linspace(0, 1, 6), np.linspace(0, 1, 5))))  # a power of ten apart


def sweeps(metrics: tuple[wb.metrics.AbstractMetric, ...]) -> tuple[wb.Sweep, ...]:
    """The grid for each shape of (33)."""
    factors = (wb.Factor("Q", ("controller.Q",), Q, share=True), wb.Factor("R", ("controller.R",), R, share=True))
    return tuple(
        wb.Sweep(
            f"printed_{shape}",
            wb.Run(proposed_as_printed("FS", shape), metrics, UNTIL, UNTIL, H),
            factors,
            wb.uncertainty.ListedPoints(UNIT),
        )
        for shape in wb.arms.laws.SHAPES
    )


def late_errors(results: wb.Results) -> dict[str, wb.Array]:
    """By shape, the larger late error (N,) of both joints in rad at each point; infinite after a run has diverged."""
    errors = {}
    for shape in wb.arms.laws.SHAPES:
        sample = results.sample(f"printed_{shape}")
        both = np.max([sample.score("late error", joint).value for joint in (0, 1)], axis=0)
        errors[shape] = np.where(np.isnan(sample.diverged_at) & np.isfinite(both), both, np.inf)
    return errors


def points() -> list[tuple[float, float]]:
    """Q and R of each point, multiples of I in N m/(rad s)."""
    return [(float(Q.quantile(np.array(a))), float(R.quantile(np.array(b)))) for a, b in UNIT]
