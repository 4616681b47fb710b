"""The outputs of many runs as columns of numbers, and the reasons for which some are refused."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from workbench.core.validation.refusals import Array, as_array, describe, known_name
from workbench.core.validation.signatures import check_arguments
from workbench.study.uncertainty.designs import AbstractDesign

Flags = NDArray[np.bool_]

# A spread of this many last places of the largest value: rounding is then 1e-5 of the variance and hides no index.
LEAST_SPREAD = 100 * np.finfo(float).eps
LARGEST = 1e304  # number of a result: sums and differences of some such are finite
# Parts of the variance that an error of the runs may make up: beyond the first it is told, beyond the second refused.
TELL_SHARE, REFUSE_SHARE = 0.01, 1.0


@dataclass(frozen=True, eq=False)
@check_arguments
class Estimate:
    """Values, each with the half-width of its confidence interval; both are NaN where the output was refused."""

    value: Array
    half: Array

    def __post_init__(self) -> None:
        check_size("Estimate(value=...)", self.value)
        check_size("Estimate(half=...)", self.half, infinite=True)
        if self.value.shape != self.half.shape:
            raise ValueError(
                "`Estimate(half=...)` must have a half-width for each value; got shapes "
                f"{self.value.shape} and {self.half.shape}."
            )

    @property
    def low(self) -> Array:
        """The lower ends of the intervals."""
        return self.value - self.half

    @property
    def high(self) -> Array:
        """The upper ends of the intervals."""
        return self.value + self.half

    @check_arguments
    def __getitem__(self, place: int) -> Estimate:
        return Estimate(self.value[place], self.half[place])


@dataclass(frozen=True, eq=False)
class Outputs:
    """Columns (N, k) of N runs by name, the names of d factors, and the reason for each column that is refused.

    `scaled_columns` are the columns with mean 0 and largest deviation 1, so that no square of them overflows or loses
    its digits, and 0 where refused; beside its mean a column is `spread` (k,) times that. `remarks` are on the others.
    """

    names: tuple[str, ...]
    factors: tuple[str, ...]
    columns: Array
    scaled_columns: Array
    spread: Array
    refusals: Mapping[str, str]
    remarks: tuple[str, ...]

    @property
    def is_accepted(self) -> Flags:
        """True for the columns that are not refused, (k,)."""
        return np.array([name not in self.refusals for name in self.names])


def outputs_of(
    call: str,
    design: AbstractDesign,
    outputs: object,
    names: Sequence[str] | None,
    factors: Sequence[str] | None,
    errors: object = None,
) -> Outputs:
    """The outputs (N,) or (N, k) of all runs of a design, NaN where a run failed, judged one by one.

    The `errors`, of the same shape, are NaN where unknown, and infinite where nothing bounds them.

    Raises
    ------
    ValueError
        If shapes or numbers of names do not fit, or all outputs are refused.
    """
    named = _names_of("factors", call, factors, [f"x{i + 1}" for i in range(design.dimensions)])
    held, columns = columns_of(call, design, outputs, names)
    k = len(held)
    refused = {name: why for name, column in zip(held, columns.T, strict=True) if (why := _flaw(column))}
    known = np.array([name not in refused for name in held], dtype=bool)
    scaled, spread = np.zeros(columns.shape), np.zeros(k)
    scaled[:, known], spread[known] = _scaled(columns[:, known])
    remarks: list[str] = []
    if errors is not None:
        off = _columns(f"{call}(errors=...)", errors, design.size)
        if off.shape != columns.shape:
            raise ValueError(f"`{call}(errors=...)` must have the outputs' shape {columns.shape}; got {off.shape}.")
        for j in np.flatnonzero(known):
            part, said = _blur(off[:, j], scaled[:, j], spread[j])
            if part > REFUSE_SHARE:
                refused[held[j]] = said if np.isinf(part) else f"{said}: what varies is the error"
            elif not part <= TELL_SHARE:
                remarks.append(f"'{held[j]}': {said}.")
    if len(refused) == k:
        said = "; ".join(f"'{name}': {why}" for name, why in list(refused.items())[:3])
        raise ValueError(f"`{call}(outputs=...)` must have an output that can be judged; got none: {said}.")
    return Outputs(held, named, columns, scaled, spread, refused, tuple(remarks))


def _blur(errors: Array, scaled: Array, spread: float) -> tuple[float, str]:
    """The part of an output's variance that the known errors of its runs make up, also in words."""
    there = errors[~np.isnan(errors)]
    if not there.size:
        return np.nan, "no run has an error"
    if lost := int(np.isinf(there).sum()):
        return np.inf, f"nothing bounds the errors of {lost} of its runs, as where half of the step fails"
    with np.errstate(over="ignore"):  # infinitely more than the spread
        part = float(np.mean((there / spread) ** 2) / np.mean(scaled**2))
    return part, f"the errors of its runs are {100 * part**0.5:.2g} % of its spread, {100 * part:.2g} % of the variance"


def columns_of(
    call: str, design: AbstractDesign, outputs: object, names: Sequence[str] | None
) -> tuple[tuple[str, ...], Array]:
    """The names (k,) and numbers (N, k) of the outputs of all runs of a design, or a refusal."""
    columns = _columns(f"{call}(outputs=...)", outputs, design.size)
    default = [f"output {j + 1}" for j in range(columns.shape[1])]
    return _names_of("names", call, names, default, ", one an output"), columns


def _names_of(what: str, call: str, given: Sequence[str] | None, default: list[str], of: str = "") -> tuple[str, ...]:
    held = tuple(default if given is None else given)
    if len(held) != len(default) or len(set(held)) < len(held):
        raise ValueError(f"`{call}({what}=...)` must be {len(default)} different names{of}; got {held}.")
    return held


class AbstractResult(Protocol):
    """The results of several outputs by name, of which some were refused for a reason."""

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the outputs."""

    @property
    def refusals(self) -> Mapping[str, str]:
        """The reasons by the names of those that were refused."""


R = TypeVar("R", bound=AbstractResult)


def of_output(results: R, name: str, *parts: str) -> R:
    """The results of one output, by its row of each of the `parts`; one that was refused is refused by its reason."""
    if name in results.refusals:
        raise ValueError(f"There is no result for '{name}': {results.refusals[name]}.")
    j, first = results.names.index(known_name(name, results.names, "outputs")), getattr(results, parts[0])
    if first.value.ndim == 1 if isinstance(first, Estimate) else first.ndim == 0:  # those of one output alone
        return results
    rows = {part: None if (held := getattr(results, part)) is None else held[j] for part in parts}
    return replace(results, names=(name,), refusals={}, **rows)  # type: ignore[type-var]


def t_quantile(call: str, confidence: float, freedom: int) -> float:
    """The width of half of a confidence interval, in standard errors."""
    if not 0 < confidence < 1:
        raise ValueError(f"`{call}(confidence=...)` must be a number between 0 and 1; got {confidence}.")
    return float(stdtrit(freedom, 0.5 + confidence / 2))


def as_outputs(outputs: object) -> Array | None:
    """A new array of doubles, truths as 0 and 1, NaN where it is masked; None of anything else."""
    try:
        if isinstance(outputs, np.ma.MaskedArray):  # what is masked is not known, and NumPy would take what lies below
            outputs = np.where(np.ma.getmaskarray(outputs), np.nan, np.ma.getdata(outputs))
        array = np.asarray(outputs)
    except Exception:  # whatever an object says when it is asked for its numbers
        return None
    return as_array(array.astype(float) if array.dtype.kind == "b" else array)


def check_size(call: str, array: Array, infinite: bool = False) -> None:
    """Refuse numbers whose sums a double does not hold, and infinite ones unless they mean something."""
    size = np.abs(array)
    if (beyond := size[(size > LARGEST) & ~(np.isinf(size) & infinite)]).size:
        raise ValueError(
            f"`{call}` must be numbers up to {LARGEST:g}, whose sums a double holds; got {beyond[0]:g}: choose another "
            "unit."
        )


def _columns(call: str, given: object, runs: int) -> Array:
    values = as_outputs(given)
    if values is None:
        raise ValueError(f"`{call}` must be an array of numbers, one row a run; got {describe(given)}.")
    if values.ndim not in (1, 2) or len(values) != runs or not values.size:
        raise ValueError(f"`{call}` must have a row for each of the {runs} runs of the design; got {values.shape}.")
    return values.reshape(runs, -1)


def _flaw(column: Array) -> str:
    """The reason why an output cannot be judged; empty if it can."""
    runs = len(column)
    if failed := int(np.isnan(column).sum()):
        return (
            f"{failed} of {runs} runs failed, and those that are left are no sample of the factors' ranges: narrow "
            "the ranges, or judge an output that a failed run has too, such as whether it failed"
        )
    if infinite := int(np.isinf(column).sum()):
        return f"{infinite} of {runs} runs are infinite, so that it has no variance: judge a bounded output instead"
    least, largest = float(column.min()), float(column.max())
    if least == largest:
        return f"it is {least:g} in all {runs} runs: no factor changes it"
    if max(-least, largest) > LARGEST:
        return f"it goes from {least:g} to {largest:g}, beyond {LARGEST:g}, where sums overflow: choose another unit"
    if largest - least <= LEAST_SPREAD * max(abs(least), abs(largest)):
        return (
            f"it varies by {largest - least:.1e} about {least:g}, which is rounding: subtract what does not vary, "
            "before it is rounded"
        )
    return ""


def _scaled(columns: Array) -> tuple[Array, Array]:
    """Columns less their mean, scaled, and their spread, computed so that no digit is lost."""
    scaled = columns - columns[:1]
    size = np.abs(scaled).max(axis=0, initial=0.0)
    scaled /= size
    scaled -= scaled.mean(axis=0)
    width = np.abs(scaled).max(axis=0, initial=0.0)
    return scaled / width, width * size
