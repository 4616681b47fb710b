"""The linear answers of a loop at rest: margins and poles at each pose, and curves over frequency at one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

import workbench as wb
from studies.d0_frequency.loops import ARM_POSES, COMPUTERS, CONTINUOUS, DRAWN_LAWS, EVERY, SHORT, AtPose, linear
from studies.paper.linearization import LEVEL

Complex = np.ndarray[Any, np.dtype[np.complex128]]
JOINTS = ("tau[0]", "tau[1]")
OMEGA = np.geomspace(0.1, 1e5, 361)  # rad/s
LIGHT, ON_AXIS = 0.05, 1e-9  # dampings of a pole of L: below the first more frequencies, below the second none
POINTS = 241  # frequencies of a computer, up to Nyquist's


@dataclass(frozen=True, eq=False)
class RestAnswer:
    """A linear loop at rest: the margins of each joint with the other closed, and the disk margin of both at once.

    `poles` (n,) are those of the closed loop: in 1/s, or those of the period's map. `alpha` is 0 if it is not stable.
    """

    stable: bool
    joints: tuple[wb.frequency.StabilityMargins, wb.frequency.StabilityMargins]
    alpha: float
    poles: wb.Array

    @property
    def delay(self) -> float:
        """The least delay margin of a joint in s; 0 if the loop is not stable."""
        return min((m.margins.delay_margin.value if m.margins else 0.0) for m in self.joints)

    @property
    def phase(self) -> float:
        """The least phase margin of a joint in degrees; 0 if the loop is not stable."""
        return min((m.margins.phase_margin.value if m.margins else 0.0) for m in self.joints)

    @property
    def single(self) -> float:
        """The least disk margin of a joint by itself; 0 if the loop is not stable."""
        return min((m.margins.disk_margin.value if m.margins else 0.0) for m in self.joints)

    @property
    def Ms(self) -> float:
        """The largest Ms of a joint; infinite if the loop is not stable."""
        return max((m.margins.Ms.gain.value if m.margins else float("inf")) for m in self.joints)


def answer_of(loop: wb.linear_loops.LinearLoop) -> RestAnswer:
    """Margins and poles of a linear loop."""
    found = loop.margins()
    stable = loop.stable
    alpha = loop.disk_margin.alpha if stable else 0.0
    return RestAnswer(
        stable, (found[JOINTS[0]], found[JOINTS[1]]), alpha, np.array([pole.value for pole in loop.poles])
    )


def rest_answers(one: AtPose) -> dict[str, RestAnswer]:
    """The answers of a law at a pose in continuous time, and at the level of SS in each computer, by its name."""
    found = {CONTINUOUS: answer_of(linear(one))}
    if one.pose == LEVEL:
        found |= {name: answer_of(linear(one, period)) for name, period in COMPUTERS.items()}
    return found


@dataclass(frozen=True, eq=False)
class Curves:
    """The answers of a loop at frequencies (m,) in rad/s: L (m, 2, 2) at both torques, and each joint's own (m, 2).

    `period` is that of the computer in s, 0 in continuous time. `gang` has the largest singular value (m,) of each
    answer of the gang of six.
    """

    period: float
    omega: wb.Array
    L: Complex
    single: Complex
    gang: dict[str, wb.Array]


def curves(law: str) -> tuple[Curves, Curves]:
    """The curves of a law at the level of the second scenario: in continuous time, and at the short period."""
    one = AtPose(law, LEVEL)
    fast = np.geomspace(OMEGA[0], np.pi / SHORT, POINTS)
    return _curves(one, None, OMEGA), _curves(one, SHORT, fast)


def _curves(one: AtPose, period: float | None, omega: wb.Array) -> Curves:
    both, cuts = linear(one, period), [linear(one, period, joint) for joint in JOINTS]
    omega = closer(omega, np.concatenate([rates(cut) for cut in cuts]))
    singles = [cut.response(omega).values[:, 0, 0] for cut in cuts]
    six = both.gang_of_six(omega)
    gang = {name: np.linalg.norm(answer.values, 2, axis=(-2, -1)) for name, answer in six.items()}
    return Curves(period or 0.0, omega, both.response(omega).values, np.stack(singles, axis=1), gang)


def rates(cut: wb.linear_loops.LinearLoop) -> Complex:
    """The poles (n,) of a loop gain in 1/s; in a computer the logarithms of those of its map over the period."""
    poles = np.asarray(cut.L.poles(), dtype=complex)
    return poles if cut.period is None else np.log(poles[poles != 0]) / cut.period


def closer(omega: wb.Array, poles: Complex) -> wb.Array:
    """The frequencies (m,) in rad/s with more of them about each lightly damped pole in 1/s, where the phase turns."""
    added = [omega]
    for pole in poles[poles.imag > 0]:
        if ON_AXIS < abs(pole.real) / abs(pole) < LIGHT:
            away = np.geomspace(0.1 * abs(pole.real), 0.3 * pole.imag, 16)
            added += [pole.imag - away, np.array([pole.imag]), pole.imag + away]
    every = np.unique(np.concatenate(added))
    return np.asarray(every[(every >= omega[0]) & (every <= omega[-1])])


def rests(results: wb.Results) -> Mapping[AtPose, Mapping[str, RestAnswer]]:
    """The answers of each law at each pose."""
    return dict(zip(EVERY, results.work("rests"), strict=True))


def over_poses(answers: Mapping[AtPose, Mapping[str, RestAnswer]], law: str) -> dict[str, RestAnswer]:
    """The answers of a law in continuous time, by pose."""
    return {pose: answers[AtPose(law, pose)][CONTINUOUS] for pose in ARM_POSES}


def all_curves(results: wb.Results) -> Mapping[str, tuple[Curves, Curves]]:
    """The curves of each law that is drawn, in continuous time and at the short period."""
    return dict(zip(DRAWN_LAWS, results.work("curves"), strict=True))
