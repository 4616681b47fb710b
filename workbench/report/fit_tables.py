"""The tables of a fit: its sensors, its numbers, the tests of its residuals, and what another experiment brings."""

from __future__ import annotations

import math
from typing import Literal

from workbench.identification.summaries.fit_summary import FitSummary
from workbench.identification.summaries.summary_parts import NumberSummary
from workbench.study.document.document import Cell, MissingCell, ReportTable, TableColumn
from workbench.study.document.phrases_and_tables import superscript_powers

RIGHT: Literal["right"] = "right"
UNKNOWN_UNIT = "?"


def sensors_table(fit: FitSummary, name: str) -> ReportTable:
    """A row for each sensor: its residuals on the fit and on the hold-out, and its noise."""
    unit = "its stated noise" if fit.is_noise_known else "its spread"
    columns = (
        TableColumn("sensor"),
        TableColumn("unit"),
        TableColumn("root mean square", align=RIGHT, digits=3),
        TableColumn("noise", align=RIGHT, digits=3),
        TableColumn(f"over {unit}", align=RIGHT, digits=3),
        TableColumn("hold-out / fit", align=RIGHT, digits=3),
        TableColumn("samples", align=RIGHT),
        TableColumn("held out", align=RIGHT),
    )
    rows = tuple(
        (
            one.name,
            unit_text(one.unit),
            one.root_mean_square,
            one.noise,
            one.misfit,
            MissingCell("none") if math.isnan(one.hold_out) else one.hold_out,
            one.count,
            one.hold_out_count,
        )
        for one in fit.sensors
    )
    noise = "stated" if fit.is_noise_known else "estimated from the residuals"
    note = f"Root mean square: that of model less sample, on the fit. Noise: its standard deviation, {noise}."
    return ReportTable(name, "The residuals of each sensor.", columns, rows, (note,))


def estimates_table(fit: FitSummary, name: str) -> ReportTable:
    """A row for each number, with its standard error and its intervals of 95 %."""
    columns = (
        TableColumn("number"),
        TableColumn("unit"),
        TableColumn("start", align=RIGHT),
        TableColumn("estimate", align=RIGHT, digits=5),
        TableColumn("standard error", align=RIGHT, digits=2),
        *_ends(""),
    )
    rows = tuple(
        (one.name, unit_text(one.unit), one.start, one.estimate, one.error, one.low, one.high) for one in fit.numbers
    )
    noise = "stated" if fit.is_noise_known else "estimated"
    searches = f"{fit.agreeing} of {fit.starts} searches" if fit.starts > 1 else "One search"
    note = (
        f"From and to: 95 % interval for outputs that are linear in the numbers, and white noise that is {noise}. "
        f"{searches} ended in this minimum, by {fit.shooting}; {fit.certificate.reason}."
    )
    return ReportTable(name, "The estimated numbers.", columns, rows, (note,))


def intervals_table(fit: FitSummary, name: str) -> ReportTable:
    """A row for each number, with its interval by each of the methods that were computed."""
    profiles = {one.name: one for one in fit.profiles}
    draws = None if fit.bootstrap is None else fit.bootstrap.intervals()
    columns = [TableColumn("number"), TableColumn("unit"), *_ends("linear ")]
    columns += [*(_ends("profile ") if profiles else ()), *(_ends("bootstrap ") if draws else ())]
    rows = []
    for number in fit.numbers:
        row: list[Cell] = [number.name, unit_text(number.unit), number.low, number.high]
        if profiles:
            profile = profiles.get(number.name)
            row += [None, None] if profile is None else [_end(end) for end in profile.interval]
        if draws:
            row += [_end(end) for end in draws[number.name]]
        rows.append(tuple(row))
    return ReportTable(name, "Intervals of the numbers.", tuple(columns), tuple(rows), _notes(fit))


def _ends(kind: str) -> tuple[TableColumn, ...]:
    return tuple(TableColumn(f"{kind}{end}", align=RIGHT, digits=5) for end in ("from", "to"))


def _notes(fit: FitSummary) -> tuple[str, ...]:
    notes = ["Linear: 95 % interval from the standard error."]
    if levels := {one.level for one in fit.profiles}:
        notes.append(f"Profile: {_levels(levels)} interval of the profile likelihood.")
    if fit.bootstrap is not None:
        failed = f"; {100 * fit.bootstrap.share_failed:.2g} % of the fits failed" if fit.bootstrap.share_failed else ""
        notes.append(
            f"Bootstrap: 95 % interval of {len(fit.bootstrap.draws)} fits to logs with {fit.bootstrap.kind} noise "
            f"drawn anew{failed}."
        )
    return tuple(notes)


def _levels(levels: set[float]) -> str:
    return " and ".join(f"{100 * level:g} %" for level in sorted(levels))


def tests_table(fit: FitSummary, name: str) -> ReportTable:
    """A row for each test of the residuals."""
    columns = (
        TableColumn("residual"),
        TableColumn("test"),
        TableColumn("statistic", align=RIGHT, digits=3),
        TableColumn("degrees of freedom", align=RIGHT),
        TableColumn("p-value", align=RIGHT, digits=2),
        TableColumn("passed"),
    )
    rows = tuple((one.about, one.kind, one.statistic, one.degrees, one.p_value, one.is_passed) for one in fit.tests)
    note = (
        "Whiteness: residuals do not tell later ones (Ljung and Box). Dependence: past values of an input do not tell "
        "residuals. A perfect model has a p-value below 0.01, and fails, in one of a hundred tests."
    )
    return ReportTable(name, "Tests of the residuals.", columns, rows, (note,))


def next_table(fit: FitSummary, name: str) -> ReportTable:
    """A row for each number: its standard error now, after the same experiments once more, and after the plan."""
    plan = fit.plan
    columns = [
        TableColumn("number"),
        TableColumn("unit"),
        TableColumn("error now", align=RIGHT, digits=2),
        TableColumn("the same once more", align=RIGHT, digits=2),
    ]
    if plan is not None:
        columns += [
            TableColumn("the plan alone", align=RIGHT, digits=2),
            TableColumn("plan / now", align=RIGHT, digits=2),
        ]
    rows = []
    for number in fit.numbers:
        row: list[Cell] = [number.name, unit_text(number.unit), number.error, number.repeated_error]
        if plan is not None:
            row += _planned(number, plan.errors)
        rows.append(tuple(row))
    notes = ["The same once more: the experiments of this log run again, and all data fitted together."]
    if plan is not None:
        notes.append(
            f"The plan: the designed experiment of {plan.duration:g} s by itself, with what it leaves out known. A "
            "dash is a number that it does not estimate."
        )
    return ReportTable(name, "Standard errors to be expected.", tuple(columns), tuple(rows), tuple(notes))


def _planned(number: NumberSummary, errors: dict[str, float]) -> list[Cell]:
    if number.name not in errors:
        return [None, None]
    return [errors[number.name], errors[number.name] / number.error if number.error else None]


def _end(value: float) -> Cell:
    """An end of an interval: one that is infinite is open, and one that is NaN is not known."""
    if math.isfinite(value):
        return value
    return MissingCell("not known" if math.isnan(value) else "open")


def unit_text(unit: str) -> str:
    """A unit for the cell of a table."""
    return "1" if unit in ("", "1") else "unknown" if unit == UNKNOWN_UNIT else superscript_powers(unit)
