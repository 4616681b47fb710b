"""Linear models at a point, in continuous time and of one period of a computer, as systems of python-control."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from workbench.core import Ode, SampledSystem
from workbench.core.point import AT_REST, OperatingPoint, rate_terms
from workbench.core.validation.number_types import Numbers
from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments
from workbench.design.linear.linear_period import one_period
from workbench.design.linear.operating_point import (
    inputs_of,
    names_of,
    places_of,
    refuse_jump_at,
    row_of,
    time_of,
    vector_of,
)
from workbench.design.linear.switching_functions import (
    Mask,
    Sides,
    SwitchingFunctions,
    UsedEntries,
    all_entries,
    sure_jacobians,
)

if TYPE_CHECKING:
    import control

    from workbench.design.linear.pointed_systems import PointedSpace


@check_arguments
def linearize(
    ode: Ode | SampledSystem,
    t: float,
    x: Numbers,
    p: Numbers | None = None,
    u: Numbers | None = None,
    *,
    at_rest: bool = False,
    side: Sides = None,
) -> PointedSpace:
    """The linear system dx' = A dx + B du, dy = Cy dx + D du about a state, with the names of `ode`.

    It is a `StateSpace` of python-control that carries its point: `x0`, `u0` and `y0`, and in `point` their names and
    units. Laws designed from it act about that point, too. For a `SampledSystem` the model is dx+ = A dx + B du over
    one sampling period from t on: the update of the law at t, then the exact solution of the plant up to the next
    instant. The matrices are exact Jacobians.

    Parameters
    ----------
    t, x
        Time in s, and the state (nx,), each number in its unit.
    p, u
        The parameter vector (np,), and the inputs (nu,). The inputs are entries of p; a given u replaces these entries.
    at_rest
        True if the state must be an equilibrium; otherwise this is not checked.
    side
        Where the state lies on a corner, of a saturation or of |s|, the side whose Jacobians are wanted: "above" or
        "below" for all states and inputs a little larger or smaller, or a direction: {"u": 1, "q[0]": -1}.

    Raises
    ------
    ValueError
        If t, x, p or u is not of its size or not finite, if `ode` declares no inputs or has no outputs, if a Jacobian
        is not finite, if the rate jumps at the state, if a Jacobian that is returned has different values on the pieces
        that meet there and no `side` is given, or if the state must be an equilibrium and is not one.

    Examples
    --------
    >>> linear = wb.linearize(wb.open_loop(wb.CartPole()), t=0.0, x=[0.0, 0.0, np.pi, 0.0], at_rest=True)
    >>> linear.A[3, 2].round(2), linear.input_labels, linear.y0.round(2)
    (np.float64(-31.18), ['F'], array([0.  , 3.14]))
    """
    return linear_model("linearize", ode, t, x, row_of(_flow_of(ode), p, u), at_rest, side)


def _flow_of(ode: Ode | SampledSystem) -> Ode:
    return ode.flow if isinstance(ode, SampledSystem) else ode


def linear_model(
    call: str,
    ode: Ode | SampledSystem,
    t: float,
    x: Numbers,
    row: Array,
    at_rest: bool = False,
    side: Sides = None,
    used_entries: UsedEntries = all_entries,
) -> PointedSpace:
    """The linear model at parameters (np,) which hold the inputs too; refusals name the call."""
    import control

    from workbench.design.linear.pointed_systems import PointedSpace

    flow, state, time = _flow_of(ode), vector_of("x", x, ode.states), time_of(t)
    for what, size in (("input", len(flow.inputs)), ("output", ode.outputs.size)):
        if size == 0:
            alone = "" if isinstance(ode, SampledSystem) else " Take `ode.A(t, x, p)` for the matrix A alone."
            way = "ClosedLoop.ode(" if isinstance(ode, Ode) else "ClosedLoop.digital(period, "
            more = f" A loop has as inputs what comes from outside by `{way}inputs=True)`." if what == "input" else ""
            raise ValueError(
                f"`{call}(ode)` needs at least one {what}, as python-control's `StateSpace` does; "
                f"'{ode.name}' has none.{alone}{more}"
            )
    if isinstance(ode, SampledSystem):
        period = one_period(call, ode, time, state, row, side, used_entries)
        matrices, output, dt = period.matrices, period.output, ode.period
        moving = step_motion(ode, state, period.end, matrices[0])
    else:
        refuse_jump_at(call, ode, time, state, row)
        matrices, dt = sure_jacobians(call, SwitchingFunctions.of(ode), time, state, row, side, used_entries), 0
        output = np.array(ode.h(time, state, row)).ravel()
        moving = motion(ode, time, state, row, matrices[0])
    if at_rest and moving:
        raise ValueError(
            f"`{call}(x=...)` must be a rest point of '{ode.name}'; at t = {time:g} {moving}. Take a point of "
            "`equilibria(...)`, or the inputs of `operating_point(...)`."
        )
    point = OperatingPoint(ode.states, inputs_of(flow), ode.outputs, state, row[places_of(flow)], output, moving)
    return PointedSpace(control.ss(*matrices, dt, name=ode.name, **names_of(flow)), point)


def motion(ode: Ode, t: float, x: Array, p: Array, A: Array, mask: Mask | np.bool = np.True_) -> str:
    """The state that moves, of those in the mask, with its rate, in words; empty at a rest point."""
    rate = ode.rate_at(t, x, p)
    return _in_words(ode, x, rate, np.abs(rate) / rate_terms(A, x) * mask)


def step_motion(system: SampledSystem, x: Array, end: Array, A: Array, mask: Mask | np.bool = np.True_) -> str:
    """The state that a period changes, of those in the mask on which the next one depends; empty if it rests."""
    return _in_words(system, x, end - x, np.abs(end - x) / (1 + np.abs(x)) * A.any(axis=0) * mask)


def _in_words(ode: Ode | SampledSystem, x: Array, change: Array, share: Array) -> str:
    worst = int(np.argmax(np.where(np.isnan(share), np.inf, share)))
    if share[worst] <= AT_REST:
        return ""
    label = ode.states.labels[worst]
    if isinstance(ode, SampledSystem):
        return f"'{label}' changes from {x[worst]:.3g} to {x[worst] + change[worst]:.3g} over a period"
    return f"the rate of '{label}' is {change[worst]:.3g}"


@check_arguments
def to_control(ode: Ode, p: Numbers | None = None, name: str | None = None) -> control.NonlinearIOSystem:
    """The system x' = f(t, x, u), y = h(t, x, u) of python-control, with the names of `ode` and its CasADi functions.

    States, inputs and outputs are named number by number, as in `q[0]`; the inputs are the declared ones, which
    overwrite theirs in the parameters p (np,).

    Raises
    ------
    ValueError
        If p does not hold np finite numbers within their bounds.

    Examples
    --------
    >>> from workbench.design.linear import to_control
    >>> to_control(wb.open_loop(wb.DCMotor())).nstates
    2
    """
    import control

    row = row_of(ode, p)
    driven = places_of(ode)

    def with_input(u: Array) -> Array:
        values = row.copy()
        values[driven] = u
        return values

    def update(t: float, x: Array, u: Array, params: object) -> Array:
        return np.array(ode.f(t, x, with_input(u))).ravel()

    def output(t: float, x: Array, u: Array, params: object) -> Array:
        return np.array(ode.h(t, x, with_input(u))).ravel()

    return control.nlsys(update, output, name=name or ode.name, **names_of(ode))
