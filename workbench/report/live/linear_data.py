"""The data with which a live page makes a loop linear again: where it rests, its Jacobians, and what it is cut at."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from inspect import signature

import casadi as ca
import numpy as np

from workbench.core import Layout, Ode, SampledSystem, StepMap
from workbench.core.equations import Loop
from workbench.core.validation.refusals import Array
from workbench.design.linear.linear_period import jump_of
from workbench.design.linear.loop_cuts import closure
from workbench.design.linear_loop import LinearLoop, linear_loop
from workbench.design.linear_loop.loop_equations import flow_of, labels_of
from workbench.design.linear_loop.loop_linearization import linear_loop_about, rest_point
from workbench.design.linear_loop.rest_state import resting_states
from workbench.report.live.linear_marches import computer_marches, continuous_marches
from workbench.report.live.marches import Modules, plain
from workbench.report.live.reference_moves import moves_later
from workbench.study.study import Outcome

FREQUENCIES, BEYOND = 200, 30.0  # frequencies of an answer, and how far they go beyond the slowest and fastest pole
MOST_DECADES = 8.0
MOST_OPERATIONS = 100_000  # of a Jacobian, which take seconds to compile
LIGHT, SHARPEST = 0.2, 1e-4  # damping: a pole between has frequencies of its own; with less its peak is not drawn whole
AROUND = np.sinh(np.linspace(-4, 4, 15))  # times the distance of such a pole from the axis, as in linear_poles.js
INTEGRATOR = 1e-9  # of the size of the fastest pole: a slower one sets no frequency


def linear_data(outcome: Outcome, modules: Modules) -> dict[str, object]:
    """The entry `linear` of a loop of a page, None beside `linear_refused` if it has no linear answer at its baseline.

    It stands on `linear_loop`, cut at all inputs of the plant, with the Runge-Kutta steps of the run in a computer.
    """
    step = outcome.measurement.trajectories.step
    try:
        baseline = baseline_of(outcome)
        return {"linear": _plain(baseline, step, modules), "linear_refused": ""}
    except (ValueError, LookupError) as error:
        return {"linear": None, "linear_refused": str(error)}


@lru_cache(maxsize=8)
def baseline_of(outcome: Outcome) -> Baseline:
    """The linear loop of an outcome, made once for its pictures and for the data of its page."""
    runs = outcome.measurement.trajectories
    found = Baseline.of(outcome.case.run.loop, runs.step)
    at = found.linear.point.instant.t
    return replace(found, moves=moves_later(runs.step.flow, runs.step.parameters.default, at, float(runs.t[-1])))


@dataclass(frozen=True, eq=False)
class Baseline:
    """The linear loop of a page before a knob is turned, and how it came about.

    It rests, or else it is frozen at its start. `frozen_states` are states of the law that adapt, and that are held as
    gains. `moves` is True if its reference is another one at a later time than that of the rest.
    """

    linear: LinearLoop
    rests: bool
    frozen_states: tuple[str, ...]
    moves: bool = False

    @staticmethod
    def of(loop: Loop | Ode | SampledSystem, step: StepMap) -> Baseline:
        """The loop at rest; if it has no rest, with its adapting gains held; if that has none, frozen at its start.

        Raises
        ------
        ValueError, LookupError
            If the loop is equations alone, has several periods, or has no linear answer at its start either.
        """
        if not _can_be_cut(loop):
            raise ValueError(
                f"'{getattr(loop, 'name', 'loop')}' is equations alone, which do not say where they can be cut: give "
                "the page the `ClosedLoop` or the `DigitalLoop` itself."
            )
        refuse_large(step)
        substeps = step.substeps if getattr(loop, "period", None) else None
        gains = adapting_states(loop)
        ways = [(True, ()), *([(True, gains)] if gains else []), (False, gains)]
        for rests, held in ways:
            try:
                linear = linear_loop(loop, freeze=held, at_rest=rests, substeps=substeps)
            except ValueError:
                if not rests:
                    raise
                continue
            if linear.point.instant.count > 1:
                raise ValueError(
                    "The blocks of this loop run at several periods, and its pictures in frequency do not move on "
                    "this page; `wb.linear_loop` has them."
                )
            return Baseline(linear, rests, held)
        raise AssertionError("the last way is refused or gives an answer")

    @property
    def sentence(self) -> str:
        """Where the loop is linear, in words."""
        t = f"t = {self.linear.point.instant.t:g} s"
        names = [name.removeprefix("controller.") for name in self.frozen_states]
        held = f", with {' and '.join(names)} held" if names else ""
        if not self.rests:
            return f"Frozen at the start, where the loop does not rest{held}."
        follows = flow_of(self.linear.point.equations.closed_loop).follows
        later = ", before the reference moves" if self.moves else ""
        return f"At rest{' at the reference' if follows else ''} at {t}{later}{held}."


def linear_at(loop: Loop | Ode | SampledSystem, step: StepMap, row: Array) -> LinearLoop:
    """The linear loop of a page at other parameters, then first states (np + nx,), of its step.

    Raises
    ------
    ValueError
        If the loop has no linear answer at its baseline or there.
    """
    baseline = Baseline.of(loop, step)
    point = baseline.linear.point
    closed = point.equations.closed_loop
    p, x = (_taken(layout, step, row) for layout in (closed.parameters, closed.states))
    values = {name: value[0] for name, value in closed.parameters.unpack(p[np.newaxis]).items()}
    starts = tuple(
        replace(entry, default=value[0])
        for entry, value in zip(closed.states.entries, closed.states.unpack(x[np.newaxis]).values(), strict=True)
    )
    flow = replace(flow_of(closed), states=Layout(starts))
    moved = replace(closed, flow=flow) if isinstance(closed, SampledSystem) else flow
    equations = replace(point.equations, closed_loop=moved)
    return linear_loop_about(rest_point(equations, point.instant, values, baseline.rests, None, point.substeps))


def _taken(layout: Layout, step: StepMap, row: Array) -> Array:
    """The numbers of a layout by their names from parameters, then states, of a step, else its defaults."""
    places, default = _places(layout, step)
    spots = np.array(places, dtype=int)
    return np.where(spots < 0, default, row[spots])


def _can_be_cut(loop: Loop | Ode | SampledSystem) -> bool:
    """True for a loop that makes equations with inputs where it is cut; equations themselves have none."""
    make = _maker(loop)
    return make is not None and "inputs" in signature(make).parameters


def _maker(loop: Loop | Ode | SampledSystem) -> Callable[..., Ode | SampledSystem] | None:
    """The function that makes the equations of a loop, or of the one that a computer closes; equations have none."""
    return getattr(getattr(loop, "loop", loop), "ode", None)


def refuse_large(step: StepMap) -> None:
    """Refuse a loop whose Jacobians take too long to compile: about as many operations as its step, for each state."""
    operations = step.operations * step.flow.states.size
    if operations > MOST_OPERATIONS:
        raise ValueError(
            f"The Jacobians of this loop have about {operations:,} operations, more than the {MOST_OPERATIONS:,} that "
            "its page holds; `wb.linear_loop` has its pictures in frequency."
        )


def adapting_states(loop: Loop | Ode | SampledSystem) -> tuple[str, ...]:
    """The states of a law that it multiplies with an error, as an adapting gain, and those that act through them alone.

    An error is known by the reference in it.
    """
    if (make := _maker(loop)) is None:
        return ()
    try:
        flow = flow_of(make("loop", inputs=True))
    except ValueError:  # a law of a computer alone, whose memory is renewed at once
        return ()
    signals = [i for name in flow.drives for i in range(flow.outputs.size)[flow.outputs.slice(name)]]
    commands = ca.densify(flow.output[signals])
    wanted = [i for name in flow.inputs if name.endswith("_ref") for i in flow.parameters.indices(name)]
    own = [name for name in flow.states.names if name.startswith("controller.")]
    if not wanted or not own:
        return ()
    by_states = ca.vec(ca.densify(ca.jacobian(commands, flow.x)))
    product = np.array(ca.DM(ca.jacobian_sparsity(by_states, flow.p[wanted]), 1), dtype=bool).any(axis=1)
    bends = np.asarray(product.reshape((commands.numel(), flow.states.size), order="F").any(axis=0))
    gains = {name for name in own if bends[flow.states.slice(name)].any()}
    steps = np.array(ca.DM(ca.jacobian_sparsity(ca.densify(flow.rate), flow.x), 1), dtype=bool)
    steps |= np.eye(len(steps), dtype=bool)
    kept = np.array([not any(i in flow.states.indices(name) for name in gains) for i in range(len(steps))])
    reach = closure(steps & kept[:, np.newaxis])
    seen = np.array(ca.DM(ca.jacobian_sparsity(commands, flow.x), 1), dtype=bool).any(axis=0) & kept
    acting = np.asarray(reach[seen].any(axis=0))
    return tuple(name for name in own if name in gains or (gains and not acting[flow.states.slice(name)].any()))


def _plain(baseline: Baseline, step: StepMap, modules: Modules) -> dict[str, object]:
    """The data of a loop with an answer."""
    point, models = baseline.linear.point, baseline.linear.models
    equations = point.equations
    closed, opened = equations.closed_loop, equations.open_loop
    assert opened is not None
    drives = len(equations.drive)
    if isinstance(opened, SampledSystem):
        marches = computer_marches(opened, drives, step.substeps, modules)
    else:
        marches = continuous_marches(opened, drives, modules)
    must = resting_states(closed, equations.ports) if baseline.rests else np.zeros(closed.states.size, dtype=bool)
    L, labels = models.kind("", "L"), labels_of(closed.states)
    known = _places(flow_of(opened).parameters, step)
    return {
        "channels": list(baseline.linear.channels),
        "period": baseline.linear.period,
        "omega": grid(baseline.linear).tolist(),
        "open_poles": len(L.states),
        "said": baseline.sentence,
        "rests": baseline.rests,
        "held": list(baseline.frozen_states),
        "labels": list(labels),
        "t": point.instant.t,
        "places": known[0],
        "given": plain(known[1]),
        "states": _places(closed.states, step)[0],
        "drive": flow_of(opened).parameters.indices("drive"),
        "must": np.flatnonzero(must).tolist(),
        "follows": _follows(closed) if baseline.rests else [],
        "read": [[label in model.states for label in labels] for model in (models.closed_model, L)],
        **marches,
    }


def _places(layout: Layout, step: StepMap) -> tuple[list[int], Array]:
    """The places of numbers of a layout among parameters, then states, of the step of a page, -1 where it has none."""
    row = np.full(layout.size, -1)
    for entry in layout.entries:
        if entry.name in step.parameters:
            row[layout.slice(entry.name)] = step.parameters.indices(entry.name)
        elif entry.name in step.states:
            row[layout.slice(entry.name)] = step.parameters.size + np.array(step.states.indices(entry.name))
    return row.tolist(), layout.default


def _follows(closed: Ode | SampledSystem) -> list[int]:
    """The states of a computer that follow from others at an instant, and not from themselves by way of any."""
    if not isinstance(closed, SampledSystem):
        return []
    jump = jump_of(closed)
    by = np.array(ca.DM(ca.jacobian_sparsity(ca.densify(jump.rate), jump.x), 1), dtype=bool)
    returns = (by & closure(by | np.eye(len(by), dtype=bool)).T).any(axis=1)
    return [int(i) for i in np.flatnonzero(~returns)]


def grid(linear: LinearLoop) -> Array:
    """Frequencies in rad/s that rise from far below the slowest pole to far above the fastest, or to Nyquist's.

    A pole of little damping has more about it, as its peak would fall between two.
    """
    period = linear.period
    poles = np.concatenate(
        [np.linalg.eigvals(M.A[0]) for M in (linear.models.closed_model, linear.models.kind("", "L"))]
    )
    if period is not None:
        with np.errstate(divide="ignore"):
            poles = np.log(poles[poles != 0].astype(complex)) / period
    sizes = np.abs(poles)
    sizes = sizes[sizes > INTEGRATOR * sizes.max(initial=0.0)]
    slowest, fastest = (float(sizes.min()), float(sizes.max())) if sizes.size else (1.0, 1.0)
    high = BEYOND * fastest if period is None else np.pi / period
    low = max(min(slowest, high) / BEYOND, high / 10**MOST_DECADES)
    omega = np.geomspace(low, high, FREQUENCIES)
    omega[-1] = high
    damping = np.abs(poles.real) / np.maximum(np.abs(poles), np.finfo(float).tiny)
    light = poles[(damping < LIGHT) & (damping >= SHARPEST) & (poles.imag > 0)]
    more = np.concatenate([omega, *[pole.imag + np.abs(pole.real) * AROUND for pole in light]])
    return np.unique(more[(more >= low) & (more <= high)])
