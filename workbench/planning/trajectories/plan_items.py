"""The limits, boundary values and durations of a plan by name, each with the rows of the program that it makes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import casadi as ca
import numpy as np

from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments
from workbench.planning.trajectories.plan_problem import PhaseProblem
from workbench.planning.trajectories.transcription import Transcription


@dataclass(frozen=True)
@check_arguments
class PlanItem:
    """One thing that was asked of a plan.

    Parameters
    ----------
    kind
        "limit", "rate limit", "start", "end", "duration" or "periodic".
    label
        The label of the state, input or output; empty for a duration.
    side
        "low" or "high", or empty for a value.
    value
        The limit or the value, in its unit.
    phase
        The name of the phase; empty for a plan of one phase.

    Examples
    --------
    >>> str(wb.planning.PlanItem("limit", "v", "high", 15.0))
    'v <= 15'
    """

    kind: str
    label: str
    side: str
    value: float
    phase: str = ""

    def __str__(self) -> str:
        where = f"{self.phase}: " if self.phase else ""
        sign = {"low": " >= ", "high": " <= "}.get(self.side, " = ")
        named = {"limit": self.label, "rate limit": f"rate of {self.label}", "duration": "duration"}
        subject = named.get(self.kind, f"{self.kind} of {self.label}")
        return f"{where}{subject}" if self.kind == "periodic" else f"{where}{subject}{sign}{self.value:.6g}"


@dataclass(frozen=True, eq=False)
class ItemRows:
    """An item, and expressions (k, 1) that are at most zero where it holds, in the unit of `size`."""

    item: PlanItem
    excess: ca.MX
    size: float


def item_rows(transcription: Transcription) -> Iterator[ItemRows]:
    """Each item of a problem with its rows; the hard rows are the defects and the links between phases alone."""
    problem = transcription.problem
    several = len(problem.phases) > 1
    for i, phase in enumerate(problem.phases):
        name = phase.name if several else ""
        yield from _duration_rows(transcription, i, name)
        yield from _limit_rows(transcription, i, name)
        yield from _rate_rows(transcription, i, name)
        yield from _value_rows(transcription, i, "end", phase.end.low, phase.end.high, name)
        yield from _signal_end_rows(transcription, i, name)
    yield from _value_rows(transcription, 0, "start", problem.start.low, problem.start.high, "")
    for place, row in zip(problem.periodic, _periodic_rows(transcription), strict=True):
        item = PlanItem("periodic", problem.names[place], "", 0.0)
        yield ItemRows(item, ca.vertcat(row, -row), 1.0)


def _duration_rows(transcription: Transcription, i: int, name: str) -> Iterator[ItemRows]:
    phase, T, size = transcription.problem.phases[i], transcription.arcs[i].T, float(transcription.scales.T[i])
    low, high = phase.duration
    if low == high:
        row = T - low / size
        yield ItemRows(PlanItem("duration", "", "", low, name), ca.vertcat(row, -row), size)
        return
    if low > 0:
        yield ItemRows(PlanItem("duration", "", "low", low, name), low / size - T, size)
    if np.isfinite(high):
        yield ItemRows(PlanItem("duration", "", "high", high, name), T - high / size, size)


def _limit_rows(transcription: Transcription, i: int, name: str) -> Iterator[ItemRows]:
    problem, scales, arc = transcription.problem, transcription.scales, transcription.arcs[i]
    phase = problem.phases[i]
    for j, label in enumerate(problem.ode.states.labels):
        values = ca.vertcat(arc.Z[j, :].T, ca.vec(arc.C[j :: problem.nx, :]))
        yield from _sides(label, phase.x.low[j], phase.x.high[j], values, float(scales.x[j]), name)
    for j, label in enumerate(problem.inputs):
        yield from _sides(label, phase.u.low[j], phase.u.high[j], arc.V[j, :].T, float(scales.u[j]), name)
    for j, label in enumerate(phase.path_names):
        size = _size(phase, j)
        values = ca.vec(transcription.terms[i].signals[j :: len(phase.path_names), :]) / size
        yield from _sides(label, phase.g.low[j], phase.g.high[j], values, size, name)


def _size(phase: PhaseProblem, j: int) -> float:
    ends = [abs(float(end)) for end in (phase.g.low[j], phase.g.high[j]) if np.isfinite(end)]
    return max(ends, default=0.0) or 1.0


def _sides(label: str, low: float, high: float, values: ca.MX, size: float, name: str) -> Iterator[ItemRows]:
    if np.isfinite(low):
        yield ItemRows(PlanItem("limit", label, "low", float(low), name), low / size - values, size)
    if np.isfinite(high):
        yield ItemRows(PlanItem("limit", label, "high", float(high), name), values - high / size, size)


def _rate_rows(transcription: Transcription, i: int, name: str) -> Iterator[ItemRows]:
    phase, terms, problem = transcription.problem.phases[i], transcription.terms[i], transcription.problem
    if problem.hold != "linear":
        return
    for side, end, sign in phase.slope.ends:
        for j in np.flatnonzero(np.isfinite(end)):
            size = float(transcription.scales.u[j])
            excess = sign * (terms.slopes[int(j), :] - float(end[j]) / size * terms.h)
            yield ItemRows(PlanItem("rate limit", problem.inputs[j], side, float(end[j]), name), excess.T, size)


def _value_rows(
    transcription: Transcription, i: int, kind: str, low: Array, high: Array, name: str
) -> Iterator[ItemRows]:
    problem, arc = transcription.problem, transcription.arcs[i]
    sizes = np.concatenate([transcription.scales.x, transcription.scales.u])
    k = 0 if kind == "start" else -1
    node = ca.vertcat(arc.Z[:, k], arc.V[:, k])
    for j in np.flatnonzero(np.isfinite(low) & np.isfinite(high)):
        row = node[int(j)] - float(low[j] / sizes[j])
        item = PlanItem(kind, problem.names[j], "", float(low[j]), name)
        yield ItemRows(item, ca.vertcat(row, -row), float(sizes[j]))


def _signal_end_rows(transcription: Transcription, i: int, name: str) -> Iterator[ItemRows]:
    phase = transcription.problem.phases[i]
    last = transcription.terms[i].signals[-len(phase.path_names) :, -1] if phase.path_names else ca.MX(0, 1)
    for j in np.flatnonzero(np.isfinite(phase.g_end.low)):
        value = float(phase.g_end.low[j])
        size = abs(value) or _size(phase, int(j))
        row = (last[int(j)] - value) / size
        yield ItemRows(PlanItem("end", phase.path_names[j], "", value, name), ca.vertcat(row, -row), size)


def _periodic_rows(transcription: Transcription) -> list[ca.MX]:
    links = transcription.links
    count = len(transcription.problem.periodic)
    return [links[links.numel() - count + k] for k in range(count)]
