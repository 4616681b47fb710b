"""Bode plot, Nyquist plot, sensitivities and poles of the loop gain of an outcome, and a table of its margins."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from workbench.core.validation.signatures import check_arguments
from workbench.report.loop_pictures import PoleZeroSet, bode_figure, nyquist_figure, pole_zero_map
from workbench.report.loop_pictures.bode_pictures import (
    DECIBELS,
    DEEPEST,
    FREQUENCY,
    frequency_limits,
    limits_of,
    nyquist_lines,
)
from workbench.report.pictures.loop_gain_table import margin_table
from workbench.report.pictures.loop_gains import LoopGain, linear_source, loop_gain
from workbench.study.document.document import Block, Figure, Panel, Paragraph
from workbench.study.document.figure import Series
from workbench.study.document.frequency_curves import FrequencyCurve, decibels, join_words
from workbench.study.document.phrases_and_tables import CrossReference, Phrase
from workbench.study.study_results import Outcome


@check_arguments
def loop_gain_pictures(outcome: Outcome, name: str = "loop_gain", width: float = 1.0) -> tuple[Block, ...]:
    """The linear pictures of a loop, cut at the inputs of its plant: blocks for a section of a study.

    They are a Bode plot and a Nyquist plot of its loop gain, its sensitivities, a map of its poles, and a table of its
    margins; on a live page all of them move with the knobs. With several channels, each is drawn with the loop closed
    at the others. For a loop without linear responses there is a paragraph that says why.

    Parameters
    ----------
    outcome
        The outcome of a case whose `Run` has a `ClosedLoop` or a `DigitalLoop`, which know the inputs of their plant.
    name
        The first part of the names of the figures and of the table.
    width
        The share of the text's width that each figure takes.

    Examples
    --------
    >>> motor = wb.DCMotor()
    >>> law = wb.PID(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0)
    >>> loop = wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0))
    >>> case = wb.Case("speed", "PI", wb.Run(loop, (wb.rmse(),), until=1.0, h=1e-2))
    >>> def sections(results):
    ...     return [wb.Section("Margins", wb.loop_gain_pictures(results["speed", "PI"]))]
    >>> study = wb.Study("s", "T", "Q?", "M.", sections=sections, cases=(case,))
    >>> from workbench.study.case_runs import run
    >>> [type(block).__name__ for block in study.sections(run(study))[0].blocks]
    ['Paragraph', 'Figure', 'Figure', 'Figure', 'Figure', 'ReportTable']
    """
    gain = loop_gain(outcome)
    if isinstance(gain, str):
        return (Paragraph(f"This loop has no linear answers: {gain}"),)
    table = f"{name}_margins"
    figures = (
        _bode(f"{name}_bode", outcome, gain, table),
        _nyquist(f"{name}_nyquist", outcome, gain),
        _sensitivities(f"{name}_sensitivity", outcome, gain),
        _poles(f"{name}_poles", outcome, gain),
    )
    about, state = (
        f"Cut at {join_words(gain.channels)}. {gain.about}",
        gain.about[0].lower() + gain.about[1:].rstrip("."),
    )
    return (
        Paragraph(f"The loop is linear about one state: {state}. It is cut at {_inputs(gain)}."),
        *(replace(figure, width=width) for figure in figures),
        margin_table(table, f"The margins and poles of the loop. {about}", outcome, gain),
    )


def _inputs(gain: LoopGain) -> str:
    """The channels in words."""
    count = len(gain.channels)
    closed = f", each while the loop stays closed at the other{'s' if count > 2 else ''}" if count > 1 else ""
    return f"the input{'s' if count > 1 else ''} {join_words(gain.channels)} of the plant{closed}"


def _curves(outcome: Outcome, gain: LoopGain) -> list[FrequencyCurve]:
    """The loop gain of each channel with its margins."""
    several = len(gain.channels) > 1
    return [
        FrequencyCurve(
            f"L at {channel}" if several else "L",
            gain.frequencies,
            gain.gains[:, i],
            gain.period,
            margins=gain.margins[i],
            source=linear_source(outcome, "loop gain", i, channel),
        )
        for i, channel in enumerate(gain.channels)
    ]


def _bode(name: str, outcome: Outcome, gain: LoopGain, table: str) -> Figure:
    caption: Phrase = (
        f"Bode plot of the loop gain at {_inputs(gain)}. {gain.about} Dashed: the gain and phase margins of ",
        CrossReference(table),
        ".",
    )
    return replace(bode_figure(name, caption, _curves(outcome, gain)), title="Bode")


def _nyquist(name: str, outcome: Outcome, gain: LoopGain) -> Figure:
    circles = ". The circles of Ms and of the disk margin touch the curve" if len(gain.channels) == 1 else ""
    caption = f"Nyquist plot of the loop gain at {_inputs(gain)}. {gain.about} Dashed: negative frequencies{circles}."
    return replace(nyquist_figure(name, caption, _curves(outcome, gain)), title="Nyquist")


def _sensitivities(name: str, outcome: Outcome, gain: LoopGain) -> Figure:
    """The magnitudes of S = 1 / (1 + L) and T = L / (1 + L) of each channel."""
    caption = (
        f"Sensitivity S = 1 / (1 + L) and complementary sensitivity T = L / (1 + L) at {_inputs(gain)}; their peaks "
        f"are Ms and Mt. {gain.about}"
    )
    curves: list[FrequencyCurve] = []
    marks: list[Series] = []
    for i, channel in enumerate(gain.channels):
        S, at = gain.sensitivities[:, i], f" at {channel}" if len(gain.channels) > 1 else ""
        for k, (label, values) in enumerate((("S", S), ("T", gain.gains[:, i] * S))):
            source = linear_source(outcome, "loop gain", i, channel)
            curve = FrequencyCurve(f"{label}{at}", gain.frequencies, values, gain.period, source=source)
            shown = curve.sources(f"magnitude of {label}")
            marks.append(Series(curve.label, gain.frequencies, decibels(values), (2 * i + k) % 12, sources=shown))
            curves.append(curve)
    return Figure(name, caption, (_gains(curves, marks),), title="S and T")


def _gains(curves: Sequence[FrequencyCurve], marks: Sequence[Series]) -> Panel:
    limits = limits_of([decibels(np.asarray(one.values, dtype=complex)) for one in curves], [0.0], DEEPEST)
    return Panel(
        "magnitude [dB]",
        tuple(marks),
        FREQUENCY,
        frequency_limits(curves),
        limits,
        "log",
        hlines=(0.0,),
        vlines=nyquist_lines(curves),
        ysteps=DECIBELS,
        aspect="wide",
    )


def _poles(name: str, outcome: Outcome, gain: LoopGain) -> Figure:
    closed = linear_source(outcome, "poles of the closed loop")
    sets = [PoleZeroSet("the closed loop", gain.poles, period=gain.period, style=0, source=closed)]
    if len(gain.cut_poles):
        cut = closed.with_name("poles of the cut loop")
        sets.append(PoleZeroSet("the cut loop", gain.cut_poles, period=gain.period, style=1, source=cut))
    sets = [one for one in sets if np.size(one.poles)]
    return replace(pole_zero_map(name, f"Poles of the loop. {gain.about}", sets), title="poles")
