"""Figures of step and impulse responses, of systems of python-control and of linear loops by their names."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from workbench.core.validation.refusals import refusal
from workbench.design.linear.system_answers import lti, period_of, step_answers
from workbench.design.linear_loop import LinearLoop
from workbench.report.linear_loop_curves import signal_units
from workbench.report.linear_loop_responses import Names, loop_responses, time_response
from workbench.report.loop_pictures import TimeResponse, impulse_figure, step_figure
from workbench.report.system_curves import Systems, one_channel, systems_by_name
from workbench.study.document.figure import Figure
from workbench.study.document.frequency_curves import add_remarks, join_words
from workbench.study.document.phrases_and_tables import Phrase


def responses_figure(
    name: str,
    systems: Systems,
    until: float | None,
    inputs: Names = None,
    outputs: Names = None,
    impulse: bool = False,
) -> Figure:
    """The responses of systems with one channel, and of outputs of loops to inputs, with a panel for each output."""
    called = name if name == "step_response" else "LinearLoop.plot"
    panels: dict[str, list[TimeResponse]] = {}
    inputs_of: dict[str, str] = {}
    for label, one in systems_by_name(systems):
        if isinstance(one, LinearLoop):
            answers = loop_responses(called, one, inputs, outputs, until, impulse)
            units = signal_units(one)
            inputs_of |= {each.input: units[each.input] for each in answers}
            for each in answers:
                alone = not label or len({other.input for other in answers if other.output == each.output}) > 1
                words = ": ".join(filter(None, (label, f"{each.output} from {each.input}" if alone else "")))
                panels.setdefault(each.output, []).append(replace(each.response, label=words))
            continue
        if inputs is not None or outputs is not None:
            raise refusal(f"{name}(system)", "a `LinearLoop`, if inputs or outputs are named", one)
        system = one_channel(name, lti(name, one))
        t, y, final = step_answers(system, until, impulse, called)
        exact = None if impulse else system
        held = time_response(label, t, y[0, 0], float(final[0, 0]), period=period_of(system), system=exact)
        panels.setdefault("", []).append(held)
    if "" in panels:  # the output of a system has no name, and is drawn over those that have one
        panels = {"": [each for held in panels.values() for each in held]}
    made = impulse_figure if impulse else step_figure
    figures = [made(name, "", held, output or "response") for output, held in panels.items()]
    remarks = []
    if inputs_of:
        added = [f"1 {' '.join((*filter(None, (unit,)), *('s',) * impulse))}".strip() for unit in inputs_of.values()]
        words = join_words([f"{size} at {into}" for into, size in zip(inputs_of, added, strict=True)])
        remarks.append(f"{'Impulse' if impulse else 'Step'} of {words}.")
    return joined_figures(name, remarks, figures, min(2, len(figures)))


def joined_figures(name: str, remarks: Sequence[Phrase], figures: Sequence[Figure], columns: int) -> Figure:
    """One figure with the panels of several, whose captions follow some remarks."""
    said = [figure.caption for figure in figures if figure.caption not in ("", ())]
    panels = tuple(panel for figure in figures for panel in figure.panels)
    numbers = figures[0].numbers if len(figures) == 1 else None
    return Figure(name, add_remarks("", [*remarks, *said]), panels, columns, numbers)
