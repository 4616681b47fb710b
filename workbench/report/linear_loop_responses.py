"""The step and impulse responses of a `LinearLoop`, from signals that are added outside to any of its signals."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from itertools import product
from typing import NamedTuple

import numpy as np

from workbench.core import Layout, Ode
from workbench.core.validation.refusals import Array
from workbench.design.control_system import System
from workbench.design.linear.system_answers import step_answers
from workbench.design.linear_loop import LinearLoop, LinearRows
from workbench.design.linear_loop.loop_channels import without_hidden_states
from workbench.design.linear_loop.loop_equations import flow_of, labels_of
from workbench.design.linear_loop.loop_model import LoopModel
from workbench.design.step_response import exact_figures
from workbench.report.linear_loop_curves import signal_units
from workbench.report.loop_pictures import TimeResponse
from workbench.study.document.figure import STYLES

NO_STEP = 1e-9  # of the largest value of a response: a final value that is nearer to the first one is no step

FEW = 4  # responses, of which the figures are exact; of more they are those of the samples

Names = str | tuple[str, ...] | None


class SignalResponse(NamedTuple):
    """The response of an output to a step or an impulse of an input, by the names of both."""

    input: str
    output: str
    response: TimeResponse


def time_response(
    label: str,
    t: Array,
    y: Array,
    final: float,
    unit: str = "",
    period: float | None = None,
    system: System | None = None,
) -> TimeResponse:
    """A response with its final value, if it tends to one and not to zero; the step of a `system` has exact figures."""
    least = NO_STEP * float(np.abs(y).max(initial=0.0))
    known = bool(np.isfinite(final) and np.isfinite(y).all() and abs(final) > least)
    info = exact_figures(system) if known and system is not None else None
    stands = info is not None or (known and abs(final - float(y[0])) > least)
    return TimeResponse(label, t, y, final if stands else None, unit, period, info=info)


def loop_responses(
    call: str, linear: LinearLoop, inputs: Names, outputs: Names, until: float | None, impulse: bool = False
) -> list[SignalResponse]:
    """The responses of outputs to inputs, by default of what the loop follows to its reference.

    A loop that follows nothing answers, with the outputs of its plant, to the loads at its inputs.
    """
    linear.system("closed", inputs, outputs)  # refuses names that are not there, delays and corners
    pairs = response_pairs(linear, inputs, outputs)
    if len(pairs) > STYLES:
        raise ValueError(
            f"`{call}` draws up to {STYLES} responses; there are {len(pairs)}: choose some by `inputs` and `outputs`. "
            f"The inputs are {', '.join(linear.inputs)}; the outputs are {', '.join(linear.outputs)}."
        )
    into, out = (tuple(dict.fromkeys(names)) for names in zip(*pairs, strict=True))
    t, values, final = _answers(call, linear.models.select_model(call, "closed", into, out), until, impulse)
    units, answers = signal_units(linear), []
    for one, other in pairs:
        place, words = (out.index(other), into.index(one)), f"{other} from {one}"
        exact = (
            None if impulse or len(pairs) > FEW or linear.models.closed_model.count > 1 else _system(linear, one, other)
        )
        response = time_response(words, t, values[place], float(final[place]), units[other], linear.period, exact)
        answers.append(SignalResponse(one, other, response))
    return answers


def _system(linear: LinearLoop, into: str, out: str) -> System:
    """The closed loop from one input to one output, of the states that lie between them."""
    return without_hidden_states(linear.models.select_model("LinearLoop.plot", "closed", (into,), (out,))).system()


def response_pairs(linear: LinearLoop | LinearRows, inputs: Names, outputs: Names) -> list[tuple[str, str]]:
    """The pairs of an input and an output that are drawn, by default what the loop follows with its references."""
    flow = flow_of(linear.point.equations.closed_loop)
    model = linear.models.select_model("LinearLoop.plot", "closed", _listed(inputs), _listed(outputs))
    followed = [name for name in flow.follows if f"{name}_ref" in flow.inputs]
    wanted = _labels(flow, (f"{name}_ref" for name in followed))
    shown = _labels(flow, followed or flow.measures)
    if inputs is None and outputs is None and followed:
        return list(zip(wanted, shown, strict=True))
    loads = _labels(flow, (f"{name}_load" for name in flow.drives if f"{name}_load" in flow.inputs))
    into = model.inputs if inputs is not None else wanted or loads or model.inputs
    out = model.outputs if outputs is not None else tuple(n for n in shown if n in model.outputs) or model.outputs
    return [(one, other) for other, one in product(out, into)]


def _labels(flow: Ode, names: Iterable[str]) -> tuple[str, ...]:
    """The names of the numbers of signals and inputs."""
    held = [flow.outputs[name] if name in flow.outputs else flow.parameters[name] for name in names]
    return labels_of(Layout(tuple(held)))


def _listed(names: Names) -> tuple[str, ...] | None:
    return (names,) if isinstance(names, str) else names


def _answers(call: str, model: LoopModel, until: float | None, impulse: bool) -> tuple[Array, Array, Array]:
    """The times (N,), the responses (ny, nu, N), and the values (ny, nu) to which they tend."""
    q, ny, nu = model.count, len(model.outputs), len(model.inputs)
    if q == 1:
        return step_answers(without_hidden_states(model).system(), until, impulse, call)
    blocks = (model.B.reshape(1, -1, q, nu), model.D.reshape(1, q * ny, q, nu))
    B, D = (part[:, :, 0] if impulse else part.sum(axis=2) for part in blocks)  # a step acts at each instant
    one = replace(
        model, B=B, D=D, outputs=tuple(f"{k}" for k in range(q * ny)), period=q * (model.period or 0), count=1
    )
    _, values, final = step_answers(without_hidden_states(one).system(), until, impulse, call)
    ahead = values.reshape(q, ny, nu, -1).transpose(1, 2, 3, 0).reshape(ny, nu, -1)
    settled = final.reshape(q, ny, nu)
    last = np.where(np.ptp(settled, axis=0) <= NO_STEP * np.abs(settled).max(initial=0.0), settled[0], np.nan)
    times = np.arange(ahead.shape[-1]) * float(model.period or 0)
    return np.asarray(times, dtype=float), np.asarray(ahead), np.asarray(last, dtype=float)
