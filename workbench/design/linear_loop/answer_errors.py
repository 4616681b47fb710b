"""Feedback of frequency answers at each frequency, with the errors and sensitivities that it passes on."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.design.frequency.response_kernel import Answers
from workbench.design.matrices import EPS, Complex

Cells = TypeVar("Cells", Array, Complex)


def cells(of: Answers, rows: Sequence[int], columns: Sequence[int]) -> Answers:
    """The answers of some outputs to some inputs."""

    def some(M: Cells) -> Cells:
        return M[:, :, list(rows)][..., list(columns)]

    return Answers(some(of.values), some(of.errors), some(of.sensitivities))


def closed_again(G: Answers, turn: Complex, again: list[int], left: list[int]) -> Answers:
    """The answers to the inputs `left` when each input of `again` is the output of the same place, turned.

    An error E of G becomes |P| E |R| to first order, where P and R lead from each output and to each input.
    """
    if not again:
        return cells(G, range(G.values.shape[2]), left)
    e, V = turn[:, again, np.newaxis], G.values
    through, back = V[:, :, again][..., left], V[..., again]
    inner = np.eye(len(again)) - e * V[:, :, again][..., again]
    to_inputs = solved(inner, e * through)
    values = np.asarray(V[..., left] + back @ to_inputs)
    from_outputs = np.abs(back @ solved(inner, e * np.broadcast_to(np.eye(len(again)), inner.shape)))
    right = np.abs(to_inputs)

    def passed(E: Array) -> Array:
        own = E[..., left] + E[..., again] @ right
        return np.asarray(own + from_outputs @ (E[:, :, again][..., left] + E[:, :, again][..., again] @ right))

    terms = passed(np.abs(V))
    return Answers(values, passed(G.errors) + 4 * (len(again) + 2) * EPS * terms, passed(G.sensitivities))


def sensitivity(L: Answers, of: str) -> Answers:
    """S = (I + L)^-1 or T = L (I + L)^-1; an error E of L becomes |S| E |S| to first order."""
    eye = np.broadcast_to(np.eye(L.values.shape[-1], dtype=complex), L.values.shape)
    S = solved(eye + L.values, eye)
    size = np.abs(S)
    terms = size @ (np.abs(L.values) + np.abs(eye)) @ size
    errors = size @ L.errors @ size + 4 * (len(eye[0, 0]) + 2) * EPS * terms
    return Answers(S if of == "S" else np.asarray(L.values @ S), errors, np.asarray(size @ L.sensitivities @ size))


def solved(matrices: Complex, right: Complex) -> Complex:
    """The solutions of (N, m) linear systems; NaN where one is singular or no number."""
    solution = np.full(np.broadcast_shapes(matrices.shape[:-1] + (1,), right.shape), np.nan, complex)
    right = np.broadcast_to(right, solution.shape)
    sound = np.asarray(np.isfinite(matrices).all(axis=(-2, -1)))
    with np.errstate(all="ignore"):
        sound &= np.abs(np.linalg.det(np.where(sound[..., np.newaxis, np.newaxis], matrices, 0))) > 0
    solution[sound] = np.linalg.solve(matrices[sound], right[sound])
    return solution
