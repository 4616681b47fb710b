"""The data with which the page of a fit runs the fitted model again, along the log, at the numbers of its knobs."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import asdict, dataclass

import numpy as np

from workbench import __version__
from workbench.core import StepMap
from workbench.core.validation.refusals import Array
from workbench.identification.estimation.fit import Fit
from workbench.identification.estimation.unknown_numbers import UnknownNumber
from workbench.identification.summaries.compared_run import ComparedRun
from workbench.identification.summaries.fit_summary import FitSummary
from workbench.report.live.links import Curve
from workbench.report.live.live_data import FORMAT
from workbench.report.live.marches import Modules, evaluation, march, page_text, plain, switches
from workbench.report.live.page_data import LiveData, Plain
from workbench.report.pictures.fit_pictures import drawn_records, with_unit
from workbench.study.document.document import Cell, ReportTable, TableColumn
from workbench.study.document.phrases_and_tables import MissingCell, ValueWithError, superscript_powers

EVERY = "every"  # of all experiments, as the scripts call it
REACH = 2.0  # a knob of a positive number goes from half of it to twice as much
WIDE = 10.0  # half widths of its interval to which each knob goes at least
MOST_NUMBERS = 4_000_000  # of the records of a page, before they are packed: some 30 MB
EVEN = 1e-9  # of a log: the jitter below which its times are those of a clock


@dataclass(frozen=True, eq=False)
class LiveFit:
    """The live part of the page of a fit: its data, and the table of the errors that its knobs change."""

    data: LiveData
    table: ReportTable


def live_fit(fit: Fit, summary: FitSummary, name: str) -> LiveFit:
    """The live part of the page of a fit, whose figures and tables have names that begin with `name`.

    Raises
    ------
    ImportError
        If llvmlite, which compiles for a browser, is not here.
    ValueError
        If a browser cannot run the equations, or no number can be turned.
    """
    numbers = [(one, ends) for one in fit.model.numbers if (ends := _range(one, fit)) is not None]
    if not numbers:
        raise ValueError("No number of this fit can be turned: a delay moves the log itself.")
    page = _Page(fit, summary, [one for one, _ in numbers], Modules(), [])
    loops = [page.loop(e) for e in range(len(summary.experiments))]
    digests = "".join(str(loop["digest"]) for loop in loops)
    rows = {e: int(str(loop["rows"])) + 1 for e, loop in enumerate(loops)}
    table, cells = _errors_table(summary, loops, f"{name}_live")
    data: LiveData = {
        "format": FORMAT,
        "study": name,
        "version": __version__,
        "fingerprint": hashlib.sha256(digests.encode()).hexdigest()[:16],
        "python": "",
        "python_linear": "",
        "scenario": EVERY,
        "knobs": [_knob(fit, one, ends) for one, ends in numbers],
        "specifications": [],
        "loops": loops,
        "modules": list(page.modules.packed_modules.values()),
        "records": page.records,
        "curves": [
            asdict(Curve(f"{name}_outputs", panel, 0, e, "t", ("y", j), (0, rows[e]), (1.0, 1.0)))
            for panel, (e, j) in enumerate(drawn_records(summary))
        ],
        "cells": cells,
        "marks": [],
        "linear_marks": [],
        "refused": {},
    }
    return LiveFit(data, table)


@dataclass(frozen=True, eq=False)
class _Page:
    """A fit with the modules and the records of its page."""

    fit: Fit
    summary: FitSummary
    numbers: list[UnknownNumber]
    modules: Modules
    records: list[str]

    def loop(self, experiment: int) -> Plain:
        """An experiment as a browser runs it."""
        whole, half = (ComparedRun.of(self.fit, experiment, is_halved) for is_halved in (False, True))
        record, place = whole.step.recorded_numbers, len(self.records)
        assert record is not None  # as a compared run has them
        if (count := 3 * record.size) * len(self.summary.experiments) > MOST_NUMBERS:  # with those of half the step
            raise ValueError(
                f"Experiment '{self.summary.experiments[experiment].name}' has {count} recorded numbers, and a page "
                f"has room for {MOST_NUMBERS // len(self.summary.experiments)} of each: decimate the log."
            )
        times, until = whole.kept_times, float(whole.kept_times[-1])
        even = np.linspace(0.0, until, len(times))
        h = until / (whole.rows * whole.stride)
        marches = {"whole": self._march(whole.step, whole.stride, place) | {"h": h}}
        marches["half"] = self._march(half.step, 2 * whole.stride, place + 1) | {"h": h / 2}
        marches["outputs"] = self._march(evaluation(whole.step, whole.readings), 1, place)
        self.records.extend(
            page_text(np.ascontiguousarray(one.step.recorded_numbers).tobytes()) for one in (whole, half)
        )
        digest = hashlib.sha256(record.tobytes() + whole.p.tobytes() + whole.x0.tobytes()).hexdigest()
        return {
            "scenario": self.summary.experiments[experiment].name,
            "law": "model",
            "label": "model",
            "digest": digest[:16],
            "until": until,
            "every": until / whole.rows,
            "rows": whole.rows,
            "times": None if np.allclose(times, even, rtol=0, atol=EVEN * until) else plain(times),
            "p": plain(whole.p),
            "x0": plain(whole.x0),
            "moves": self._moves(whole),
            "seed": "0",
            "normals": 0,
            "switches": switches(self.fit.model.ode),
            "coarse": [],
            **marches,
            "drawing": None,
            "sensors": [with_unit(one.name, one.unit) for one in self.summary.sensors],
            **self._scores(whole, half),
            "linear": None,
            "linear_refused": "",
        }

    def _march(self, step: StepMap, stride: int, record: int) -> dict[str, object]:
        return march(step, stride, self.modules) | {"record": record, "recorded": int(step.rule.d.numel())}

    def _moves(self, run: ComparedRun) -> list[Plain]:
        """The place that each knob moves."""
        moves: list[Plain] = []
        for knob, number in enumerate(self.numbers):
            if place := run.places.get(number.name):
                at = {of: [place.place] if place.of == of else [] for of in ("p", "x")}
                moves.append({"knob": knob, **at, "names": []})
        return moves

    def _scores(self, whole: ComparedRun, half: ComparedRun) -> Plain:
        """The root mean squares as programs, and their values with their errors at the estimates."""
        values, finer = whole.root_mean_squares(), half.root_mean_squares()
        names = [one.name for one in self.summary.sensors]
        units = [superscript_powers(one.unit) or "1" for one in self.summary.sensors]
        metrics = [
            {"name": f"RMSE {part}", "units": units, "labels": names, "time": False, "program": program.plain()}
            for part, program in whole.programs.items()
        ]
        return {"metrics": metrics, "scores": [_pairs(values[part], finer[part]) for part in whole.programs]}


def _pairs(values: Array, finer: Array) -> list[list[float | str]]:
    """The values with their errors, for JSON."""
    return [plain([value, 2 * abs(value - half)]) for value, half in zip(values.tolist(), finer.tolist(), strict=True)]


def _range(number: UnknownNumber, fit: Fit) -> tuple[float, float, bool] | None:
    """The ends of a knob, and whether it moves by factors; None for a number that a page cannot turn."""
    if number.kind == "delay":
        return None
    value, half = fit.values[number.name], 0.0 if fit.is_exact else _half(fit, number.name)
    is_positive = value > 0 and number.low >= 0
    if is_positive and WIDE * half < value * (1 - 1 / REACH):
        low, high = value / REACH, value * REACH
    else:
        span = max(abs(value), WIDE * half) or 1.0
        low, high = (value / (2 * REACH) if is_positive else value - span), value + span
    low, high = max(low, number.low), min(high, number.high)
    return (low, high, is_positive and low > 0) if low < value < high else None


def _half(fit: Fit, name: str) -> float:
    low, high = fit.intervals()[name]
    return (high - low) / 2


def _knob(fit: Fit, number: UnknownNumber, ends: tuple[float, float, bool]) -> Plain:
    """A knob at the estimate, with its interval."""
    low, high, log = ends
    return {
        "name": number.name,
        "paths": (number.name,),
        "low": low,
        "high": high,
        "log": log,
        "origin": "",
        "share": False,
        "value": fit.values[number.name],
        "unit": superscript_powers(number.unit) if number.unit not in ("", "?") else "1",
        "interval": None if fit.is_exact else plain(np.clip(fit.intervals()[number.name], low, high)),
    }


def _errors_table(summary: FitSummary, loops: list[Plain], name: str) -> tuple[ReportTable, list[Plain]]:
    """The table of the errors of each record, and its live cells."""
    parts = list(dict.fromkeys(metric["name"] for loop in loops for metric in _metrics(loop)))
    columns = (
        TableColumn("experiment"),
        TableColumn("sensor"),
        TableColumn("unit"),
        *(TableColumn(str(part), align="right") for part in parts),
    )
    rows: list[tuple[Cell, ...]] = []
    cells: list[Plain] = []
    for e, loop in enumerate(loops):
        names, scores = [metric["name"] for metric in _metrics(loop)], loop["scores"]
        assert isinstance(scores, list)
        for j, sensor in enumerate(summary.sensors):
            row: list[Cell] = [str(loop["scenario"]), sensor.name, superscript_powers(sensor.unit) or "1"]
            for column, part in enumerate(parts, len(row)):
                if part not in names:
                    row.append(None)
                    continue
                metric = names.index(part)
                row.append(_cell(scores[metric][j]))
                place = {"table": name, "row": len(rows), "column": column}
                cells.append(place | {"loop": e, "metric": metric, "number": j, "scale": 1.0})
            rows.append(tuple(row))
    note = "RMSE: root mean square of model less sample, at the numbers of the knobs. Brackets: the error by the step."
    return ReportTable(name, "The errors of each record.", columns, tuple(rows), (note,)), cells


def _metrics(loop: Mapping[str, object]) -> list[dict[str, object]]:
    metrics = loop["metrics"]
    assert isinstance(metrics, list)
    return metrics


def _cell(pair: list[float | str]) -> Cell:
    value, error = (float(number) for number in pair)
    return ValueWithError(value, error) if np.isfinite(value) and np.isfinite(error) else MissingCell("no sample")
