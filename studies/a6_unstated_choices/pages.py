"""The page of a6: pictures and answers, the rankings, the nearest fits, what is open, and how far to trust it."""

from collections.abc import Mapping, Sequence

import numpy as np

from studies.a6_unstated_choices import findings, fits, ranking
from studies.a6_unstated_choices.draws import RANDOM, SHORTEST, named, slug
from studies.a6_unstated_choices.fits import CLOSE, EVALUATIONS, FINE, SECOND, SEED, TARGETS, Fits
from studies.a6_unstated_choices.loops import PROPOSED, SCENARIOS, SQUARE, STIFF, Reading, factors_of, unit
from studies.a6_unstated_choices.one_experiment import AMPLITUDES, FREQUENCY, Shared, shared
from studies.paper.card import LAWS, PUBLISHED
from workbench.study.document.document import Cell, Column, Itemize, Measured, Paragraph, Section, Table
from workbench.study.document.phrases import raised
from workbench.study.study import Results
from workbench.study.uncertainty.factors import Factor

COUNTED = (Column("horizon", "s", "right"), Column("of draws", align="right"), Column("of search", align="right"))


def sections(results: Results) -> Sequence[Section]:
    """The report."""
    every, one = ranking.ranked(results), shared(results)
    met = {law: fits.fits_of(results, law) for law in LAWS}
    pictures = (
        ranking.ranks_figure(results, every["of the card"]),
        ranking.deciding_figure(results, ranking.indices(results)),
    )
    return (
        Section("What was found", (*pictures, *findings.findings(results))),
        Section("The rankings under four priors", (RANKING, priors_table(every))),
        Section("The nearest fits", (FITTING, cells(met), together(met), numbers(met), shared_table(one))),
        Section("What the choices that fit have in common", (spread(met),)),
        open_section(results),
        trust_section(results),
    )


def headlines(results: Results) -> Sequence[str]:
    """The findings in a line each."""
    return tuple(f"{one.kind}: {one.statement}" for one in findings.findings(results))


RANKING = Paragraph(
    f"Independent draws of everything at once, {RANDOM.runs} for each prior: all readings alike, the same horizon "
    "and the same square wave for the six laws of a draw. A range is no prior: within it a number can be drawn "
    "evenly, or evenly on a logarithmic scale. The prior of the card does the second with Q, R and l of "
    f"{PROPOSED} alone, which are known by their order of magnitude, and the first with all other numbers; "
    "'exchanged' does the opposite. (sigma of RBF-ASMC, whose range begins at 0, is always drawn evenly.) New runs "
    "are made for each prior. A run that diverged before its horizon is worse than any other."
)
FITTING = Paragraph(
    f"A search for each law looks at {EVALUATIONS} choices, by differential evolution (seed {SEED}), for one set of "
    "gains that brings both rows of the law near the printed ones, each at its own horizon; for "
    f"{PROPOSED}, which has the most readings, there are two (seeds {SEED} and {SECOND}; the second was picked by "
    "hand: of 0 to 5, 4 and 5 alone come within 1 % of the four cells at the step of the search, 4 to 0.10 % and 5 to "
    "0.11 %; the other four miss by 3.4 to 6.4 %). The rivals that switch are searched as a computer with an implicit "
    "relay runs them every 2 ms, which does what the boundary layer does whatever the gain. The nearest points, and "
    "some from the whole course of the search that are within 0.5 %, are then run again in continuous time, with the "
    f"boundary layer of the paper, at {1e3 * FINE:.3g} ms and at half of it; only these runs are called fits, and the "
    "change to half of the step counts against them."
)


def priors_table(every: ranking.Ranked) -> Table:
    """Of a hundred draws how many have the proposed law below each rival, and first, by column and prior."""
    rows: list[tuple[Cell, ...]] = []
    for rival in (*LAWS[1:], None):
        for column, title in ranking.COLUMNS.items():
            parts = [ranking.ahead(columns[column], rival) for columns in every.values()]
            shown = (f"{100 * value:.0f} ({100 * low:.0f} to {100 * high:.0f})" for value, low, high in parts)
            words = "first" if rival is None else f"below {rival}"
            rows.append((f"{PROPOSED} {words}", title, *shown, ranking.majority(parts)))
    return Table(
        "priors",
        f"Of a hundred draws how many have {PROPOSED} below a rival, or first, under four priors.",
        (Column("is"), Column("column"), *(Column(name, "%", "right") for name in every), Column("in most draws")),
        tuple(rows),
        (f"In brackets {ranking.INTERVALS}; one question has four lines. Seed {RANDOM.seed}.",),
    )


def cells(every: Mapping[str, Fits]) -> Table:
    """The nearest fit of each printed cell by itself."""
    rows: list[tuple[Cell, ...]] = []
    for target in fits.CELLS:
        ((scenario, (joint,)),) = TARGETS[target].items()
        for law in LAWS:
            one, printed = every[law].fits[target], PUBLISHED[scenario, joint].values[law]
            value, error = (float(part[scenario][joint - 1]) for part in (one.values, one.errors))
            met: tuple[Cell, ...] = ("diverged", None)
            if np.isfinite([value, error]).all():
                met = (Measured(value, abs(error)), f"{100 * (value / printed - 1):+.2f}")
            rows.append(
                (target, law, f"{printed:.4f}", *met, f"{one.horizon[scenario]:.1f}", *_counts(every, law, target))
            )
    sizes = (Column(name, of, "right") for name, of in (("printed", "rad"), ("nearest", "rad"), ("off", "%")))
    return Table(
        "cells",
        "The 24 printed cells: the nearest that was found, by how much it is off, and how many choices come "
        "within 1 %.",
        (Column("cell"), Column("law"), *sizes, *COUNTED),
        tuple(rows),
        (
            f"Of draws: within 1 % at some horizon, of {RANDOM.runs} independent draws of everything. Of search: the "
            f"same of the points of the search, {EVALUATIONS} each, which are not independent.",
        ),
    )


def _counts(every: Mapping[str, Fits], law: str, target: str) -> tuple[str, ...]:
    """The counts of draws and of searched points within 1 % of a target."""
    return tuple(f"{(part[target] <= CLOSE).sum()}" for part in (every[law].drawn, every[law].sought))


def together(every: Mapping[str, Fits]) -> Table:
    """The nearest fit of the rows and of all four cells of a law."""
    rows: list[tuple[Cell, ...]] = []
    for target in ("FS", "SS", "both"):
        for law in LAWS:
            one = every[law].fits[target]
            times = " and ".join(f"{T:.1f}" for T in one.horizon.values())
            rows.append((target, law, f"{100 * one.miss:.2f}", times, *_counts(every, law, target)))
    return Table(
        "together",
        "Cells that are to be met by one choice: both joints of a scenario, and all four cells of a law.",
        (Column("cells"), Column("law"), Column("largest miss", "%", "right"), *COUNTED),
        tuple(rows),
    )


def numbers(every: Mapping[str, Fits]) -> Table:
    """The choices that the fits are made of."""
    rows = [(t, law, findings.fit_words(law, t, every[law].fits[t].numbers)) for t in TARGETS for law in LAWS]
    return Table(
        "numbers",
        "The numbers and readings of these fits.",
        (Column("cells"), Column("law"), Column("numbers and readings")),
        tuple(rows),
    )


def shared_table(one: Shared) -> Table:
    """The numbers of each law in the one experiment."""
    return Table(
        "shared",
        "One experiment for the second scenario: by how much the rows of the laws are off, and with which numbers.",
        (Column("law"), Column("larger miss", "%", "right"), Column("numbers and readings")),
        tuple((law, f"{100 * one.miss[law]:.2f}", one.numbers[law]) for law in LAWS),
        (f"a1 {AMPLITUDES[0]:g} rad, a2 {AMPLITUDES[1]:g} rad, f {FREQUENCY:g} Hz, horizon {one.horizon:.1f} s.",),
    )


def spread(every: Mapping[str, Fits]) -> Table:
    """The range of each number among the choices that fit."""
    rows: list[tuple[Cell, ...]] = []
    for law in LAWS:
        for i, factor in enumerate(factors_of(law, "SS")):
            row: list[Cell] = []
            for target in ("FS", "both"):
                values = every[law].close[target][:, i]
                if not len(values) or (factor in SQUARE and target == "FS"):
                    row.append(None)
                elif isinstance(factor.distribution, Reading):
                    row.append(" or ".join(factor.distribution.names[int(place)] for place in np.unique(values)))
                else:
                    row.append(f"{values.min():.3g} to {values.max():.3g}")
            rows.append((law, factor.name, words(factor), *row))
    heads = ("law", "number or reading", "searched over", "first scenario", "all four cells")
    return Table(
        "spread",
        "The least and the largest value of each number among the choices, of draws and search together, that come "
        "within 1 % of both joints of the first scenario, and of all four cells of the law.",
        tuple(map(Column, heads)),
        tuple(rows),
        (
            "At the steps of the search; the true ranges are wider. Empty: no such choice, or the scenario has "
            "no such number.",
        ),
    )


def words(factor: Factor) -> str:
    """The range of a factor."""
    spread = factor.distribution.words()
    return f"share of the card's own: {spread}" if factor.share else spread


def open_section(results: Results) -> Section:
    """The numbers that are searched, and those that are not."""
    laws: dict[str, list[str]] = {}
    rows: dict[str, tuple[Cell, ...]] = {}
    for law in LAWS:
        for factor in factors_of(law, "SS"):
            laws.setdefault(factor.name, []).append(law)
            of = "all, in the second scenario" if factor in SQUARE else ", ".join(laws[factor.name])
            rows[factor.name] = (factor.name, of, words(factor), raised(unit(law, factor)) or None)
    minus, beside = results.sample("minus"), results.sample("observed_pid")
    off = float(fits.nearest(PROPOSED, "FS", {"FS": minus}).min())
    return Section(
        "What is open",
        (
            Table(
                "open",
                "What the paper leaves open, and over what it is searched and drawn: the ranges of the card of a1.",
                (Column("number or reading"), Column("of"), Column("over"), Column("unit")),
                tuple(rows.values()),
                (f"And the horizon, {SHORTEST} to 30 s. RMSE is (43) over samples every 10 ms.",),
            ),
            Paragraph("Taken as given, though the paper does not state it:"),
            Itemize(
                (
                    f"R from {STIFF:g} on instead of the card's 0.001: below, (34) falls from P(0) so fast, at 720 / R "
                    "1/s, that a run at 1 ms diverges by its step alone;",
                    f"the plus in (33): with the minus that is printed {minus.failed} of {len(minus)} draws of the "
                    f"rest diverge, and the nearest of the others is off the printed row by {100 * off:.2g} %; no "
                    "search was made with the minus, so the shares leave it out;",
                    f"exact measurements for PID: beside observer (10) {beside.failed} of {len(beside)} draws diverge;",
                    "no limit of torques, no noise, no sampling; the sample time of (43); zero derivatives of the "
                    "square wave.",
                )
            ),
        ),
    )


def trust_section(results: Results) -> Section:
    """Steps, their errors, and failed runs."""
    rows: list[tuple[Cell, ...]] = []
    for law in LAWS:
        tuned = results.tuned(slug("search", law))
        for scenario in SCENARIOS:
            random, check = (
                results.sample(name) for name in (named("random", law, scenario), slug("check", law, scenario))
            )
            change, fine = (max(one.step_error("RMSE (43)", joint) for joint in (0, 1)) for one in (random, check))
            failed = int(np.isfinite(tuned.samples[scenario.lower()].diverged_at).sum())
            lost = (f"{random.failed} of {len(random)}", f"{failed} of {tuned.tuning.size}")
            rows.append((scenario, law, f"{1e3 * random.h:g}", *lost, change, f"{check.failed} of {len(check)}", fine))
    columns = (
        Column("scenario"),
        Column("law"),
        Column("step", "ms", "right"),
        Column("draws that diverged", align="right"),
        Column("of the search", align="right"),
        Column("step error of draws", "rad", "right", digits=2),
        Column("checks that diverged", align="right"),
        Column("step error of checks", "rad", "right", digits=2),
    )
    return Section(
        "How far these numbers can be trusted",
        (
            Paragraph(
                "The error of the step is the largest change of RMSE at 30 s from the step to half of it, over one "
                "draw of 32, and over all checks. Of a rival that switches by a computer it is that of the motion "
                "between two instants; how far the computer is from the boundary layer the checks show. The chattering "
                "of a boundary layer makes every method one of first order: the change tells the size of the error and "
                "bounds nothing. Counted here is every run that diverges within 30 s; one that does so later than the "
                "horizon of its draw has its RMSE there."
            ),
            Table("steps", "Steps, their errors, and runs that diverged.", columns, tuple(rows)),
        ),
    )
