"""Trajectories: states over time, run by run, with the runs that diverged marked."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from workbench.core import StepMap
from workbench.core.plot_registry import draw
from workbench.core.validation.notebook_display import table_to_html
from workbench.core.validation.refusals import Array, describe, whole
from workbench.core.validation.signatures import check_arguments
from workbench.core.views import NotebookPage
from workbench.engine.divergence import Divergence
from workbench.engine.job import Job
from workbench.engine.kept_outputs import group_of
from workbench.engine.stability import span
from workbench.engine.state_bounds import StateExtremes
from workbench.engine.step_check import StepCheck, check_step

if TYPE_CHECKING:
    import pandas as pd

DIVERGENCE_COLUMN = "diverged at [s]"  # the column of a table that has the times of divergence


@dataclass(frozen=True, eq=False)
@check_arguments
class Trajectories:
    """B runs of one `StepMap` at N common times."""

    job: Job
    t: Array  # (N,), in s
    x: Array  # (B, N, nx); from the time a run has diverged its rows are NaN
    divergence: Divergence
    tolerance: float = 1e-2  # of the change of a state to half the step, relative to its largest value
    is_step_chosen: bool = False  # True if the step was chosen for that tolerance
    extremes: StateExtremes | None = None  # of states with bounds, over the steps before the last kept time

    def __post_init__(self) -> None:
        shape = (len(self.job.p), self.t.size, self.job.step.states.size)
        if self.t.ndim != 1 or self.x.shape != shape or self.t.size == 0:
            raise ValueError(
                f"`Trajectories(x=...)` must have shape {shape}, for the runs of its job, its times and states; "
                f"got {self.x.shape} and times {self.t.shape}."
            )

    @property
    def step(self) -> StepMap:
        """The step that was run."""
        return self.job.step

    @property
    def arithmetic(self) -> str:
        """The rounding of their operations: 'fused', 'portable' or 'casadi'."""
        return self.job.arithmetic

    @property
    def p(self) -> Array:
        """The parameters of each run, (B, np)."""
        return self.job.p

    @property
    def diverged_at(self) -> Array:
        """(B,), the time of the first step whose state is not finite; NaN for a run that stayed finite."""
        return self.divergence.at

    @property
    def diverged_in(self) -> tuple[str | None, ...]:
        """For each run the first of its states that was not finite at that time; None for a run that stayed finite."""
        labels = self.step.states.labels
        return tuple(labels[i] if i >= 0 else None for i in self.divergence.state)

    @property
    def has_diverged(self) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
        """(B,), true for each run that diverged."""
        return np.asarray(np.isfinite(self.diverged_at))

    @cached_property
    def check(self) -> StepCheck:
        """The stability limit of the step and the change to half of it, along up to four of the runs."""
        return check_step(self.job, self.t, self.x, self.divergence, self.tolerance, self.is_step_chosen)

    @property
    def losses(self) -> str:
        """The runs that diverged, in words, with the time and the state of the first; empty if none did."""
        if not self.has_diverged.any():
            return ""
        first = int(np.nanargmin(self.diverged_at))
        where = f"at {self.diverged_at[first]:.4g} s in '{self.diverged_in[first]}'"
        if len(self) == 1:
            return f"the run diverged {where}"
        return f"{int(self.has_diverged.sum())} of {len(self)} runs diverged, run {first} first {where}"

    @property
    def warnings(self) -> tuple[str, ...]:
        """The sentences that every view of the runs shows: which diverged, passed a bound, and have too long a step."""
        return tuple(filter(None, (self.losses, *self.excursions, *self.check.warnings)))

    @property
    def excursions(self) -> tuple[str, ...]:
        """A sentence for each state that passes a bound of its block at any step, with the time and the value."""
        return self._extremes.sentences

    @cached_property
    def _extremes(self) -> StateExtremes:
        """The extremes of the states with bounds: those that a watch has, and those of the kept times."""
        kept = StateExtremes.of_runs(self.step, self.job.begin, self.job.stride, self.x)
        return kept if self.extremes is None else self.extremes.with_later(kept)

    def __repr__(self) -> str:
        runs = f"{len(self)} run{'' if len(self) == 1 else 's'}"
        parts = [f"{runs} of '{self.step.flow.name}' at {len(self.t)} times to {self.t[-1]:g} s"]
        parts += [f"{int(self.has_diverged.sum())} diverged"] if self.has_diverged.any() else []
        if self.is_step_chosen:
            check = self.check
            parts.append(f"step of {span(check.limit.h)} chosen for a tolerance of {self.tolerance:g}")
            parts[-1] += "" if np.isnan(check.change) else f" (half of it changes a state by {check.change:.1e})"
        return f"<{'; '.join([', '.join(parts), *self.excursions, *self.check.warnings])}>"

    def _repr_html_(self) -> str:
        units = [unit for entry in self.step.states.entries for unit in entry.units]
        columns = [column[np.isfinite(column)] for column in self.x.T]
        ends = [(f"{part.min():.6g}", f"{part.max():.6g}") if part.size else ("", "") for part in columns]
        rows = [(name, unit, *end) for name, unit, end in zip(self.step.states.labels, units, ends, strict=True)]
        title = f"{repr(self)[1:-1]}; {self.losses}" if self.losses else repr(self)[1:-1]
        return table_to_html(title, ("state", "unit", "least", "largest"), rows)

    def __len__(self) -> int:
        return len(self.x)

    def __getitem__(self, name: str) -> Array:
        """A state or an output by name, (B, N, *shape); the state if both have the name."""
        if name in self.step.states:
            return self.step.states.unpack(self.x)[name]
        if name in self.step.outputs:
            return self._outputs_beside(name)[name]
        known = (*self.step.states.names, *self.step.outputs.names)
        raise LookupError(f"There is no {describe(name)} among the states and outputs: {', '.join(known)}.")

    @property
    def outputs(self) -> dict[str, Array]:
        """The outputs by name, each (B, N, *shape)."""
        return {name: self._outputs_beside(name)[name] for name in self.step.outputs.names}

    def _outputs_beside(self, name: str) -> dict[str, Array]:
        """The outputs that are evaluated with one of them, kept by the group of its name."""
        group = group_of(self.step, name)
        if group.layout.names[0] not in self._kept_outputs:
            k = np.round(self.t / self.step.h).astype(int)
            self._kept_outputs[group.layout.names[0]] = group.values(self.job, k, self.x)
        return self._kept_outputs[group.layout.names[0]]

    @cached_property
    def _kept_outputs(self) -> dict[str, dict[str, Array]]:
        """The outputs that were asked for so far, by the first name of their group."""
        return {}

    @check_arguments
    def to_frame(self, run: int | None = None) -> pd.DataFrame:
        """A table with a column per number of the states and outputs, `v [V]` or `q[0] [rad]`, and a row per time in s.

        One run is indexed by time; all runs, where there are several and none is named, by run and time. If a run
        diverged, a column `diverged at [s]` has its time; `attrs["warnings"]` has the warnings.

        Raises
        ------
        ValueError
            If there is no run of that number.
        """
        import pandas as pd

        runs = range(len(self)) if run is None else [whole("to_frame(run=...)", run, 0, len(self) - 1)]
        frames = {i: pd.DataFrame(self._columns(i), index=pd.Index(self.t, name="t [s]")) for i in runs}
        frame = pd.concat(frames, names=["run"]) if len(frames) > 1 else frames[runs[0]]
        frame.attrs["warnings"] = list(self.warnings)
        return frame

    def _columns(self, run: int) -> dict[str, Array]:
        states, outputs = self.step.states, self.step.outputs
        columns: dict[str, Array] = {}
        for entry in (*states.entries, *(entry for entry in outputs.entries if entry.name not in states)):
            flat = self[entry.name][run].reshape(len(self.t), -1, order="F")
            names = entry.labels() if entry.size > 1 else [entry.name]
            heads = (f"{name} [{unit}]" if unit else name for name, unit in zip(names, entry.units, strict=True))
            columns |= zip(heads, flat.T, strict=True)
        return columns | (
            {DIVERGENCE_COLUMN: np.full(len(self.t), self.diverged_at[run])} if self.has_diverged.any() else {}
        )

    def plot(self, *names: str, run: int | None = None) -> Any:
        """A figure of signals over time, as `workbench.plot` draws it."""
        return draw(self, *names, run=run)

    @property
    def page_step(self) -> float:
        """The step of a page of the loop in s, or the substep: half of a chosen one that is not doubled evenly."""
        step = self.step
        count = step.substeps if step.finer else round(self.t[-1] / step.h)
        return step.h / step.substeps / (2 if self.is_step_chosen and count % 2 else 1)

    def live(self, **options: object) -> NotebookPage:
        """A page on which the numbers of the loop can be turned, as `workbench.live` makes it with what is `asked`.

        Raises
        ------
        ValueError
            If a computer closes the loop, or the runs have other numbers than the loop's own.
        """
        step, alone = self.step, (np.array_equal(self.p[0], self.step.parameters.default), not len(self.p) > 1)
        if not step.rule.rate.numel() or not all(alone):
            raise ValueError(
                "`Trajectories.live()` must have one run of a loop in continuous time, at the loop's own numbers; for "
                "any other write `workbench.live(loop, until=...)`, which takes a loop that a computer closes too."
            )
        page: NotebookPage = import_module("workbench").live(
            step.flow, until=float(self.t[-1]), h=self.page_step, **options
        )
        return page
