"""The sentences by which a page says from which fit its arm comes: first of all, and in each finding."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

import workbench as wb
from studies.paper.fitted_arm import FIT, PLANT


def fitted_study(study: wb.Study) -> wb.Study:
    """The study under another name, title and method if a fit is given; the study itself without one."""
    if FIT is None:
        return study
    return replace(
        study,
        name=f"{study.name}_of_fit",
        title=f"{study.title}, with an arm from a fit",
        method=f"{source_words(FIT)} {study.method}",
    )


def fitted_page(page: wb.Page) -> wb.Page:
    """The page with the fit first, and with the fit in the information of each finding; itself without a fit."""
    if FIT is None:
        return page
    findings = tuple(
        replace(
            one,
            information=(f"{source_words(FIT)} ", *as_parts(one.information)),
            assumptions=(f"{drawn_words(FIT)} ", *(() if one.assumptions == "nothing" else as_parts(one.assumptions))),
        )
        for one in page.findings
    )
    answer = (f"Arm fitted to {FIT.source or 'a log without a name'}. ", *as_parts(page.answer))
    return replace(page, answer=answer, findings=findings, sections=(arm_section(FIT), *page.sections))


def as_parts(phrase: Any) -> tuple[Any, ...]:
    """The parts of a phrase."""
    return phrase if isinstance(phrase, tuple) else (phrase,)


def source_words(fit: wb.FittedParameters) -> str:
    """The sentence that names the log."""
    return f"The plant's numbers come from a fit of {fit.source or 'a log without a name'}."


def drawn_words(fit: wb.FittedParameters) -> str:
    """The sentence on the numbers that are drawn with their covariance."""
    return (
        f"{', '.join(fit.names)} of the plant are drawn with the covariance of the fit, in place of any range that is "
        "stated for them; models have the estimates where they had the paper's numbers."
    )


def arm_section(fit: wb.FittedParameters) -> wb.Section:
    """The numbers of the fit, and what speaks against it."""
    errors = np.array(list(fit.standard_errors.values()))
    correlation = fit.covariance / np.outer(errors, errors)
    np.fill_diagonal(correlation, 0.0)
    rows = []
    for i, name in enumerate(fit.names):
        other = int(np.argmax(np.abs(correlation[i])))
        most = f"{correlation[i, other]:+.2f} with {fit.names[other]}" if len(fit.names) > 1 else None
        rows.append((f"{PLANT}{name}", f"{fit.centre[i]:.6g}", f"{errors[i]:.2g}", fit.units[i], most))
    heads = ("number", "estimate", "standard error", "unit", "largest correlation")
    columns = tuple(wb.document.TableColumn(head) for head in heads)
    table = wb.document.ReportTable(
        "fit", f"The numbers of the plant that come from a fit of {fit.source}.", columns, tuple(rows)
    )
    doubts = " ".join(fit.warnings) or "The fit has no warning."
    text = (
        f"{source_words(fit)} {drawn_words(fit)} Where this page speaks of the numbers of the card or of the paper, "
        f"these numbers are meant as estimated here. {doubts}"
    )
    return wb.Section("The arm of this page", (wb.Paragraph(text), table))
