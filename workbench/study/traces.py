"""Outcomes over time, as figures: one line a law, one panel a window of time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.study.document import Figure, Label, Panel, Phrase, Series, Style
from workbench.study.study import Outcome
from workbench.validation.doors import door


@dataclass(frozen=True)
@door
class Window:
    """A stretch of time in s, and what of the ordinate is shown; None fits it to the curves."""

    start: float
    end: float
    ylim: tuple[float, float] | None = None


@door
def traces(
    name: str,
    caption: Phrase,
    outcomes: Sequence[Outcome],
    signal: str,
    joint: int,
    ylabel: Label,
    windows: Sequence[Window],
    reference: str = "",
) -> Figure:
    """A signal of one joint for several laws; `reference` names an output drawn once beneath them."""
    panels = []
    for window in windows:
        series = [curve(o, signal, joint, window, o.case.law, o.case.style) for o in outcomes]
        if reference:
            longest = max(outcomes, key=lambda o: int(np.isfinite(o.signal(reference, joint)).sum()))
            wanted = curve(longest, reference, joint, window, "reference", "reference")
            series.append(wanted)
        panels.append(Panel(ylabel, tuple(series), xlim=(window.start, window.end), ylim=window.ylim))
    return Figure(name, caption, tuple(panels), columns=len(panels))


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
def curve(outcome: Outcome, signal: str, joint: int, window: Window, label: Label, style: Style) -> Series:
    """One signal within a window; after a run has diverged there is a gap."""
    inside = (outcome.t >= window.start - 1e-9) & (outcome.t <= window.end + 1e-9)
    y = outcome.signal(signal, joint)
    return Series(label, outcome.t[inside], np.where(np.isfinite(y), y, np.nan)[inside], style)
