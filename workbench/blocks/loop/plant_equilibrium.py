"""The rest of a plant: whether its own rate is zero at a state and inputs, and the point of a design for it."""

from __future__ import annotations

import casadi as ca
import numpy as np

from workbench.blocks.loop import wiring
from workbench.blocks.loop.contracts import AbstractPlant, is_recursion
from workbench.core import Layout, Signals
from workbench.core.point import AT_REST, OperatingPoint, gain_of, rate_terms
from workbench.core.validation.refusals import Array, vector


def motion_of(plant: AbstractPlant, x: Array, u: Array) -> str:
    """The state that does not rest at x (nx,) under u (nu,) and t = 0, with its rate, in words; empty if all rest."""
    states, inputs, symbols, steps = plant.states, plant.inputs, plant.states.symbols(), is_recursion(plant)
    signals = Signals(states.view(symbols)), Signals(inputs.view(ca.SX(ca.DM(u))))
    moves = states.flatten(wiring.call_block(plant, "update" if steps else "rate", states, ca.SX(0), *signals))
    rate = ca.densify(moves - symbols if steps else moves)
    function = ca.Function("rest", [symbols], [rate, ca.densify(ca.jacobian(rate, symbols))])
    value, slope = (np.array(part) for part in function(x))
    share = np.abs(value.ravel()) / rate_terms(slope, x)
    worst = int(np.argmax(np.where(np.isnan(share), np.inf, share)))
    if share[worst] <= AT_REST:
        return ""
    what = "step" if steps else "rate"
    return f"the {what} of '{states.labels[worst]}' is {float(value.ravel()[worst]):.3g}"


def point_for(call: str, plant: AbstractPlant, design: object, x0: object, u0: object) -> tuple[object, Array, Array]:
    """The gain of a design, and the state (nx,) and the inputs (nu,) about which it is: given, its own, or zero.

    A design without a point is about x = 0, u = 0 unless they are given, and the plant must rest there.
    """
    K, point = gain_of(design)
    nx, nu = plant.states.size, plant.inputs.size
    x = None if x0 is None else vector(f"{call}(x0=...)", x0, nx, "states")
    u = None if u0 is None else vector(f"{call}(u0=...)", u0, nu, "inputs")
    if x is not None and u is not None:
        return K, x, u
    if point is not None:
        refuse_other(call, point, plant.states, plant.inputs)
        return K, point.x0 if x is None else x, point.u0 if u is None else u
    x, u = (np.zeros(nx) if x is None else x), (np.zeros(nu) if u is None else u)
    if moving := motion_of(plant, x, u):
        where = " and ".join(f"{name} = 0" for name, given in (("x0", x0), ("u0", u0)) if given is None)
        raise ValueError(
            f"`{call}(K=...)` must come with the point that it is about, as `{type(plant).__name__}` does not rest at "
            f"{where}: {moving}. Give the design itself, as `lqr` or `place` returns it for a linearised plant, in the "
            "place of its K; or x0=... and u0=..."
        )
    return K, x, u


def refuse_other(call: str, point: OperatingPoint, states: Layout, inputs: Layout) -> None:
    """Refuse the point of another plant, and one at which a plant does not rest."""
    for what, own, port in (("states", point.states, states), ("inputs", point.inputs, inputs)):
        if own.labels != port.labels:
            raise ValueError(
                f"`{call}(...)` must have a design made for the {what} {', '.join(port.labels)}; this design is for "
                f"{', '.join(own.labels)}."
            )
    if point.moving_state:
        raise ValueError(
            f"`{call}(...)` must have a design made at a rest point, where a plant can be held; {point.moving_state} "
            "at the point of this one. Take a point of `operating_point` or `equilibria`, or give x0=... and u0=..."
        )
