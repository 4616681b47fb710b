"""The common fields of the marks of a figure: labels, styles, and arrays of one length."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from workbench.core.notation.formula import Formula
from workbench.core.validation.refusals import Array, describe

Label: TypeAlias = str | Formula | tuple[str | Formula, ...]
Style: TypeAlias = int | Literal["reference", "bound", "aid"]
Spans: TypeAlias = tuple[tuple[Array, ...], tuple[Array, ...]]  # all numbers along the abscissa, and along the ordinate
if TYPE_CHECKING:
    Flags: TypeAlias = NDArray[np.bool_] | bool
else:
    Flags = object  # whatever NumPy makes into truths: the field's class refuses the rest

STYLES = 12


class AbstractMark(Protocol):
    """A mark with a label and a style, and fields by their names."""

    @property
    def label(self) -> Label:
        """The label, in the legend."""

    @property
    def style(self) -> Style:
        """The look."""


def store(
    mark: AbstractMark, names: tuple[str, ...], gaps: tuple[str, ...] = (), intervals: tuple[str, ...] = ()
) -> None:
    """Copy fields to read-only arrays (N,), finite but for NaN in `gaps`; of `intervals` any numbers, or NaN."""
    call = f"{type(mark).__name__}({describe(mark.label)})"
    if mark.style not in (*range(STYLES), "reference", "bound", "aid"):
        raise ValueError(
            f"`{call}` takes a style of 0 to {STYLES - 1}, 'reference', 'bound' or 'aid'; got {describe(mark.style)}."
        )
    shape = getattr(mark, names[0]).shape
    for name in (*names, *intervals):
        given = getattr(mark, name)
        array = np.full(shape, np.nan) if given is None else given.copy()
        if array.shape != shape or len(shape) != 1 or not array.size:
            raise ValueError(f"`{call}` needs {' and '.join(names)} of one length N >= 1; got {name} of {array.shape}.")
        if name in names and (np.isinf(array).any() or (name not in gaps and np.isnan(array).any())):
            rule = "finite, or NaN for a gap" if name in gaps else "finite"
            raise ValueError(f"`{call}` needs a {name} that is {rule}; got one that is not.")
        array.flags.writeable = False
        object.__setattr__(mark, name, array)
