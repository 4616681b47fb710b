"""A smaller repair than that of four slips: (3) and (28) alone, with (24) and the minus of (33) as printed."""

from dataclasses import replace

import numpy as np

from studies.a1_paper_tables.assumptions import SMALL
from studies.a1_paper_tables.printed import gain_floor, loses_positivity
from studies.paper.card import CARD, PUBLISHED
from studies.paper.comparison import PROPOSED
from studies.paper.laws import ARM, paper_observer, proposed_as_printed
from workbench.controllers.aosmc_rgs import SHAPES
from workbench.loop import ClosedLoop
from workbench.study.document.document import Cell, Column, Diverged, Measured, Paragraph, Table
from workbench.study.study import Outcome, Results

PAIRS = {f"FS, (3) and (28) repaired, Q = {Q:g} I": Q for Q in (SMALL, 1.0)}  # Q in N m/(rad s); R = I


def with_two_repairs(shape: str, Q: float) -> ClosedLoop:
    """The printed law in the first scenario with C right in model and observer, and qd_r in (28)."""
    loop = proposed_as_printed("FS", shape)
    law = replace(loop.controller, model=ARM, velocity="reference", Q=Q * np.eye(2))
    return replace(loop, controller=law, observer=replace(loop.observer, state=paper_observer()))


def runs(results: Results) -> list[Outcome]:
    """Those of the law with two repairs: for each Q each reading of (33)."""
    return [results[pair, shape] for pair in PAIRS for shape in SHAPES]


def kept(results: Results) -> list[Outcome]:
    """Those that end with K positive definite all along."""
    return [run for run in runs(results) if run.diverged_at is None and loses_positivity(run) is None]


def _late(results: Results) -> str:
    pairs = [[run.score("late error", j)[0] for run in kept(results)] for j in (0, 1)]
    worst = [f"{max(values, default=np.inf):.3f} rad (joint {j + 1})" for j, values in enumerate(pairs)]
    return f"at most {' and '.join(worst)}"


def fewer(results: Results) -> str:
    """The finding in a sentence."""
    return (
        f"With (3) and (28) repaired alone, and the same Q and R, {len(kept(results))} of {len(runs(results))} runs "
        f"track for {CARD['FS: horizon']:g} s: K stays positive definite, with late errors of {_late(results)}."
    )


def tracking(results: Results) -> tuple[Paragraph, Table]:
    """What two repairs give."""
    printed = [PUBLISHED["FS", j + 1].values[PROPOSED] for j in (0, 1)]
    above = [100 * (run.score("RMSE (43)", j)[0] / printed[j] - 1) for run in kept(results) for j in (0, 1)]
    rows: list[tuple[Cell, ...]] = []
    for run, Q in zip(runs(results), (Q for Q in PAIRS.values() for _ in SHAPES), strict=True):
        lost, gone = loses_positivity(run), run.diverged_at
        scores: list[Cell] = [
            Measured(*run.score(metric, j)) if gone is None else Diverged(gone)
            for metric in ("RMSE (43)", "late error")
            for j in (0, 1)
        ]
        floor = float(np.nanmin(gain_floor(run))) if lost is None else None
        rows.append((f"{Q:g} I", run.case.law, "never" if lost is None else f"{lost:.2f}", floor, *scores))
    columns = (
        Column("Q"),
        Column("reading of (33)"),
        Column("K not positive", "s", "right"),
        Column("least eigenvalue of K", "N m", digits=3),
        *(Column(f"{what} of q{j}", "rad", "right") for what in ("RMSE", "late error") for j in (1, 2)),
    )
    until = f"{CARD['FS: horizon']:g} s"
    return (
        Paragraph(
            f"Tracking needs fewer repairs. With (3) and (28) repaired alone, (24) and the minus of (33) as printed, "
            f"and R = I, K stays positive definite for {until} in {len(kept(results))} of {len(runs(results))} runs, "
            f"with late errors of {_late(results)}; RMSE (43) is {min(above):.0f} to {max(above):.0f} % above the "
            "printed values. What the minus costs in the table above is with the fitted Q and R."
        ),
        Table(
            "two_repairs",
            f"The law with (3) and (28) repaired alone: first scenario, derived arm, over {until}, R = I.",
            columns,
            tuple(rows),
            ("RMSE: by (43). Least eigenvalue: of the symmetric part of K, over the run.",),
        ),
    )
