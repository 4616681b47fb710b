"""The test if a reference of a loop changes after an instant."""

from __future__ import annotations

import casadi as ca
import numpy as np

from workbench.core import Ode
from workbench.core.validation.refusals import Array

LOOKED_AT = 2000  # times until a horizon


def moves_later(flow: Ode, p: Array, t: float, until: float) -> bool:
    """True if a reference has another value at some time between `t` and `until` in s than at `t`.

    References that depend on states have no values of their own.
    """
    names = [f"{name}_ref" for name in flow.follows if f"{name}_ref" in flow.outputs]
    places = [i for name in names for i in range(flow.outputs.size)[flow.outputs.slice(name)]]
    wanted = ca.densify(flow.output[places])
    if not places or not until > t or any(ca.which_depends(wanted, flow.x, 1, True)):
        return False
    value = ca.Function("reference", [flow.t, flow.p], [wanted])
    own, times = np.array(value(t, p)), np.linspace(t, until, LOOKED_AT)
    return any(not np.array_equal(np.array(value(at, p)), own, equal_nan=True) for at in times)
