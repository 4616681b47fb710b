"""The conditions under which a generalized plant has an H2 or an H-infinity controller, each refused by its name.

With D12 = U [0; S] V' the path from u to z loses rank at s exactly where a mode s of A - B2 D12^+ C1 is not observed by
the errors that u does not reach. So zeros on the axis are found by the test of Popov, Belevitch and Hautus, too.

References
----------
Zhou, Doyle, Glover (1996), Robust and Optimal Control, sections 16.1 and 17.1, assumptions (A1) to (A4).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np
from scipy import linalg

from workbench.core.validation.refusals import Array
from workbench.design.linear.linear_modes import HautusMode, hautus_mode, mode_at
from workbench.design.matrices import EPS, DesignError, pole_text
from workbench.design.synthesis.generalized_plant import PlantParts

HIDDEN = 1e-12  # a mode whose relative distance from being hidden is smaller counts as hidden
RANK = 1e-13  # the relative size of a singular value that counts as zero
UNSURE = 16.0  # roundings of A by which an eigenvalue may lie on the other side


def check_conditions(call: str, plant: PlantParts, period: float | None = None) -> None:
    """Refuse a plant that breaks one of the conditions (A1) to (A4), in that order.

    A sampled plant comes as its bilinear transform, and its modes and frequencies are named as those of z.
    """
    for failure in _failures(plant, period):
        raise DesignError(f"`{call}`: {failure}")


def _failures(p: PlantParts, period: float | None) -> Iterator[str]:
    for mode in hidden_modes(p.A, p.B2):
        yield (
            f"the pair (A, B2) is not stabilisable: no control moves the mode {mode_text(mode.value, period)} of A "
            f"(relative distance {mode.margin:.1e}). Give it an actuator, or leave it out of the plant and its weights."
        )
    for mode in hidden_modes(p.A.T, p.C2.T):
        yield (
            f"the pair (C2, A) is not detectable: no measurement shows the mode {mode_text(mode.value, period)} of A "
            f"(relative distance {mode.margin:.1e}). Give it a sensor, or leave it out of the plant and its weights."
        )
    where = "" if period is None else " at z = -1"
    if not full_columns(p.D12):
        yield (
            f"D12{where} must have full column rank {p.D12.shape[1]}, or some control is not penalised; its singular "
            f"values are {_values(p.D12)}. Add a weight of each control to the errors."
        )
    if not full_columns(p.D21.T):
        yield (
            f"D21{where} must have full row rank {len(p.D21)}, or some measurement has no noise; its singular values "
            f"are {_values(p.D21)}. Add noise of each measurement to the disturbances."
        )
    shift, limit = ("jw", "imaginary axis") if period is None else ("exp(jwT)", "unit circle")
    for omega in axis_zeros(p):
        yield (
            f"[A - {shift} I, B2; C1, D12] loses column rank at w = {_frequency(omega, period):.6g} rad/s: the path "
            f"P12 from the controls to the errors has a zero on the {limit}. Give this mode a weight in the errors, or "
            "shift it."
        )
    for omega in axis_zeros(p.dual()):
        yield (
            f"[A - {shift} I, B1; C2, D21] loses row rank at w = {_frequency(omega, period):.6g} rad/s: the path P21 "
            f"from the disturbances to the measurements has a zero on the {limit}. Let a disturbance drive this mode, "
            "or shift it."
        )


def mode_text(value: complex, period: float | None) -> str:
    """A mode of the plant as it came."""
    return pole_text(value if period is None else (1 + value) / (1 - value))


def _frequency(omega: float, period: float | None) -> float:
    """A frequency of the plant as it came, in rad/s."""
    return omega if period is None else 2 / period * math.atan(omega)


def full_columns(D: Array) -> bool:
    """True if the columns of a matrix are independent beyond rounding."""
    if len(D) < D.shape[1]:
        return False
    values = linalg.svdvals(D)
    return bool(values[-1] > RANK * values[0] and values[0] > 0)


def hidden_modes(A: Array, B: Array) -> Iterator[HautusMode]:
    """The modes of A on the imaginary axis or right of it that no column of B moves, within rounding."""
    yield from _hidden(A, B, lambda value, unsure: value.real >= -unsure)


def axis_zeros(p: PlantParts) -> Iterator[float]:
    """The frequencies in rad/s at which the path from u to z has a zero on the imaginary axis, within rounding."""
    pseudo = np.linalg.pinv(p.D12)
    apart = linalg.null_space(p.D12.T)
    A = p.A - p.B2 @ pseudo @ p.C1
    for mode in _hidden(A.T, p.C1.T @ apart, lambda value, unsure: abs(value.real) <= unsure):
        yield abs(mode.value.imag)


def _hidden(A: Array, B: Array, is_doubtful: Callable[[complex, float], bool]) -> Iterator[HautusMode]:
    scale = float(np.linalg.norm(np.hstack([A, B]), 2)) or 1.0
    for value, unsure in eigenvalues(A):
        if not is_doubtful(value, unsure):
            continue
        mode = hautus_mode(A, B, value, scale, [""] * len(A))
        if not is_doubtful(mode.value, unsure):  # the descent went to a hidden mode of another place
            mode = mode_at(A, B, value, scale, [""] * len(A))
        if mode.margin <= HIDDEN:
            yield mode


def eigenvalues(A: Array) -> Iterator[tuple[complex, float]]:
    """Each eigenvalue with the distance by which rounding of the matrix may move it."""
    balanced, _ = linalg.matrix_balance(A)
    # a list, as SciPy's stub forgets one of the three
    values, left, right = list(linalg.eig(balanced, left=True, right=True))
    along = np.maximum(np.abs((left.conj() * right).sum(axis=0)), np.sqrt(EPS))
    size = float(np.linalg.norm(balanced, 2))
    for value, cosine in zip(values, along, strict=True):
        yield complex(value), UNSURE * EPS * size / float(cosine)


def _values(D: Array) -> str:
    return ", ".join(f"{value:.3g}" for value in linalg.svdvals(D))
