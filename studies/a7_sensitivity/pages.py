"""The pictures of a7, and the tables beside them: the indices of AOSMC-RGS, and the spread of all laws."""

from collections.abc import Mapping

import numpy as np

from studies.a7_sensitivity.factors import GROUPS, group_of, labels, written
from studies.a7_sensitivity.results import FLOOR, LawResults, interval, middles, named
from studies.a7_sensitivity.sweeps import EVERY, METRICS, NARROW, OF_LATE, PROPOSED
from workbench.study.document.document import Cell, Column, Figure, Paragraph, Section, Table
from workbench.study.pictures import indices_over_time, morris_plane, quantile_bands, sobol_bars, tornado_figure
from workbench.study.uncertainty import Estimate, SobolIndices

FELT = 0.02  # of the variance, below which a pair is not worth a word
SHOWN = ("RMSE", "late error", "TV")
UNITS = {"TV": "N m/s", "effort": "N m"}  # and rad elsewhere


def indices_figure(one: LawResults, joint: int) -> Figure:
    """The indices of the metrics of one joint."""
    return sobol_bars(
        f"aosmc_rgs_sobol_q{joint + 1}",
        f"Indices of {one.law}, joint {joint + 1}.",
        one.shares_of([(metric, joint) for metric in SHOWN]),
        one.indices.note_of("RMSE", joint),
        labels=labels(one.indices.factors),
    )


def bands_figure(laws: Mapping[str, LawResults]) -> Figure:
    """The error of every law over time."""
    first = laws[PROPOSED].random
    lost = ", ".join(f"{law} {one.random.failed}" for law, one in laws.items())
    return quantile_bands(
        "bands",
        f"The error of joint 1 in each window of {EVERY:g} s, over random draws of all factors; errors below "
        f"{1e3 * FLOOR:g} mrad are drawn there, as the integrals behind them round.",
        middles(first),
        {law: one.bands(0) for law, one in laws.items()},
        f"Of each law {first.note_of('ISE', 0)} (the errors are those of {PROPOSED}). Failed runs: {lost}",
        "log10 of the error [rad]",
    )


def proposed_section(one: LawResults) -> Section:
    """The proposed law in full."""
    effects, over_time = one.effects_on([("RMSE", 0), ("RMSE", 1)]), one.shares_over_time(0)
    tornadoes = (
        tornado_figure(
            name,
            f"The {metric} of joint 1 of {PROPOSED} at the ends of the range of each factor by itself.",
            one.tornado_of(metric, 0),
            one.swings.note_of(metric, 0),
            "rad",
            labels=labels(one.swings.factors),
        )
        for name, metric in (("aosmc_rgs_tornado", "RMSE"), ("aosmc_rgs_tornado_late", "late error"))
    )
    return Section(
        f"{PROPOSED} in full",
        (
            indices_figure(one, 1),
            *tornadoes,
            morris_plane(
                "aosmc_rgs_morris",
                f"Elementary effects on the RMSE of {PROPOSED}.",
                effects,
                one.screening.note_of("RMSE", 0),
                "rad",
                labels=labels(effects.factors),
            ),
            indices_over_time(
                "aosmc_rgs_over_time",
                f"Indices of the error of joint 1 of {PROPOSED}, its root mean square in each window of {EVERY:g} s.",
                middles(one.indices),
                over_time,
                one.indices.note_of("ISE", 0),
                labels=labels(one.indices.factors),
            ),
            Paragraph(f"{course(over_time, middles(one.indices))} {acting_pairs(one.shares)}"),
            totals_table(one),
        ),
    )


def course(indices: SobolIndices, t: np.ndarray) -> str:
    """The part of the error of a window that the gains decide: at first, at most, and at last."""
    total = indices.of_group("gains", total=True)
    most = int(np.nanargmax(total.value))
    wide, unsure = (
        ", ".join(f"{t[k]:.3g}" for k in np.flatnonzero(~(2 * half < NARROW)))
        for half in (total.half, indices.ST.half.max(axis=1))
    )
    return (
        f"The total indices of all gains sum to {interval(total[0])} in the first window, to {interval(total[most])} "
        f"around {t[most]:.3g} s, where they have most to say, and to {interval(total[-1])} in the last; what is left "
        f"is the arm and its model. Where an interval is wider than {NARROW:g}, as a few runs have most of the "
        f"variance, it is open what decides: of all gains together around {wide or 'none'} s, of single factors around "
        f"{unsure or 'none'} s."
    )


def acting_pairs(indices: SobolIndices) -> str:
    """The pairs of factors that act together, as far as the runs can tell."""
    names = [f"{indices.factors[i]} and {indices.factors[j]}" for i, j in indices.pairs]
    told = [
        f"{names[place]} ({output})"
        for output in indices.names
        for place in np.flatnonzero(indices[output].S2.low > FELT)
    ]
    return (
        f"Of {len(names)} pairs of factors, whose intervals hold together, an S2 above {FELT:g} is told for "
        f"{', '.join(told) or 'none'}."
    )


def totals_table(one: LawResults) -> Table:
    """The total index of every factor and output, with half of its interval."""
    total = one.shares.ST
    rows = (
        (written(factor), *(interval(Estimate(total.value[k, i], total.half[k, i])) for k in range(len(one.outputs))))
        for i, factor in enumerate(one.shares.factors)
    )
    heads = (f"{metric}, q{joint + 1}" for metric, joint in one.outputs)
    return Table(
        "aosmc_rgs_totals",
        f"Total indices ST of {one.law}, each with its interval of 95 %. {OF_LATE}",
        (Column("factor"), *(Column(head, align="right") for head in heads)),
        tuple(rows),
        one.shares.remarks,
    )


def laws_section(laws: Mapping[str, LawResults]) -> Section:
    """Gains against arm and model, and the spread of each metric."""
    return Section("All laws", (groups_table(laws), spread_table(laws)))


def groups_table(laws: Mapping[str, LawResults]) -> Table:
    """First-order parts of gains, arm and model, and what is left for factors that act together."""
    rows: list[tuple[Cell, ...]] = []
    for law, one in laws.items():
        has = {group_of(factor) for factor in one.shares.factors}
        for metric, joint in ((metric.name, joint) for metric in METRICS for joint in (0, 1)):
            shares = one.shares[named(metric, joint)]
            whole = shares.of_group("all")
            cells = (interval(shares.of_group(group)) if group in has else None for group in GROUPS)
            rest = interval(Estimate(1 - whole.value, whole.half))
            rows.append((law, metric, joint + 1, f"{float(shares.deviation):.2g}", *cells, rest))
    return Table(
        "groups",
        "The parts of the variance of each metric that gains, arm and model have by themselves (sums of S1, intervals "
        "of 95 %), and what is left, which is due to factors that act together. Deviations are in rad, of the TV in "
        f"N m/s, of the effort in N m; an interval wider than {NARROW:g} decides nothing here.",
        (
            *map(Column, ("law", "metric", "joint")),
            *(Column(head, align="right") for head in ("standard deviation", *GROUPS, "together")),
        ),
        tuple(rows),
    )


def spread_table(laws: Mapping[str, LawResults]) -> Table:
    """Median and 95 % quantile of each metric."""
    rows: list[tuple[Cell, ...]] = []
    for law, joint in ((law, joint) for law in laws for joint in (0, 1)):
        cells = []
        for metric in METRICS:
            one = laws[law].spread(metric.name, joint)
            high = f"{one.high[0, -1]:.3g}" if np.isfinite(one.high[0, -1]) else "not bounded"
            cells += [f"{one.value[0, 1]:.3g}", f"{one.value[0, -1]:.3g} ({high})"]
        rows.append((law, joint + 1, *cells))
    columns = (
        Column(f"{metric.name}, {what}", metric.unit or UNITS.get(metric.name, "rad"), "right")
        for metric in METRICS
        for what in ("median", "95 % (at most)")
    )
    return Table(
        "spread",
        f"Median and 95 % quantile of each metric over {len(laws[PROPOSED].random)} random draws of all factors; in "
        f"brackets the end of the quantile's interval of 95 %. {OF_LATE}",
        (Column("law"), Column("joint"), *columns),
        tuple(rows),
    )
