"""The limit cycle of SMC in its layer when the torque comes a period late: by harmonic balance, and simulated."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import workbench as wb
from studies.d0_frequency.loops import substeps
from studies.paper.card import CARD as PAPER
from studies.paper.linearization import POSES, holding_torque, still

POSE = POSES["folded down"]  # there M is diagonal: each joint is a loop by itself
PERIODS = (5e-4, 1e-3, 1.5e-3, 1.8e-3, 2.2e-3, 2.5e-3, 3e-3, 4e-3, 5e-3, 7.5e-3, 1e-2)  # s
PUSHES = ((0.001, 0.001), (0.1, 0.1), (-0.6, 0.4), (1.0, -0.5))  # rad/s, from which runs start
UNTIL, LATE = 6.0, 4.0  # s: the oscillation is looked at after `LATE`
QUIET = 1e-6  # rad/s: s at rest, but for what still decays
K, PHI = float(PAPER["SMC: K"][0]), float(PAPER["phi"])


@dataclass(frozen=True, eq=False)
class LimitCycle:
    """The balance at a period, and the oscillations of s of joint 1 from each push."""

    balance: wb.chattering.Balance
    runs: tuple[wb.chattering.RecordedOscillation, ...]

    @property
    def prediction(self) -> tuple[float, float] | None:
        """The frequency in rad/s and the amplitude in rad/s of the oscillation that attracts, None at rest."""
        held = [one for one in self.balance.oscillations if one.stable]
        return (held[-1].frequency, held[-1].amplitude) if held else None

    @property
    def rest(self) -> bool:
        """True if the layer is wider than that at which the last oscillation of the balance ends."""
        return self.balance.least_phi < PHI

    def agrees(self, run: int) -> bool:
        """True if a run rests where the balance does, and oscillates where it does not."""
        return self.rest is (self.runs[run].amplitude <= QUIET)


def late_step(period: float) -> wb.core.StepMap:
    """The step of the arm under SMC in a computer whose torque acts a period late."""
    waiting = {"tau": holding_torque(POSE)}
    return wb.DigitalLoop(still("SMC", POSE), period, delay=True, initial_commands=waiting).ode().step(substeps(period))


def linear_part(period: float) -> wb.chattering.LinearPart:
    """From the switched torque of joint 1 to its s, where joint 2 switches nothing."""
    step = late_step(period)
    p = step.parameters.default.copy()
    p[step.parameters.labels.index("controller.K[1]")] = 0.0
    return wb.chattering.linear_part_of(step, step.states.default, p)


def limit_cycle(period: float) -> LimitCycle:
    """The balance and the runs at a period in s."""
    W = linear_part(period)
    step = late_step(period)
    starts = np.vstack([step.states.pack({"plant.qd": np.array(push)}) for push in PUSHES])
    out = wb.simulate(step, None, starts, until=period * round(UNTIL / period), every=period)
    late = out.t >= LATE
    runs = tuple(wb.chattering.record_oscillation(out.t[late], s[late, 0]) for s in out["s"])
    return LimitCycle(wb.chattering.harmonic_balance(W, wb.chattering.BoundaryLayer(K, PHI)), runs)
