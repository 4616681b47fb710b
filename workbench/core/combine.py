"""Equations made of equations: quadratures and sensitivities carried along with an Ode."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import casadi as ca
import numpy as np

from workbench.core.layout import Entry, Layout
from workbench.core.ode import Ode
from workbench.validation.doors import door


@door
def with_quadrature(ode: Ode, integrands: Mapping[str, ca.SX], units: Mapping[str, str] | None = None) -> Ode:
    """The same equation with one more state per integrand g(t, x, p): z' = g, z(0) = 0.

    Parameters
    ----------
    integrands
        A name per integrand, each an expression (k, 1) in the symbols of `ode`.
    """
    entries = tuple(Entry(name, np.zeros(g.numel()), (units or {}).get(name, "")) for name, g in integrands.items())
    extra = Layout(entries)
    z = extra.symbols()
    return replace(
        ode,
        states=ode.states + extra,
        x=ca.vertcat(ode.x, z),
        rate=ca.vertcat(ode.rate, *[ca.vec(g) for g in integrands.values()]),
    )


@door
def with_sensitivity(ode: Ode, names: Sequence[str]) -> Ode:
    """The same equation with S = dx/dtheta carried along: S' = (df/dx) S + df/dtheta.

    Each name is a parameter, a state (its initial value) or one number of either (`plant.q[0]`).
    S is a state 'S' of shape (nx, k), the columns in the order of the names. Where f has a corner
    (saturation, |s|), S is that of the smooth pieces, which is exact but for the corners' instants.

    Raises
    ------
    ValueError
        If no name is given.
    LookupError
        If a name is neither a parameter's nor a state's; the message names the nearest.
    """
    if not names:
        raise ValueError("`with_sensitivity(names=...)` needs at least one parameter or state; got none.")
    nx, columns, starts = ode.states.size, [], []
    for name in names:
        of_parameter = _is_parameter(ode, name)
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


def _is_parameter(ode: Ode, name: str) -> bool:
    """Whether the name is a parameter's, or else a state's; a name that is neither is refused."""
    if name in ode.parameters or name in ode.parameters.labels:
        return True
    known = {entry.name: entry for entry in ode.parameters.entries + ode.states.entries}
    Layout(tuple(known.values())).indices(name)
    return False
