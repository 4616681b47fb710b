"""Sentences on the modes of a linear loop that grow, that lie near the axis, or that its cut does not show."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, overload

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.design.linear import Pole
from workbench.design.linear.hidden_modes import hidden_modes
from workbench.design.linear_loop.loop_model import LoopModel
from workbench.design.matrices import EPS, pole_text

if TYPE_CHECKING:
    import control

DEAD = 1e-9  # a pole z of this size decays within a period, so that nothing of it can be hidden


def loop_remarks(
    closed_model: LoopModel,
    poles: Sequence[Pole],
    L: control.StateSpace | None,
    at_rest: bool,
    corner_signals: Sequence[str],
) -> tuple[str, ...]:
    """Sentences on the poles of a closed loop, on what its gain L hides, on its motion, and on signals with corners."""
    found: list[str] = []
    if poles:
        size = float(np.linalg.norm(closed_model.A[0], 2))
        found += mode_remarks(poles, size, closed_model.period is not None, with_advice=True)
    if L is not None:
        found += hidden_remarks(L)
    if not at_rest:
        found.append("The loop is frozen at a state that is not at rest, so its poles prove nothing about its motion.")
    found += [f"'{name}' has a corner or a jump at this state, so it has no linear answer." for name in corner_signals]
    return tuple(found)


def decay_of(pole: Pole, discrete: bool) -> float:
    """The distance of a pole from instability, to the left of the axis in 1/s or inside of the unit circle."""
    return 1 - abs(pole.value) if discrete else -pole.value.real


@overload
def doubt_of(condition: float, size: float, count: int) -> float: ...
@overload
def doubt_of(condition: Array, size: float, count: int) -> Array: ...
def doubt_of(condition: float | Array, size: float, count: int) -> float | Array:
    """The distance by which rounding may have moved poles of these conditions, of a matrix of this norm and rows."""
    doubt: float | Array = count * EPS * size * np.minimum(condition, 1 / EPS)
    return doubt


def mode_remarks(poles: Sequence[Pole], size: float, discrete: bool, with_advice: bool) -> tuple[str, ...]:
    """A sentence for each pole of the closed loop that grows, or that doubles cannot tell from one that does."""
    unit, sentences = "" if discrete else " 1/s", []
    for pole in (pole for pole in poles if pole.value.imag >= 0):
        decay, doubt = decay_of(pole, discrete), doubt_of(pole.condition, size, len(poles))
        where = f"the mode {pole_text(pole.value)}{unit} of {', '.join(pole.states)}"
        if decay < -doubt:
            sentences.append(f"The closed loop is not stable: {where} grows.")
        elif decay <= doubt:
            axis = "unit circle" if discrete else "imaginary axis"
            advice = ". If its state is constant, name it in `freeze`" if with_advice else ""
            sentences.append(f"The closed loop has a pole on the {axis} to within rounding errors: {where}{advice}.")
    return tuple(sentences)


def hidden_remarks(L: control.StateSpace) -> tuple[str, ...]:
    """A sentence for each mode that cannot be controlled or observed at the cut, and for those not decided."""
    if not L.nstates:
        return ()
    discrete, words, sentences = bool(L.isdtime(strict=True)), dict[str, list[str]](), []
    for test, word in (("controllable", "controlled"), ("observable", "observed")):
        modes, undecided = hidden_modes(L, test, DEAD if discrete else 0.0)
        for mode in modes:
            where = f"{pole_text(mode.value)}{'' if discrete else ' 1/s'} of {', '.join(mode.states)}"
            words.setdefault(where, []).append(word)
        if undecided:
            sentences.append(
                f"It is not decided whether {undecided} of the {L.nstates} modes of the loop gain can be {word} at the "
                "cut: their eigenvectors are too ill-conditioned."
            )
    verbs = {where: " or ".join(dict.fromkeys(each)) for where, each in words.items()}
    shown = [
        f"The loop gain at the cut does not show the mode {where}, which cannot be {verb} there."
        for where, verb in verbs.items()
    ]
    return (*shown, *sentences)
