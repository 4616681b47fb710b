"""The exact gradient of a run's worth in the numbers that were chosen for it, from sensitivities along the run."""

from __future__ import annotations

import casadi as ca
import numpy as np

from workbench.claims.margins import Largest
from workbench.core import Ode, rk4, with_quadrature, with_sensitivity
from workbench.metrics import AbstractMetric
from workbench.proofs.box import Box
from workbench.simulate import Trajectories, simulate
from workbench.validation.refusals import Array, multiple, seconds, vector
from workbench.validation.signatures import door

ROWS = 400  # of the run at which the worst instant is looked for


@door
def slope_of(ode: Ode, metric: AbstractMetric, box: Box, u: Array, until: float, h: float) -> Array | None:
    """d(metric)/du (d,) at a point u (d,) of the unit cube, up to a positive factor; None where there is none.

    An integral has the sensitivity of its quadrature at the horizon; the largest value over time that of its
    signal at the instant where it is largest, by the envelope theorem. Where the equation has jumps the slope
    lacks what they add, so it is good for a direction only.
    """
    u = vector("slope_of(u=...)", u, len(box.labels), "numbers of the box")
    steps = multiple("slope_of(until=...)", seconds("slope_of(until=...)", until), seconds("slope_of(h=...)", h), "h")
    y = ode.outputs.view(ode.output)
    metric = metric.of(ode)
    metric.check(ode, until)
    g = metric.integrand(ode.t, y)
    if g is None and not isinstance(metric, Largest):
        return None
    if g is not None:
        ode = with_quadrature(ode, {"worth": ca.densify(g)})
    p, x0 = box.rows(box.at(u[np.newaxis]))
    carried = with_sensitivity(ode, box.labels)
    rest = carried.states.default[x0.shape[1] :]
    stride = max(1, steps // ROWS)
    kept = h * stride if steps % stride == 0 else h
    runs = simulate(rk4(carried, h), p, np.hstack([x0, rest[np.newaxis]]), until=until, every=kept)
    if runs.diverged.any():
        return None
    S = runs["S"][0]
    if g is not None:
        worst = int(np.argmax(runs["worth"][0, -1]))
        slope = S[-1, carried.states.slice("worth").start + worst]
    else:
        assert isinstance(metric, Largest)
        slope = _at_the_worst(ode, metric.signal, box, runs, S)
    return np.asarray(slope * (box.high - box.low))


def _at_the_worst(ode: Ode, signal: str, box: Box, runs: Trajectories, S: Array) -> Array:
    """d(signal)/d(theta) at the kept instant where the signal is largest."""
    y = ode.outputs.view(ode.output)[signal]
    places = [ode.parameters.labels.index(label) if label in ode.parameters.labels else -1 for label in box.labels]
    direct = ca.jacobian(y, ode.p)
    columns = ca.horzcat(*(direct[:, i] if i >= 0 else ca.SX(y.numel(), 1) for i in places))
    parts = ca.Function("parts", [ode.t, ode.x, ode.p], [ca.densify(ca.jacobian(y, ode.x)), ca.densify(columns)])
    where, component = np.unravel_index(np.argmax(runs[signal][0]), runs[signal][0].shape)
    by_state, by_number = (
        np.array(part) for part in parts(runs.t[where], runs.x[0, where, : ode.states.size], runs.p[0])
    )
    return np.asarray(by_state[component] @ S[where] + by_number[component])
