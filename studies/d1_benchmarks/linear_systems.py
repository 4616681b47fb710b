"""Systems of python-control, as its users make them: the processes and plants that the designs of d1 are given."""

from __future__ import annotations

from collections.abc import Sequence

import control
import numpy as np

import workbench as wb


def transfer_function(num: Sequence[float], den: Sequence[float]) -> control.TransferFunction:
    """num / den, in descending powers of s."""
    return control.tf(list(num), list(den))


def error_law(A: wb.Array, B: wb.Array, C: wb.Array, D: wb.Array, reads: list[str], drives: list[str]) -> wb.LinearLaw:
    """A law of the errors of signals, by its matrices."""
    return wb.LinearLaw(control.ss(A, B, C, D, inputs=reads, outputs=drives), error=True)


def step_response(plant: control.TransferFunction, until: float, count: int) -> tuple[wb.Array, wb.Array]:
    """Instants in s, and the response of a plant to a unit step at these."""
    t, y = control.step_response(plant, np.linspace(0.0, until, count))
    return np.asarray(t), np.asarray(y)
