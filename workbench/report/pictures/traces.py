"""Outcomes over time, as figures: one line a law, one panel a window of time; or one panel a law."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from workbench.core.validation.signatures import check_arguments
from workbench.study.document.document import Paragraph, Section
from workbench.study.document.figure import STYLES, Band, Figure, Label, Mark, Panel, Series, Style
from workbench.study.document.phrases_and_tables import Phrase, superscript_powers
from workbench.study.document.source import Source
from workbench.study.evidence.law_tables import side_by_side
from workbench.study.result_marks import changes_by_jumps, labels_of, signal_source, time_source
from workbench.study.study import Outcome


@dataclass(frozen=True)
@check_arguments
class Window:
    """An interval of time from `start` to `end` in s, and the limits `ylim` of the ordinate; None fits them to the
    curves.

    Examples
    --------
    >>> wb.pictures.Window(0.0, 2.0, ylim=(-1.0, 1.0)).end
    2.0
    """

    start: float
    end: float
    ylim: tuple[float, float] | None = None


@check_arguments
def traces(
    name: str,
    caption: Phrase,
    outcomes: Sequence[Outcome],
    signal: str,
    number: int | str,
    ylabel: Label,
    windows: Sequence[Window],
    reference: str = "",
) -> Figure:
    """A signal over time for several laws, its component by label or `number`; `reference` names an output below them.

    If an earlier law has the same style, a law takes the next free one. With more than three laws each has its own
    panel, with the range of all in grey. Two adjacent windows share it, the second compressed; others have their own.

    Raises
    ------
    ValueError
        If there are more laws than styles.

    Examples
    --------
    >>> motor = wb.Run(wb.open_loop(wb.DCMotor(), "motor"), (wb.effort("omega"),), until=1.0, every=0.1, h=1e-2)
    >>> study = wb.Study("s", "T", "Q?", "M.", lambda results: [], cases=(wb.Case("speed", "no law", motor),))
    >>> outcome = wb.study.run(study)["speed", "no law"]
    >>> window = wb.pictures.Window(0.0, 1.0)
    >>> wb.pictures.traces("speed", "Speed of the motor.", [outcome], "omega", 0, "speed [rad/s]", [window]).name
    'speed'
    """
    panels, styles = [], _styles(name, outcomes)
    if len(outcomes) > TOGETHER:
        for joined in _joined(windows):
            panels += _multiples(outcomes, signal, number, ylabel, joined, reference, styles)
        return Figure(name, caption, tuple(panels), columns=ACROSS)
    for window in windows:
        series = [
            curve(o, signal, number, window, o.case.law, style) for o, style in zip(outcomes, styles, strict=True)
        ]
        if reference:
            longest = max(outcomes, key=_finite_rows)
            series.append(curve(longest, reference, number, window, "reference", "reference"))
        panels.append(Panel(ylabel, tuple(series), xlim=(window.start, window.end), ylim=window.ylim))
    return Figure(name, caption, tuple(panels), columns=len(panels))


def _joined(windows: Sequence[Window]) -> list[tuple[Window, float | None]]:
    """The whole of two windows, one behind the other, and where the second begins; else each window with None."""
    if len(windows) != 2 or windows[0].end != windows[1].start:
        return [(window, None) for window in windows]
    first, second = windows
    return [(Window(first.start, second.end, first.ylim), first.end)]


def _multiples(
    outcomes: Sequence[Outcome],
    signal: str,
    number: int | str,
    ylabel: Label,
    joined: tuple[Window, float | None],
    reference: str,
    styles: Sequence[int],
) -> list[Panel]:
    """A panel for each law: its curve, what is wanted, and the range of all laws."""
    window, cut = joined
    curves = [curve(o, signal, number, window, o.case.law, style) for o, style in zip(outcomes, styles, strict=True)]
    behind: list[Mark] = [*_range_of(curves)]
    if reference:
        longest = max(outcomes, key=_finite_rows)
        behind.insert(0, curve(longest, reference, number, window, "reference", "reference"))
    return [
        Panel(
            ylabel if k % ACROSS == 0 else "",
            (one, *behind),
            xlim=(window.start, window.end),
            ylim=window.ylim,
            title=one.label,
            xcut=cut,
        )
        for k, one in enumerate(curves)
    ]


def _range_of(curves: Sequence[Series]) -> list[Band]:
    """The strip between the least and the greatest of curves at the times of the longest, where any has a number."""
    times = max((one.x for one in curves), key=len)
    numbers = np.array([np.interp(times, one.x, one.y, left=np.nan, right=np.nan) for one in curves])
    there = np.isfinite(numbers).any(axis=0)
    low, high = np.nanmin(numbers[:, there], axis=0), np.nanmax(numbers[:, there], axis=0)
    return [Band("range of all laws", times[there], low, high, "reference")] if there.any() else []


def _finite_rows(outcome: Outcome) -> int:
    """The number of kept times at which an outcome had not diverged."""
    return int(np.isfinite(outcome.measurement.trajectories.x[0]).all(axis=1).sum())


TOGETHER = 3  # curves of laws that one panel can hold, as more lie on each other
ACROSS = 3  # panels side by side, one a law
ONE_RUN = "Bold: smaller than all others in this one run of each law. One run does not show which law is better."


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


@check_arguments
def components(
    name: str,
    caption: Phrase,
    outcome: Outcome,
    lines: Sequence[tuple[Label, str, int | str]],
    ylabel: Label,
    windows: Sequence[Window],
) -> Figure:
    """Several signals of one law: each line is a label, a signal, and one of its numbers by label or from 0."""
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


@check_arguments
def curve(
    outcome: Outcome,
    signal: str,
    number: int | str = 0,
    window: Window | None = None,
    label: Label = "",
    style: Style = 0,
    *,
    over: tuple[str, int | str] | None = None,
    look: Literal["line", "steps", "marks"] | None = None,
    seconds: tuple[float, str] = (1.0, "s"),
    unit: tuple[float, str] = (1.0, ""),
) -> Series:
    """One number of a signal, by its label or counted from 0, over time or over another signal.

    After a run has diverged there is a gap.

    Parameters
    ----------
    window
        The interval that is drawn; by default all kept times.
    over
        The signal, and its number, on the abscissa in place of the time.
    look
        As in `Series`; by default steps for a signal that changes by jumps alone, as the command of a computer, else a
        line.
    seconds, unit
        The unit of time, and that of the signal, as (number of it in one second or one unit, name): (1e3, "ms").

    Raises
    ------
    LookupError
        If there is no such signal, or it has no such number.
    ValueError
        If no kept time lies in the window.

    Examples
    --------
    >>> motor = wb.Run(wb.open_loop(wb.DCMotor(), "motor"), (wb.effort("omega"),), until=1.0, every=0.1, h=1e-2)
    >>> study = wb.Study("s", "T", "Q?", "M.", lambda results: [], cases=(wb.Case("speed", "no law", motor),))
    >>> outcome = wb.study.run(study)["speed", "no law"]
    >>> wb.pictures.curve(outcome, "omega").x.shape
    (11,)
    """
    first, last = _rows(outcome, window)
    x, of_x = outcome.t, time_source(outcome, (first, last)).times(*seconds)
    if over is not None:
        of_x = signal_source(outcome, *over, (first, last))
        x = outcome.signal(over[0], of_x.place)
        last = first + int(np.isfinite(x[first:last]).cumprod().sum())
        of_x = replace(of_x, rows=(first, last))
    of_y = signal_source(outcome, signal, number, (first, last)).times(*unit)
    y = outcome.signal(signal, of_y.place)
    x, y = (one.scale * np.where(np.isfinite(z), z, np.nan)[first:last] for one, z in ((of_x, x), (of_y, y)))
    if look is None:
        look = "steps" if over is None and changes_by_jumps(outcome, of_y) else "line"
    return Series(label, x, y, style, look, (of_x, of_y))


def _rows(outcome: Outcome, window: Window | None) -> tuple[int, int]:
    """The first kept time within a window, and the one behind the last."""
    t = outcome.t
    if window is None:
        return 0, len(t)
    inside = np.flatnonzero((t >= window.start - 1e-9) & (t <= window.end + 1e-9))
    if not inside.size:
        raise ValueError(
            f"`curve(window=...)` must hold a kept time of '{outcome.case.name}', which are from {t[0]:g} s to "
            f"{t[-1]:g} s; got {window.start:g} s to {window.end:g} s."
        )
    return int(inside[0]), int(inside[-1]) + 1


@check_arguments
def loops_section(
    heading: Phrase,
    about: Phrase,
    outcomes: Sequence[Outcome],
    signal: str = "e",
    *,
    caption: Phrase = "",
    cut: float | None = None,
) -> Section:
    """A section on several laws for a page with knobs: a signal over time, and a table of the metrics.

    After `cut`, in s, the time axis of the figure is compressed, so that each part takes half of a panel.

    Raises
    ------
    ValueError
        If there is no outcome, more laws than styles, or no time on both sides of `cut`.
    """
    if not outcomes:
        raise ValueError("`loops_section(outcomes=...)` needs at least one outcome; got none.")
    shown = [signal_source(outcomes[0], signal, place) for place in range(len(labels_of(outcomes[0], signal)))]
    figure = _loops_figure(outcomes, signal, shown, caption, cut)
    title = "Metrics of {}, for each law with its numbers from this study."
    tables = (
        side_by_side(f"loops_{one.place}", title.format(one.words), outcomes, signal=one.place, notes=(ONE_RUN,))
        for one in shown
    )
    return Section(heading, (Paragraph(about), figure, *tables))


def _loops_figure(
    outcomes: Sequence[Outcome], signal: str, shown: Sequence[Source], caption: Phrase, cut: float | None
) -> Figure:
    """A panel for each number of a signal with a line a law; or, with many laws, a panel for each of these."""
    whole, styles = Window(0.0, float(max(outcome.t[-1] for outcome in outcomes))), _styles("loops", outcomes)
    span = None if cut is None else (whole.start, whole.end)
    panels, caption = [], caption or f"{signal} of each law with its numbers from this study."
    if not (len(outcomes) > TOGETHER >= len(shown) and len({one.unit for one in shown}) == 1):
        for one in shown:
            lines = [curve(o, signal, one.place, whole, o.case.law, k) for o, k in zip(outcomes, styles, strict=True)]
            label = f"{one.words} [{superscript_powers(one.unit)}]" if one.unit else one.words
            panels.append(Panel(label, tuple(lines), xlim=span, xcut=cut))
        return Figure("loops", caption, tuple(panels), columns=min(2, len(panels)))
    label = f"{signal} [{superscript_powers(shown[0].unit)}]" if shown[0].unit else signal
    drawn = [[curve(o, signal, one.place, whole, one.words, k) for k, one in enumerate(shown)] for o in outcomes]
    behind = _range_of([line for lines in drawn for line in lines])
    for k, (outcome, lines) in enumerate(zip(outcomes, drawn, strict=True)):
        ylabel = "" if k % ACROSS else label
        panels.append(Panel(ylabel, (*lines, *behind), xlim=span, title=outcome.case.law, xcut=cut))
    return Figure("loops", caption, tuple(panels), columns=ACROSS)
