"""The numbers of a nonlinear predictive law whose model has disturbances of its inputs as its last states."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from workbench.blocks.loop.contracts import AbstractPlant
from workbench.core import Layout
from workbench.core.validation.refusals import Array


def disturbances_of(model: AbstractPlant) -> Layout:
    """The disturbances of the inputs among the states of a model, as `InputDisturbances` has them."""
    port = getattr(model, "input_disturbances", None)
    return port if isinstance(port, Layout) else Layout()


def with_disturbances(numbers: Mapping[str, object], model: AbstractPlant) -> dict[str, object]:
    """The numbers of a design with zeros for the disturbances of a model, behind the states of the plant."""
    own, nd = dict(numbers), disturbances_of(model).size
    if not nd:
        return own
    nx = model.states.size - nd

    def with_zeros(name: str, axes: tuple[int, ...]) -> Array:
        part = np.asarray(own[name], dtype=float)
        for axis in axes:
            part = np.insert(part, [nx] * nd, 0.0, axis=axis)
        return part

    return own | {
        name: with_zeros(name, axes) for name, axes in (("Q", (0, 1)), ("P", (0, 1)), ("K", (1,)), ("x0", (0,)))
    }
