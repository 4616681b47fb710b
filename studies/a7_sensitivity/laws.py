"""What a7 says of each law: pictures and tables of its indices, the proposed law at more length than its rivals."""

from dataclasses import replace

import numpy as np

from studies.a7_sensitivity.results import FLOOR, Found, middles, unit_of
from studies.a7_sensitivity.sweeps import CLEARED, EVERY, HELD, METRICS, NARROW, OF_LATE, PROPOSED
from studies.a7_sensitivity.words import labels, percent, with_interval, written
from workbench.study.document.document import Block, Cell, Column, Paragraph, Phrase, Reference, Section, Table
from workbench.study.pictures import (
    indices_over_time,
    morris_plane,
    quantile_bands,
    second_order_map,
    sobol_bars,
    tornado_figure,
)
from workbench.study.uncertainty import SobolIndices

FELT = 0.02  # of the variance, below which a pair is not worth a word
SHOWN = ("RMSE", "late error", "TV")


def stem(law: str) -> str:
    """The beginning of the names of a law's tables and figures."""
    return law.lower().replace("-", "_")


def proposed(found: dict[str, Found]) -> Section:
    """The proposed law in full."""
    one, key = found[PROPOSED], stem(PROPOSED)
    outputs = [(metric, 1) for metric in SHOWN]
    pairs = one.shares_of([("late error", 0), ("late error", 1)])
    return Section(
        f"{PROPOSED} in full",
        (
            *law_blocks(one),
            tornado_figure(
                f"{key}_tornado",
                f"The RMSE of joint 1 of {PROPOSED} at the ends of the range of each factor by itself.",
                one.tornado_of("RMSE", 0),
                one.swings.note_of("RMSE", 0),
                unit_of("RMSE"),
                labels=labels(one.swings.factors),
            ),
            sobol_bars(
                f"{key}_sobol_q2",
                f"Indices of {PROPOSED}, joint 2.",
                one.shares_of(outputs),
                one.indices.note_of("RMSE", 1),
                labels=labels(one.shares.factors),
            ),
            tornado_figure(
                f"{key}_tornado_late",
                f"The late error of joint 1 of {PROPOSED} at the ends of the range of each factor by itself.",
                one.tornado_of("late error", 0),
                one.swings.note_of("late error", 0),
                "rad",
                labels=labels(one.swings.factors),
            ),
            second_order_map(
                f"{key}_pairs",
                f"Pairs of factors in the variance of the late error of {PROPOSED}.",
                pairs,
                one.indices.note_of("late error", 0),
                labels=labels(pairs.factors),
            ),
            *over_time(one),
        ),
    )


def over_time(one: Found) -> tuple[Block, ...]:
    """Which factors matter when."""
    key = stem(one.law)
    indices = one.shares_over_time(0)
    return (
        Paragraph(course(one, indices)),
        indices_over_time(
            f"{key}_over_time",
            f"Indices of the error of joint 1 of {one.law} in each window of {EVERY:g} s.",
            middles(one.indices),
            indices,
            one.indices.note_of("ISE", 0),
            labels=labels(one.indices.factors),
        ),
    )


def course(one: Found, indices: SobolIndices) -> str:
    """How much of the error of a window the gains decide: at first, at most, and at last."""
    total, t = indices.of_group("gains", total=True), middles(one.indices)
    most = int(np.nanargmax(total.value))
    first, top, last = (with_interval(float(total.value[k]), float(total.half[k])) for k in (0, most, -1))
    wide, unsure = (
        ", ".join(f"{t[k]:.3g}" for k in np.flatnonzero(~(2 * part < NARROW)))
        for part in (total.half, indices.ST.half.max(axis=1))
    )
    of_gains = (
        f" Its interval is wider than {NARROW:g}, and what the gains decide open, about {wide} s." if wide else ""
    )
    of_one = (
        f" Intervals of single factors are wider than {NARROW:g} about {unsure} s, where a few runs have most of the "
        "variance: which of them decides is open there."
    )
    return (
        f"The error of a window is its root mean square over {EVERY:g} s. The total indices of all gains of {one.law} "
        f"sum to {first} in the first window, to {top} around {t[most]:.3g} s, where they have most "
        f"to say, and to {last} in the last; what is left is the arm and its model.{of_gains}"
        f"{of_one if unsure else ''}"
    )


def rivals(found: dict[str, Found]) -> tuple[Section, ...]:
    """Each rival in brief."""
    return tuple(Section(law, law_blocks(one)) for law, one in found.items() if law != PROPOSED)


def law_blocks(one: Found) -> tuple[Block, ...]:
    """What every law has: effects, indices, and what acts in pairs."""
    law, key = one.law, stem(one.law)
    first = [(metric, 0) for metric in SHOWN]
    effects = one.effects_on("RMSE")
    plane = morris_plane(
        f"{key}_morris",
        f"Elementary effects on the RMSE of {law}.",
        effects,
        one.screening.note_of("RMSE", 0),
        unit_of("RMSE"),
        labels=labels(effects.factors),
    )
    return (
        Paragraph(left_out(one)),
        plane if law == PROPOSED else replace(plane, columns=2),
        sobol_bars(
            f"{key}_sobol",
            f"Indices of {law}, joint 1.",
            one.shares_of(first),
            one.indices.note_of("RMSE", 0),
            labels=labels(one.shares.factors),
        ),
        totals_table(one),
        *([Paragraph(acting_pairs(one.shares))] if one.shares.S2 is not None else []),
    )


def left_out(one: Found) -> Phrase:
    """Which factors the screening cleared, and whether the runs bear that out."""
    held = HELD[one.law]
    if not held:
        return ("The Sobol indices are those of all factors of ", Reference(f"{stem(one.law)}_morris"), ".")
    share, most = largest_shares(one, high=False), largest_shares(one, high=True)
    worst = max(held, key=lambda name: share[name])
    largest = max(most[name] for name in held)
    verdict = (
        f"below the {percent(CLEARED)} that the rule asks"
        if largest < CLEARED
        else f"more than the {percent(CLEARED)} that the rule allows"
        if share[worst] >= CLEARED
        else f"below the {percent(CLEARED)} that the rule asks, but not so within the intervals"
    )
    names = ", ".join(held)
    return (
        f"Left at their values in the Sobol indices: {names}. By the screening the largest mu* among them is that of "
        f"{worst}, {percent(share[worst])} of the largest of the same output, at most {percent(largest)} within the "
        f"intervals: {verdict}.",
    )


def largest_shares(one: Found, high: bool) -> dict[str, float]:
    """The largest mu* of each factor over the outputs, or the upper end of its interval, relative to the largest mu*
    of the same output.
    """
    size = one.effects.mu_star
    share = ((size.high if high else size.value) / size.value.max(axis=1, keepdims=True)).max(axis=0)
    return dict(zip(one.effects.factors, share.tolist(), strict=True))


def totals_table(one: Found) -> Table:
    """ST of every factor and output, with half of its interval."""
    key, indices = stem(one.law), one.shares
    rows: list[tuple[Cell, ...]] = [
        (written(factor), *(with_interval(value, half) for value, half in zip(values, halves, strict=True)))
        for factor, values, halves in zip(indices.factors, indices.ST.value.T, indices.ST.half.T, strict=True)
    ]
    heads = (f"{metric}, q{joint + 1}" for metric, joint in one.outputs)
    columns = (Column("factor"), *(Column(head, align="right") for head in heads))
    return Table(
        f"{key}_totals",
        f"Total indices ST of {one.law}.",
        columns,
        tuple(rows),
        (f"{one.indices.note}. Each value with its interval of 95 %. {OF_LATE}", *indices.remarks),
    )


def acting_pairs(indices: SobolIndices) -> str:
    """The pairs of factors that act together, as far as the runs can tell."""
    said = [f"{name}: {', '.join(pairs)}" for name in indices.names if (pairs := told(indices[name]))]
    if not said:
        return f"For none of {len(indices.pairs)} pairs does the interval of S2 lie above {FELT:g}."
    return (
        f"Of {len(indices.pairs)} pairs these act together: {'; '.join(said)}. (Second-order indices whose interval "
        f"lies above {FELT:g}; the intervals of all pairs of an output hold together.)"
    )


def told(one: SobolIndices) -> list[str]:
    """The pairs of one output whose S2 is there, and can be."""
    assert one.S2 is not None
    found = []
    for place, (i, j) in enumerate(one.pairs):
        low, value, half = one.S2.low[place], one.S2.value[place], one.S2.half[place]
        if low > FELT:
            found.append((float(value), f"{one.factors[i]} and {one.factors[j]} {with_interval(value, half)}"))
    return [words for _, words in sorted(found, reverse=True)[:3]]


def spread(found: dict[str, Found]) -> Section:
    """How far runs lie apart: over time, and at the horizon."""
    bands = {law: one.bands(0) for law, one in found.items()}
    first = found[PROPOSED]
    lost = ", ".join(f"{law} {one.random.failed}" for law, one in found.items())
    note = f"Of each law {first.random.note_of('ISE', 0)} (the errors are those of {PROPOSED}). Failed runs: {lost}"
    return Section(
        "How far the runs lie apart",
        (
            quantile_bands(
                "bands",
                f"The error of joint 1 in each window of {EVERY:g} s, over random draws of all factors; errors below "
                f"{1e3 * FLOOR:g} mrad are drawn there, as the integrals behind them round.",
                middles(first.random),
                bands,
                note,
                "log10 of the error [rad]",
            ),
            spread_table(found),
        ),
    )


def spread_table(found: dict[str, Found]) -> Table:
    """Median and 95 % quantile of each metric."""
    rows: list[tuple[Cell, ...]] = []
    for law, one in found.items():
        for joint in (0, 1):
            cells = []
            for metric in METRICS:
                held = one.spread(metric.name, joint)
                high = "" if np.isfinite(held.high[0, -1]) else " or more"
                cells += [f"{held.value[0, 1]:.3g}", f"{held.value[0, -1]:.3g} ({_end(held.high[0, -1])}){high}"]
            rows.append((law, joint + 1, *cells))
    heads = [(metric.name, metric.unit or unit_of(metric.name)) for metric in METRICS]
    columns = tuple(
        Column(f"{name}, {what}", unit, "right") for name, unit in heads for what in ("median", "95 % (at most)")
    )
    return Table(
        "spread",
        "Median and 95 % quantile of each metric over random draws of all factors; in brackets the end of the "
        "quantile's interval of 95 %.",
        (Column("law"), Column("joint"), *columns),
        tuple(rows),
        (f"{len(found[PROPOSED].random)} random runs of each law.", OF_LATE),
    )


def _end(value: float) -> str:
    return f"{value:.3g}" if np.isfinite(value) else "not bounded"
