"""Sample: the values that the runs of a sweep gave, put together from its chunks."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace

import numpy as np

from workbench.study.document.phrases import raised
from workbench.study.uncertainty.designs import AbstractDesign
from workbench.validation.refusals import Array, Integers, described, nearest
from workbench.validation.signatures import door

ARRAYS = ("t", "drawn", "values", "again", "errors", "limits", "diverged_at")


@dataclass(frozen=True, eq=False)
@door
class Sample:
    """N runs of one loop: the values of its d factors, and those of its metrics in k columns at T times."""

    name: str
    factors: tuple[str, ...]
    columns: tuple[tuple[str, int, str], ...]  # a metric, its number counted from 0, and its unit
    t: Array  # (T,), the times in s, each metric being taken from the start to there; the last is the horizon
    h: float
    seed: int
    fingerprint: str
    drawn: Array  # (N, d)
    values: Array  # (N, T, k), NaN from the time at which a run diverged
    again: Integers  # (m,), the numbers of the runs that were run at h / 2 too
    errors: Array  # (m, T, k), by how much that changed their values
    limits: Array  # (m,), the longest step in s stable at a few states of these; inf where all are, NaN where unknown
    diverged_at: Array  # (N,), in s, NaN for a run that stayed finite
    design: AbstractDesign | None = None  # none where a ledger was read without its study
    arithmetic: str = ""
    labels: tuple[str, ...] = ()  # of each column, as 'joint 1' or a signal's name; none in a ledger of old
    tolerance: float | None = None  # for which pilots chose the step

    def __len__(self) -> int:
        return len(self.values)

    @property
    def digest(self) -> str:
        """A name of equations, times, seed and arithmetic, and of the numbers of all runs (64 hexadecimal digits)."""
        digest = hashlib.sha256(self.fingerprint.encode())
        for name in ARRAYS:
            digest.update(getattr(self, name).astype("<f8").tobytes())
        return digest.hexdigest()

    @property
    def failed(self) -> int:
        """The number of runs that diverged."""
        return int(np.isfinite(self.diverged_at).sum())

    @door
    def outputs(self, metric: str, joint: int = 0) -> Array:
        """A metric of one of its numbers, a joint of an arm, at the horizon, (N,); NaN for a run that diverged."""
        return np.asarray(self.values[:, -1, self._column(metric, joint)])

    @door
    def over_time(self, metric: str, joint: int = 0) -> Array:
        """A metric of one of its numbers from the start to each of the times, (N, T)."""
        return np.asarray(self.values[:, :, self._column(metric, joint)])

    @door
    def errors_of(self, metric: str, joint: int = 0) -> Array:
        """The error of a metric at the horizon in each run, (N,), as indices and effects ask for it.

        NaN for a run that was not run at h / 2 too, or diverged; infinite for one that h / 2 lost and h did not.
        """
        told = self.errors[:, -1, self._column(metric, joint)]
        lost = np.isnan(told) & np.isnan(self.diverged_at[self.again])
        errors = np.full(len(self), np.nan)
        errors[self.again] = np.where(lost, np.inf, told)
        return errors

    @door
    def step_error(self, metric: str, joint: int = 0) -> float:
        """The largest change of a metric at the horizon from h to h / 2, over the runs that were run again.

        NaN if all of them diverged at h; infinite if one that stayed finite at h diverged at h / 2.
        """
        errors = self.errors[:, -1, self._column(metric, joint)][np.isnan(self.diverged_at[self.again])]
        return float(np.where(np.isnan(errors), np.inf, errors).max()) if len(errors) else np.nan

    @door
    def only(self, runs: Integers) -> Sample:
        """The sample of some runs, by their numbers in rising order, which are numbered anew."""
        if runs.ndim != 1 or not ((runs >= 0) & (runs < len(self))).all() or (np.diff(runs) <= 0).any():
            raise ValueError(
                f"`only(runs)` takes numbers of runs in rising order, from 0 to {len(self) - 1}; got others."
            )
        held = np.isin(self.again, runs)
        return replace(
            self,
            drawn=self.drawn[runs],
            values=self.values[runs],
            again=np.searchsorted(runs, self.again[held]),
            errors=self.errors[held],
            limits=self.limits[held],
            diverged_at=self.diverged_at[runs],
            design=None,
        )

    @property
    def note(self) -> str:
        """The words below a figure: runs, failed runs, the seed if anything is drawn, step."""
        lost = np.isnan(self.errors[:, -1]).all(axis=1) & np.isnan(self.diverged_at[self.again])
        more = f", and {lost.sum():,} more at half of the step" if lost.any() else ""
        half = f", and half of it in {len(self.again):,} runs" if len(self.again) else ""
        seed = f"; seed {self.seeds}" if self.design is None or hasattr(self.design, "seed") else ""
        runs = f"{len(self):,} runs, {self.failed:,} of them diverged{more}"
        chosen = "" if self.tolerance is None else f"; chosen by pilot runs for a tolerance of {self.tolerance:g}"
        return f"{runs}{seed}; step {_duration(self.h)}{half}{self.beyond}{chosen}"

    @property
    def seeds(self) -> str:
        """The seed that the runs were drawn with, and that of the noise if it is another one."""
        drawn = getattr(self.design, "seed", self.seed)
        return f"{drawn}" if drawn == self.seed or self.seed == 0 else f"{drawn}, of the noise {self.seed}"

    @property
    def beyond(self) -> str:
        """The number of looked-at runs whose step is beyond the stability limit, in words."""
        beyond, unknown = self.limits[self.limits < self.h], int(np.isnan(self.limits).sum())
        said = [f"; stability limit not known of {unknown:,}"] if unknown else []
        if len(beyond):
            least = float(f"{beyond.min():.3g}")
            said.append(f"; BEYOND the stability limit in {len(beyond):,} of these, down to {_duration(least)}")
        return "".join(said)

    @door
    def note_of(self, metric: str, joint: int = 0) -> str:
        """The note below a figure of a metric, with the step error of that metric."""
        column = self._column(metric, joint)
        error, unit = self.step_error(metric, joint), self.columns[column][2]
        several = sum(name == metric for name, _, _ in self.columns) > 1
        label = self.labels[column] if self.labels else f"joint {joint + 1}"
        of = f"step error of {metric}{f' of {label}' if several else ''}"
        if np.isnan(error):
            return f"{self.note}; {of} not known"
        if np.isinf(error):
            return f"{self.note}; {of} not bounded, as a run diverges at half of the step alone"
        return f"{self.note}; {of} at most {_plain(error)}{f' {raised(unit)}' if unit not in ('', '1') else ''}"

    @property
    def heads(self) -> tuple[str, ...]:
        """A head for each column: the metric with the signal or, where it counts joints, the number, from 0."""
        labels = self.labels or ("joint 1",) * len(self.columns)
        named = zip(self.columns, labels, strict=True)
        return tuple(f"{metric}[{number if ' ' in label else label}]" for (metric, number, _), label in named)

    def _column(self, metric: str, joint: int) -> int:
        known = [(name, place) for name, place, _ in self.columns]
        if (metric, joint) not in known:
            places = [str(place) for name, place in known if name == metric]
            names = sorted({name for name, _ in known})
            there = f"its numbers are {', '.join(places)}" if places else f"its metrics are {', '.join(names)}"
            raise LookupError(
                f"The sweep '{self.name}' has no number {joint} of {described(metric)}: {there}."
                f"{'' if places else nearest(metric, names)}"
            )
        return known.index((metric, joint))


def _plain(number: float) -> str:
    """Two digits of a number as one writes it: 0.0021, and 2.1×10⁻⁵."""
    digits, power = f"{number:.1e}".split("e")
    return f"{number:.2g}" if -4 < int(power) < 4 or not number else f"{digits}×{raised(f'10^({int(power)})')}"


def _duration(seconds: float) -> str:
    """A short time as one writes it: 0.001 s, and 62.5 µs."""
    return f"{seconds:.6g} s" if seconds >= 1e-4 else f"{1e6 * seconds:.3g} µs"
