"""A table of the margins of an outcome's loop gain, its Bode and Nyquist plots, sensitivities and poles."""

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

LOOP = "the loop"  # in captions without a name


@check_arguments
def loop_gain_pictures(
    outcome: Outcome, name: str = "loop_gain", width: float = 1.0, loop: str | None = None
) -> tuple[Block, ...]:
    """The linear pictures of a loop, cut at the inputs of its plant: blocks for a section of a study.

    The blocks are a table of the margins, a Bode plot and a Nyquist plot of the loop gain, the sensitivities, and a map
    of the poles. On a live page they move with the knobs. If there are several channels, each is drawn with the loop
    closed at the others. For a loop without linear responses, the only block is a paragraph that gives the reason.

    Parameters
    ----------
    outcome
        The outcome of a case whose `Run` has a `ClosedLoop` or a `DigitalLoop`, which know the inputs of their plant.
    name
        The first part of the names of the figures and of the table.
    width
        The share of the text's width that each figure takes.
    loop
        The loop in words for the captions, for example "the motor under PI"; "" for none. The default is "the loop
        under" and the name of the law.

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
    ['Paragraph', 'ReportTable', 'Figure', 'Figure', 'Figure', 'Figure']
    """
    gain = loop_gain(outcome)
    if isinstance(gain, str):
        return (Paragraph(f"This loop has no linear answers: {gain}"),)
    table = f"{name}_margins"
    words = f"the loop under {outcome.case.law}" if loop is None else loop
    figures = (
        _bode(f"{name}_bode", words, outcome, gain, table),
        _nyquist(f"{name}_nyquist", words, outcome, gain),
        _sensitivities(f"{name}_sensitivity", words, outcome, gain),
        _poles(f"{name}_poles", words, outcome, gain),
    )
    state = gain.about[0].lower() + gain.about[1:].rstrip(".")
    about = f"Margins and poles of {words or LOOP}, cut at {join_words(gain.channels)}. {gain.about}"
    return (
        Paragraph(f"The loop is linearised about one state: {state}. It is cut at {_inputs(gain)}."),
        margin_table(table, about, outcome, gain),
        *(replace(figure, width=width) for figure in figures),  # last: no figure of a PDF then leaves its section
    )


def _of(loop: str) -> str:
    """The loop whose loop gain is shown, before the place of the cut."""
    return f" of {loop}," if loop else ""


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


def _bode(name: str, loop: str, outcome: Outcome, gain: LoopGain, table: str) -> Figure:
    caption: Phrase = (
        f"Bode plot of the loop gain{_of(loop)} at {_inputs(gain)}. {gain.about} Dashed: the gain and phase margins "
        "of ",
        CrossReference(table),
        ".",
    )
    return replace(bode_figure(name, caption, _curves(outcome, gain)), title="Bode")


def _nyquist(name: str, loop: str, outcome: Outcome, gain: LoopGain) -> Figure:
    circles = ". The circles of Ms and of the disk margin touch the curve" if len(gain.channels) == 1 else ""
    caption = (
        f"Nyquist plot of the loop gain{_of(loop)} at {_inputs(gain)}. {gain.about} Dashed: negative "
        f"frequencies{circles}."
    )
    return replace(nyquist_figure(name, caption, _curves(outcome, gain)), title="Nyquist")


def _sensitivities(name: str, loop: str, outcome: Outcome, gain: LoopGain) -> Figure:
    """The magnitudes of S = 1 / (1 + L) and T = L / (1 + L) of each channel."""
    caption = (
        f"Sensitivity S = 1 / (1 + L) and complementary sensitivity T = L / (1 + L){_of(loop)} at {_inputs(gain)}. The "
        f"peaks of S and T are Ms and Mt. {gain.about}"
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


def _poles(name: str, loop: str, outcome: Outcome, gain: LoopGain) -> Figure:
    closed = linear_source(outcome, "poles of the closed loop")
    sets = [PoleZeroSet("the closed loop", gain.poles, period=gain.period, style=0, source=closed)]
    if len(gain.cut_poles):
        cut = closed.with_name("poles of the cut loop")
        sets.append(PoleZeroSet("the cut loop", gain.cut_poles, period=gain.period, style=1, source=cut))
    sets = [one for one in sets if np.size(one.poles)]
    return replace(pole_zero_map(name, f"Poles of {loop or LOOP}. {gain.about}", sets), title="poles")
