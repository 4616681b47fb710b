"""The time at which the references of a loop first leave the values that they have at an instant."""

from __future__ import annotations

import casadi as ca
import numpy as np

from workbench.core import Ode
from workbench.validation.refusals import Array

LOOKED_AT = 2000  # times until a horizon
HALVINGS = 60  # of the interval in which a reference moves


def first_move(flow: Ode, p: Array, t: float, until: float) -> float | None:
    """The time in s, between `t` and `until`, at which a reference is first another than at `t`; None if at none.

    References that depend on states have no time of their own.
    """
    names = [f"{name}_ref" for name in flow.follows if f"{name}_ref" in flow.outputs]
    places = [i for name in names for i in range(flow.outputs.size)[flow.outputs.slice(name)]]
    wanted = ca.densify(flow.output[places])
    if not places or not until > t or any(ca.which_depends(wanted, flow.x, 1, True)):
        return None
    value = ca.Function("reference", [flow.t, flow.p], [wanted])
    own = np.array(value(t, p))

    def moved(at: float) -> bool:
        return not np.array_equal(np.array(value(at, p)), own, equal_nan=True)

    times = np.linspace(t, until, LOOKED_AT).tolist()
    k = next((k for k, at in enumerate(times) if moved(at)), None)
    if k is None:
        return None
    low, high = times[k - 1], times[k]
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        low, high = (low, middle) if moved(middle) else (middle, high)
    return high
