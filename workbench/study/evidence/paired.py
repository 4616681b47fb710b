"""Paired: one metric of several laws over the same draws of what is uncertain."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from workbench.core.layout import Array, nearest
from workbench.core.numbers import Integers, numbers
from workbench.core.sockets import described
from workbench.study.cells import check_text
from workbench.study.sample import Sample
from workbench.study.sampling import LatinHypercube, MonteCarlo

LEAST = 20  # draws, below which no interval here holds what it says


@dataclass(frozen=True, eq=False)
class Paired:
    """A metric, of which less is better, of L laws in N draws: row k is the same draw for all laws.

    Attributes
    ----------
    values
        (N, L); infinite for a failed run, which is worse than any other.
    errors
        (L,), how far off a value may be by the step; NaN where that is not known.
    failed
        (L,), how many runs failed.
    note
        What must stand below a table: draws, seed, steps.
    """

    metric: str
    unit: str
    laws: tuple[str, ...]
    values: Array
    errors: Array
    failed: Integers
    note: str = ""

    def __len__(self) -> int:
        return len(self.values)

    def place(self, law: str) -> int:
        """The column of a law."""
        if law not in self.laws:
            raise LookupError(f"There is no law '{law}' among the {len(self.laws)}.{nearest(law, self.laws)}")
        return self.laws.index(law)

    @property
    def said(self) -> str:
        """The note, with the failed runs and the largest error of the step."""
        failed = ", ".join(f"{law} in {count:,}" for law, count in zip(self.laws, self.failed, strict=True) if count)
        lost = f"failed runs: {failed}, each taken as worse than any other" if failed else "no run failed"
        error = f"{self.errors.max():.2g} {self.unit}".strip() if not np.isnan(self.errors).any() else "not known"
        return f"{self.metric}: {len(self):,} draws; {lost}; error of the step at most {error}."


def paired(
    values: Mapping[str, Any], *, metric: str, unit: str = "", errors: Mapping[str, float] | None = None, note: str = ""
) -> Paired:
    """The values of one metric, of which less is better, by law.

    Parameters
    ----------
    values
        Law to its values (N,) over the same draws in the same order; NaN where a run failed.
    errors
        Law to the error of its values by the step, in their unit; without it they are taken as exact.

    Raises
    ------
    ValueError
        If there are fewer than two laws or 20 draws, laws differ in their number of draws, a value is minus
        infinity, or an error is negative or that of no law.
    """
    for word, text in (("metric", metric), ("unit", unit), ("note", note)):
        check_text(f"paired({word}=...)", text)
    if not isinstance(values, Mapping) or len(values) < 2:
        raise ValueError(f"`paired(values)` must map two laws or more to their values; got {described(values)}.")
    columns = {law: _column(law, column) for law, column in values.items()}
    sizes = {law: len(column) for law, column in columns.items()}
    if len(set(sizes.values())) > 1:
        said = ", ".join(f"{size} of {law}" for law, size in sizes.items())
        raise ValueError(f"`paired(values)` compares laws draw by draw, so that each has a value in each; got {said}.")
    if (size := next(iter(sizes.values()))) < LEAST:
        raise ValueError(f"`paired(values)` needs at least {LEAST} draws for intervals that hold; got {size}.")
    known = {} if errors is None else dict(errors)
    if errors is not None and set(known) != set(columns):
        raise ValueError(f"`paired(errors=...)` must have one error for each of {list(columns)}; got {list(known)}.")
    if any(error < 0 for error in known.values()):
        raise ValueError(f"`paired(errors=...)` must not be negative; got {known}.")
    table = np.column_stack(list(columns.values()))
    failed = np.isnan(table).sum(axis=0)
    off = np.array([float(known.get(law, 0.0)) for law in columns])
    return Paired(metric, unit, tuple(columns), np.where(np.isnan(table), np.inf, table), off, failed, note)


def same_draws(samples: Mapping[str, Sample]) -> str:
    """The note of the samples of several laws, one draw a row, or a refusal where rows are not the same draws.

    Raises
    ------
    ValueError
        If two samples differ in factors or their values, or are no independent draws, as those of a grid are not.
    """
    if not isinstance(samples, Mapping) or not samples:
        raise ValueError(f"`same_draws(samples)` must map laws to their samples; got {described(samples)}.")
    (first, held), *others = samples.items()
    for law, sample in samples.items():
        if not isinstance(sample.design, MonteCarlo | LatinHypercube | None):
            raise ValueError(
                f"`same_draws(samples)` needs independent draws, of `MonteCarlo` or `LatinHypercube`; those of '{law}' "
                f"are points of a {type(sample.design).__name__}, from which no interval follows."
            )
    for law, other in others:
        if other.factors != held.factors or not np.array_equal(other.drawn, held.drawn):
            raise ValueError(
                f"`same_draws(samples)` compares laws in the same draws of the same factors; '{first}' and '{law}' "
                "differ in them: give their sweeps the same factors and the same design."
            )
    runs = f"{len(held):,} draws of {len(held.factors)} factors, the same for each law"
    seed = f"; seed {held.design.seed}" if isinstance(held.design, MonteCarlo | LatinHypercube) else ""
    steps = "; ".join(f"{h:g} s for {', '.join(laws)}" for h, laws in _by_step(samples).items())
    again = min(len(sample.again) for sample in samples.values())
    return f"{runs}{seed}; steps: {steps}; each with half of it in {again:,} runs"


def _column(law: str, given: Any) -> Array:
    try:
        column = numbers(given)
    except (TypeError, ValueError):
        column = np.zeros(())
    if column.ndim != 1 or np.isneginf(column).any():
        raise ValueError(
            f"`paired(values)` must hold one number a draw for '{law}', NaN where the run failed; got "
            f"{described(given)}."
        )
    return column


def _by_step(samples: Mapping[str, Sample]) -> dict[float, list[str]]:
    steps: dict[float, list[str]] = {}
    for law, sample in samples.items():
        steps.setdefault(sample.h, []).append(law)
    return steps
