"""What a7 says of exact derivatives: where they are slopes, and whether they foretell the global indices."""

import numpy as np
from sensitivity_found import Found, named
from sensitivity_local import Local
from sensitivity_sweeps import METRICS, PROPOSED
from sensitivity_words import with_interval, written

from workbench.core.layout import Array
from workbench.study.document import Cell, Column, Itemize, Paragraph, Section, Table, Verdict

NEAR = 0.1  # of a variance: how far a linear share may lie beyond the interval of S1 and still foretell it


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


def gap(one: Found, local: Local, metric: str, joint: int) -> Array:
    """How far the linear shares are from S1 beyond its intervals, (d,); NaN where there is no gradient."""
    first = one.shares[named(metric, joint)].S1
    return np.asarray(np.maximum(np.abs(local.shares(metric, joint) - first.value) - first.half, 0.0))


def foretold(found: dict[str, Found], near: dict[str, Local], metric: str = "RMSE") -> Verdict:
    """Whether the derivatives at one point say what the indices over the whole range say."""
    # of NumPy, whose largest value is NaN where one is: without a gradient nothing is foretold
    gaps = {law: float(np.max([gap(found[law], near[law], metric, joint) for joint in (0, 1)])) for law in near}
    missed = [law for law, far in gaps.items() if not far <= NEAR]
    listed = ", ".join(f"{law} {far:.3f}" for law, far in gaps.items())
    return Verdict(
        "holds" if not missed else "fails",
        f"Over these ranges the {metric} of every law is so near to linear that its gradient at one point foretells "
        f"every first-order index: no linear share lies more than {NEAR:g} beyond the interval of S1.",
        f"Largest difference of a linear share from S1 beyond its interval: {listed}.",
    )


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
            gaps = [float(gap(found[law], local, metric.name, joint).max()) for joint in (0, 1)]
            rows.append((law, metric.name, f"{holds} of {of}", *map(_number, gaps)))
    columns = (
        Column("law"),
        Column("metric"),
        Column("gradient is the slope", align="right"),
        Column("linear share beyond S1, q1", align="right"),
        Column("q2", align="right"),
    )
    return Table(
        "slopes",
        "For how many derivatives the gradient is the slope of the runs (within 0.1 % over the narrow and 10 % over "
        "the wide change), and how far a linear share lies at most beyond the interval of S1.",
        columns,
        tuple(rows),
    )


def _number(value: float) -> str | None:
    return None if np.isnan(value) else f"{value:.2f}"
