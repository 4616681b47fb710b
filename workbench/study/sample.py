"""Sample: the numbers that were drawn for the runs of a sweep, and the measurement of these runs."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from workbench.core.validation.refusals import Array, Integers, refusal
from workbench.core.validation.signatures import check_arguments
from workbench.engine.metrics import Measurement, Score
from workbench.study.document.phrases_and_tables import superscript_powers
from workbench.study.document.source import Source
from workbench.study.uncertainty.designs import AbstractDesign

Design = TypeVar("Design", bound=AbstractDesign)

ARRAYS = (
    "t",
    "values",
    "diverged_at",
    "looked_at",
    "errors",
    "half_diverged_at",
    "limits",
)  # of a measurement, beside what was drawn


@dataclass(frozen=True, eq=False)
@check_arguments
class Sample:
    """N runs of one loop: `factor_values` (N, d) of its d `factors`, and the `measurement` of the runs.

    `seed` is that of the runs, `fingerprint` that of the equations, and `arithmetic` the one of the runs. `design` is
    None if the runs were read from a ledger without the study.
    """

    name: str
    factors: tuple[str, ...]
    factor_values: Array
    measurement: Measurement
    seed: int
    fingerprint: str
    design: AbstractDesign | None = None  # none where a ledger was read without its study
    arithmetic: str = ""

    def __len__(self) -> int:
        return len(self.factor_values)

    def design_of(self, kind: type[Design]) -> Design:
        """The design of the runs, of the kind that a method needs: `sample.design_of(wb.SobolDesign)` for indices.

        Raises
        ------
        ValueError
            If the runs have another design, or were read without one.
        """
        if not isinstance(kind, type):
            raise refusal("Sample.design_of(kind)", "a class of designs, as `SobolDesign` is", kind)
        if not isinstance(self.design, kind):
            raise ValueError(
                f"`Sample.design_of(kind)` must be the kind of the sample's own design, a "
                f"`{type(self.design).__name__}`; got `{kind.__name__}`. Draw the sweep by that design."
            )
        return self.design

    @property
    def digest(self) -> str:
        """A hash of equations, times, seed and arithmetic, and of the numbers of all runs (64 hexadecimal digits)."""
        digest = hashlib.sha256(self.fingerprint.encode())
        for array in (self.factor_values, *(getattr(self.measurement, name) for name in ARRAYS)):
            digest.update(array.astype("<f8").tobytes())
        return digest.hexdigest()

    @property
    def h(self) -> float:
        """The step of the values in s."""
        return self.measurement.h

    @property
    def t(self) -> Array:
        """The times up to which the metrics are taken, (T,), in s."""
        return self.measurement.t

    @property
    def values(self) -> Array:
        """The metrics in k columns from the start to each of the times, (N, T, k); NaN once a run has diverged."""
        return self.measurement.values

    @property
    def diverged_at(self) -> Array:
        """The time at which each run diverged, (N,), in s; NaN for a run that stayed finite."""
        return self.measurement.diverged_at

    @property
    def diverged_count(self) -> int:
        """The number of runs that diverged."""
        return self.measurement.diverged_count

    @check_arguments
    def score(self, metric: str, signal: int | str = 0) -> Score:
        """A metric of one signal at the horizon in each run, by the signal's label or its number from 0."""
        return self.measurement.score(metric, signal)

    @check_arguments
    def over_time(self, metric: str, signal: int | str = 0) -> Array:
        """A metric of one signal from the start to each of the times, (N, T)."""
        return self.measurement.over_time(metric, signal)

    @check_arguments
    def only(self, runs: Integers) -> Sample:
        """The sample with only these runs, named by their numbers in rising order and then numbered anew from 0."""
        measurement = self.measurement.only(runs)  # refuses others
        return replace(self, factor_values=self.factor_values[runs], measurement=measurement, design=None)

    @property
    def note(self) -> str:
        """The words below a figure: runs, failed runs, the seed if anything is drawn, step, and pulses not seen."""
        found = self.measurement
        lost = np.isfinite(found.half_diverged_at) & np.isnan(self.diverged_at[found.looked_at])
        more = f", and {lost.sum():,} more at half of the step" if lost.any() else ""
        half = f", and half of it in {len(found.looked_at):,} runs" if len(found.looked_at) else ""
        seed = f"; seed {self.seeds}" if self.design is None or hasattr(self.design, "seed") else ""
        runs = f"{len(self):,} runs, {self.diverged_count:,} of them diverged{more}"
        choice = found.choice
        by = "" if choice is None else choice.by
        chosen = "" if choice is None else f"; chosen by pilot runs for a tolerance of {choice.tolerance:g}"
        unseen = "".join(f"; {sentence}" for sentence in (*found.excursions, *found.pulse_warnings))
        return f"{runs}{seed}; step {_duration(self.h)}{by}{half}{self.beyond}{chosen}{unseen}"

    @property
    def seeds(self) -> str:
        """The seed that the runs were drawn with, and that of the noise if it is another one."""
        drawn = getattr(self.design, "seed", self.seed)
        return f"{drawn}" if drawn == self.seed or self.seed == 0 else f"{drawn}, of the noise {self.seed}"

    @property
    def beyond(self) -> str:
        """The number of repeated runs whose step is beyond the stability limit, in words."""
        limits = self.measurement.limits
        beyond, unknown = limits[limits < self.h], int(np.isnan(limits).sum())
        said = [f"; stability limit not known of {unknown:,}"] if unknown else []
        if len(beyond):
            least = float(f"{beyond.min():.3g}")
            said.append(f"; BEYOND the stability limit in {len(beyond):,} of these, down to {_duration(least)}")
        return "".join(said)

    @check_arguments
    def note_of(self, metric: str, signal: int | str = 0) -> str:
        """The note below a figure of a metric of one signal, with its largest error."""
        score = self.score(metric, signal)
        several = sum(one.metric == metric for one in self.measurement.columns) > 1
        of = f"error of {metric}{f' of {score.label or signal}' if several else ''}"
        if np.isnan(error := score.largest_error):
            return f"{self.note}; {of} not known"
        if np.isinf(error):
            return f"{self.note}; {of} not bounded, as a run diverges at half of the step alone"
        unit = f" {superscript_powers(score.unit)}" if score.unit not in ("", "1") else ""
        return f"{self.note}; {of} at most {_plain(error)}{unit}"

    @check_arguments
    def source(self, metric: str, signal: int | str = 0, law: str = "") -> Source:
        """The source of marks that show a metric of one signal in these runs; its notes are those of `note_of`."""
        _, place, unit, label = self.measurement.column(metric, signal)
        notes = self.note, self.note_of(metric, place).removeprefix(f"{self.note}; ")
        return Source(law, self.name, "metric", metric, place, label, unit, self.digest, None, 1.0, law, notes)


def _plain(number: float) -> str:
    """Two digits of a number as one writes it: 0.0021, and 2.1×10⁻⁵."""
    digits, power = f"{number:.1e}".split("e")
    return (
        f"{number:.2g}" if -4 < int(power) < 4 or not number else f"{digits}×{superscript_powers(f'10^({int(power)})')}"
    )


def _duration(seconds: float) -> str:
    """A short time as one writes it: 0.001 s, and 62.5 µs."""
    return f"{seconds:.6g} s" if seconds >= 1e-4 else f"{1e6 * seconds:.3g} µs"
