"""The linear loops of b3 over frequency, in continuous time and in the computer of each plant."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

import workbench as wb
from studies.b3_any_plant.loops import SUBSTEPS, laws_of, loop, run
from studies.b3_any_plant.settings import SETTINGS, Setting

POINTS = 301
BEYOND = 30.0  # times the fastest pole, and below the slowest one: the ends of a picture
STILL = ("controller.outer.integral", "controller.inner.integral")  # of a PD, whose integrals have no gain
ITEMS = tuple((setting.name, law) for setting in SETTINGS for law in laws_of(setting))


@dataclass(frozen=True, eq=False)
class LinearAnswer:
    """The margins of each input, the others closed, the disk margin of all at once, and the poles (n,) of the loop.

    The poles are in 1/s, in a computer those of the map of its period. `alpha` is 0 if the loop is not stable.
    """

    inputs: tuple[str, ...]
    computer: bool
    margins: tuple[wb.frequency.StabilityMargins, ...]
    alpha: float
    poles: wb.Array

    @property
    def largest(self) -> complex:
        """The pole that decays slowest: of the largest real part, or nearest to the unit circle."""
        return complex(self.poles[0])


@dataclass(frozen=True, eq=False)
class FrequencyAnswer:
    """A loop at rest in continuous time, with the loop gains (m, inputs) at `omega` (m,) in rad/s, and in its computer.

    Where a loop has no linear answer there is None, and `reasons` says why.
    """

    continuous: LinearAnswer | None
    computer: LinearAnswer | None
    omega: wb.Array
    gains: wb.Array
    reasons: tuple[str, ...]


def frequency_answer(item: tuple[str, str]) -> FrequencyAnswer:
    """The linear answers of a plant under a law, by their names."""
    name, law = item
    setting = next(one for one in SETTINGS if one.name == name)
    reasons: list[str] = []
    omega, gains, found = np.zeros(0), np.zeros((0, 0), dtype=complex), list[LinearAnswer | None]()
    for computer in (False, True):
        try:
            linear = linear_at_rest(setting, law, computer=computer)
            found.append(answer_of(linear))
        except (wb.linear.DesignError, ValueError) as refused:
            reasons.append(str(refused))
            found.append(None)
            continue
        if not computer:
            omega = frequencies([linear_at_rest(setting, one) for one in laws_of(setting)])
            singles = [linear_at_rest(setting, law, at=channel) for channel in linear.channels]
            gains = np.stack([one.response(omega).values[:, 0, 0] for one in singles], axis=1)
    return FrequencyAnswer(found[0], found[1], omega, gains, tuple(reasons))


def linear_at_rest(
    setting: Setting, law: str, at: str | None = None, *, computer: bool = False
) -> wb.linear_loops.LinearLoop:
    """The linear loop where the plant rests at its operating point, cut at its inputs or at one of them."""
    closed: Any = loop(setting, law)
    still = STILL if isinstance(closed.controller, wb.Cascade) else ()
    rest = setting.open.states.unpack(setting.point.x)
    values = {f"plant.{name}": np.reshape(part, setting.open.states[name].shape) for name, part in rest.items()}
    if not computer:
        return wb.linear_loop(closed, at, values, freeze=still)
    # a computer holds what it last computed, so that its plant rests where that is, to rounding: all states are sought
    inside = run(setting, law, computer=True).loop
    assert isinstance(inside, wb.DigitalLoop)
    return wb.linear_loop(inside, at, freeze=still, substeps=SUBSTEPS)


def answer_of(linear: wb.linear_loops.LinearLoop) -> LinearAnswer:
    """Margins and poles of a linear loop."""
    found = linear.margins()
    alpha = linear.disk_margin.alpha if linear.stable else 0.0
    poles = np.array([pole.value for pole in linear.poles])
    each = tuple(found[name] for name in linear.channels)
    return LinearAnswer(linear.channels, linear.period is not None, each, alpha, poles)


def frequencies(loops: Sequence[wb.linear_loops.LinearLoop]) -> wb.Array:
    """The frequencies of a picture of loops in rad/s, from below their slowest pole to beyond their fastest."""
    sizes = np.array([abs(pole.value) for linear in loops for pole in linear.poles])
    sizes = sizes[sizes > 1e-9 * sizes.max()]
    return np.geomspace(sizes.min() / BEYOND, sizes.max() * BEYOND, POINTS)


def answers(results: wb.Results) -> Mapping[tuple[str, str], FrequencyAnswer]:
    """The linear answers of each plant under each law."""
    return dict(zip(ITEMS, results.work("frequency"), strict=True))
