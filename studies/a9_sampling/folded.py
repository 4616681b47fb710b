"""What theory foresees of a relay run by a computer, on the folded arm, whose joints are uncoupled."""

from dataclasses import dataclass, replace

import numpy as np

from studies.paper.card import CARD
from studies.paper.laws import ARM, RIVALS
from workbench.core import Step
from workbench.design.chattering import (
    Cycle,
    Oscillation,
    RecordedOscillation,
    Relay,
    cut,
    harmonic_balance,
    record_oscillation,
    relay_cycles,
)
from workbench.loop import ClosedLoop
from workbench.observers import FullState
from workbench.plants import Manipulator
from workbench.signals import Hold
from workbench.simulate import simulate
from workbench.validation.refusals import Array

PERIODS = (1e-3, 2e-3, 5e-3, 1e-2)  # s
FOLDED = np.array([0.0, np.pi])  # M is diagonal here
PUSH = np.array([0.3, -0.2])  # rad/s, from which a run starts
UNTIL, LATE = 6.0, 4.0  # s
K = float(CARD["SMC: K"][0])


@dataclass(frozen=True)
class Row:
    """The relay of joint 1 at one period, late or not: by harmonic balance, by its exact cycle, and in a run.

    `variation` is the total variation of the first torque per second in the run.
    """

    period: float
    delay: bool
    balance: Oscillation | None
    cycle: Cycle | None
    run: RecordedOscillation
    variation: float

    @property
    def foreseen(self) -> float | None:
        """The total variation of the exact cycle, N m/s: twice 2 K each time round."""
        return None if self.cycle is None else 4 * K * self.cycle.frequency / (2 * np.pi)


def folded(period: float, delay: bool, switching: str) -> Step:
    """SMC of the card that holds the folded arm."""
    law = replace(RIVALS["SMC"], saturation=switching)
    loop = ClosedLoop(Manipulator(ARM, q=FOLDED), FullState(2), law, Hold(FOLDED))
    return loop.digital(period, delay=delay).step(2)


def row(period: float, delay: bool) -> Row:
    """Both predictions beside a run."""
    step = folded(period, delay, "clip")
    p = step.parameters.default
    p[step.parameters.labels.index("controller.K[1]")] = 0.0
    W = cut(step, step.states.default, p)
    balance = next((o for o in harmonic_balance(W, Relay(K)).oscillations if o.stable), None)
    relay = folded(period, delay, "sign")
    run = simulate(relay, x0=relay.states.pack({"plant.qd": PUSH}), until=UNTIL, every=period)
    late = run.t >= LATE
    seen = record_oscillation(run.t[late], run["s"][0, late, 0])
    samples = round(np.pi / (seen.frequency or np.inf) / period)
    cycle = next((c for c in relay_cycles(W, K) if c.samples == samples), None)
    return Row(period, delay, balance, cycle, seen, _variation(run["tau"][0, late, 0], period))


def _variation(tau: Array, period: float) -> float:
    return float(np.abs(np.diff(tau)).sum() / (period * (len(tau) - 1)))
