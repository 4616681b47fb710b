"""What a simulation hands back: states over time, run by run, with the runs that diverged marked."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from workbench.core import Step
from workbench.core.layout import Array

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, eq=False)
class Trajectories:
    """B runs of one `Step` at N common times.

    Attributes
    ----------
    t
        (N,), in s.
    x
        (B, N, nx); from the time a run has diverged its rows are NaN.
    p
        (B, np).
    diverged_at
        (B,), the time of the first step whose state is not finite; NaN for a run that stayed finite.
    """

    step: Step
    t: Array
    x: Array
    p: Array
    diverged_at: Array

    @property
    def diverged(self) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
        """(B,), whether each run diverged."""
        return np.asarray(np.isfinite(self.diverged_at))

    def __len__(self) -> int:
        return len(self.x)

    def __getitem__(self, name: str) -> Array:
        """A state or an output by name, (B, N, *shape); what a law and its loop call by the same name is the state."""
        if name in self.step.states:
            return self.step.states.unpack(self.x)[name]
        if name in self.step.outputs:
            return self._outputs[name]
        known = (*self.step.states.names, *self.step.outputs.names)
        raise LookupError(f"There is no '{name}' among the states and outputs: {', '.join(known)}.")

    @cached_property
    def _outputs(self) -> dict[str, Array]:
        n = len(self.t)
        k = np.round(self.t / self.step.h)[np.newaxis]
        y = self.step.y.map(n)
        rows = [np.array(y(k, run.T, np.repeat(p[:, np.newaxis], n, axis=1))).T for run, p in self._runs()]
        return self.step.outputs.unpack(np.stack(rows))

    def _runs(self) -> list[tuple[Array, Array]]:
        return list(zip(self.x, self.p, strict=True))

    def to_frame(self, run: int = 0) -> pd.DataFrame:
        """One run as a table: a column per state and output, indexed by time in s."""
        import pandas as pd

        outputs = self._outputs
        columns = dict(zip(self.step.states.labels, self.x[run].T, strict=True))
        for entry in self.step.outputs.entries:
            flat = outputs[entry.name][run].reshape(len(self.t), -1)
            columns |= dict(zip(entry.labels(), flat.T, strict=True))
        return pd.DataFrame(columns, index=pd.Index(self.t, name="t"))
