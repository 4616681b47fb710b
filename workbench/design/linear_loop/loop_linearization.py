"""The call by which a loop becomes linear: about the state at which it rests, or frozen where it starts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from inspect import signature
from typing import TYPE_CHECKING

import numpy as np

from workbench.core import Ode, SampledSystem
from workbench.core.equations import Loop
from workbench.core.point import AT_REST
from workbench.core.validation.number_types import Values
from workbench.core.validation.refusals import whole
from workbench.core.validation.signatures import check_arguments
from workbench.design.linear_loop.frequency_answers import CutModels
from workbench.design.linear_loop.linear_loop import LinearLoop
from workbench.design.linear_loop.loop_equations import LoopEquations, split_values
from workbench.design.linear_loop.loop_point import LoopPoint, point_models, without_corners
from workbench.design.linear_loop.point_model import Instant
from workbench.design.linear_loop.rest_state import motion_of, motion_sentences, resting_states, seek_rest, start_of
from workbench.design.matrices import DesignError

if TYPE_CHECKING:  # a door lets it pass: the corner says what is wrong with it
    from workbench.design.linear.switching_functions import Sides

CALL = "linear_loop"


@check_arguments
def linear_loop(
    loop: Loop | Ode | SampledSystem,
    at: str | tuple[str, ...] | None = None,
    values: Values | None = None,
    *,
    t: float = 0.0,
    freeze: tuple[str, ...] = (),
    delays: Mapping[str, float] | None = None,
    at_rest: bool = True,
    side: Sides = None,
    substeps: int | None = None,
) -> LinearLoop:
    """The loop linearised at the state where it rests, by exact Jacobians: loop gain, margins, poles and responses.

    A loop in a computer is its map over a period, or over the common multiple of several periods.

    Parameters
    ----------
    loop
        A `ClosedLoop` or a `DigitalLoop`; or an `Ode` with inputs, which has responses of="closed" only.
    at
        Inputs or outputs of the plant at which the loop is cut, or single numbers (`tau[0]`); all inputs by default.
    values
        Parameters and states by name. These states are kept; Newton's method seeks the others from the initial state.
    t
        The time in s of references and disturbances, a multiple of the period of a computer.
    freeze
        States that are held constant, such as an adapting gain; they become parameters.
    delays
        Delays in s by port, for a loop in continuous time; they are exact. A load enters behind the delay.
    at_rest
        True if the loop must be at rest. With False it need not rest, and is frozen where it starts.
    side
        The side of a corner, as of `linearize`.
    substeps
        The number of Runge-Kutta steps in a period of the computer; without it the flow is exact.

    Raises
    ------
    LookupError
        If `at` or `delays` names no port, `values` no parameter or state, or `freeze` no state.
    ValueError
        If `loop` is not one of these, a value is out of bounds, a Jacobian has a corner, or periods lack a multiple.
    DesignError
        If the loop does not rest: what moves is named.

    Examples
    --------
    >>> motor = wb.DCMotor()
    >>> law = wb.PID(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0)
    >>> linear = wb.linear_loop(wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0)))
    >>> linear.margins()["v"].phase_margin.value.__round__(2)
    38.67
    >>> linear.response([1.0, 10.0], "closed", "omega_ref", "omega").bode().decibels.ravel().round(2)
    array([0.03, 3.01])
    """
    equations = LoopEquations.of(CALL, loop, (at,) if isinstance(at, str) else at, delays or {}, freeze)
    point = rest_point(equations, Instant.of(CALL, equations.closed_loop, t), values or {}, at_rest, side, substeps)
    given = {"at": at, "t": t, "freeze": freeze, "delays": delays, "at_rest": at_rest, "side": side}
    return linear_loop_about(replace(point, arguments=_arguments({**given, "substeps": substeps})))


def _arguments(arguments: Mapping[str, object]) -> str:
    """The arguments that differ from the defaults of `linear_loop`, as Python writes them in a call."""
    defaults = {name: one.default for name, one in signature(linear_loop).parameters.items()}
    return "".join(f", {name}={value!r}" for name, value in arguments.items() if repr(value) != repr(defaults[name]))


def rest_point(
    equations: LoopEquations,
    instant: Instant,
    values: Values,
    at_rest: bool,
    side: Sides,
    substeps: int | None,
) -> LoopPoint:
    """The point at which a loop rests, or at which it starts; a loop that should rest and does not is refused."""
    if substeps is not None:
        whole(f"{CALL}(substeps=...)", substeps)
    closed = equations.closed_loop
    rows, parameters, fixed = split_values(CALL, closed, values)
    if len(rows) > 1:
        raise ValueError(
            f"`{CALL}(values=...)` takes one value for each name; got {len(rows)} rows. Make the loop linear once, and "
            "take `linear_loop(...).rows(values)`."
        )
    must = resting_states(closed, equations.ports)
    kept = fixed if at_rest else list(range(closed.states.size))
    motion = motion_of(CALL, closed, instant, substeps)
    start = start_of(closed, instant, rows, parameters, kept)
    found, share = seek_rest(motion, start, parameters, must, kept, isinstance(closed, SampledSystem))
    (moving,) = motion_sentences(CALL, closed, instant, found, parameters, share, must) if at_rest else ("",)
    if moving:
        raise DesignError(moving)
    resting = bool((share <= AT_REST).all())
    return LoopPoint(equations, instant, found[0], parameters[0], resting, side, substeps, tuple(fixed))


def linear_loop_about(point: LoopPoint) -> LinearLoop:
    """The linear loop about a point, without the outputs that have a corner there."""
    closed, opened = point_models(CALL, point, point.x, point.p)
    bent = tuple(dict.fromkeys((*closed.corner_signals, *(opened.corner_signals if opened else ()))))
    cut = None if opened is None else without_corners(opened.model, bent)
    delays = np.array(point.equations.delays)
    models = CutModels(without_corners(closed.model, bent), cut, point.equations.channels, delays)
    return LinearLoop(point, models, bent)
