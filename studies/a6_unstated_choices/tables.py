"""The tables and the figure of a6 on rankings, fits and what is open."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

import workbench as wb
from studies.a6_unstated_choices import fits, loops
from studies.a6_unstated_choices.draws import LIMIT, LIMITED_DESIGN, OF_CARD, PRIORS, RANDOM, rmse_by_law, sweep_name
from studies.a6_unstated_choices.experiments import AMPLITUDES, FREQUENCY, Experiment
from studies.a6_unstated_choices.findings import fit_words
from studies.a6_unstated_choices.fits import Fit
from studies.a6_unstated_choices.loops import PROPOSED_LAW, SCENARIOS, slug
from studies.a6_unstated_choices.ranking import LIMITS, ends, most, shares_of
from studies.a6_unstated_choices.rows import FIXED_READINGS, Row
from studies.a6_unstated_choices.scope import OMITTED_CHOICES
from studies.a6_unstated_choices.shares import COLUMNS, RIVALS, Cell, Cells, Rerun
from studies.paper import unstated_choices
from studies.paper.card import LAWS, PUBLISHED_COLUMNS

Fits = Mapping[tuple[str, str], Fit]  # by law and target
COUNT_COLUMNS = (
    wb.document.TableColumn("of draws", align="right"),
    wb.document.TableColumn("of search", align="right"),
)


def ranks_figure(results: wb.Results, columns: Mapping[tuple[str, int], wb.evidence.Ranks]) -> wb.document.Figure:
    """The ranks of the laws in the four columns, a panel each."""
    lost = sum(int(columns[scenario, 1].samples.failures.sum()) for scenario in SCENARIOS)
    samples = [results.sample(sweep_name("random", law, scenario)) for law in LAWS for scenario in SCENARIOS]
    runs = sum(int(np.isfinite(sample.diverged_at).sum()) for sample in samples)
    note = (
        f"{RANDOM.runs} draws for each scenario, prior of the card, seed {RANDOM.seed}; {lost} runs diverge before the "
        f"horizon of their draw ({runs} within the longest horizon), and each counts as worse than any other"
    )
    caption = "How often each law has each rank by RMSE, over all unstated numbers and readings."
    one = {
        column: wb.pictures.rank_figure("ranks", caption, dict(zip(LAWS, each.ranks.value, strict=True)), note)
        for column, each in columns.items()
    }
    panels = tuple(replace(figure.panels[0], title=COLUMNS[column]) for column, figure in one.items())
    first = one["FS", 1]
    tables = {column: figure.numbers for column, figure in one.items() if figure.numbers is not None}
    rows = tuple((COLUMNS[column], *row) for column, table in tables.items() for row in table.rows)
    numbers = wb.document.ReportTable(
        "ranks", caption, (wb.document.TableColumn("column"), *tables["FS", 1].columns), rows
    )
    return replace(first, panels=panels, columns=2, numbers=numbers)


def below_table(every: Cells, limited_cells: Cells) -> wb.document.ReportTable:
    """The answer by column: least and largest share under the four priors."""
    rows = []
    for words, some in (("none", every), (f"{LIMIT[0]:g}, {LIMIT[1]:g} N m", limited_cells)):
        for rival in (*RIVALS, None):
            question = "first of six" if rival is None else f"below {rival}"
            shown = (f"{most(some, rival, at)}: {ends(shares_of(some, rival, at))}" for at in COLUMNS)
            rows.append((question, words, *shown))
    heads = (
        wb.document.TableColumn(f"{PROPOSED_LAW} is"),
        wb.document.TableColumn("torque limit"),
        *map(wb.document.TableColumn, COLUMNS.values()),
    )
    note = (
        "'yes' or 'no': the share and its interval are above or below one half under all four priors. 'mixed': above "
        "under one prior and below under another. 'undecided': an interval contains one half. The shares are the least "
        "and the largest of four priors."
    )
    return wb.document.ReportTable(
        "below",
        f"Is the RMSE of {PROPOSED_LAW} below the rival's in most draws? The answer by column.",
        heads,
        tuple(rows),
        (note,),
    )


def priors_table(every: Cells) -> wb.document.ReportTable:
    """The share of draws with the proposed law below each rival, and first, by column and prior."""
    rows = []
    for rival in (*RIVALS, None):
        words = f"{PROPOSED_LAW} first" if rival is None else f"{PROPOSED_LAW} below {rival}"
        for column, title in COLUMNS.items():
            shown = (
                f"{100 * one.value:.0f} ({100 * one.low:.0f} to {100 * one.high:.0f})"
                for one in shares_of(every, rival, column)
            )
            rows.append((words, title, *shown, most(every, rival, column)))
    return wb.document.ReportTable(
        "priors",
        f"Share of draws in which the RMSE of {PROPOSED_LAW} is below a rival's, or the smallest, under each prior.",
        (
            wb.document.TableColumn("event"),
            wb.document.TableColumn("column"),
            *(wb.document.TableColumn(name, "%", "right") for name in PRIORS),
            wb.document.TableColumn("in most draws"),
        ),
        tuple(rows),
        (
            f"In brackets is the interval; the sample of the first finding explains it. Seed {RANDOM.seed}; no torque "
            "limit.",
        ),
    )


def limits_table(results: wb.Results) -> wb.document.ReportTable:
    """The median RMSE of each law without and with a limit of the torques, prior of the card."""
    rows = []
    for law in LAWS:
        for (scenario, joint), title in COLUMNS.items():
            pair = []
            for kind in ("random", "limited"):
                values = rmse_by_law(results, kind, scenario, OF_CARD)[law][: LIMITED_DESIGN.runs, joint - 1]
                median = float(np.median(np.where(np.isnan(values), np.inf, values)))
                pair.append(f"{median:.3f}" if np.isfinite(median) else "diverged")
            rows.append((law, title, *pair))
    heads = (
        wb.document.TableColumn("law"),
        wb.document.TableColumn("column"),
        wb.document.TableColumn("no limit", "rad", "right"),
        wb.document.TableColumn("limit", "rad", "right"),
    )
    note = (
        f"{LIMITED_DESIGN.runs} draws, prior of the card; limit: {LIMITS}. 'diverged': at least half of the runs "
        "diverged."
    )
    return wb.document.ReportTable(
        "limits", "Median RMSE without and with a limit of the torques.", heads, tuple(rows), (note,)
    )


def step_table(again: Mapping[Cell, Rerun]) -> wb.document.ReportTable:
    """The draws that were run at half of the step too, by prior and column."""
    rows = []
    for cell, one in again.items():
        prior, column = cell
        rows.append(
            (prior, COLUMNS[column], len(one.errors), int(one.is_inaccurate.sum()), int(one.is_undecided.sum()))
        )
    heads = ("prior", "column", "repeated", "changed by over 1 %", "rank not known")
    columns = tuple(wb.document.TableColumn(head, align="right" if i > 1 else "left") for i, head in enumerate(heads))
    caption = f"The error of the step in the draws of {PROPOSED_LAW}, each at the horizon of the draw."
    return wb.document.ReportTable(
        "step", caption, columns, tuple(rows), ("Rank not known: a rival is nearer than the error of the step.",)
    )


def cells_table(law_fits: Fits) -> wb.document.ReportTable:
    """The nearest fit of each printed cell by itself."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for target in fits.CELLS:
        ((scenario, (joint,)),) = fits.TARGETS[target].items()
        for law in LAWS:
            one, printed = law_fits[law, target], PUBLISHED_COLUMNS[scenario, joint].values[law]
            value, error = (float(part[scenario][joint - 1]) for part in (one.values, one.errors))
            shown: tuple[wb.document.Cell, ...] = ("diverged", None)
            if np.isfinite([value, error]).all():
                shown = (wb.document.ValueWithError(value, abs(error)), f"{100 * (value / printed - 1):+.2f}")
            horizon = f"{one.horizon[scenario]:.1f}"
            rows.append((target, law, f"{printed:.4f}", *shown, horizon, one.of_draws, one.of_search))
    units = {"printed": "rad", "nearest": "rad", "off": "%", "horizon": "s"}
    return wb.document.ReportTable(
        "cells",
        "The 24 printed cells: the nearest fit, its distance, and the number of choices within 1 %.",
        (
            wb.document.TableColumn("cell"),
            wb.document.TableColumn("law"),
            *(wb.document.TableColumn(name, unit, "right") for name, unit in units.items()),
            *COUNT_COLUMNS,
        ),
        tuple(rows),
        (
            f"Of draws: the number of {RANDOM.runs} independent draws of everything that are within 1 % at some "
            f"horizon. Of search: the same number for the {fits.EVALUATIONS} points of each search, which are not "
            "independent.",
        ),
    )


def together(law_fits: Fits) -> wb.document.ReportTable:
    """The nearest fit of the rows and of all four cells of a law, and the choice that it is made of."""
    rows = []
    for target in ("FS", "SS", "both"):
        for law in LAWS:
            one = law_fits[law, target]
            times = " and ".join(f"{T:.1f}" for T in one.horizon.values())
            words = fit_words(law, target, one.numbers)
            rows.append((target, law, f"{100 * one.miss:.2f}", times, one.of_draws, one.of_search, words))
    heads = (
        wb.document.TableColumn("cells"),
        wb.document.TableColumn("law"),
        wb.document.TableColumn("largest miss", "%", "right"),
        wb.document.TableColumn("horizon", "s", "right"),
    )
    return wb.document.ReportTable(
        "together",
        "Cells met by one choice: both joints of a scenario, and all four cells of a law.",
        (*heads, *COUNT_COLUMNS, wb.document.TableColumn("numbers and readings")),
        tuple(rows),
    )


def nearest_table(every: Sequence[Row]) -> wb.document.ReportTable:
    """The nearest miss of each sign and shape of (33)."""
    shapes = list(dict.fromkeys(row.shape for row in every))
    by = {(row.sign, row.shape): row for row in every}
    rows = tuple((sign, *(f"{100 * by[sign, shape].fit.miss:.2g}" for shape in shapes)) for sign in FIXED_READINGS)
    heads = (
        wb.document.TableColumn("sign of (33)"),
        *(wb.document.TableColumn(shape, "%", "right") for shape in shapes),
    )
    caption = (
        f"The larger miss of the two printed cells of {PROPOSED_LAW} in the first scenario: the nearest by sign and "
        "shape."
    )
    return wb.document.ReportTable("row_nearest", caption, heads, rows)


def rows_table(every: Sequence[Row]) -> wb.document.ReportTable:
    """The nearest choice of each search."""
    rows = tuple(
        (
            row.sign,
            row.shape,
            f"{100 * row.fit.miss:.2g}",
            f"{row.fit.horizon['FS']:.1f}",
            ", ".join(row.repairs) or "none",
            row.fit.of_search,
            row.words,
        )
        for row in every
    )
    heads = (
        wb.document.TableColumn("sign"),
        wb.document.TableColumn("shape"),
        wb.document.TableColumn("miss", "%", "right"),
        wb.document.TableColumn("horizon", "s", "right"),
        wb.document.TableColumn("not as printed"),
        wb.document.TableColumn("within 1 %", align="right"),
        wb.document.TableColumn("numbers"),
    )
    caption = (
        "The choices with these misses, their readings that are not as printed, and the number of points of each "
        "search within 1 %."
    )
    return wb.document.ReportTable("rows", caption, heads, rows)


def experiment_table(name: str, one: Experiment) -> wb.document.ReportTable:
    """The miss of each law in one experiment, and its numbers."""
    wave = f"a1 {AMPLITUDES[0]:g} rad, a2 {AMPLITUDES[1]:g} rad, f {FREQUENCY:g} Hz, horizon {one.horizon:.1f} s"
    caption, note = {
        "common": ("One horizon for all laws in the first scenario.", f"Horizon {one.horizon:.1f} s."),
        "shared": ("One square wave and one horizon for all laws in the second scenario.", f"{wave}."),
    }[name]
    heads = (
        wb.document.TableColumn("law"),
        wb.document.TableColumn("larger miss", "%", "right"),
        wb.document.TableColumn("numbers and readings"),
    )
    rows = tuple((law, f"{100 * one.miss[law]:.2g}", one.numbers[law]) for law in LAWS)
    return wb.document.ReportTable(name, caption, heads, rows, (note,))


def omitted_table() -> wb.document.ReportTable:
    """The choices that no factor varies."""
    return unstated_choices.table("omitted", "Choices of a1 that this study does not vary.", OMITTED_CHOICES)


def open_table(law: str) -> wb.document.ReportTable:
    equations = loops.loop(law, "SS").ode()
    space = wb.uncertainty.Space(loops.factors_of(law, "SS"), equations.parameters, equations.states)
    return wb.uncertainty.factor_table(
        space,
        slug("open", law),
        f"The unstated numbers and readings of {law}; a1, a2 and f only in the second scenario.",
    )


def trust_table(results: wb.Results) -> wb.document.ReportTable:
    rows = []
    for law in LAWS:
        for scenario in SCENARIOS:
            kinds = sweep_name("random", law, scenario), slug("check", law, scenario)
            rows.append((scenario, law, *(results.sample(name).note_of("sampled RMSE") for name in kinds)))
    heads = tuple(map(wb.document.TableColumn, ("scenario", "law", "draws", "fits")))
    return wb.document.ReportTable("steps", "Steps, their errors at 30 s, and runs that diverged.", heads, tuple(rows))
