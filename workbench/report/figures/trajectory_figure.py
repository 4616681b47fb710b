"""Trajectories as a figure of matplotlib's own axes, for a notebook: a panel a signal, a line a run or law."""

from __future__ import annotations

from collections.abc import Mapping
from textwrap import wrap

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from workbench.core import StepMap
from workbench.core.piecewise_constant import is_piecewise_constant
from workbench.core.validation.refusals import Array, known_name, whole
from workbench.core.validation.signatures import check_arguments
from workbench.engine import Trajectories
from workbench.report.figures.style import LINES
from workbench.study.document.figure import STYLES

WARNING = "#a00000"  # the colour of what warns
LETTERS = 95  # of a warning in a line
BEYOND = 10.0  # times the size of all else in a panel, at which the curve of a run that diverges is cut off


@check_arguments
def plot_runs(runs: Trajectories | Mapping[str, Trajectories], *names: str, run: int | None = None) -> Figure:
    """Signals over time by matplotlib: a panel for each, with its unit, and a line for each number, run and law.

    The `runs` are of one loop, or of several by the names of their laws, which then share the panels. The `names` are
    of states or outputs; without any what the loop follows, or else what its plant gives, and the commands are drawn,
    or all outputs, or all states. `run` is the number of the one that is drawn; None for all. A run that diverged ends
    at a cross, and the title says when, in which state, and what else is to be known of the step.

    Raises
    ------
    LookupError
        If there is no such signal.
    ValueError
        If there is nothing to draw, no run of that number, or more lines in a panel than there are styles.

    Examples
    --------
    >>> runs = wb.simulate(wb.open_loop(wb.DCMotor()), until=1.0)
    >>> figure = wb.plot(runs, "omega")
    >>> len(figure.axes)
    1
    """
    held = dict(runs) if isinstance(runs, Mapping) else {"": runs}
    if not held:
        raise ValueError("`plot(runs)` must be trajectories, or a mapping from laws to theirs; got an empty mapping.")
    signals = names or next(iter(held.values())).step.flow.default_signals
    canvas = Figure(figsize=(6.3, 0.3 + 2.1 * len(signals)), layout="constrained")
    panels = canvas.subplots(len(signals), 1, sharex=True, squeeze=False)[:, 0]
    for name, ax in zip(signals, panels, strict=True):
        _draw(ax, name, held, run)
    panels[-1].set_xlabel("time [s]")
    if sentences := [f"{law}: {said}" if law else said for law, runs in held.items() for said in runs.warnings]:
        lines = [line for said in sentences for line in wrap(f"{said[0].upper()}{said[1:]}.", LETTERS)]
        panels[0].set_title("\n".join(lines), loc="left", fontsize="small", color=WARNING)
    entries: dict[str, Artist] = {}
    for ax in panels:
        handles, labels = ax.get_legend_handles_labels()
        entries |= dict(zip(labels, handles, strict=True)) | entries
    if entries:
        canvas.legend(entries.values(), entries.keys(), loc="outside upper center", ncols=min(4, len(entries)))
    return canvas


def _draw(ax: Axes, name: str, held: Mapping[str, Trajectories], run: int | None) -> None:
    """A signal of all laws, over its reference."""
    count, units = 0, ""
    calm: list[Array] = []
    lost: list[tuple[Array, Array, float, str]] = []
    for law, runs in held.items():
        step = runs.step
        known_name(name, dict.fromkeys((*step.states.names, *step.outputs.names)), "states and outputs of these runs")
        entry = step.states[name] if name in step.states else step.outputs[name]
        chosen = range(len(runs)) if run is None else [whole("plot(run=...)", run, 0, len(runs) - 1)]
        units = units or ", ".join(dict.fromkeys(filter(None, entry.units)))
        for i in chosen:
            flat = runs[name][i].reshape(len(runs.t), -1, order="F")
            for place, (label, y) in enumerate(zip(entry.labels(), flat.T, strict=True)):
                parts = (law, label if entry.size > 1 else "", f"run {i}" if len(chosen) > 1 else "")
                look = LINES[count % STYLES]
                ax.plot(
                    runs.t,
                    y,
                    label=", ".join(filter(None, parts)),
                    drawstyle=_drawstyle(step, name, place),
                    color=look["color"],
                    linestyle=look["linestyle"],
                    linewidth=look["linewidth"],
                )
                if runs.has_diverged[i]:
                    lost.append((runs.t, y, runs.diverged_at[i], look["color"]))
                else:
                    calm.append(y)
                count += 1
    if count > STYLES:
        raise ValueError(
            f"`plot(...)` draws up to {STYLES} lines in a panel, each in a style of its own; '{name}' has {count}: "
            "name a run, as in `run=0`, or draw fewer laws."
        )
    first = next(iter(held.values()))
    if f"{name}_ref" in first.step.outputs:
        wanted = first[f"{name}_ref"][run or 0].reshape(len(first.t), -1, order="F")
        for place, y in enumerate(wanted.T):
            style = _drawstyle(first.step, f"{name}_ref", place)
            ax.plot(first.t, y, color="#b4b4b4", linewidth=3.0, zorder=1.5, label="reference", drawstyle=style)
        calm.extend(wanted.T)
    if lost:
        _mark(ax, lost, calm)
        ax.set_xlim(0, max(runs.t[-1] for runs in held.values()))
    ax.set_ylabel(f"{name} [{units}]" if units else name)
    ax.grid(True, color="#dddddd", linewidth=0.4)


def _drawstyle(step: StepMap, name: str, place: int) -> str:
    """The style in which matplotlib draws a number of a signal: steps, if it changes by jumps alone."""
    return "steps-post" if is_piecewise_constant(step.flow, name, place) else "default"


def _mark(ax: Axes, lost: list[tuple[Array, Array, float, str]], calm: list[Array]) -> None:
    """A cross where each curve that diverges ends, or leaves the panel, and a dotted line at the time of divergence.

    The panel is as high as what else there is to see: the `calm` curves, and the others up to ten times their size.
    """
    numbers = np.concatenate([*calm, *(y[:1] for _, y, _, _ in lost)])
    reach = BEYOND * (float(np.abs(numbers[np.isfinite(numbers)]).max(initial=0.0)) or 1.0)
    ends = [numbers[np.isfinite(numbers)]]
    for t, y, at, color in lost:
        outside = np.abs(np.nan_to_num(y, nan=np.inf)) > reach
        last = max(int(np.argmax(outside)) - 1, 0) if outside.any() else len(y) - 1
        ends.append(y[: last + 1][np.isfinite(y[: last + 1])])
        ax.plot(t[last], y[last], marker="X", markersize=8, color=color, markeredgecolor=WARNING, zorder=4)
        ax.axvline(at, color=WARNING, linestyle=":", linewidth=1.0)
    low, high = (float(limit(np.concatenate(ends), initial=0.0)) for limit in (np.min, np.max))
    margin = 0.05 * (high - low) or 1.0
    ax.set_ylim(low - margin, high + margin)
