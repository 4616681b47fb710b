"""An `Ode` with more states: integrals along the solution, or sensitivities to parameters and initial values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import casadi as ca
import numpy as np

from workbench.core.layout import Entry, Layout
from workbench.core.ode import Ode
from workbench.core.validation.signatures import check_arguments


@check_arguments
def with_quadrature(ode: Ode, integrands: Mapping[str, ca.SX], units: Mapping[str, str] | None = None) -> Ode:
    """The same equation with a state z for each integrand g(t, x, p), (k, 1), by its name: z' = g, z(0) = 0."""
    entries = tuple(Entry(name, np.zeros(g.numel()), (units or {}).get(name, "")) for name, g in integrands.items())
    extra = Layout(entries)
    z = extra.symbols()
    return replace(
        ode,
        states=ode.states + extra,
        x=ca.vertcat(ode.x, z),
        rate=ca.vertcat(ode.rate, *[ca.vec(g) for g in integrands.values()]),
    )


@check_arguments
def with_sensitivity(ode: Ode, names: Sequence[str]) -> Ode:
    """The same equation with S = dx/dtheta carried along: S' = (df/dx) S + df/dtheta.

    Each name is a parameter, a state (its initial value) or one number of either (`plant.q[0]`). S is a state 'S' of
    shape (nx, k), the columns in the order of the names; where f has a corner (saturation, |s|), it is that of the
    smooth pieces.

    Raises
    ------
    ValueError
        If no name is given.
    LookupError
        If a name is neither a parameter's nor a state's; the message names the nearest.

    Examples
    --------
    >>> from workbench.core import with_sensitivity
    >>> with_sensitivity(wb.open_loop(wb.DCMotor()), ["J"]).states.labels
    ('omega', 'i', 'S[0,0]', 'S[1,0]')
    """
    if not names:
        raise ValueError("`with_sensitivity(names=...)` needs at least one parameter or state; got none.")
    nx, columns, starts = ode.states.size, [], []
    known = {entry.name: entry for entry in ode.parameters.entries + ode.states.entries}
    for name in names:
        Layout(tuple(known.values())).indices(name)  # refuses a name of neither
        of_parameter = name in ode.parameters or name in ode.parameters.labels
        for i in (ode.parameters if of_parameter else ode.states).indices(name):
            columns.append(ca.jacobian(ode.rate, ode.p[i]) if of_parameter else ca.SX(nx, 1))
            starts.append(np.zeros(nx) if of_parameter else np.eye(nx)[i])
    extra = Layout((Entry("S", np.stack(starts, axis=1)),))
    s = extra.symbols()
    S = ca.reshape(s, nx, len(columns))
    rate = ca.jacobian(ode.rate, ode.x) @ S + ca.horzcat(*columns)
    return replace(
        ode,
        states=ode.states + extra,
        x=ca.vertcat(ode.x, s),
        rate=ca.vertcat(ode.rate, ca.vec(ca.densify(rate))),
    )
