"""What a7 rests on: what is varied and why so far, the errors of the step, and the runs that could betray it."""

from dataclasses import dataclass

import numpy as np

from studies.a7_sensitivity.factors import SPAN, TOLERANCE, factors
from studies.a7_sensitivity.results import Found
from studies.a7_sensitivity.sweeps import HALVED, METRICS, PROPOSED, SEED, STEPS, UNTIL, loop, metrics
from studies.a7_sensitivity.words import percent, written
from studies.paper.laws import RIVALS
from workbench.metrics import measure
from workbench.study.document.document import Cell, Column, Paragraph, Section, Table
from workbench.study.uncertainty.factors import Space

WORST = 3  # runs a joint with the largest TV, which are run again
KEPT = 0.01  # s between the states at which the limit of stability is looked for


@dataclass(frozen=True)
class Stress:
    """The runs of a law with the largest total variation, run again at half of the step.

    Attributes
    ----------
    error
        The largest change of the TV, relative to its standard deviation over all runs.
    limit
        The shortest of the longest stable steps along them, in s.
    """

    law: str
    runs: int
    error: float
    limit: float

    @property
    def holds(self) -> bool:
        """Whether the step is within the limit."""
        return STEPS[self.law] <= self.limit


def stress(one: Found) -> Stress:
    """Where gains have grown most, chattering is worst and the limit of stability nearest."""
    sample = one.indices
    values = np.stack([sample.outputs("TV", joint) for joint in (0, 1)], axis=1)
    worst = np.unique(np.argsort(-values, axis=0)[:WORST])
    ode = loop(one.law).ode()
    moved = tuple(factor for factor in factors(one.law) if factor.name in sample.factors)
    points = np.concatenate([sample.design.points(run, run + 1) for run in worst.tolist()])
    p, x0 = Space(moved, ode.parameters, ode.states).rows(points)
    again = measure(ode, metrics(one.law), p, x0, until=UNTIL, h=STEPS[one.law], every=KEPT)
    error = float((again.scores["TV"].error / values.std(axis=0)).max())
    return Stress(one.law, len(worst), error, min(limit.limit for limit in again.limits))


def varied() -> Section:
    """What is varied, over which ranges, and why no farther."""
    ode = loop(PROPOSED).ode()
    table = Space(factors(PROPOSED), ode.parameters, ode.states).table(
        "factors", f"What is varied of {PROPOSED}; the arm, g and D are varied in the same way for all laws."
    )
    return Section(
        "What is varied",
        (
            Paragraph(
                "All factors are shares of the numbers on the card (a1), independent of one another. What the paper "
                f"states is off by up to {percent(TOLERANCE)} either way. What is assumed lies within a factor of "
                f"{SPAN:g}, evenly on a logarithmic scale, and within the range on the card where that is narrower. "
                "The ranges of the card are mostly wider, up to a factor of 20. Over those the adaptive laws grow "
                "gains of several hundred N m, and behind a layer of 0.01 rad/s a gain of 300 N m is stable for steps"
                " below 0.02 ms only: beyond them a run chatters by the step alone. So the indices hold for these "
                "ranges, and say nothing of wider ones."
            ),
            Paragraph(
                "The arm and the model of it are factors of their own: where one moves and the other does not, the "
                "law believes in a wrong arm. Gravity is the exception, which both know. PID has no model; its gains "
                "follow from an assumed pole, and are as uncertain as that. Links that are off by 10 % are a bad "
                "model; the rule is the same for all numbers so that no index rests on our taste."
            ),
            table,
            gains_table(),
        ),
    )


def gains_table() -> Table:
    """What else is varied: the gains of the rivals."""
    rows: list[tuple[Cell, ...]] = []
    known = {factor.name for factor in factors(PROPOSED)}
    for law in RIVALS:
        for factor in factors(law):
            if factor.name not in known or factor.name == "K(0)":
                rows.append((law, written(factor.name), factor.distribution.words(), factor.origin))
    heads = ("law", "factor", "share of its own value", "origin")
    return Table("gains", "What else is varied of the rivals.", tuple(map(Column, heads)), tuple(rows))


def trust(found: dict[str, Found], stresses: list[Stress]) -> Section:
    """Runs, failures, errors of the step."""
    beyond = [one.law for one in stresses if not one.holds]
    said = (
        f"In {', '.join(beyond)} one of these runs is beyond its limit: its TV is partly that of the step."
        if beyond
        else "All of them are within their limit: the largest TV is that of the law."
    )
    return Section(
        "Can the numbers be trusted?",
        (
            Paragraph(
                f"{sum(len(s) for one in found.values() for s in one.samples):,} runs of {UNTIL:g} s, seed {SEED}. "
                "A sample with a failed run has no indices. "
                f"One run in {HALVED} is run again at half of the step. The step errs most in runs whose gains grow "
                f"largest, and these chatter most: so the {WORST} runs of each joint with the largest TV are run again "
                f"too. {said}"
            ),
            runs_table(found),
            stress_table(stresses),
        ),
    )


def runs_table(found: dict[str, Found]) -> Table:
    """Of each law runs, failures, step, and the worst error of each metric."""
    rows: list[tuple[Cell, ...]] = []
    for law, one in found.items():
        counts = " + ".join(str(len(sample)) for sample in one.samples)
        errors = (_relative(one, metric.name) for metric in METRICS)
        lost = sum(sample.failed for sample in one.samples)
        rows.append((law, counts, lost, f"{1e3 * STEPS[law]:.4g}", *(f"{error:.1g}" for error in errors)))
    columns = (
        Column("law"),
        Column("runs: screening + indices + random + tornado"),
        Column("failed", align="right"),
        Column("step", "ms", "right"),
        *(Column(f"error of {metric.name}", align="right") for metric in METRICS),
    )
    return Table(
        "runs",
        "Runs, failed runs, step, and the largest change of each metric at half of the step, relative to its standard "
        "deviation over the runs.",
        columns,
        tuple(rows),
    )


def _relative(one: Found, metric: str) -> float:
    """The largest error of a metric, relative to its standard deviation over the runs of the indices."""
    worst = []
    for joint in (0, 1):
        spread = float(one.indices.outputs(metric, joint).std())
        for sample in one.samples:
            errors = sample.errors_of(metric, joint)
            worst.append(float(np.nanmax(errors)) / spread)
    return max(worst)


def stress_table(stresses: list[Stress]) -> Table:
    """The runs with the largest TV, run again."""
    rows: tuple[tuple[Cell, ...], ...] = tuple(
        (one.law, one.runs, f"{1e3 * STEPS[one.law]:.4g}", f"{1e3 * one.limit:.3g}", f"{one.error:.1g}")
        for one in stresses
    )
    columns = (
        Column("law"),
        Column("runs", align="right"),
        Column("step", "ms", "right"),
        Column("shortest limit", "ms", "right"),
        Column("largest error of the TV", align="right"),
    )
    return Table(
        "stress",
        "The runs with the largest TV: the longest stable step along them, and the largest change of the TV at half of "
        "the step, relative to its standard deviation.",
        columns,
        rows,
    )
