"""The unit of a signal for the equipment that is in its way, and the sizes of the equipment's numbers."""

from copy import copy
from dataclasses import Field
from typing import ClassVar, Protocol, TypeVar

import numpy as np

from workbench.core import Layout
from workbench.core.block import quantities
from workbench.core.validation.refusals import known_name


class Equipment(Protocol):
    """A block in the way of a signal."""

    __dataclass_fields__: ClassVar[dict[str, Field[object]]]

    @property
    def signal(self) -> str:
        """The name of the signal."""


T = TypeVar("T", bound=Equipment)


def fit_element(field: str, element: T, port: Layout, of: str) -> T:
    """An element with the unit of its signal, or a refusal of one that fits no signal of the port."""
    entry = port[known_name(element.signal, port.names, f"{of} of the plant")]
    for f, quantity in quantities(element):
        shape = np.shape(getattr(element, f.name))
        differ = quantity.is_symbolic and "{unit}" in quantity.unit and len(set(entry.units)) > 1
        if quantity.shape != ("*",) or shape == entry.shape or not (shape or differ):
            continue
        must = f"be one number, as '{entry.name}' is"
        if entry.shape:
            why = f" (in {entry.unit})" if differ else ", or one for all"
            must = f"be {entry.size} numbers, one for each of '{entry.name}'{why}"
        raise ValueError(f"`{type(element).__name__}({f.name}=...)` in `{field}` must {must}; got shape {shape}.")
    twin = copy(element)
    object.__setattr__(twin, "unit", entry.unit)
    return twin
