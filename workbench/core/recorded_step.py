"""A step of an `Ode` along given instants, with recorded signals in the place of some of its parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from workbench.core.layout import Entry, Layout
from workbench.core.methods import RK4
from workbench.core.ode import Ode
from workbench.core.step import StepMap, StepRule
from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments


@dataclass(frozen=True, eq=False)
@check_arguments
class SignalRecord:
    """Numbers over time between N + 1 instants: in each of the N intervals they change along a straight line.

    Parameters
    ----------
    t
        (N + 1,), the instants in s, which do not decrease; two may be one, where a delay parts them.
    labels
        The nd parameters of an `Ode` that the numbers replace, as `v` or `u[0]`.
    begins, ends
        (N, nd), the numbers at the begin and at the end of each interval. A jump lies between two intervals.

    Raises
    ------
    ValueError
        If the instants decrease, or the shapes do not fit each other.
    """

    t: Array
    labels: tuple[str, ...]
    begins: Array
    ends: Array

    def __post_init__(self) -> None:
        shape = (self.t.size - 1, len(self.labels))
        if self.t.ndim != 1 or self.t.size < 2 or not (np.diff(self.t) >= 0).all():
            raise ValueError("`SignalRecord(t=...)` must be at least two instants that do not decrease.")
        if self.begins.shape != shape or self.ends.shape != shape:
            raise ValueError(
                f"`SignalRecord(begins=..., ends=...)` must have shape {shape}, a row for each interval and a column "
                f"for each label; got {self.begins.shape} and {self.ends.shape}."
            )

    @property
    def rows(self) -> Array:
        """(N, 2 + 2 nd): of each interval its middle and length in s, and the middle and change of each number."""
        return record_rows(self.t, self.begins, self.ends)


def record_rows(t: Array, begins: Array, ends: Array) -> Array:
    """The rows (N, 2 + 2 nd) of a `SignalRecord`, or their derivatives from those of its instants and numbers."""
    middles = (t[:-1] + t[1:]) / 2
    return np.column_stack([middles, np.diff(t), (begins + ends) / 2, ends - begins])


@check_arguments
def recorded_step(ode: Ode, recording: SignalRecord) -> StepMap:
    """A Runge-Kutta step from each instant of a recording to the next, as a `StepMap` whose time is their number.

        x' = dt f(tm + s dt, x, p),   s from -1/2 to 1/2,   with the recorded parameters u = um + s du

    The instants are those of the recording, so that samples that jitter are met. What jumps in time within an interval
    is decided at its middle: let the jump be an instant.

    Raises
    ------
    LookupError
        If a label is no parameter of the equation.
    """
    places = [place for label in recording.labels for place in ode.parameters.indices(label)]
    nd, switches = len(places), ode.switches
    h, k, t, m = (ca.SX.sym(name) for name in ("h", "k", "t", "m"))
    d = ca.SX.sym("d", 2 + 2 * nd)
    middle, length, values, changes = d[0], d[1], d[2 : 2 + nd], d[2 + nd :]
    rate = switches.rate if switches.has_instants else ode.rate

    def along(expression: ca.SX, s: ca.SX | float) -> ca.SX:
        symbols = ca.vertcat(ode.t, switches.m, ode.p[places])
        return ca.substitute(expression, symbols, ca.vertcat(middle + s * length, middle, values + s * changes))

    rule = StepRule(
        h, k, t, ode.x, ode.p, ca.SX(0, 1), length * along(rate, t - m), ca.SX(0, 1), along(ode.output, -0.5), m=m, d=d
    )
    return StepMap(
        1.0,
        ode.states,
        ode.parameters,
        ode.outputs,
        rule,
        ode,
        RK4.amplification,
        recorded_numbers=recording.rows,
    )


@check_arguments
def with_directions(step: StepMap, parameters: tuple[int, ...], slopes: Mapping[str, Array] | None = None) -> StepMap:
    """The step with a direction of change carried along: S+ = (dF/dx) S + (dF/dp) e_p + (dF/dd) D e_d.

    The states 'change of x' (nx,) and 'direction of change' (m,) follow those of the step. A run whose direction is a
    unit vector carries the derivative with respect to one number: a parameter by its place, or a number on which the
    recorded ones depend. For an initial state the direction is zero, and S starts at a unit vector.

    Parameters
    ----------
    step
        A step of `recorded_step`, or any other.
    parameters
        The places of the parameters among all.
    slopes
        By name, the derivatives (N, nd) of the recorded numbers of each step, such as those by a delay.
    """
    rule, n = step.rule, step.states.size
    rows = dict(slopes or {})
    size = len(parameters) + len(rows)
    more = Layout(
        (Entry("change of x", np.zeros(n)), *([Entry("direction of change", np.zeros(size))] if size else []))
    )
    symbols = more.symbols()
    S, direction = symbols[:n], symbols[n:]
    in_p, of_rows = ca.SX.zeros(rule.p.numel()), ca.SX.sym("slopes", len(rows) * rule.d.numel())
    for i, place in enumerate(parameters):
        in_p[place] += direction[i]
    in_d = ca.SX.zeros(rule.d.numel())
    for i in range(len(rows)):
        in_d += direction[len(parameters) + i] * of_rows[i * rule.d.numel() : (i + 1) * rule.d.numel()]
    sources, changes = ca.vertcat(rule.x, rule.p, rule.d), ca.vertcat(S, in_p, in_d)
    update = ca.densify(ca.jtimes(rule.next, sources, changes))
    extended = replace(rule.written_out, d=ca.vertcat(rule.d, of_rows))
    numbers = step.recorded_numbers
    if rows:
        assert numbers is not None  # `slopes` are the derivatives of such numbers
        numbers = np.column_stack([numbers, *rows.values()])
    wider = replace(step, rule=extended, recorded_numbers=numbers)
    return wider.with_memory(more, symbols, ca.vertcat(update, direction))
