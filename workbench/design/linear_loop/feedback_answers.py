"""Feedback of frequency answers at each frequency, with the errors and sensitivities that it passes on."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.design.frequency.response_kernel import FrequencyAnswers
from workbench.design.matrices import EPS, Complex

Cells = TypeVar("Cells", Array, Complex)


def cells(of: FrequencyAnswers, rows: Sequence[int], columns: Sequence[int]) -> FrequencyAnswers:
    """The answers of some outputs to some inputs."""

    def some(M: Cells) -> Cells:
        return M[:, :, list(rows)][..., list(columns)]

    return FrequencyAnswers(some(of.values), some(of.errors), some(of.sensitivities))


def close_inputs(
    G: FrequencyAnswers, turn: Complex, closed_inputs: list[int], open_inputs: list[int]
) -> FrequencyAnswers:
    """The answers to the inputs `open_inputs` when each of `closed_inputs` is minus the output of the same place.

    An error E of G becomes |P| E |R| to first order, where P and R lead from each output and to each input.
    """
    if not closed_inputs:
        return cells(G, range(G.values.shape[2]), open_inputs)
    e, V = turn[:, closed_inputs, np.newaxis], G.values
    through, back = V[:, :, closed_inputs][..., open_inputs], V[..., closed_inputs]
    inner = np.eye(len(closed_inputs)) - e * V[:, :, closed_inputs][..., closed_inputs]
    to_inputs = solve_each(inner, e * through)
    values = np.asarray(V[..., open_inputs] + back @ to_inputs)
    from_outputs = np.abs(back @ solve_each(inner, e * np.broadcast_to(np.eye(len(closed_inputs)), inner.shape)))
    right = np.abs(to_inputs)

    def propagate(E: Array) -> Array:
        own = E[..., open_inputs] + E[..., closed_inputs] @ right
        return np.asarray(
            own
            + from_outputs
            @ (E[:, :, closed_inputs][..., open_inputs] + E[:, :, closed_inputs][..., closed_inputs] @ right)
        )

    terms = propagate(np.abs(V))
    return FrequencyAnswers(
        values, propagate(G.errors) + 4 * (len(closed_inputs) + 2) * EPS * terms, propagate(G.sensitivities)
    )


def sensitivity(L: FrequencyAnswers, of: str) -> FrequencyAnswers:
    """S = (I + L)^-1 or T = L (I + L)^-1; an error E of L becomes |S| E |S| to first order."""
    eye = np.broadcast_to(np.eye(L.values.shape[-1], dtype=complex), L.values.shape)
    S = solve_each(eye + L.values, eye)
    size = np.abs(S)
    terms = size @ (np.abs(L.values) + np.abs(eye)) @ size
    errors = size @ L.errors @ size + 4 * (len(eye[0, 0]) + 2) * EPS * terms
    return FrequencyAnswers(
        S if of == "S" else np.asarray(L.values @ S), errors, np.asarray(size @ L.sensitivities @ size)
    )


def solve_each(matrices: Complex, right: Complex) -> Complex:
    """The solutions of (N, m) linear systems; NaN where one is singular or no number."""
    solution = np.full(np.broadcast_shapes(matrices.shape[:-1] + (1,), right.shape), np.nan, complex)
    right = np.broadcast_to(right, solution.shape)
    sound = np.asarray(np.isfinite(matrices).all(axis=(-2, -1)))
    with np.errstate(all="ignore"):
        sound &= np.abs(np.linalg.det(np.where(sound[..., np.newaxis, np.newaxis], matrices, 0))) > 0
    solution[sound] = np.linalg.solve(matrices[sound], right[sound])
    return solution
