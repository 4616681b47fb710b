"""The section of c0 on repeated logs: coverage of the intervals, and bias of regressions."""

from __future__ import annotations

import numpy as np

import workbench as wb
from studies.c0_identify_arm.arm import BASE, FREE, TRUTH, WORDS
from studies.c0_identify_arm.estimates import CUTOFFS
from studies.c0_identify_arm.judgement import (
    BASE_NAMES,
    Accuracy,
    Evidence,
    of_base_numbers,
    of_output_errors,
    of_regressions,
)
from studies.c0_identify_arm.sections import number_column


def coverage_section(evidence: Evidence) -> wb.Section:
    """Repeated logs: coverage, spread, and the bias of regressions."""
    words = (
        "Each kind of log is repeated with new noise. Output errors compare the whole run with the readings, so noise "
        "enters where it arises. A regression instead differentiates the readings. In the law's log the torque answers "
        "the same noise, and the noise of the regressors is part of the result. The higher the cutoff of its filter, "
        "the smaller the inertias become. They do so in the designed log as well, where the noise of the regressors is "
        "the only cause."
    )
    return wb.Section(
        "Repeated logs",
        (wb.Paragraph(words), coverage_table(evidence), bias_figure(evidence), bias_table(evidence)),
    )


def coverage_table(evidence: Evidence) -> wb.document.ReportTable:
    """The coverage of intervals, and spread beside stated errors."""
    both = [of_output_errors(one[BASE.name]) for one in (evidence.law_repeats, evidence.designed_repeats)]
    promised = np.array(evidence.designed_log.plan.errors) / np.abs(TRUTH)
    rows: list[tuple[wb.document.Cell, ...]] = []
    for i, name in enumerate(FREE):
        cells = [c for one in both for c in (100 * one.mean_errors[i], 100 * one.spread[i], 100 * one.coverage[i])]
        rows.append((WORDS[name], *map(float, cells), float(100 * promised[i])))
    columns = (
        wb.document.TableColumn("number"),
        *(
            number_column(f"{log}: {words}", "%", digits)
            for log in ("law", "designed")
            for words, digits in (("stated", 2), ("spread", 2), ("coverage", 3))
        ),
        number_column("designed: promised", "%", 2),
    )
    band = coverage_band(both[0].count)
    notes = (
        f"In per cent of the number. Stated: the mean of the standard errors of {both[0].count} fits. Spread: the "
        "standard deviation of the estimates. Promised: by the design, before the experiment. Coverage: of the 95 % "
        f"intervals; by chance it lies between {band[0]:.1f} and {band[1]:.1f} % for one number with a probability of "
        "99.9 %.",
    )
    return wb.document.ReportTable("coverage", "Standard errors and coverage.", columns, tuple(rows), notes)


def coverage_band(count: int, share: float = 0.95, tail: float = 5e-4) -> tuple[float, float]:
    """The percentages of `count` intervals between which the number that holds lies, by the binomial distribution."""
    weights = np.cumsum([0.0, *(np.log(count - k) - np.log(k + 1) for k in range(count))])
    weights = np.exp(weights + np.arange(count + 1) * np.log(share) + np.arange(count, -1, -1) * np.log(1 - share))
    below = np.cumsum(weights)
    low, high = int(np.searchsorted(below, tail)), int(np.searchsorted(below, 1 - tail))
    return 100 * low / count, 100 * high / count


def estimators(evidence: Evidence, log: str) -> dict[str, Accuracy]:
    """The accuracy of all estimators on a log."""
    repeats = evidence.law_repeats if log == "law" else evidence.designed_repeats
    fits = {"output errors": of_base_numbers(repeats[BASE.name])}
    return fits | {f"{c:g} Hz": of_regressions(evidence.regressions[log, c]) for c in CUTOFFS}


def bias_figure(evidence: Evidence) -> wb.document.Figure:
    """The bias of base parameters over the cutoff."""
    panels = []
    for log, title in (("law", "law's log"), ("designed", "designed log")):
        marks: list[wb.document.Mark] = []
        every = [of_regressions(evidence.regressions[log, c]) for c in CUTOFFS]
        for i in range(4):
            values = np.array([100 * one.bias[i] for one in every])
            half = np.array([100 * one.bias_error[i] for one in every])
            x = np.array(CUTOFFS) * 1.03 ** (i - 1.5)
            marks.append(wb.document.Points(BASE_NAMES[i], x, values, style=i, ylow=values - half, yhigh=values + half))
        panels.append(
            wb.document.Panel(
                "bias [%]", tuple(marks), "cutoff of the filter [Hz]", xscale="log", title=title, hlines=(0.0,)
            )
        )
    caption = "The bias of regressions of the torques over the cutoff of their filter, with 95 % intervals."
    return wb.document.Figure("bias", caption, tuple(panels), columns=2)


def short_number(value: float) -> str:
    """A number with two digits behind the point, or without any from 10 on."""
    value = round(value, 2) + 0.0  # no minus zero
    return (f"{value:.2f}" if abs(value) < 9.995 else f"{value:.0f}").replace("-", "−")


def bias_table(evidence: Evidence) -> wb.document.ReportTable:
    """The bias and coverage of all estimators."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for log, title in (("law", "law's log"), ("designed", "designed log")):
        for k, (words, one) in enumerate(estimators(evidence, log).items()):
            worst = 4 + int(np.argmax(np.abs(one.bias[4:])))  # of the frictions
            cells = [short_number(100 * one.bias[i]) for i in (0, 1, 2, 3, worst)]
            least = None if words == "output errors" else float(100 * one.coverage.min())
            rows.append((title if k == 0 else "", words, *cells, "no" if one.is_unbiased else "yes", least))
    columns = (
        wb.document.TableColumn("log"),
        wb.document.TableColumn("estimator"),
        *(wb.document.TableColumn(one, "%", "right") for one in (*BASE_NAMES[:4], "worst friction")),
        wb.document.TableColumn("biased"),
        number_column("least coverage", "%", 2),
    )
    notes = (
        "The mean of the estimates less the truth, in per cent of the truth. Worst friction: the largest bias of the "
        "four frictions. Biased: a number's mean is off by more than 3.3 standard errors of the mean. Least coverage: "
        "of the 95 % intervals of any number. A cutoff in Hz is that of the filter of a regression.",
    )
    return wb.document.ReportTable("bias_numbers", "The bias of all estimators.", columns, tuple(rows), notes)
