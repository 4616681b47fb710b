"""Systems of python-control, as its users make them: the processes and plants that the designs of d1 are given."""

from __future__ import annotations

from collections.abc import Sequence

import control
import numpy as np

import workbench as wb

System = control.StateSpace


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


def impulse_response(system: control.TransferFunction, until: float, count: int) -> tuple[wb.Array, wb.Array]:
    """Instants in s, and the response of a system to a unit impulse at these."""
    t, y = control.impulse_response(system, np.linspace(0.0, until, count))
    return np.asarray(t), np.asarray(y)


def realization(system: control.TransferFunction) -> control.StateSpace:
    """A transfer function by matrices."""
    return control.ss(system, remove_useless_states=False)


def coefficients(system: control.StateSpace) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Numerator and denominator of a system of one channel, in descending powers of s."""
    one = control.tf(system)
    return tuple(map(float, one.num[0][0])), tuple(map(float, one.den[0][0]))


def state_space(A: wb.Array, B: wb.Array, C: wb.Array, D: wb.Array) -> control.StateSpace:
    """A system by its matrices."""
    return control.ss(A, B, C, D, remove_useless_states=False)


def distillation_column() -> control.StateSpace:
    """The closed loop N of the distillation column under its inverse-based controller, from the uncertainty of both
    inputs and the disturbances to the weighted inputs and the weighted errors; rates per minute.

    The plant is G0 / (75 s + 1), the controller 0.7 / s (75 s + 1) G0^-1, w_I = (s + 0.2) / (0.5 s + 1) for each input,
    and w_P = (s / 2 + 0.05) / s. What cancels is left out.
    """
    G0 = np.array([[87.8, -86.4], [108.2, -109.6]])
    G1, one = np.linalg.inv(G0), np.eye(2)
    add = _gain(np.hstack([one, one]))
    to_inputs = (
        _lag(2.0, 0.4 - 4.0, 2.0) * add * control.append(_lag(0.7, 0.7), _lag(0.7, 0.7 * -51.5, 52.5) * _gain(G1))
    )
    to_errors = _lag(0.7, 0.05 - 0.35, 0.5) * add * control.append(_gain(G0) * _lag(1 / 75, 1 / 75), _gain(one))
    both = control.append(to_inputs, to_errors)
    doubled = np.vstack([np.eye(4), np.eye(4)])
    return control.ss(both.A, both.B @ doubled, both.C, both.D @ doubled)


def _lag(rate: float, gain: float, direct: float = 0.0) -> control.StateSpace:
    """direct + gain / (s + rate) in two channels."""
    return control.append(*[control.ss(-rate, 1.0, gain, direct)] * 2)


def _gain(matrix: wb.Array) -> control.StateSpace:
    return control.ss([], [], [], matrix)
