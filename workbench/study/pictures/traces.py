"""Outcomes over time, as figures: one line a law, one panel a window of time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.core import Ode
from workbench.study.document.document import Paragraph, Section
from workbench.study.document.figure import STYLES, Figure, Label, Panel, Series, Style
from workbench.study.document.phrases import Phrase, raised
from workbench.study.evidence.law_tables import side_by_side
from workbench.study.study import Outcome
from workbench.validation.signatures import door


@dataclass(frozen=True)
@door
class Window:
    """A stretch of time in s, and the limits of the ordinate; None fits them to the curves."""

    start: float
    end: float
    ylim: tuple[float, float] | None = None


@door
def traces(
    name: str,
    caption: Phrase,
    outcomes: Sequence[Outcome],
    signal: str,
    component: int,
    ylabel: Label,
    windows: Sequence[Window],
    reference: str = "",
) -> Figure:
    """A component of a signal for several laws; `reference` names an output drawn once beneath them.

    A law whose style an earlier one has takes the next that is free.

    Raises
    ------
    ValueError
        If there are more laws than styles.
    """
    panels, styles = [], _styles(name, outcomes)
    for window in windows:
        series = [curve(o, signal, component, window, o.case.law, style) for o, style in zip(outcomes, styles, strict=True)]
        if reference:
            longest = max(outcomes, key=lambda o: int(np.isfinite(o.signal(reference, component)).sum()))
            wanted = curve(longest, reference, component, window, "reference", "reference")
            series.append(wanted)
        panels.append(Panel(ylabel, tuple(series), xlim=(window.start, window.end), ylim=window.ylim))
    return Figure(name, caption, tuple(panels), columns=len(panels))


ONE_RUN = "Bold: below all others in this one run of each law, which does not say which law is better."


def _styles(name: str, outcomes: Sequence[Outcome]) -> list[int]:
    """One for each outcome, as its case has it unless an earlier one does."""
    if len(outcomes) > STYLES:
        raise ValueError(
            f"`traces('{name}', outcomes=...)` must be at most {STYLES} laws, as no two of a figure share a style; got "
            f"{len(outcomes)}: draw fewer."
        )
    styles: list[int] = []
    for outcome in outcomes:
        free = (style for style in (outcome.case.style, *range(STYLES)) if style not in styles)
        styles.append(next(free))
    return styles


@door
def components(
    name: str,
    caption: Phrase,
    outcome: Outcome,
    lines: Sequence[tuple[Label, str, int]],
    ylabel: Label,
    windows: Sequence[Window],
) -> Figure:
    """Several signals of one law: each line is a label, a signal and the place of one of its numbers."""
    panels = tuple(
        Panel(
            ylabel,
            tuple(curve(outcome, signal, i, window, label, style) for style, (label, signal, i) in enumerate(lines)),
            xlim=(window.start, window.end),
            ylim=window.ylim,
        )
        for window in windows
    )
    return Figure(name, caption, panels, columns=len(panels))


@door
def curve(outcome: Outcome, signal: str, component: int, window: Window, label: Label, style: Style) -> Series:
    """One component of a signal within a window; after a run has diverged there is a gap."""
    inside = (outcome.t >= window.start - 1e-9) & (outcome.t <= window.end + 1e-9)
    y = outcome.signal(signal, component)
    return Series(label, outcome.t[inside], np.where(np.isfinite(y), y, np.nan)[inside], style)


@door
def loops_section(heading: Phrase, about: Phrase, outcomes: Sequence[Outcome], signal: str = "e") -> Section:
    """Laws at their own numbers, for a page on which these are turned: a signal over time, and the metrics.

    Raises
    ------
    ValueError
        If there is no outcome, or more laws than styles.
    """
    if not outcomes:
        raise ValueError("`loops_section(outcomes=...)` needs at least one outcome; got none.")
    entry = outcomes[0].measurement.trajectories.step.outputs[signal]
    labels = [signal] if entry.size == 1 else entry.labels()
    ode = outcomes[0].ode if isinstance(outcomes[0].ode, Ode) else outcomes[0].ode.flow
    if ode.counts and entry.size > 1:
        labels = [f"{signal} of {ode.counts} {place + 1}" for place in range(entry.size)]
    whole, styles = Window(0.0, float(max(outcome.t[-1] for outcome in outcomes))), _styles("loops", outcomes)
    panels = []
    for place, (label, unit) in enumerate(zip(labels, entry.units, strict=True)):
        lines = [curve(o, signal, place, whole, o.case.law, style) for o, style in zip(outcomes, styles, strict=True)]
        panels.append(Panel(f"{label} [{raised(unit)}]" if unit else label, tuple(lines)))
    figure = Figure("loops", f"{signal} of each law at its own numbers.", tuple(panels), columns=min(2, len(panels)))
    title = "Metrics of {} of each law at its own numbers."
    tables = (
        side_by_side(f"loops_{place}", title.format(label), outcomes, signal=place, notes=(ONE_RUN,))
        for place, label in enumerate(labels)
    )
    return Section(heading, (Paragraph(about), figure, *tables))
