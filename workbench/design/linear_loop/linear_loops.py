"""The call by which a loop becomes linear: about the state at which it rests, or frozen where it starts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from workbench.core import Sampled
from workbench.core.point import AT_REST
from workbench.design.linear_loop.frequency_answers import CutModels
from workbench.design.linear_loop.linear_loop import LinearLoop
from workbench.design.linear_loop.loop_equations import LoopEquations, split_values
from workbench.design.linear_loop.loop_point import LoopPoint, point_models, straight
from workbench.design.linear_loop.point_model import Instant
from workbench.design.linear_loop.rest_state import find_rest, motion_of, resting_states, start_of, unrest
from workbench.design.matrices import Refused
from workbench.validation.refusals import finite, whole
from workbench.validation.signatures import door

CALL = "linear_loop"


@door
def linear_loop(
    loop: Any,
    at: str | tuple[str, ...] | None = None,
    values: Mapping[str, Any] | None = None,
    *,
    t: float = 0.0,
    freeze: tuple[str, ...] = (),
    delays: Mapping[str, float] | None = None,
    at_rest: bool = True,
    side: Any = None,
    substeps: int | None = None,
) -> LinearLoop:
    """The linear answers of a loop, by exact Jacobians, about the state at which it rests.

    A loop in a computer is not approximated: the map of its period is the exact Jacobian of the jump (readings, law,
    queue of commands, updates of all memories) and of the flow of the plant behind the hold. If blocks run at several
    periods, the maps over their common one are lifted.

    Parameters
    ----------
    loop
        A `ClosedLoop`, or a `DigitalLoop` for one in its computer. Equations (an `Ode` or a `Sampled` with inputs) are
        taken too, and answer of="closed" alone.
    at
        Inputs or outputs of the plant at which the loop is cut, as names or single numbers such as `tau[0]`; all
        inputs if not given.
    values
        Parameters and states by name, in the place of their own values. The rest state is sought from the initial
        state, and states that are named keep their values.
    t
        The time in s of references and disturbances, a multiple of the period of a computer.
    freeze
        States that are held, as an adapting gain is: parameters take their places.
    delays
        Delays in s by port, after which a signal acts on the plant or is read, exact at every frequency. A computer has
        its own: `DigitalLoop(delay=...)`.
    at_rest
        False if the loop need not rest: it is then frozen where it starts.
    side
        The side of a corner, as of `linearize`.
    substeps
        Of a computer, the number of Runge-Kutta steps in which a run takes each period, if the Jacobian is to be that
        of the run's own step; without it the flow is exact.

    Raises
    ------
    LookupError
        If `at` or `delays` names no port, `values` no parameter or state, or `freeze` no state.
    ValueError
        If `loop` is none of these, a value is out of its bounds, the reference or a disturbance moves in time, a
        Jacobian that counts has a corner, or blocks of a computer have no common period.
    Refused
        If no rest state is found: what still moves is named.

    Examples
    --------
    >>> motor = wb.DCMotor()
    >>> law = wb.PID2(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0)
    >>> linear = wb.linear_loop(wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0)))
    >>> linear.margins()["v"].margins.phase_margin.value.__round__(2)
    38.67
    >>> linear.response([1.0, 10.0], "closed", "omega_ref", "omega").bode().decibels.ravel().round(2)
    array([0.03, 3.01])
    """
    if substeps is not None:
        whole(f"{CALL}(substeps=...)", substeps)
    equations = LoopEquations.of(CALL, loop, (at,) if isinstance(at, str) else at, delays or {}, freeze)
    closed = equations.closed
    rows, parameters, fixed = split_values(CALL, closed, values or {})
    if len(rows) > 1:
        raise ValueError(
            f"`{CALL}(values=...)` takes one value for each name; got {len(rows)} rows. Make the loop linear once, and "
            "take `linear_loop(...).rows(values)`."
        )
    instant = Instant.of(CALL, closed, finite(f"{CALL}(t=...)", t, " of seconds"))
    must = resting_states(closed, equations.ports)
    kept = fixed if at_rest else list(range(closed.states.size))
    motion = motion_of(CALL, closed, instant, substeps)
    start = start_of(closed, instant, rows, parameters, kept)
    rows, share = find_rest(motion, start, parameters, must, kept, isinstance(closed, Sampled))
    x, p = rows[0], parameters[0]
    (moving,) = unrest(CALL, closed, instant, rows, parameters, share, must) if at_rest else ("",)
    if moving:
        raise Refused(moving)
    closed_model, opened_model = point_models(CALL, equations, instant, x, p, side, substeps)
    bent = tuple(dict.fromkeys((*closed_model.bent, *(opened_model.bent if opened_model else ()))))
    models = CutModels(
        straight(closed_model.model, bent),
        None if opened_model is None else straight(opened_model.model, bent),
        equations.channels,
        np.array(equations.delays),
    )
    resting = bool((share <= AT_REST).all())
    return LinearLoop(LoopPoint(equations, instant, x, p, bent, resting, side, substeps), models)
