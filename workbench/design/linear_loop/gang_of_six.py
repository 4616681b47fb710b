"""The gang of six: what references, loads and noise do to the outputs and the inputs of a plant."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from workbench.core import Layout
from workbench.core.validation.refusals import Array
from workbench.design.linear_loop.frequency_answers import CutModels, FrequencyResponse, refuse_pole, response_of
from workbench.design.linear_loop.loop_equations import LoopEquations, flow_of, labels_of
from workbench.design.matrices import EPS


def gang(equations: LoopEquations, models: CutModels, omega: Array) -> dict[str, FrequencyResponse]:
    """The six answers by name, at frequencies (m,) in rad/s; of a loop that follows nothing four."""
    call, flow = "LinearLoop.gang_of_six", flow_of(equations.closed_loop)
    if equations.open_loop is None:
        raise ValueError(f"`{call}(...)` needs a `ClosedLoop` or a `DigitalLoop`; equations do not say what is a load.")
    u, y = (labels_of(Layout(tuple(flow.outputs[name] for name in names))) for names in (flow.drives, flow.measures))
    loads = [f"{name}_load" for name in flow.drives]
    noises = [name for name in flow.inputs if name not in loads and name.endswith("_noise")]
    wanted = [name for name in flow.inputs if name not in loads and name not in noises]

    def answer(inputs: list[str], outputs: tuple[str, ...], sign: float = 1.0) -> FrequencyResponse:
        found, seen, shown = models.response(call, "closed", omega, inputs, outputs)
        return response_of(omega, replace(found, values=sign * found.values), seen, shown)

    found = {"TF": answer(wanted, y), "CSF": answer(wanted, u)} if wanted else {}
    found |= {"PS": answer(loads, y), "T": answer(loads, u, -1.0), "CS": answer(noises, u, -1.0)}
    read = answer(noises, y)
    values = read.values + np.eye(len(y), len(read.inputs))
    found["S"] = replace(read, values=values, errors=read.errors + EPS * np.abs(values))
    return {name: refuse_pole(f"{call}(...)", one) for name, one in found.items()}
