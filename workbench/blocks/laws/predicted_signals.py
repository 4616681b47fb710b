"""The plan of a predictive law as signals that a run records and a page draws."""

from __future__ import annotations

from collections.abc import Mapping

import casadi as ca
import numpy as np

from workbench.core import Layout
from workbench.core.block import Vector

TIMES = "predicted_t"


def predicted_signals(plan: tuple[tuple[Layout, ca.SX, Vector], ...], period: float) -> dict[str, ca.SX]:
    """The times of the stages of a plan from now on, and the numbers of layouts at these stages.

    A part of the plan has deviations (size, N + 1) from a rest (size,). All stages of the first number of a signal
    stand first.
    """
    stages = plan[0][1].shape[1]
    signals = {TIMES: ca.SX(np.arange(stages) * period)}
    for layout, deviations, rest in plan:
        numbers = deviations + ca.repmat(ca.SX(rest), 1, stages)
        signals |= {_name(name): ca.vec(numbers[layout.slice(name), :].T) for name in layout.names}
    return signals


def predicted_units(*layouts: Layout) -> Mapping[str, str]:
    """The units of these signals."""
    entries = [entry for layout in layouts for entry in layout.entries]
    return {TIMES: "s"} | {_name(entry.name): ", ".join(dict.fromkeys(entry.units)) for entry in entries}


def _name(signal: str) -> str:
    return f"predicted_{signal}"
