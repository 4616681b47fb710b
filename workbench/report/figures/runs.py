"""Trajectories as a figure of matplotlib's own axes, for a notebook: a panel a signal, a line a run or law."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from workbench.report.figures.style import LINES
from workbench.simulate import Trajectories
from workbench.study.document.figure import STYLES
from workbench.validation.refusals import known, whole
from workbench.validation.signatures import door


@door
def plot_runs(runs: Trajectories | Mapping[str, Trajectories], *names: str, run: int | None = None) -> Figure:
    """Signals over time by matplotlib: a panel for each, with its unit, and a line for each number, run and law.

    The `runs` are of one loop, or of several by the names of their laws, which then share the panels. The `names` are
    of states or outputs; without any what the loop follows and drives, or all outputs, or all states, is drawn. `run`
    is the number of the one that is drawn; None for all.

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
    signals = names or _usual(next(iter(held.values())))
    canvas = Figure(figsize=(6.3, 0.3 + 2.1 * len(signals)), layout="constrained")
    panels = canvas.subplots(len(signals), 1, sharex=True, squeeze=False)[:, 0]
    for name, ax in zip(signals, panels, strict=True):
        _draw(ax, name, held, run)
    panels[-1].set_xlabel("time [s]")
    entries: dict[str, Any] = {}
    for ax in panels:
        handles, labels = ax.get_legend_handles_labels()
        entries |= dict(zip(labels, handles, strict=True)) | entries
    if entries:
        canvas.legend(entries.values(), entries.keys(), loc="outside upper center", ncols=min(4, len(entries)))
    return canvas


def _usual(runs: Trajectories) -> tuple[str, ...]:
    """The signals that are drawn unless others are named."""
    flow = runs.step.flow
    applied = (f"{name}_applied" for name in flow.drives)
    loop = (*flow.follows, *(name for name in applied if name in flow.outputs))
    return loop or runs.step.outputs.names or runs.step.states.names


def _draw(ax: Axes, name: str, held: Mapping[str, Trajectories], run: int | None) -> None:
    """A signal of all laws, over its reference."""
    count, units = 0, ""
    for law, runs in held.items():
        step = runs.step
        known(name, dict.fromkeys((*step.states.names, *step.outputs.names)), "states and outputs of these runs")
        entry = step.states[name] if name in step.states else step.outputs[name]
        chosen = range(len(runs)) if run is None else [whole("plot(run=...)", run, 0, len(runs) - 1)]
        units = units or ", ".join(dict.fromkeys(filter(None, entry.units)))
        for i in chosen:
            flat = runs[name][i].reshape(len(runs.t), -1, order="F")
            for label, y in zip(entry.labels(), flat.T, strict=True):
                parts = (law, label if entry.size > 1 else "", f"run {i}" if len(chosen) > 1 else "")
                look = {key: LINES[count % STYLES][key] for key in ("color", "linestyle", "linewidth")}
                ax.plot(runs.t, y, label=", ".join(filter(None, parts)), **look)
                count += 1
    if count > STYLES:
        raise ValueError(
            f"`plot(...)` draws up to {STYLES} lines in a panel, each in a style of its own; '{name}' has {count}: "
            "name a run, as in `run=0`, or draw fewer laws."
        )
    first = next(iter(held.values()))
    if f"{name}_ref" in first.step.outputs:
        wanted = first[f"{name}_ref"][run or 0].reshape(len(first.t), -1, order="F")
        ax.plot(first.t, wanted, color="#b4b4b4", linewidth=3.0, zorder=1.5, label="reference")
    ax.set_ylabel(f"{name} [{units}]" if units else name)
    ax.grid(True, color="#dddddd", linewidth=0.4)
