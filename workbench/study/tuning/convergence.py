"""Course: the progress of one search of a tuning, whether it has settled, and why points are inadmissible."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments
from workbench.proofs.differential_evolution import Flags
from workbench.study.sample import Sample
from workbench.study.tuning.tuning import GAIN, Tuning


@dataclass(frozen=True, eq=False)
@check_arguments
class SearchCourse:
    """The least objective of a search after each of its generations."""

    tuning: Tuning
    search: int  # counted from 0
    bests: Array  # (G,), at the step h; infinite while no point is admissible

    @property
    def seed(self) -> int:
        """The seed of the search."""
        return self.tuning.seeds[self.search]

    @property
    def evaluations(self) -> Array:
        """The evaluations after each generation, (G,)."""
        return self.tuning.population * np.arange(1.0, len(self.bests) + 1)

    @property
    def late_gain(self) -> float:
        """The relative gain of the last window; NaN if there is none yet, infinite if nothing was admissible before."""
        window = self.tuning.window
        if not 0 < window < len(self.bests):
            return np.nan
        before, after = self.bests[-1 - window], self.bests[-1]
        return share(before - after, after) if np.isfinite(before) else np.inf

    @property
    def has_settled(self) -> bool:
        """True if its last window gained no more than 1 %; False if it is too short to tell."""
        return bool(self.late_gain <= GAIN)

    @property
    def has_ended(self) -> bool:
        """True if it needs no more evaluations, though it may have more."""
        return self.tuning.settle is not None and len(self.bests) >= self.tuning.least and self.has_settled

    @property
    def doubt(self) -> str:
        """The reason why it may not have found its best, in a sentence; empty if it has settled."""
        if np.isnan(late := self.late_gain):
            return f"The search of seed {self.seed} is too short to tell whether it has settled."
        if np.isinf(late):
            return f"The search of seed {self.seed} found an admissible point only in its last quarter, or none."
        gained = f"The search of seed {self.seed} became better by {percent(late)} in its last quarter"
        return "" if self.has_settled else f"{gained}: it has not settled."


def reasons_of(objectives: Array, samples: Mapping[str, Sample]) -> dict[str, int]:
    """The number of points that are not admissible, by reason, from objectives (N,) and runs by trial."""
    reasons: dict[str, int] = {}
    for name, one in samples.items():
        nameless = int((~have_values(one) & np.isnan(one.diverged_at)).sum())
        reasons |= {f"the run in '{name}' diverged": one.diverged_count, f"a metric in '{name}' is no number": nameless}
    worthless = np.all([have_values(one) for one in samples.values()], axis=0) & ~np.isfinite(objectives)
    return reasons | {"the objective is infinite": int(worthless.sum())}


def have_values(sample: Sample) -> Flags:
    """The runs that have a value of every metric at the horizon; a run near overflow may not, though it is finite."""
    return np.asarray(~np.isnan(sample.measurement.values[:, -1]).any(axis=1))


def share(part: float, whole: float) -> float:
    """The ratio of a part to a whole; infinite if the whole is zero and the part is not."""
    return 0.0 if part == 0 else part / abs(whole) if whole else np.inf


def percent(share: float) -> str:
    """A share as text in percent."""
    if 0 < share < 1e-4:
        return "less than 0.01 %"
    return f"{100 * share:.2g} %" if share < 0.995 else f"{100 * share:,.0f} %"
