"""Paired: one metric of several laws over the same draws of the uncertain numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from workbench.core.validation.refusals import Array, Integers, describe, known_name
from workbench.core.validation.signatures import check_arguments
from workbench.study.document.source import Source
from workbench.study.sample import Sample
from workbench.study.uncertainty.designs import LatinHypercube, MonteCarlo
from workbench.study.uncertainty.outputs import as_outputs, check_size

LEAST = 20  # draws, below which no interval here holds what it says


@dataclass(frozen=True, eq=False)
@check_arguments
class PairedSamples:
    """A metric, of which less is better, of L laws in N draws: row k is the same draw for all laws.

    `values` (N, L) are infinite for a failed run. `errors` (L,) bound the error of a value due to the step, NaN if not
    known, and `step_errors` (N, L) are those of the runs that were repeated. `failures` (L,) counts the failed runs.
    `note` is the note below a table, and `sources` (L,) are the samples, None for values of another origin.
    """

    metric: str
    unit: str
    laws: tuple[str, ...]
    values: Array  # (N, L); infinite for a failed run, which is worse than any other
    errors: Array  # (L,), how far off a value may be by the step; NaN where that is not known
    failures: Integers  # (L,), how many runs failed
    note: str = ""  # below a table: draws, seed, steps
    sources: tuple[Source | None, ...] = ()  # (L,), the samples; None for values of another origin
    step_errors: Array | None = None  # (N, L), the error of each run that was run again; NaN for the other runs

    def __post_init__(self) -> None:
        check_size("PairedSamples(values=...)", self.values, infinite=True)
        check_size("PairedSamples(errors=...)", self.errors, infinite=True)
        laws = len(self.laws)
        if self.values.shape[1:] != (laws,) or not self.errors.shape == self.failures.shape == (laws,):
            shapes = f"{self.values.shape}, {self.errors.shape} and {self.failures.shape}"
            raise ValueError(
                f"`PairedSamples(values, errors, failures)` must have shapes (N, {laws}), ({laws},) and ({laws},), a "
                f"column for each law; got {shapes}."
            )
        if self.step_errors is not None and self.step_errors.shape != self.values.shape:
            raise ValueError(
                "`PairedSamples(step_errors=...)` must have an error for each of the values, of shape "
                f"{self.values.shape}, NaN where a run was not run again; got {self.step_errors.shape}."
            )

    def __len__(self) -> int:
        return len(self.values)

    @check_arguments
    def place(self, law: str) -> int:
        """The number of a law's column, from 0."""
        return self.laws.index(known_name(law, self.laws, "laws"))

    @check_arguments
    def source(self, law: str) -> Source | None:
        """The sample of a law and the metric, as a `Source`; None if the values came from elsewhere."""
        return self.sources[self.place(law)] if self.sources else None

    @property
    def footnote(self) -> str:
        """The note below a table: the failed runs and the largest error of the step."""
        failed = ", ".join(f"{law} in {count:,}" for law, count in zip(self.laws, self.failures, strict=True) if count)
        lost = f"failed runs: {failed}, each taken as worse than any other" if failed else "no run failed"
        known = self.errors[~np.isnan(self.errors)]
        largest = f"at most {known.max(initial=0):.2g} {self.unit}".strip()
        error = "not known" if not len(known) else largest if np.isfinite(known).all() else "not bounded"
        unknown = ", ".join(law for law, off in zip(self.laws, self.errors, strict=True) if np.isnan(off))
        but = f", of {unknown} not known" if unknown and len(known) else ""
        return f"{self.metric}: {len(self):,} draws; {lost}; error of the step {error}{but}."


@check_arguments
def pair_samples(
    values: Mapping[str, object],
    *,
    metric: str,
    unit: str = "",
    errors: Mapping[str, float] | None = None,
    note: str = "",
    samples: Mapping[str, Sample] | None = None,
    step_errors: Mapping[str, object] | None = None,
) -> PairedSamples:
    """The values of one metric, of which less is better, by law.

    Parameters
    ----------
    values
        By law, the values (N,) over the same draws in the same order; NaN where a run failed.
    errors
        By law, the error of its values due to the step, in their unit; by default values are taken as exact.
    samples
        By law, the sample of its values. It gives the note below a table and the source of each number.
    step_errors
        By law, the errors (N,) of its values due to the step, NaN where a run was not repeated at h / 2. `pool`
        needs them to divide each error by its own value.

    Raises
    ------
    ValueError
        If there are fewer than two laws or 20 draws, laws differ in their number of draws, a value is minus infinity,
        an error is negative or that of no law, or the samples or the errors of runs are of other laws or draws.

    Examples
    --------
    >>> from workbench.study.evidence import pair_samples
    >>> draws = np.random.default_rng(1).random(40)
    >>> errors = {"PID": 1e-3, "SMC": 0.0}
    >>> pair_samples({"PID": draws, "SMC": draws + 0.1}, metric="error", unit="rad", errors=errors).laws
    ('PID', 'SMC')
    """
    if len(values) < 2:
        raise ValueError(f"`pair_samples(values)` must map two laws or more to their values; got {describe(values)}.")
    columns = {law: _column(law, column) for law, column in values.items()}
    sizes = {law: len(column) for law, column in columns.items()}
    if len(set(sizes.values())) > 1:
        said = ", ".join(f"{size} of {law}" for law, size in sizes.items())
        raise ValueError(
            f"`pair_samples(values)` compares laws draw by draw, so that each has a value in each; got {said}."
        )
    if (size := next(iter(sizes.values()))) < LEAST:
        raise ValueError(f"`pair_samples(values)` needs at least {LEAST} draws for intervals that hold; got {size}.")
    off = np.zeros(len(columns)) if errors is None else _errors(errors, columns)
    table = np.column_stack(list(columns.values()))
    failed = np.isnan(table).sum(axis=0)
    sources: tuple[Source, ...] = ()
    if samples is not None:
        note, sources = "; ".join(filter(None, (note, same_draws(samples)))), _sources(samples, columns, metric, unit)
    again = None if step_errors is None else _repeated(step_errors, columns, table.shape)
    table = np.where(np.isnan(table), np.inf, table)
    return PairedSamples(metric, unit, tuple(columns), table, off, failed, note, sources, again)


def _sources(samples: Mapping[str, Sample], columns: Mapping[str, Array], metric: str, unit: str) -> tuple[Source, ...]:
    if set(samples) != set(columns):
        raise ValueError(
            f"`pair_samples(samples=...)` must have one sample for each of {list(columns)}; got "
            f"{describe(list(samples))}."
        )
    held = ((law, samples[law]) for law in columns)
    return tuple(Source(law, one.name, "metric", metric, 0, "", unit, one.digest, title=law) for law, one in held)


def _errors(given: Mapping[str, float], columns: Mapping[str, Array]) -> Array:
    if set(given) != set(columns):
        raise ValueError(
            f"`pair_samples(errors=...)` must have one error for each of {list(columns)}; got {describe(list(given))}."
        )
    found = np.array([given[law] for law in columns])
    if (found < 0).any():
        raise ValueError(
            f"`pair_samples(errors=...)` must be numbers that are not negative; got {describe(dict(given))}."
        )
    return found


def _repeated(given: Mapping[str, object], columns: Mapping[str, Array], shape: tuple[int, ...]) -> Array:
    """The errors (N, L) of the runs that were run again."""
    if set(given) != set(columns):
        raise ValueError(
            f"`pair_samples(step_errors=...)` must have the errors of each of {list(columns)}; got "
            f"{describe(list(given))}."
        )
    arrays = [as_outputs(given[law]) for law in columns]
    if any(one is None or one.shape != shape[:1] or (one < 0).any() for one in arrays):
        raise ValueError(
            f"`pair_samples(step_errors=...)` must hold {shape[0]} errors for each law, not negative, and NaN where a "
            f"run was not run again; got {describe(dict(given))}."
        )
    return np.column_stack([one for one in arrays if one is not None])


@check_arguments
def same_draws(samples: Mapping[str, Sample]) -> str:
    """The note of the samples of several laws, which must have the same independent draws, one per row, and horizon."""
    if not samples:
        raise ValueError("`same_draws(samples)` must map laws to their samples, at least one; got none.")
    (first, held), *others = samples.items()
    for law, sample in samples.items():
        if not isinstance(sample.design, MonteCarlo | LatinHypercube | None):
            raise ValueError(
                f"`same_draws(samples)` needs independent draws, of `MonteCarlo` or `LatinHypercube`; those of '{law}' "
                f"are points of a {type(sample.design).__name__}, from which no interval follows."
            )
    for law, other in others:
        if other.factors != held.factors or not np.array_equal(other.factor_values, held.factor_values):
            raise ValueError(
                f"`same_draws(samples)` compares laws in the same draws of the same factors; '{first}' and '{law}' "
                "differ in them: give their sweeps the same factors and the same design."
            )
        if other.t[-1] != held.t[-1]:
            raise ValueError(
                f"`same_draws(samples)` compares laws over the same time; '{first}' runs for {held.t[-1]:g} s and "
                f"'{law}' for {other.t[-1]:g} s: give their sweeps the same `until`."
            )
    runs = f"{len(held):,} draws of {len(held.factors)} factors, the same for each law"
    by_step: dict[float, list[str]] = {}
    for law, sample in samples.items():
        by_step.setdefault(sample.h, []).append(law)
    seed = f"; seed {held.design.seed}" if isinstance(held.design, MonteCarlo | LatinHypercube) else ""
    steps = "; ".join(f"{h:g} s for {', '.join(laws)}" for h, laws in by_step.items())
    step = f"steps {steps}" if len(by_step) > 1 else f"step {held.h:g} s"
    again = min(len(sample.measurement.looked_at) for sample in samples.values())
    beyond = "".join(f"; {law}: {said[2:]}" for law, sample in samples.items() if (said := sample.beyond))
    return f"{runs}{seed}; {step}, and half of it in {again:,} runs{beyond}."


def _column(law: str, given: object) -> Array:
    column = as_outputs(given)
    if column is None or column.ndim != 1 or np.isneginf(column).any():
        raise ValueError(
            f"`pair_samples(values)` must hold one number a draw for '{law}', NaN where the run failed; got "
            f"{describe(given)}."
        )
    return column
