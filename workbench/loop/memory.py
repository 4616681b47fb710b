"""The memory of a block: where it starts, and a step of it."""

from __future__ import annotations

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout
from workbench.core.block import quantities, unit_of
from workbench.validation.shapes import Memory


def euler(z: Memory, rates: Memory, period: float) -> dict[str, ca.SX]:
    """z + period z', the explicit Euler step of each part of a memory."""
    return {name: z[name] + period * rate for name, rate in rates.items()}


def starts(block: object) -> Layout:
    """The fields that a block declares by `initial`, as the layout of its states."""
    held = ((f.name, np.asarray(getattr(block, f.name), dtype=float), q) for f, q in quantities(block) if not q.lifted)
    return Layout(tuple(Entry(name, x, unit_of(block, q), symbol=q.symbol) for name, x, q in held))
