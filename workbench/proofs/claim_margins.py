"""A search: margins of claims as outputs of an equation, the box of its numbers, and the slope of its objective."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, Ode, rk4, with_quadrature, with_sensitivity
from workbench.core.claim import BlockClaim, Claim
from workbench.core.validation.refusals import (
    Array,
    as_array,
    describe,
    known_name,
    matrix,
    multiple,
    nearest,
    require,
    seconds,
    vector,
)
from workbench.core.validation.signatures import check_arguments
from workbench.engine import Trajectories, simulate
from workbench.engine.metrics.contract import AbstractMetric, Parts

PRIME = "'"
# Below and above any violation, in the loop's arithmetic, where an infinity would become NaN; the second stands for a
# margin that is not a number.
LEAST_MARGIN, UNDEFINED_MARGIN = -1e300, 1e300


class SignalsOf(Mapping[str, ca.SX]):
    """The signals of an equation by name, seen from a block at `path`: its own names, outputs, states, parameters, t.

    A prime behind a name is the derivative along a solution, d/dt + (d/dx) f.
    """

    @check_arguments
    def __init__(self, ode: Ode, path: str = "") -> None:
        states, parameters = ode.states.view(ode.x), ode.parameters.view(ode.p)
        everything = {**parameters, **states, **ode.outputs.view(ode.output)}
        own = {k.removeprefix(path): v for k, v in {**parameters, **states}.items() if path and k.startswith(path)}
        self._ode, self._held = ode, {"t": ode.t, **everything, **own}

    def __getitem__(self, name: str) -> ca.SX:
        if isinstance(name, str) and name.endswith(PRIME):
            return derivative(self._ode, self[name.removesuffix(PRIME)])
        return self._held[known_name(name, self._held, f"signals of '{self._ode.name}'")]

    def __iter__(self) -> Iterator[str]:
        return iter(self._held)

    def __len__(self) -> int:
        return len(self._held)


@check_arguments
def derivative(ode: Ode, value: ca.SX) -> ca.SX:
    """The derivative of an expression (any shape) in t, x, p along the solutions of x' = f(t, x, p)."""
    flat = ca.vec(ca.densify(value))
    along = ca.jtimes(flat, ca.vertcat(ode.t, ode.x), ca.vertcat(1, ode.rate))
    return ca.reshape(along, *value.shape)


@dataclass(frozen=True)
@check_arguments
class Largest(AbstractMetric):
    """The largest value of an output over all steps, with its sign, (k, 1); `UNDEFINED_MARGIN` if it is NaN once."""

    signal: str

    @property
    def watches(self) -> tuple[str, ...]:
        """The signal of the metric."""
        return (self.signal,)

    def memory(self, size: int) -> Layout:
        """The largest so far."""
        return Layout((Entry("largest", np.full(size, LEAST_MARGIN)),))

    def update(self, k: ca.SX, h: ca.SX, z: Parts, y: Parts) -> Parts:
        """The larger of the memory and the present value."""
        signal = y[self.signal]
        return {
            "largest": ca.fmax(z["largest"], ca.if_else(ca.fabs(signal) < UNDEFINED_MARGIN, signal, UNDEFINED_MARGIN))
        }

    def value(self, integral: Array, z: Mapping[str, Array], horizon: float) -> Array:
        """The largest value of the run."""
        return z["largest"]


@check_arguments
def violation(claim: Claim) -> Largest:
    """The largest violation of a claim over all instants of a run: positive where it is broken."""
    name = f"violation of {claim.name}"
    return Largest(name, "", f"largest negative margin of {claim.name}", name)


@check_arguments
def with_violations(ode: Ode, claims: Sequence[BlockClaim]) -> Ode:
    """The same equation with one more output for each claim: minus its margin, `violation of ...`.

    Examples
    --------
    >>> slow = wb.core.Claim("it is slow", "omega < 2 rad/s.", "a book", (), lambda signals: 2 - signals["omega"])
    >>> motor = wb.open_loop(wb.DCMotor(), "motor")
    >>> wb.proofs.with_violations(motor, [wb.core.BlockClaim(slow)]).outputs.names
    ('omega', 'violation of it is slow')
    """
    entries, columns = [], [ode.output]
    for said in {said.claim.name: said for said in claims}.values():
        if said.claim.margin is None:
            name = said.claim.name
            raise ValueError(
                f"`with_violations(claims=...)` needs margins, which a run can break; the claim '{name}' has none."
            )
        margin = said.claim.margin(SignalsOf(ode, said.path))
        require(f"The margin of '{said.claim.name}'", margin, ca.SX)
        value = -ca.vec(ca.densify(margin))
        entries.append(Entry(violation(said.claim).signal, np.zeros(value.numel())))
        columns.append(value)
    return replace(ode, outputs=ode.outputs + Layout(tuple(entries)), output=ca.vertcat(*columns))


@dataclass(frozen=True, eq=False)
@check_arguments
class Box:
    """The box low <= theta <= high of d numbers of an equation, each a parameter or an initial state.

    The `labels` name the numbers one by one, as `plant.q[0]`; `low` and `high` are (d,).
    """

    ode: Ode
    labels: tuple[str, ...]
    low: Array
    high: Array

    def __post_init__(self) -> None:
        for side in ("low", "high"):
            vector(f"Box({side}=...)", getattr(self, side), len(self.labels), "labels")

    @staticmethod
    @check_arguments
    def of(ode: Ode, ranges: Mapping[str, tuple[object, object]]) -> Box:
        """A box from (low, high) per name: of a number (`plant.q[0]`), or of all numbers of a quantity (`plant.q`)."""
        labels: list[str] = []
        ends: list[Array] = []
        for name, pair in ranges.items():
            mine = _labels(ode, name)
            labels += mine
            sides = [as_array(end) for end in pair]
            if any(side is None or side.size not in (1, len(mine)) for side in sides):
                must = f"must give (low, high) for '{name}', each a number or {len(mine)} of them"
                raise ValueError(f"`Box.of(ranges=...)` {must}; got {describe(pair)}.")
            ends.append(np.stack([np.broadcast_to(side.ravel(), len(mine)) for side in sides if side is not None]))
        if not labels or len(set(labels)) < len(labels):
            raise ValueError(f"`Box.of(ranges=...)` must give each sought number one range; got {list(ranges)}.")
        low, high = np.concatenate(ends, axis=1)
        if not (np.isfinite([low, high]).all() and (low <= high).all()):
            raise ValueError(f"`Box.of(ranges=...)` must have finite ends, low <= high; got {low} and {high}.")
        box = Box(ode, tuple(labels), low, high)
        for end in (low, high):
            box.rows(end[np.newaxis])  # refuses what is out of the bounds of its quantity
        return box

    @check_arguments
    def at(self, u: Array) -> Array:
        """theta (B, d) of points u (B, d) of the unit cube."""
        u = matrix("Box.at(u=...)", u, columns=len(self.labels))
        return np.asarray(self.low + u * (self.high - self.low))

    @check_arguments
    def rows(self, theta: Array) -> tuple[Array, Array]:
        """Parameters (B, np) and initial states (B, nx) of theta (B, d)."""
        theta = matrix("Box.rows(theta=...)", theta, columns=len(self.labels))
        columns = dict(zip(self.labels, theta.T, strict=True))
        parameters = {name: value for name, value in columns.items() if name in self.ode.parameters.labels}
        states = {name: value for name, value in columns.items() if name not in parameters}
        rows = self.ode.parameters.pack(parameters), self.ode.states.pack(states)
        p, x0 = (np.tile(part, (len(theta) // len(part), 1)) for part in rows)
        return p, x0


def _labels(ode: Ode, name: str) -> list[str]:
    for layout in (ode.parameters, ode.states):
        if name in layout:
            return layout[name].labels()
        if name in layout.labels:
            return [name]
    names = (*ode.parameters.names, *ode.states.names)
    raise LookupError(f"There is no parameter and no state {describe(name)} in '{ode.name}'.{nearest(name, names)}")


ROWS = 400  # of the run at which the worst instant is looked for


@check_arguments
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
    if runs.has_diverged.any():
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
