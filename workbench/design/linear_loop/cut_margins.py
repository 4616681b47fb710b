"""The margins of a loop that is cut: of each channel while the others are closed, and of all at once."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from workbench.design.frequency import Bandwidth, StabilityMargins, bandwidth, sensitivity_bandwidth, stability_margins
from workbench.design.linear import DiskMargin, disk_margin
from workbench.design.linear_loop.frequency_answers import CutModels
from workbench.design.linear_loop.loop_model import LoopModel
from workbench.design.matrices import DesignError

if TYPE_CHECKING:
    import control


def channel_margins(call: str, models: CutModels, names: Sequence[str]) -> dict[str, StabilityMargins]:
    """The margins at each channel of the cut, by its name."""
    refuse_rates(call, models)
    opened, found = models.open_drives(call), {}
    for i, name in zip(models.channels, names, strict=True):
        others = [k for k in range(len(models.delays)) if k != i]
        if models.delays[others].any():
            raise ValueError(
                f"`{call}` of '{name}' needs a loop without delays elsewhere; there is one of "
                f"{models.delays[others].max():g} s. Take `response`, or a `PadeDelay` of `EquippedPlant` there."
            )
        own = opened.closed_at(others).part([i], [0]).negative()
        found[name] = stability_margins(own.system(), float(models.delays[i]))
    return found


def common_margin(call: str, models: CutModels) -> DiskMargin:
    """The disk margin of all channels of the cut at once."""
    refuse_rates(call, models)
    L = models.kind(call, "L")
    if L.period is None:
        return disk_margin(L.system())
    found = disk_margin(_on_the_axis(call, L).system())
    return DiskMargin(found.alpha, found.alpha_above, 2 / L.period * math.atan(found.frequency))


def kind_bandwidth(system: control.StateSpace, of: str) -> Bandwidth:
    """The bandwidth of a kind: of "S" the first frequency at which it rises above -3 dB."""
    return (sensitivity_bandwidth if of == "S" else bandwidth)(system)


def refuse_rates(call: str, models: CutModels) -> None:
    """Refuse the margins of a loop whose blocks run at several periods."""
    if models.closed_model.count > 1:
        raise ValueError(
            f"`{call}` needs one loop gain; here blocks run at several periods, and the gain at an instant is not that "
            "at the next. Ask for M = `hinf_norm('S')` of the lifted loop: gains from M / (M + 1) to M / (M - 1), or a "
            "phase lost below 2 asin(1 / 2M), keep it stable."
        )


def _on_the_axis(call: str, L: LoopModel) -> LoopModel:
    """The continuous model with the values of a discrete one: z = (1 + s) / (1 - s)."""
    A, B, Cy, D, eye = L.A[0], L.B[0], L.Cy[0], L.D[0], np.eye(len(L.states))
    if np.linalg.cond(A + eye) > 1e14:
        raise DesignError(f"`{call}`: the loop gain has a pole at z = -1, Nyquist's frequency, where it is infinite.")
    inverse, root = np.linalg.inv(A + eye), math.sqrt(2.0)
    matrices = (inverse @ (A - eye), root * inverse @ B, root * Cy @ inverse, D - Cy @ inverse @ B)
    A, B, Cy, D = (np.asarray(M)[np.newaxis] for M in matrices)
    return LoopModel(A, B, Cy, D, L.states, L.inputs, L.outputs)
