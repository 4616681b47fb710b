"""Answers of several channels over frequency as plain data, and the loop gains that are read from them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from workbench.core.validation.refusals import Array, refusal
from workbench.core.validation.signatures import check_arguments
from workbench.study.document.figure import Label
from workbench.study.document.frequency_curves import (
    Complex,
    Complexes,
    FrequencyCurve,
    check_frequencies,
    complexes,
    number,
)
from workbench.study.document.phrases_and_tables import Phrase


@dataclass(frozen=True, eq=False)
@check_arguments
class FrequencyMatrix:
    """The responses `values` (m, ny, nu) of several channels at `frequencies` (m,) in rad/s; NaN is a gap.

    `inputs` and `outputs` are names, one each, by default u1, u2, ... and y1, y2, ... For a loop in a computer,
    `period` is its period in s. For a loop gain, `disk_margin` is for all channels at once.
    """

    label: Label
    frequencies: Array
    values: Complexes
    inputs: tuple[str, ...] = ()
    outputs: tuple[str, ...] = ()
    period: float | None = None
    disk_margin: float | None = None

    def __post_init__(self) -> None:
        omega = check_frequencies("FrequencyMatrix(frequencies=...)", self.frequencies, self.period)
        values = complexes("FrequencyMatrix(values=...)", self.values, 3, gaps=True)
        if len(values) != len(omega) or 0 in values.shape:
            must = f"an array ({len(omega)}, ny, nu), a matrix for each frequency"
            raise refusal("FrequencyMatrix(values=...)", must, self.values)
        for name, letter, count in (("outputs", "y", values.shape[1]), ("inputs", "u", values.shape[2])):
            given = getattr(self, name)
            if given and len(given) != count:
                raise refusal(f"FrequencyMatrix({name}=...)", f"a name for each of {count} {name}", given)
            object.__setattr__(self, name, given or tuple(f"{letter}{k + 1}" for k in range(count)))
        object.__setattr__(self, "frequencies", omega)
        object.__setattr__(self, "values", values)

    @property
    def has_answers(self) -> NDArray[np.bool_]:
        """True at the frequencies at which all channels have an answer."""
        return np.asarray(np.isfinite(self.values).all(axis=(1, 2)))


def square_channels(call: str, matrices: Sequence[FrequencyMatrix]) -> None:
    """Refuse no matrices, and any that has not one output for each input."""
    if not matrices:
        raise ValueError(f"`{call}` must have at least one matrix of answers; got none.")
    for one in matrices:
        if one.values.shape[1] != one.values.shape[2]:
            raise ValueError(
                f"`{call}` needs one output for each input; '{one.label}' has {one.values.shape[1]} outputs and "
                f"{one.values.shape[2]} inputs."
            )


def determinant_curve(loop: FrequencyMatrix) -> FrequencyCurve:
    """det(I + L) over frequency."""
    values = np.full(len(loop.frequencies), np.nan, complex)
    values[loop.has_answers] = np.linalg.det(np.eye(loop.values.shape[1]) + loop.values[loop.has_answers])
    return FrequencyCurve(loop.label, loop.frequencies, values, loop.period)


def characteristic_curves(loop: FrequencyMatrix) -> list[FrequencyCurve]:
    """The eigenvalues of L over frequency, in an order in which each is continuous."""
    from scipy.optimize import linear_sum_assignment  # here, as it takes long to import

    size, last = loop.values.shape[1], None
    values = np.full((len(loop.frequencies), size), np.nan, complex)
    for k in np.flatnonzero(loop.has_answers):
        found: Complex = np.linalg.eigvals(loop.values[k])
        if last is None:
            found = found[np.argsort(-np.abs(found), kind="stable")]
        else:
            found = found[linear_sum_assignment(np.abs(last[:, np.newaxis] - found))[1]]
        values[k] = last = found
    own = loop.label if isinstance(loop.label, tuple) else (loop.label,)
    return [
        FrequencyCurve((*own, f", locus {j + 1}"), loop.frequencies, values[:, j], loop.period) for j in range(size)
    ]


def disk_remarks(loops: Sequence[FrequencyMatrix]) -> list[Phrase]:
    """The disk margin of all channels at once, of each loop that has one."""
    return [
        (*(one.label if isinstance(one.label, tuple) else (one.label,)), f": disk margin {number(one.disk_margin)}.")
        for one in loops
        if one.disk_margin is not None
    ]
