"""The linear model of equations at one state, by exact Jacobians; corners on which it depends are refused."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from workbench.core import Ode, SampledSystem
from workbench.core.notation.program import walk
from workbench.core.validation.refusals import Array, finite
from workbench.design.linear.linear_period import jump_of, one_period
from workbench.design.linear.loop_cuts import loop_entries
from workbench.design.linear.operating_point import inputs_of, places_of, refuse_jump_at
from workbench.design.linear.switching_functions import (
    Mask,
    Sides,
    SwitchingFunctions,
    UsedEntries,
    chosen_pieces,
    corner_entries,
    side_direction,
    sure_jacobians,
)
from workbench.design.linear_loop.loop_equations import Equations, flow_of, instants_of, labels_of
from workbench.design.linear_loop.loop_model import LoopModel, lift_maps
from workbench.proofs.interval import jumps


@dataclass(frozen=True, eq=False)
class Instant:
    """The time t in s at which equations are linear, and in a computer the first of `count` instants that recur."""

    t: float
    count: int = 1

    @staticmethod
    def of(call: str, equations: Equations, t: object) -> Instant:
        """The instant at the time t in s; the first that is like all later ones, where a computer begins otherwise."""
        t = finite(f"{call}(t=...)", t, " of seconds")
        if not isinstance(equations, SampledSystem):
            return Instant(t)
        count, _ = instants_of(equations)
        k = round(t / equations.period)
        if abs(t / equations.period - k) > 1e-6 or k < 0:
            raise ValueError(
                f"`{call}(t=...)` must be a multiple of the period {equations.period:g} s, from zero on; got {t:g} s."
            )
        jump = jump_of(equations)
        first = count if k == 0 and jumps(walk(ca.densify(jump.rate)), [jump.t.name()]) else k
        return Instant(first * equations.period, count)


@dataclass(frozen=True, eq=False)
class PointModel:
    """The model at a state, its outputs (ny,) there, and the outputs on a corner, whose rows are NaN."""

    model: LoopModel
    output: Array
    corner_signals: tuple[str, ...]


def point_model(
    call: str,
    equations: Equations,
    at: Instant,
    x: Array,
    p: Array,
    ports: Sequence[str],
    side: Sides = None,
    substeps: int | None = None,
) -> PointModel:
    """The linear model at a state (nx,) and parameters (np,).

    The outputs `ports` must have a Jacobian, as the states that reach them must. Other outputs on a corner are named,
    and their rows are NaN.
    """
    flow, n = flow_of(equations), equations.states.size
    names = (labels_of(flow.states), input_labels(flow), labels_of(flow.outputs))
    spare = np.array([label.partition("[")[0] not in ports for label in names[2]], dtype=bool)
    used = _uses(n, spare)
    if isinstance(equations, Ode):
        matrices, odd = _continuous(call, equations, at.t, x, p, side, used)
        rows, period = [np.array(M)[np.newaxis] for M in matrices], None
        output = np.array(equations.h(at.t, x, p)).ravel()
    else:
        maps, odd, period, output, state = [], np.zeros(equations.outputs.size, dtype=bool), equations.period, None, x
        for k in range(at.count):
            t = at.t + k * equations.period
            one = one_period(call, equations, t, state, p, side, used, substeps=substeps, is_lifted=at.count > 1)
            A, B, Cy, D = one.matrices
            maps.append((A[np.newaxis], B[np.newaxis], Cy[np.newaxis], D[np.newaxis]))
            odd, state = odd | one.odd, one.end
            output = one.output if output is None else output
        rows = list(lift_maps(maps))
    odd = odd & spare
    assert output is not None
    for i in np.flatnonzero(np.tile(odd, at.count)):
        rows[2][:, i], rows[3][:, i] = np.nan, np.nan
    bent = tuple(names[2][i] for i in np.flatnonzero(odd))
    A, B, Cy, D = rows
    return PointModel(LoopModel(A, B, Cy, D, *names, period, at.count), output, bent)


def input_labels(flow: Ode) -> tuple[str, ...]:
    """The names of the numbers of the declared inputs."""
    return labels_of(inputs_of(flow))


def _uses(n: int, spare: Mask) -> UsedEntries:
    rows = np.concatenate([np.zeros(n, dtype=bool), spare])

    def used_entries(pattern: Mask) -> Mask:
        """True for the entries on which all outputs but the spare ones, and all poles, depend."""
        mask = loop_entries(np.where(rows[:, np.newaxis], False, pattern), n)
        return np.where(rows[:, np.newaxis], False, mask)

    return used_entries


def _continuous(
    call: str, ode: Ode, t: float, x: Array, p: Array, side: Sides, used_entries: UsedEntries
) -> tuple[tuple[Array, Array, Array, Array], Mask]:
    """The Jacobians at a state, and the outputs whose rows differ between the pieces that meet there."""
    refuse_jump_at(call, ode, t, x, p)
    corners, n = SwitchingFunctions.of(ode).at(t, x, p), len(x)
    matrices = sure_jacobians(call, corners, t, x, p, side, used_entries)
    pieces = corners.pieces(t, x, p)
    step = side_direction(call, corners, side, x, p[places_of(ode)])
    if pieces and step is not None:
        pieces = chosen_pieces(corners, pieces, step, (t, x, p))
    odd = corner_entries(pieces)[n:].any(axis=1) if pieces else np.zeros(ode.outputs.size, dtype=bool)
    return matrices, np.asarray(odd)
