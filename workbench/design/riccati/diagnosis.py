"""Why an equation has no stabilising solution: the mode that the inputs do not move, or that costs nothing.

References
----------
Hautus (1969), Controllability and observability conditions of linear autonomous systems, Indag. Math. 31
(the test of Popov, Belevitch and Hautus).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import linalg

from workbench.design.matrices import Complex
from workbench.design.riccati.equation import Data, norm
from workbench.design.riccati.hamiltonian import hamiltonian
from workbench.validation.refusals import Array

NEAR = 1e-7  # half the digits and a little more: eigenvalues that meet on the boundary are found no better
LOST = 1e-12  # a relative distance from a loss of rank that rounding may have made
MOST_MODES = 40  # each asks for singular values


@dataclass(frozen=True)
class Words:
    """How the reasons read for a regulator, or for an estimator, whose equation is that of the transposed system."""

    unmoved: str
    free: str


REGULATOR = Words(
    unmoved="the pair (A, B) is not stabilisable: no input moves the unstable mode {mode} of A (relative PBH distance "
    "{distance:.1e}). Give it an actuator, or leave it out of the model",
    free="the mode {mode} of A lies on the {edge} and costs nothing in Q (relative PBH distance {distance:.1e}), so it "
    "stays where it is. Give it a weight in Q",
)
ESTIMATOR = Words(
    unmoved="the pair (A, C) is not detectable: no output sees the unstable mode {mode} of A (relative PBH distance "
    "{distance:.1e}). Give it a sensor, or leave it out of the model",
    free="the mode {mode} of A lies on the {edge} and no noise drives it (relative PBH distance {distance:.1e}), so "
    "the filter stops to look at it. Give it noise in Qn",
)


def reason(d: Data, discrete: bool, words: Words = REGULATOR) -> str:
    """One sentence on why there is no stabilising solution, or an empty text if none is seen."""
    modes: Complex = np.asarray(linalg.eigvals(d.A, d.E), dtype=complex)
    modes = modes[np.isfinite(modes)]
    inside = 1 - np.abs(modes) if discrete else -modes.real
    scale = 1.0 if discrete else max(1e-300, float(np.abs(modes).max(initial=0)))
    return (
        _unmoved(d, modes[inside <= NEAR * scale], words)
        or _free(d, modes[np.abs(inside) <= NEAR * scale], discrete, words)
        or ("" if discrete else _axis(d))
    )


def _unmoved(d: Data, modes: Complex, words: Words) -> str:
    mode, distance = _worst(d, modes, d.B, beside=True)
    return "" if distance > LOST else words.unmoved.format(mode=figure(mode), distance=distance)


def _free(d: Data, modes: Complex, discrete: bool, words: Words) -> str:
    mode, distance = _worst(d, modes, d.Q, beside=False)
    if distance > LOST or d.S.any():
        return ""
    edge = "unit circle" if discrete else "imaginary axis"
    return words.free.format(mode=figure(mode), distance=distance, edge=edge)


def _axis(d: Data) -> str:
    try:
        values = np.linalg.eigvals(hamiltonian(d))
    except (np.linalg.LinAlgError, ValueError):
        return ""
    nearest = values[np.abs(values.real).argmin()]
    if abs(nearest.real) > NEAR * np.abs(values).max():
        return ""
    return (
        f"the Hamiltonian matrix has the eigenvalue {figure(complex(0, abs(nearest.imag)))} on the imaginary axis, "
        "within rounding, so no X stabilises A - B K. Weigh the states more in Q"
    )


def _worst(d: Data, modes: Complex, other: Array, beside: bool) -> tuple[complex, float]:
    """The mode whose pencil [A - mode E, other], or the same stacked, comes nearest to a loss of rank."""
    found = 0j, np.inf
    E = np.eye(d.n) if d.E is None else d.E
    # both parts are made of one size, so that neither hides the other's zeros
    size = [max(norm(matrix), 1e-300) for matrix in (d.A, other)]
    for mode in modes[:MOST_MODES]:
        parts = [(d.A - mode * E) / size[0], other / size[1]]
        values = np.linalg.svd(np.hstack(parts) if beside else np.vstack(parts), compute_uv=False)
        if values[-1] < found[1]:
            found = complex(mode), float(values[-1])
    return found


def figure(mode: complex) -> str:
    """A pole in four digits, as a real number if it is one."""
    return f"{mode.real:.4g}" if abs(mode.imag) < 1e-12 * (1 + abs(mode)) else f"{mode.real:.4g}{mode.imag:+.4g}j"
