"""Held signals: states and outputs that change by jumps alone, as a step or the command of a computer."""

from __future__ import annotations

from functools import lru_cache

import casadi as ca

from workbench.core.ode import Ode


@lru_cache(maxsize=1024)
def is_piecewise_constant(flow: Ode, signal: str, place: int) -> bool:
    """True if a number of a state or an output is constant between jumps; False for what the flow does not have.

    Its derivative along a solution, d/dt + (d/dx) x', is zero as an expression; comparisons have the derivative zero.
    """
    if signal in flow.states:
        rate = flow.rate[flow.states.slice(signal)]
        return bool(rate[place].is_zero())
    if signal not in flow.outputs:
        return False
    y = flow.output[flow.outputs.slice(signal)][place]
    moving = [x for x, rate in zip(ca.vertsplit(flow.x), ca.vertsplit(flow.rate), strict=True) if not rate.is_zero()]
    return bool(ca.gradient(ca.densify(y), ca.vertcat(flow.t, *moving)).is_zero())
