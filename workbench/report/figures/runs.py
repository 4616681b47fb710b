"""Trajectories as a figure: a panel a signal, a line a run or law."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure as Canvas

from workbench.core import Entry
from workbench.report.figures.axes import plot
from workbench.simulate import Trajectories
from workbench.study.document.curves import STYLES, Array, Series
from workbench.study.document.document import Figure
from workbench.study.document.panel import Panel
from workbench.validation.refusals import described, nearest, whole
from workbench.validation.signatures import door


@door
def plot_runs(runs: Trajectories | Mapping[str, Trajectories], *names: str, run: int | None = None) -> Canvas:
    """Signals over time by matplotlib: a panel for each, with its unit, and a line for each number, run and law.

    Parameters
    ----------
    runs
        Those of one loop, or of several by the names of their laws, which then share the panels.
    names
        Of states or outputs; without any what the loop follows and drives, or all outputs, or all states.
    run
        The number of the run that is drawn; None for all.

    Raises
    ------
    LookupError
        If there is no such signal.
    ValueError
        If there is nothing to draw, no run of that number, or more lines in a panel than there are styles.

    Examples
    --------
    >>> runs = wb.simulate(wb.rk4(wb.open_loop(wb.DCMotor()), 1e-3), until=1.0)
    >>> figure = wb.plot(runs, "omega")
    >>> len(figure.axes)
    1
    """
    held = dict(runs) if isinstance(runs, Mapping) else {"": runs}
    if not held:
        raise ValueError("`plot(runs)` must be trajectories, or a mapping from laws to theirs; got an empty mapping.")
    shown = names or _usual(next(iter(held.values())))
    panels = tuple(_panel(name, held, run) for name in shown)
    return plot(Figure("trajectories", "", panels))


def _usual(runs: Trajectories) -> tuple[str, ...]:
    flow = runs.step.flow
    applied = (f"{name}_applied" for name in flow.drives)
    loop = (*flow.follows, *(name for name in applied if name in flow.outputs))
    return loop or runs.step.outputs.names or runs.step.states.names


def _panel(name: str, held: Mapping[str, Trajectories], run: int | None) -> Panel:
    lines: list[tuple[str, Array, Array]] = []
    for law, runs in held.items():
        entry = _entry(runs, name)
        chosen = range(len(runs)) if run is None else [whole("plot(run=...)", run, 0, len(runs) - 1)]
        for i in chosen:
            flat = runs[name][i].reshape(len(runs.t), -1, order="F")
            for label, y in zip(entry.labels(), flat.T, strict=True):
                parts = (law, label if entry.size > 1 else "", f"run {i}" if len(chosen) > 1 else "")
                lines.append((", ".join(filter(None, parts)), runs.t, np.where(np.isfinite(y), y, np.nan)))
    if len(lines) > STYLES:
        raise ValueError(
            f"`plot(...)` draws up to {STYLES} lines in a panel, each in a style of its own; '{name}' has {len(lines)}"
            ": name a run, as in `run=0`, or draw fewer laws."
        )
    series = [Series(label, t, y, style) for style, (label, t, y) in enumerate(lines)]
    first = next(iter(held.values()))
    if f"{name}_ref" in first.step.outputs:
        flat = first[f"{name}_ref"][0 if run is None else run].reshape(len(first.t), -1, order="F")
        series += [Series("reference", first.t, y, "reference") for y in flat.T]
    unit = ", ".join(dict.fromkeys(filter(None, _entry(first, name).units)))
    return Panel(f"{name} [{unit}]" if unit else name, tuple(series))


def _entry(runs: Trajectories, name: str) -> Entry:
    """A state or output by name; what is both is the state, as in `runs[name]`."""
    for port in (runs.step.states, runs.step.outputs):
        if name in port:
            return port[name]
    known = dict.fromkeys((*runs.step.states.names, *runs.step.outputs.names))
    near = f"{nearest(name, known)} It has: {', '.join(known)}."
    raise LookupError(f"`plot(...)` knows no {described(name)} in {runs!r}.{near}")
