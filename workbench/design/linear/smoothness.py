"""Where an equation has no linear model: at a jump of its rate."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np

from workbench.core import Layout, Ode
from workbench.design.linear.arguments import inputs_of, places_of
from workbench.notation.program import walk
from workbench.proofs.interval import jumps
from workbench.validation.refusals import Array

ON_IT = 1e-12  # a switching function smaller than this share of the state counts as zero
JUMP = 1e-9  # the least difference of two rates, relative to their size, that counts as a jump


def refuse_jumps(call: str, ode: Ode, p: Array) -> None:
    """Refuse an equation whose rate may jump as its states change: a transition matrix would jump with it."""
    from workbench.reference.surfaces import Switched

    for surface in Switched.of(ode, p).surfaces:
        if surface.jumps and ca.depends_on(surface.sigma, ode.x):
            raise ValueError(
                f"`{call}(ode=...)` must have a rate that is continuous in the states; that of '{ode.name}' may jump "
                f"where {surface.name} = 0, and the transition matrix with it. Hold what moves slowly by `held`, or "
                f"take {_smooth(ode)}."
            )


def refuse_jump_at(call: str, ode: Ode, t: float, x: Array, p: Array) -> None:
    """Refuse a point at which a rate or an output jumps; one at which it only bends, as |s| does, is let pass."""
    driven = places_of(ode)
    moving = [symbol.name() for symbol in ca.vertsplit(ca.vertcat(ode.x, ode.p[driven]))]
    both = ca.densify(ca.vertcat(ode.rate, ode.output))
    if not jumps(walk(both), moving):
        return
    _refuse_jump_of_states(call, ode, t, x, p)
    _refuse_jump_nearby(call, ode, both, t, x, p)


def _refuse_jump_nearby(call: str, ode: Ode, both: ca.SX, t: float, x: Array, p: Array) -> None:
    """Refuse a point on whose two sides, along a state or an input, rates and outputs differ by more than a slope."""
    driven = places_of(ode)
    z = ca.vertcat(ode.x, ode.p[driven])
    function = ca.Function("both", [ode.t, ode.x, ode.p], [both, ca.densify(ca.jacobian(both, z))])
    names = (*(f"the rate of '{label}'" for label in ode.states.labels), *map(repr, ode.outputs.labels))
    for i, label in enumerate((*ode.states.labels, *inputs_of(ode).labels)):
        sides = []
        for sign in (-1, 1):
            state, row = x.copy(), p.copy()
            vector, place = (state, i) if i < len(x) else (row, driven[i - len(x)])
            vector[place] += sign * ON_IT * (1 + abs(vector[place]))
            sides.append([np.array(part) for part in function(t, state, row)])
        (low, slope), (high, other) = sides
        steep = 4 * ON_IT * (1 + abs(vector[place])) * np.maximum(np.abs(slope[:, i]), np.abs(other[:, i]))
        change = np.abs(high - low).ravel() - steep
        if change.max() > JUMP * (1 + np.abs(low).max()):
            raise ValueError(
                f"`{call}(...)`: {names[int(change.argmax())]} jumps by {change.max():.3g} as '{label}' changes at "
                "this state, so it has no linear model there; take another state or input."
            )


def _refuse_jump_of_states(call: str, ode: Ode, t: float, x: Array, p: Array) -> None:
    from workbench.reference.surfaces import Switched  # half a second, which few callers need

    try:
        switched = Switched.of(_with_outputs(ode), p)
    except ValueError:  # it switches by an operation that has no surface: a wave in time, say
        return
    surfaces = switched.surfaces
    if not any(surface.jumps for surface in surfaces) or any(surface.level is not None for surface in surfaces):
        return
    sides = ca.vertcat(ca.SX(0, 1), *[s.side for s in surfaces], *[s.corner for s in surfaces])
    given = [switched.t, switched.x, sides]
    sigmas = ca.Function("sigmas", given, [ca.vertcat(*[s.sigma for s in surfaces])])
    rate = ca.Function("rate", given, [ca.densify(switched.rate)])
    count = len(surfaces)
    at, x = np.zeros(2 * count), np.concatenate([x, np.zeros(ode.outputs.size)])
    for k in range(count):  # a switching function may hold the sides of those before it
        at[[k, count + k]] = np.sign(float(sigmas(t, x, at)[k])) or 1.0
    near = np.abs(np.array(sigmas(t, x, at)).ravel()) <= ON_IT * (1 + np.abs(x).max())
    here = np.array(rate(t, x, at)).ravel()
    for k in map(int, np.flatnonzero(near)):
        across = at.copy()
        across[[k, count + k]] *= -1
        change = np.abs(np.array(rate(t, x, across)).ravel() - here)
        if surfaces[k].jumps and change.max() > JUMP * (1 + np.abs(here).max()):
            worst = int(change.argmax())
            names = (*(f"the rate of '{label}'" for label in ode.states.labels), *map(repr, ode.outputs.labels))
            raise ValueError(
                f"`{call}(...)`: {names[worst]} jumps by {change[worst]:.3g} at this state, "
                f"where {surfaces[k].name} = 0, so it has no linear model there; take {_smooth(ode)}, or a "
                "state off the surface."
            )


def _smooth(ode: Ode) -> str:
    """What to put in place of a jump; the friction of a file is made smooth where the file is read."""
    friction = any(name.endswith(".coulomb") for name in ode.parameters.names)
    return f"a continuous saturation{' (of friction from a file: `friction_speed=...`)' if friction else ''}"


def _with_outputs(ode: Ode) -> Ode:
    """The equation with its outputs as rates of more states, which nothing depends on."""
    more = ode.outputs.prefixed("output ")
    return replace(
        ode,
        states=ode.states + more,
        x=ca.vertcat(ode.x, more.symbols()),
        rate=ca.vertcat(ode.rate, ode.output),
        outputs=Layout(),
        output=ca.SX(0, 1),
    )
