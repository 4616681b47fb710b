"""`fit_section`: the page of a fit as a section of a report; what speaks against the fit stands first."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from workbench.core.validation.signatures import check_arguments
from workbench.identification.estimation.fit import Fit
from workbench.identification.summaries.fit_summary import FitSummary
from workbench.report.fit_tables import estimates_table, intervals_table, next_table, sensors_table, tests_table
from workbench.report.pictures.fit_pictures import (
    correlations_figure,
    outputs_figure,
    profiles_figure,
    residuals_figure,
)
from workbench.study.document.document import Block, Itemize, Paragraph, Section, Strong
from workbench.study.document.phrases_and_tables import Phrase
from workbench.study.document.words import join_names

PART = 0.1  # of the largest entry of a direction: a smaller one is not named


class FitPart(NamedTuple):
    """A heading and the blocks below it."""

    heading: str
    blocks: tuple[Block, ...]


@check_arguments
def fit_section(fit: Fit | FitSummary, heading: Phrase = "The fit", name: str = "fit") -> Section:
    """A section of a report on a fit, which opens with the misfit and all that speaks against the fit.

    Then come its sensors and numbers in tables, the log beside the model with its hold-out shaded, residuals with their
    tests, correlations, what the log cannot tell in words, profile likelihoods, and what another experiment brings.

    Parameters
    ----------
    fit
        The result of `wb.fit`, or its summary `wb.identification.FitSummary.of(fit, ...)`, which can hold profiles,
        draws and a designed experiment, and which a `Work` of a study may return.
    heading
        The heading of the section.
    name
        The first part of the names of its figures and tables, of lower-case letters, digits and underscores.

    Raises
    ------
    ValueError
        If the name does not fit.

    Examples
    --------
    >>> motor = wb.open_loop(wb.DCMotor())
    >>> t = np.linspace(0.0, 2.0, 101)
    >>> v = 12.0 * np.sign(np.sin(5.0 * t) + 0.1)
    >>> log = wb.Dataset.of(t, {"v": v, "omega": np.cumsum(v) / 400}, {"v": "V", "omega": "rad/s"})
    >>> section = wb.fit_section(wb.fit(motor, log, ["J", "R"]), "The motor")
    >>> type(section.blocks[0]).__name__
    'Paragraph'
    """
    summary = FitSummary.of(fit) if isinstance(fit, Fit) else fit
    return Section(heading, tuple(block for part in fit_parts(summary, name) for block in part.blocks))


def fit_parts(fit: FitSummary, name: str) -> tuple[FitPart, ...]:
    """The blocks of a fit, in parts with a heading each."""
    against = (Itemize(fit.warnings),) if fit.warnings else ()
    first = (Paragraph(verdict(fit)), *against, sensors_table(fit, f"{name}_sensors"))
    numbers = (estimates_table(fit, f"{name}_estimates"), outputs_figure(fit, f"{name}_outputs"))
    tests = (tests_table(fit, f"{name}_tests"),) if fit.tests else ()
    residuals = (residuals_figure(fit, f"{name}_residuals"), *tests)
    certainty: list[Block] = [correlations_figure(fit, f"{name}_correlations")] if len(fit.names) > 1 else []
    certainty += _null_blocks(fit)
    if fit.profiles or fit.bootstrap is not None:
        certainty.append(intervals_table(fit, f"{name}_intervals"))
    if fit.profiles:
        remarks = tuple(remark for profile in fit.profiles for remark in profile.remarks)
        certainty += [profiles_figure(fit, f"{name}_profiles"), *([Itemize(remarks)] if remarks else [])]
    parts = [
        FitPart("The misfit and the numbers", (*first, *numbers)),
        FitPart("The residuals", residuals),
        FitPart("What the log tells, and what it does not", tuple(certainty)),
    ]
    if not fit.is_exact:
        parts.append(FitPart("What another experiment brings", _next_blocks(fit, name)))
    return tuple(parts)


def verdict(fit: FitSummary) -> Phrase:
    """The misfit in a sentence, after whether anything speaks against the fit."""
    count = len(fit.warnings)
    head = f"{count} point{'s speak' if count > 1 else ' speaks'} against this fit." if count else ""
    said = _misfit(fit)
    return (Strong(head), f" {said}") if head else f"Nothing was found against this fit. {said}"


def _misfit(fit: FitSummary) -> str:
    if fit.is_exact:
        return (
            "The model follows the log to rounding: the log has no noise, as that of a simulation, and no standard "
            "error means anything."
        )
    unit = "times its stated noise" if fit.is_noise_known else "of its spread"
    worst = max(fit.sensors, key=lambda one: one.misfit)
    several = len(fit.sensors) > 1
    said = f"The residuals of '{worst.name}' are {worst.misfit:.3g} {unit}"
    said += "; this is the largest misfit." if several else "."
    tried = [one for one in fit.sensors if math.isfinite(one.hold_out)]
    if not tried:
        return said
    late = max(tried, key=lambda one: one.hold_out)
    where = f", for '{late.name}'" if several else ""
    return f"{said} On the hold-out residuals are {'at most ' * several}{late.hold_out:.3g} times as large{where}."


def _null_blocks(fit: FitSummary) -> list[Block]:
    """The directions that the log cannot tell, and the one that it tells least, in words."""
    blocks: list[Block] = []
    if fit.null_sentences:
        left = [name for name in fit.larger_set if name not in fit.names]
        blocks.append(
            Paragraph(
                f"The log cannot tell all of {join_names(fit.larger_set)} apart"
                f"{f', so that {join_names(left)} must come from elsewhere' if left else ''}:"
            )
        )
        blocks.append(Itemize(fit.null_sentences))
    elif fit.larger_set:
        blocks.append(Paragraph(f"The log could tell all of {join_names(fit.larger_set)}."))
    told = "The log tells all numbers that were fitted: no direction of them leaves all outputs unchanged."
    blocks.append(Paragraph(told if fit.is_exact else f"{told} {_weakest(fit)}"))
    return blocks


def _weakest(fit: FitSummary) -> str:
    """The relative change of the numbers that is least certain, at the size of one standard error."""
    sized = _sized(fit)
    if not sized:
        return "No number is known to within its own size."
    relative = np.array([fit.numbers[i].error / abs(fit.numbers[i].estimate) for i in sized])
    spreads, directions = np.linalg.eigh(fit.correlation[np.ix_(sized, sized)] * np.outer(relative, relative))
    direction = directions[:, -1] * np.sqrt(spreads[-1])
    order = np.argsort(-np.abs(direction))
    direction = direction * np.sign(direction[order[0]])
    moves = [
        f"{fit.numbers[sized[i]].name} by {100 * direction[i]:+.2g} %"
        for i in order.tolist()
        if abs(direction[i]) > PART * abs(direction[order[0]])
    ]
    together = " together" if len(moves) > 1 else ""
    return f"It tells least about this change, here of one standard error: {join_names(moves)}{together}."


def _sized(fit: FitSummary) -> list[int]:
    """The places of the numbers that are larger than their errors."""
    return [i for i, one in enumerate(fit.numbers) if one.error < abs(one.estimate)]


def _next_blocks(fit: FitSummary, name: str) -> tuple[Block, ...]:
    """The errors to be expected of more data of the same kind, and of a designed experiment."""
    said = (
        "The same experiment once more divides the standard errors of all shared numbers by the root of two, and four "
        "such logs halve them, if the model is right."
    )
    if sized := _sized(fit):
        least = max((fit.numbers[i] for i in sized), key=lambda one: one.error / abs(one.estimate))
        said += f" Least certain is {least.name}: its error is {100 * least.error / abs(least.estimate):.2g} % of it."
    blocks: list[Block] = [Paragraph(said), next_table(fit, f"{name}_next")]
    if fit.plan is not None:
        blocks.append(Paragraph(_plan_words(fit)))
        if fit.plan.warnings:
            blocks.append(Itemize(fit.plan.warnings))
    return tuple(blocks)


def _plan_words(fit: FitSummary) -> str:
    plan = fit.plan
    assert plan is not None  # as the caller has asked
    now = {one.name: one.error for one in fit.numbers}
    ratios = {name: error / now[name] for name, error in plan.errors.items() if now.get(name)}
    best, worst = min(ratios, key=lambda key: ratios[key]), max(ratios, key=lambda key: ratios[key])
    said = f"The designed experiment of {plan.duration:g} s has {ratios[best]:.2g} times the present error of {best}"
    said += f", and {ratios[worst]:.2g} times that of {worst}." if worst != best else "."
    if plan.active_limits:
        said += f" It is held back by the limits of {join_names(plan.active_limits)}."
    return said
