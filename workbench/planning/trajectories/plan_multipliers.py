"""Multipliers of a plan by name: by how much the objective changes with each limit, value and duration."""

from __future__ import annotations

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.planning.trajectories.ipopt_solver import ProgramEnd
from workbench.planning.trajectories.plan_items import PlanItem, item_rows
from workbench.planning.trajectories.transcription import Transcription

TOUCH = 1e-6  # of its size, within which a limit is reached


def multipliers(end: ProgramEnd) -> dict[PlanItem, float]:
    """The derivative of the objective with respect to each limit, boundary value and duration.

    A limit that holds with room to spare has zero. That of a state is the sum over all nodes and points.
    """
    transcription = end.transcription
    parts = transcription.split(end.bound_multipliers)
    signals = _signal_multipliers(transcription, end.constraint_multipliers)
    problem, scales, slopes = transcription.problem, transcription.scales, {}
    for rows in item_rows(transcription):
        item = rows.item
        place = _phase_place(transcription, item)
        T, z, inner, v = parts[place]
        moves = list(problem.names)
        if item.kind == "duration":
            slopes[item] = -_side(T, item.side) / float(scales.T[place])
        elif item.kind == "end" and item.label not in moves:
            row = signals[place][problem.phases[place].path_names.index(item.label)]
            slopes[item] = -float(row[-1])
        elif item.kind in ("start", "end"):
            k, j = (0 if item.kind == "start" else -1), moves.index(item.label)
            value = z[k, j] / scales.x[j] if j < problem.nx else v[k, j - problem.nx] / scales.u[j - problem.nx]
            slopes[item] = -float(value)
        elif item.kind == "limit" and item.label in moves:
            j = moves.index(item.label)
            if j < problem.nx:
                free = z[:, j].copy()
                _blank(free, transcription, place, j)
                slopes[item] = -(_side(free, item.side) + _side(inner[:, :, j].ravel(), item.side)) / scales.x[j]
            else:
                slopes[item] = -_side(v[:, j - problem.nx], item.side) / scales.u[j - problem.nx]
        elif item.kind == "limit":
            j = problem.phases[place].path_names.index(item.label)
            is_fixed = bool(np.isfinite(problem.phases[place].g_end.low[j]))  # at the last point
            slopes[item] = -_side(signals[place][j][: -1 if is_fixed else None], item.side)
    return {item: float(value) for item, value in slopes.items()}


def _phase_place(transcription: Transcription, item: PlanItem) -> int:
    if item.kind == "start":
        return 0
    names = [phase.name for phase in transcription.problem.phases]
    return names.index(item.phase) if item.phase else len(names) - 1


def _blank(values: Array, transcription: Transcription, place: int, j: int) -> None:
    """Leave out the multipliers of nodes whose value is fixed, which are those of the value."""
    problem = transcription.problem
    if place == 0 and np.isfinite(problem.start.low[j]):
        values[0] = 0.0
    if np.isfinite(problem.phases[place].end.low[j]):
        values[-1] = 0.0


def _side(values: Array, side: str) -> float:
    """The sum of multipliers of one side: CasADi's are positive at an upper bound."""
    if side == "high":
        return float(np.maximum(values, 0.0).sum())
    return float(np.minimum(values, 0.0).sum()) if side == "low" else float(values.sum())


def _signal_multipliers(transcription: Transcription, lam: Array) -> list[Array]:
    """For each phase the multipliers (ng, points) of its limited outputs and signals."""
    problem, at, rows = transcription.problem, transcription.links.numel(), []
    for phase, terms in zip(problem.phases, transcription.terms, strict=True):
        at += terms.defects.numel()
        count = terms.signals.numel() if phase.path_names else 0
        names = max(len(phase.path_names), 1)
        rows.append(lam[at : at + count].reshape(-1, names).T)
        at += count
        if problem.has_slopes:
            finite = [np.isfinite(end).sum() for _, end, _ in phase.slope.ends]
            at += int(sum(finite)) * len(transcription.meshes[len(rows) - 1])
    return rows


def active_spans(end: ProgramEnd) -> dict[str, tuple[tuple[float, float], ...]]:
    """By limit, the spans of time in s over which a state, input or output lies on it at all nodes."""
    transcription, values = end.transcription, end.values
    problem, spans, begin = transcription.problem, {}, 0.0
    for phase, arc in zip(problem.phases, values, strict=True):
        t = begin + arc.T * arc.shares
        u = np.vstack([arc.u, arc.u[-1:]]) if arc.is_held else arc.u
        g = np.array(phase.path(t[np.newaxis], arc.x.T, u.T)).T if phase.path_names else np.zeros((len(t), 0))
        name = phase.name if len(problem.phases) > 1 else ""
        groups = [(problem.ode.states.labels, phase.x, arc.x), (problem.inputs, phase.u, u)]
        for labels, ends, rows in [*groups, (phase.path_names, phase.g, g)]:
            for j, label in enumerate(labels):
                for side, bounds, _ in ends.ends:
                    if np.isfinite(bounds[j]):
                        size = max(abs(float(bounds[j])), float(np.ptp(rows[:, j])))
                        touches = np.abs(rows[:, j] - bounds[j]) <= TOUCH * size
                        item = PlanItem("limit", label, side, float(bounds[j]), name)
                        if found := _spans(t, touches):
                            spans[str(item)] = found
        begin = float(t[-1])
    return spans


def _spans(t: Array, touches: Array) -> tuple[tuple[float, float], ...]:
    edges = np.flatnonzero(np.diff(np.concatenate([[0], touches.astype(int), [0]])))
    return tuple((float(t[a]), float(t[b - 1])) for a, b in zip(edges[::2], edges[1::2], strict=True))
