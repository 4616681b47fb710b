"""How a6 reads: the answers, what is open, the nearest fits, how many there are, and who wins."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from paper_card import LAWS, PUBLISHED
from unstated_draws import RANDOM, at_draws, factors_of, slug
from unstated_fits import CLOSE, EVALUATIONS, FINE, TARGETS, Fit, fit, nearest, runs
from unstated_loops import FACTORS, PROPOSED, SCENARIOS, SQUARE, Reading
from unstated_ranking import deciding_section, ranking_section, rankings, winner_verdict

from workbench.core.layout import Array
from workbench.study.document import Cell, Column, Itemize, Measured, Paragraph, Section, Table, Verdict
from workbench.study.factors import Factor
from workbench.study.study import Results

CELLS = tuple(target for target in TARGETS if "q" in target)
WIDE = 0.5  # of a range: what is found over more of it is not determined


@dataclass(frozen=True, eq=False)
class Found:
    """What was found for one law.

    Attributes
    ----------
    fits
        By target.
    drawn, sought
        The misses of the independent draws and of the points of the search, by target.
    close
        By target the values (n, d) of the factors in all choices within 1 %, of draws and search together.
    """

    law: str
    fits: Mapping[str, Fit]
    drawn: Mapping[str, Array]
    sought: Mapping[str, Array]
    close: Mapping[str, Array]


@cache
def found_for(results: Results, law: str) -> Found:
    """Fits and counts of a law."""
    tuned = results.tuned(slug("search", law))
    checks = {scenario: results.sample(slug("check", law, scenario)) for scenario in SCENARIOS}
    random = {scenario: at_draws(results, "random", law, scenario) for scenario in SCENARIOS}
    fits = {target: fit(law, target, tuned, checks) for target in TARGETS}
    drawn = {target: nearest(law, target, random) for target in TARGETS}
    sought = {target: nearest(law, target, runs(tuned)) for target in TARGETS}
    both = np.concatenate([random["SS"].drawn, tuned.numbers])
    close = {target: both[np.concatenate([drawn[target], sought[target]]) <= CLOSE] for target in TARGETS}
    return Found(law, fits, drawn, sought, close)


def sections(results: Results) -> Sequence[Section]:
    """What the report says."""
    found = {law: found_for(results, law) for law in LAWS}
    ranked = rankings(results)
    return (
        Section("What was found", (*verdicts(found), winner_verdict(ranked))),
        open_section(),
        fits_section(found),
        counts_section(found),
        ranking_section(results, ranked),
        deciding_section(results),
        trust_section(results, found),
    )


def headlines(results: Results) -> Sequence[str]:
    """The findings in a line each."""
    found = {law: found_for(results, law) for law in LAWS}
    return tuple(f"{verdict.statement} {verdict.evidence}" for verdict in verdicts(found))


def verdicts(found: Mapping[str, Found]) -> tuple[Verdict, ...]:
    """What the fits say."""
    ours = found[PROPOSED].fits["FS"]
    fits = [found[law].fits[cell] for law in LAWS for cell in CELLS]
    both = [found[law].fits["both"] for law in LAWS]
    worst = max(both, key=lambda one: one.miss)
    met = sum(one.met for one in fits)
    wide = {law: wide_factors(found[law]) for law in LAWS}
    return (
        Verdict(
            "holds" if ours.met else "fails",
            f"Numbers and readings that are not stated give the printed row of {PROPOSED} in the first scenario.",
            f"The nearest: off by {_percent(ours.miss)} at most, the error of the step included, at a horizon of "
            f"{ours.horizon['FS']:.2f} s.",
        ),
        Verdict(
            "holds" if met == len(fits) else "fails",
            "So do they for every one of the 24 printed cells.",
            f"{met} of {len(fits)} cells are met within {_percent(CLOSE)}.",
        ),
        Verdict(
            "holds" if all(one.met for one in both) else "fails",
            "One choice for each law gives all four cells of that law, each scenario at a horizon of its own.",
            f"So it is for {sum(one.met for one in both)} of {len(both)} laws; the largest miss is that of {worst.law}, "
            f"{_percent(worst.miss)}. Each law has its own square wave and horizons: one experiment for all is "
            "not asked here.",
        ),
        Verdict(
            "fails" if any(wide.values()) else "holds",
            "The printed tables determine the numbers that are not stated.",
            "Over more than half of its range lies, among the choices that meet all four cells of a law within "
            f"{_percent(CLOSE)}: "
            + "; ".join(f"of {law} {', '.join(names) if names else 'none'}" for law, names in wide.items())
            + ".",
        ),
    )


def _percent(part: float) -> str:
    return f"{100 * part:.2g} %"


def wide_factors(found: Found) -> tuple[str, ...]:
    """The factors whose values among the choices that meet all four cells span more than half of their range."""
    factors, close = factors_of(found.law, "SS"), found.close["both"]
    if not len(close):
        return ()
    return tuple(f.name for f, values in zip(factors, close.T, strict=True) if span_of(f, values) > WIDE)


def span_of(factor: Factor, values: Array) -> float:
    """What part of its range values of a factor span: of the logarithms, or of the readings, where it has these."""
    spread = factor.distribution
    if isinstance(spread, Reading):
        return len(np.unique(values)) / len(spread.names)
    u = np.linspace(0, 1, 2001)
    ends = np.interp([values.min(), values.max()], spread.quantile(u), u)
    return float(ends[1] - ends[0])


def open_section() -> Section:
    """What is searched, and what is not."""
    laws: dict[str, list[str]] = {}
    known = {factor.name: factor for law in LAWS for factor in factors_of(law, "SS")}
    for law in LAWS:
        for factor in FACTORS[law]:
            laws.setdefault(factor.name, []).append(law)
    rows = tuple(
        (name, ", ".join(laws.get(name, ["all, in the second scenario"])), _words(factor)) for name, factor in known.items()
    )
    return Section(
        "What is open",
        (
            Paragraph(
                "The ranges are those of the card of a1; a number known by its order of magnitude only is spread over "
                "its logarithm. Where two laws have a number of one name, it is the same for both. The horizon, 5 to "
                "30 s, needs no run of its own: a run gives RMSE at every time."
            ),
            Table(
                "open",
                "What the paper leaves open, and over what it is searched and drawn.",
                (Column("number or reading"), Column("of"), Column("over")),
                rows,
                ("RMSE is (43) over samples every 10 ms.",),
            ),
            Paragraph("Taken as given, though the paper does not state it:"),
            Itemize(
                (
                    "the plus in (33): with the minus that is printed the gain turns negative and the path is lost (a1);",
                    "exact measurements for PID: beside observer (10), which is slower than its poles, most of its runs "
                    "diverge;",
                    "no limit of torques, no noise, no sampling; the sample time of (43); zero derivatives of the "
                    "square wave.",
                )
            ),
        ),
    )


def _words(factor: Factor) -> str:
    words = factor.distribution.words()
    return f"share of the card's own: {words}" if factor.share else words


def said(one: Fit, square: bool) -> str:
    """The numbers of a fit in words."""
    parts = []
    for factor in factors_of(one.law, "SS" if square else "FS"):
        value, spread = one.numbers[factor.name], factor.distribution
        shown = spread.names[round(value)] if isinstance(spread, Reading) else f"{value:.4g}"
        parts.append(f"{factor.name} {shown}")
    return ", ".join(parts)


def fits_section(found: Mapping[str, Found]) -> Section:
    """The nearest fit of each cell, and of the cells of a law together."""
    cells: list[tuple[Cell, ...]] = []
    for target in CELLS:
        ((scenario, (joint,)),) = TARGETS[target].items()
        for law in LAWS:
            one = found[law].fits[target]
            cells.append(
                (
                    target,
                    law,
                    f"{PUBLISHED[scenario, joint].values[law]:.4f}",
                    *_value(one, scenario, joint),
                    f"{one.horizon[scenario]:.2f}",
                    *_counts(found[law], target),
                    said(one, scenario == "SS"),
                )
            )
    columns = (
        Column("cell"),
        Column("law"),
        Column("printed", "rad", "right"),
        Column("nearest", "rad", "right"),
        Column("off", "%", "right"),
        Column("horizon", "s", "right"),
        Column("of draws", align="right"),
        Column("of search", align="right"),
        Column("its numbers"),
    )
    return Section(
        "The nearest fits",
        (
            Paragraph(
                f"A search for each law looks at {EVALUATIONS} choices, by differential evolution, for one set of "
                "gains that brings both rows of the law near the printed ones, each at its own horizon. The rivals that "
                "switch are searched as a computer with an implicit relay runs them every 2 ms, which does what the "
                "boundary layer does whatever the gain. The nearest points are then run again in continuous time, with "
                f"the boundary layer of the paper, at {1e3 * FINE:.3g} ms and at half of it. What stands here are "
                "these runs; only they are called fits."
            ),
            Table(
                "cells",
                "The 24 printed cells: the nearest that was found, by how much it is off, how many choices come within "
                "1 %, and its numbers.",
                columns,
                tuple(cells),
                (
                    f"of draws: within 1 % at some horizon, of {RANDOM.runs} independent draws of everything. of search: "
                    f"the same of the {EVALUATIONS} points of the search, which are not independent.",
                    "In brackets the change from the step to half of it.",
                ),
            ),
            _together(found),
        ),
    )


def _value(one: Fit, scenario: str, joint: int) -> tuple[Cell, Cell]:
    value, error = (float(part[scenario][joint - 1]) for part in (one.values, one.errors))
    printed = PUBLISHED[scenario, joint].values[one.law]
    if not np.isfinite([value, error]).all():
        return "diverged", None
    return Measured(value, abs(error)), f"{100 * (value / printed - 1):+.2f}"


def _counts(found: Found, target: str) -> tuple[Cell, Cell]:
    return tuple(f"{int((part[target] <= CLOSE).sum())}" for part in (found.drawn, found.sought))  # type: ignore[return-value]


def _together(found: Mapping[str, Found]) -> Table:
    """Rows and all four cells of a law."""
    rows: list[tuple[Cell, ...]] = []
    for target in ("FS", "SS", "both"):
        for law in LAWS:
            one = found[law].fits[target]
            horizons = " and ".join(f"{T:.2f}" for T in one.horizon.values())
            words = said(one, target != "FS")
            rows.append((target, law, f"{100 * one.miss:.2f}", horizons, *_counts(found[law], target), words))
    columns = (
        Column("cells"),
        Column("law"),
        Column("largest miss", "%", "right"),
        Column("horizon", "s", "right"),
        Column("of draws", align="right"),
        Column("of search", align="right"),
        Column("its numbers"),
    )
    return Table(
        "together",
        "Cells that are to be met by one choice: both joints of a scenario, and all four cells of a law.",
        columns,
        tuple(rows),
        ("The miss includes the change from the step to half of it.",),
    )


def counts_section(found: Mapping[str, Found]) -> Section:
    """What the choices that fit have in common."""
    rows: list[tuple[Cell, ...]] = []
    for law in LAWS:
        for i, factor in enumerate(factors_of(law, "SS")):
            row: list[Cell] = [law, factor.name, _words(factor)]
            for target in ("FS", "both"):
                close = found[law].close[target]
                square = factor in SQUARE and target == "FS"
                row.append(None if square or not len(close) else _range(factor, close[:, i]))
            rows.append(tuple(row))
    return Section(
        "What the choices that fit have in common",
        (
            Paragraph(
                "A number is determined by the tables if all choices that meet them have nearly the same. These are "
                "the least and the largest value among the choices, of draws and search together, that come within 1 % "
                "of both joints of the first scenario, and of all four cells of the law. As they are what was found, "
                "the true ranges are wider."
            ),
            Table(
                "spread",
                "The spread of each number among the choices within 1 %.",
                (
                    Column("law"),
                    Column("number or reading"),
                    Column("searched over"),
                    Column("first scenario"),
                    Column("all four cells"),
                ),
                tuple(rows),
                ("At the steps of the search. Empty: there is no such choice, or the scenario has no such number.",),
            ),
        ),
    )


def _range(factor: Factor, values: Array) -> str:
    if isinstance(factor.distribution, Reading):
        return " or ".join(factor.distribution.names[int(place)] for place in np.unique(values))
    return f"{values.min():.3g} to {values.max():.3g}"


def trust_section(results: Results, found: Mapping[str, Found]) -> Section:
    """Steps, their errors, and failed runs."""
    rows: list[tuple[Cell, ...]] = []
    for law in LAWS:
        tuned = results.tuned(slug("search", law))
        for scenario in SCENARIOS:
            random, check = (results.sample(slug(kind, law, scenario)) for kind in ("random", "check"))
            change = [random.step_error("RMSE (43)", joint) for joint in (0, 1)]
            fine = [check.step_error("RMSE (43)", joint) for joint in (0, 1)]
            failed = int(np.isfinite(tuned.samples[scenario.lower()].diverged_at).sum())
            rows.append(
                (
                    scenario,
                    law,
                    f"{1e3 * random.h:g}",
                    f"{random.failed} of {len(random)}",
                    f"{failed} of {EVALUATIONS}",
                    f"{max(change):.1e}",
                    f"{check.failed} of {len(check)}",
                    f"{max(fine):.1e}",
                )
            )
    columns = (
        Column("scenario"),
        Column("law"),
        Column("step", "ms", "right"),
        Column("draws that diverged", align="right"),
        Column("of the search", align="right"),
        Column("step error of draws", "rad", "right"),
        Column("checks that diverged", align="right"),
        Column("step error of checks", "rad", "right"),
    )
    return Section(
        "How far these numbers can be trusted",
        (
            Paragraph(
                "The error of the step is the largest change of RMSE at 30 s from the step to half of it, over one draw "
                "of 32, and over all checks. Of a rival that switches by a computer it is that of the motion between two "
                "instants; how far the computer is from the boundary layer show the checks. The chattering of a "
                "boundary layer makes every method one of first order: the change tells the size of the error, and "
                "bounds nothing. A choice whose run diverged is no fit, and is counted."
            ),
            Table("steps", "Steps, their errors, and runs that diverged.", columns, tuple(rows)),
        ),
    )
