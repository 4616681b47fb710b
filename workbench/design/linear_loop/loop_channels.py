"""The channels of a cut loop one by one, each while the loop is closed at the others, and the frequencies that fit."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.design.linear.loop_cuts import closure
from workbench.design.linear.system_answers import SystemRoots, fitting_frequencies, system_roots
from workbench.design.linear_loop.frequency_answers import CutModels
from workbench.design.linear_loop.loop_model import LoopModel
from workbench.design.matrices import Complex

TURNS = 1.0  # full turns of a delay, at which the frequencies of a loop with a delay end
BEYOND = 3.0  # times the highest frequency that they must show


def channel_models(models: CutModels, k: int) -> CutModels:
    """The models of a loop that is cut at its channel k, and closed at its other ones."""
    return replace(models, channels=(models.channels[k],))


def channel_roots(call: str, models: CutModels, k: int) -> SystemRoots:
    """The poles, the zeros and the gain of L at one channel, of the states on which it depends, without its delay.

    Over lifted periods the poles are those of one of them, and zeros are left out.
    """
    L = without_hidden_states(channel_models(models, k).kind(call, "L"))
    if L.count > 1:
        return SystemRoots(_of_one_period(np.linalg.eigvals(L.A[0]), L.count), np.zeros(0, complex), None, L.period)
    return system_roots(L.system())


def loop_frequencies(call: str, models: CutModels, crossovers: Iterable[float] = ()) -> Array:
    """Frequencies in rad/s that show a loop, by the rule of `fitting_frequencies`: about its roots, open and closed.

    Those of a loop with delays end after a turn of the longest one, or behind the highest of the `crossovers`.
    """
    period = models.closed_model.period
    roots = [
        _of_one_period(np.linalg.eigvals(without_hidden_states(models.closed_model).A[0]), models.closed_model.count)
    ]
    if models.open_model is not None:
        for k in range(len(models.channels)):
            own = channel_roots(call, models, k)
            roots += [own.poles, own.zeros]
    longest = float(models.delays.max(initial=0.0))
    if longest:
        roots.append(np.array([-1 / longest], dtype=complex))
    omega = fitting_frequencies(SystemRoots(np.concatenate(roots), np.zeros(0, complex), None, period))
    if longest:
        top = max(2 * math.pi * TURNS / longest, *(BEYOND * at for at in crossovers), 0.0)
        omega = omega[omega <= top]
    return np.asarray(omega)


def without_hidden_states(model: LoopModel) -> LoopModel:
    """The model without the states that nothing moves from outside, or that no output shows, by the zeros of A."""
    A, B, Cy = (np.nan_to_num(M) != 0 for M in (model.A, model.B, model.Cy))
    reach = closure(A.any(axis=0) | np.eye(A.shape[-1], dtype=bool))  # reach[i, j]: j reaches i
    moved = reach[:, B.any(axis=(0, 2))].any(axis=1)
    seen = reach[Cy.any(axis=(0, 1))].any(axis=0)
    keep = np.flatnonzero(moved & seen)
    return replace(
        model,
        A=model.A[:, keep][:, :, keep],
        B=model.B[:, keep],
        Cy=model.Cy[:, :, keep],
        states=tuple(model.states[i] for i in keep),
    )


def _of_one_period(values: Complex, count: int) -> Complex:
    """The poles z of one period, in continuous time s, of those of so many periods."""
    if count == 1:
        return np.asarray(values, dtype=complex)
    return np.asarray(np.where(values == 0, 0, np.exp(np.log(np.where(values == 0, 1, values)) / count)))
