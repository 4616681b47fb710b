"""States that are held where they are: what moves slowly, or not at all, becomes a parameter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import casadi as ca
import numpy as np

from workbench.core import Layout, Ode
from workbench.validation.signatures import door


@door
def held(ode: Ode, names: Sequence[str]) -> Ode:
    """The same equation with the named states held: parameters of the same names take their places.

    Of an adaptive loop it is the loop of frozen gains; its Jacobian is the block of the states that are left.

    Parameters
    ----------
    names
        Names of states, as in 'controller.K'.

    Raises
    ------
    ValueError
        If no name is given, or no state would be left.
    LookupError
        If a name is no state's; the message names the nearest.
    """
    if not names:
        raise ValueError("`held(names=...)` must be names of states, at least one; got none.")
    chosen = [ode.states[name] for name in names]
    rest = Layout(tuple(entry for entry in ode.states.entries if entry.name not in names))
    if not rest.size:
        raise ValueError(f"`held(names=...)` must leave a state that moves; '{ode.name}' has no other.")
    fixed = [place for entry in chosen for place in ode.states.indices(entry.name)]
    free = np.setdiff1d(np.arange(ode.states.size), fixed).tolist()
    return replace(
        ode,
        states=rest,
        parameters=ode.parameters + Layout(tuple(chosen)),
        x=ode.x[free],
        p=ca.vertcat(ode.p, ode.x[fixed]),
        rate=ode.rate[free],
    )
