"""What a7 says of exact derivatives: where they are slopes, and whether they foretell the global indices."""

import numpy as np

from studies.a7_sensitivity.local import Local
from studies.a7_sensitivity.results import Found, named
from studies.a7_sensitivity.sweeps import METRICS, PROPOSED
from studies.a7_sensitivity.words import narrow, with_interval, written
from workbench.study.document.document import Cell, Column, Itemize, Paragraph, Section, Table, Verdict

NEAR = 0.1  # of a variance: how far a linear share may lie from S1 and still foretell it


def gradients(found: dict[str, Found], near: dict[str, Local]) -> Section:
    """Gradients beside differences, and beside the global indices."""
    return Section(
        "Exact derivatives at the numbers of the card",
        (
            Paragraph(
                "The derivative of each metric with respect to each number, from the equations themselves: exact for "
                "the steps that are taken. It is held against runs beside this one, over 0.01 % and over 1 % of the "
                "number. Where a law saturates or switches, the gradient sees the pieces and not the instants between "
                "them, and may be no slope at all."
            ),
            foretold(found, near),
            elasticities(near[PROPOSED]),
            shares_table(found[PROPOSED], near[PROPOSED]),
            slopes_table(found, near),
            Paragraph(
                f"What the workbench warns of for {PROPOSED}; of its rivals the table says in how many places it does."
            ),
            Itemize(near[PROPOSED].found.warnings or ("Nothing.",)),
        ),
    )


def gap(one: Found, local: Local, metric: str, joint: int) -> tuple[float, float]:
    """The linear share that lies farthest from its S1, by how much it does, and half of the interval of that S1.

    NaN where there is no gradient.
    """
    first = one.shares[named(metric, joint)].S1
    apart = np.abs(local.shares(metric, joint) - first.value)
    worst = int(np.argmax(apart))  # of NumPy, whose largest value is NaN where one is
    return float(apart[worst]), float(first.half[worst])


def foretold(found: dict[str, Found], near: dict[str, Local], metric: str = "RMSE") -> Verdict:
    """How often the derivatives at one point say what the indices over the whole range say."""
    gaps = {(law, joint): gap(found[law], near[law], metric, joint) for law in near for joint in (0, 1)}
    wide = [key for key in gaps if not narrow(found[key[0]].shares[named(metric, key[1])].S1)]
    held = [key for key, (far, half) in gaps.items() if far + half <= NEAR and key not in wide]
    # without a gradient, where the difference is NaN, nothing is foretold
    missed = [key for key, (far, half) in gaps.items() if not far - half <= NEAR]
    listed = ", ".join(f"{law} q{joint + 1} {with_interval(*one)}" for (law, joint), one in gaps.items())
    slopes = ", ".join(f"{law} in {holds} of {of}" for law in near for holds, of in [near[law].held(metric)])
    left = len(gaps) - len(held) - len(missed)
    return Verdict(
        "open" if left else "found",
        f"For {len(held)} of {len(gaps)} pairs of law and joint the gradient at the numbers of the card foretells "
        f"every first-order index of the {metric} within {NEAR:g}; for {len(missed)} it is farther off{_open(left)}.",
        f"Largest difference of a linear share from S1, with the interval of that S1: {listed}. The gradient is the "
        f"slope of the runs, of all derivatives at both joints: {slopes}.",
        "S1, of Sobol designs with a quadratic control variate, against the share of a linear function with the exact "
        "gradient.",
        "The ranges of this study, which are alike for all laws.",
        "Wider ranges, over which gains act by curves.",
    )


def _open(count: int) -> str:
    return f", and for {count} the intervals leave it open" if count else ""


def elasticities(local: Local) -> Table:
    """Percent of the RMSE by percent of each factor, by three roads."""
    rows: list[tuple[Cell, ...]] = []
    parts = [local.elasticities("RMSE", joint) for joint in (0, 1)]
    for i, factor in enumerate(local.factors):
        rows.append((written(factor), *(f"{kind[i]:.4f}" for three in parts for kind in three)))
    kinds = ("gradient", "over 0.01 %", "over 1 %")
    columns = (
        Column("factor"),
        *(Column(f"q{joint}, {kind}", "%/%", "right") for joint in (1, 2) for kind in kinds),
    )
    return Table(
        "elasticities",
        f"By how many percent the RMSE of {PROPOSED} changes for each percent of a factor: by the gradient, and by "
        "runs beside this one.",
        columns,
        tuple(rows),
    )


def shares_table(one: Found, local: Local) -> Table:
    """The parts of the variance if a metric were linear, beside S1."""
    rows: list[tuple[Cell, ...]] = []
    for i, factor in enumerate(local.factors):
        cells: list[Cell] = [written(factor)]
        for metric in METRICS:
            first, linear = one.shares[named(metric.name, 0)].S1, local.shares(metric.name, 0)[i]
            cells += [_number(linear), with_interval(first.value[i], first.half[i])]
        rows.append(tuple(cells))
    heads = (f"{metric.name}, {what}" for metric in METRICS for what in ("linear", "S1"))
    return Table(
        "linear_shares",
        f"The part of the variance of each metric of joint 1 of {PROPOSED} that a factor would have were the metric "
        "linear, beside the first-order index.",
        (Column("factor"), *(Column(head, align="right") for head in heads)),
        tuple(rows),
    )


def slopes_table(found: dict[str, Found], near: dict[str, Local]) -> Table:
    """Of each law for how many derivatives the gradient is the slope, and how far linear shares are from S1."""
    rows: list[tuple[Cell, ...]] = []
    for law, local in near.items():
        for metric in METRICS:
            holds, of = local.held(metric.name)
            gaps = [gap(found[law], local, metric.name, joint) for joint in (0, 1)]
            cells = (None if np.isnan(far) else with_interval(far, half) for far, half in gaps)
            rows.append((law, metric.name, f"{holds} of {of}", *cells))
    columns = (
        Column("law"),
        Column("metric"),
        Column("gradient is the slope", align="right"),
        Column("linear share off S1, q1", align="right"),
        Column("q2", align="right"),
    )
    return Table(
        "slopes",
        "For how many derivatives the gradient is the slope of the runs (within 0.1 % over the narrow and 10 % over "
        "the wide change), and how far a linear share lies at most from S1, with the interval of that S1.",
        columns,
        tuple(rows),
    )


def _number(value: float) -> str | None:
    return None if np.isnan(value) else f"{value:.2f}"
