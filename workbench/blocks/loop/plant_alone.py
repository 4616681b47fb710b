"""The plant without a loop, as an `Ode` with declared inputs."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca

from workbench.blocks.loop import wiring
from workbench.blocks.loop.contracts import AbstractPlant, is_recursion
from workbench.blocks.loop.port_checks import refuse_instants, refuse_shared_names
from workbench.core import Ode, Signals, lift
from workbench.core.ode import time_beside
from workbench.core.publications import origins
from workbench.core.validation.signatures import check_arguments


@check_arguments
def open_loop(plant: AbstractPlant, name: str = "plant") -> Ode:
    """The plant alone as an `Ode`, without a loop.

    The inputs u of the plant become entries of the parameter vector p, and `Ode.inputs` has their names.

    Parameters
    ----------
    plant
        A plant in continuous time.
    name
        The name of the equations.

    Raises
    ------
    ValueError
        If `plant` is not a plant, is in discrete time, or uses one name for two of its states, inputs and parameters.

    Examples
    --------
    >>> wb.open_loop(wb.CartPole()).inputs, wb.open_loop(wb.CartPole()).outputs.names
    (('F',), ('x', 'phi'))
    """
    if is_recursion(plant):
        raise ValueError(
            f"`{type(plant).__name__}` moves in discrete time and has no rate: take it in a `digital` loop."
        )
    refuse_instants(plant)
    refuse_shared_names(plant)
    lifted = lift(plant)
    states, inputs, outputs = plant.states, plant.inputs, plant.outputs
    u, t, x = inputs.symbols(), time_beside(states, inputs, lifted.layout), states.symbols()
    z = Signals(states.view(x))
    rate = wiring.call_block(lifted.block, "rate", states, t, z, Signals(inputs.view(u)))
    y = wiring.call_block(lifted.block, "measure", outputs + plant.truths, t, z)
    watched = outputs.flatten({name: ca.densify(part) for name, part in y.only(outputs).items()})
    p = ca.vertcat(lifted.symbols, u)
    equations, ends = (t, x, p, states.flatten(rate), watched), wiring.horizon(plant)
    ode = Ode(name, states, lifted.layout + inputs, outputs, *equations, inputs=inputs.names, horizon=ends)
    drawing = wiring.plant_drawing(lifted.block, t, z, p, ode.parameters)
    return replace(ode, counts=plant.counts, drawing=drawing, origins=origins(plant))
