"""The fits of a6 as tables: cell by cell, together, and what they have in common."""

from collections.abc import Mapping

import numpy as np

from studies.a6_unstated_choices.draws import RANDOM, factors_of
from studies.a6_unstated_choices.fits import CLOSE, EVALUATIONS, FINE, SECOND, SEED, TARGETS, Fit
from studies.a6_unstated_choices.loops import PROPOSED, SQUARE, Reading
from studies.a6_unstated_choices.results import Found, said, words
from studies.paper.card import LAWS, PUBLISHED
from workbench.study.document.document import Cell, Column, Measured, Paragraph, Section, Table
from workbench.study.uncertainty.factors import Factor
from workbench.validation.refusals import Array

CELLS = tuple(target for target in TARGETS if "q" in target)
COUNTED = (
    Column("horizon", "s", "right"),
    Column("of draws", align="right"),
    Column("of search", align="right"),
)


def fits_section(found: Mapping[str, Found]) -> Section:
    """The nearest fit of each cell, and of the cells of a law together."""
    return Section(
        "The nearest fits",
        (
            Paragraph(
                f"A search for each law looks at {EVALUATIONS} choices, by differential evolution (seed {SEED}), for "
                "one set of gains that brings both rows of the law near the printed ones, each at its own horizon; for "
                f"{PROPOSED}, which has the most readings, there are two (seeds {SEED} and {SECOND}; the second was "
                "picked by hand: of 0 to 5, 4 and 5 alone come within 1 % of the four cells at the step of the search, "
                "4 to 0.10 % and 5 to 0.11 %; the other four miss by 3.4 to 6.4 %). "
                "The rivals that switch are searched as a computer with an implicit relay runs them every 2 ms, which "
                "does what the boundary layer does whatever the gain. The nearest points, and some from the whole "
                "course of the search that are within 0.5 %, are then run again in "
                f"continuous time, with the boundary layer of the paper, at {1e3 * FINE:.3g} ms and at half of it. "
                "What stands here are these runs; only they are called fits. Where a gain has grown so large that this "
                "step is beyond the stability limit of the layer, the change to half of it is large, and counts "
                "against the fit."
            ),
            _cells(found),
            _together(found),
            _numbers(found),
        ),
    )


def _cells(found: Mapping[str, Found]) -> Table:
    rows: list[tuple[Cell, ...]] = []
    for target in CELLS:
        ((scenario, (joint,)),) = TARGETS[target].items()
        for law in LAWS:
            one, printed = found[law].fits[target], PUBLISHED[scenario, joint].values[law]
            value, horizon = _value(one, scenario, joint), f"{one.horizon[scenario]:.1f}"
            rows.append((target, law, f"{printed:.4f}", *value, horizon, *_counts(found[law], target)))
    columns = (
        Column("cell"),
        Column("law"),
        Column("printed", "rad", "right"),
        Column("nearest", "rad", "right"),
        Column("off", "%", "right"),
        *COUNTED,
    )
    return Table(
        "cells",
        "The 24 printed cells: the nearest that was found, by how much it is off, and how many choices come "
        "within 1 %.",
        columns,
        tuple(rows),
        (
            f"Of draws: within 1 % at some horizon, of {RANDOM.runs} independent draws of everything. Of search: the "
            f"same of the points of the search, {EVALUATIONS} each, which are not independent.",
        ),
    )


def _numbers(found: Mapping[str, Found]) -> Table:
    """What all fits are made of."""
    rows = []
    for target, met in TARGETS.items():
        for law in LAWS:
            rows.append((target, law, said(found[law].fits[target], square="SS" in met)))
    return Table(
        "numbers",
        "The numbers and readings of these fits.",
        (Column("cells"), Column("law"), Column("numbers and readings")),
        tuple(rows),
        ("With them the horizons of the tables before.",),
    )


def _value(one: Fit, scenario: str, joint: int) -> tuple[Cell, Cell]:
    value, error = (float(part[scenario][joint - 1]) for part in (one.values, one.errors))
    printed = PUBLISHED[scenario, joint].values[one.law]
    if not np.isfinite([value, error]).all():
        return "diverged", None
    return Measured(value, abs(error)), f"{100 * (value / printed - 1):+.2f}"


def _counts(found: Found, target: str) -> tuple[Cell, Cell]:
    drawn, sought = (f"{int((part[target] <= CLOSE).sum())}" for part in (found.drawn, found.sought))
    return drawn, sought


def _together(found: Mapping[str, Found]) -> Table:
    """Rows and all four cells of a law."""
    rows: list[tuple[Cell, ...]] = []
    for target in ("FS", "SS", "both"):
        for law in LAWS:
            one = found[law].fits[target]
            horizons = " and ".join(f"{T:.1f}" for T in one.horizon.values())
            rows.append((target, law, f"{100 * one.miss:.2f}", horizons, *_counts(found[law], target)))
    columns = (
        Column("cells"),
        Column("law"),
        Column("largest miss", "%", "right"),
        *COUNTED,
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
            row: list[Cell] = [law, factor.name, words(factor)]
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
