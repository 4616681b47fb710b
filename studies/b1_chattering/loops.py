"""The loop of the first joint, its predictions, and its runs from several starts."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

import workbench as wb
from studies.paper.card import CARD
from studies.paper.laws import ARM, RIVALS

LAGS, PERIODS = (0.0, 2e-3, 1e-2, 2e-2), (1e-3, 2e-3, 5e-3)  # s
PAIRS = tuple((lag, period) for lag in LAGS for period in PERIODS)
SWITCHES = {"relay": "sign", "layer": "clip"}
FOLDED_POSE = np.array([0.0, np.pi])  # here M is diagonal: each joint chatters by itself
PUSH = np.array([0.3, -0.2])  # rad/s, from which a run starts
STARTS = ((0.1, 0.1), (-0.6, 0.4), (1.0, -0.5))  # rad/s, others
UNTIL, LATE = 6.0, 4.0  # s: what is measured is after `LATE`
QUIET = 1e-6  # rad/s: s at rest, but for what still decays
REGULAR = 1e-6  # of the scatter of an oscillation
NEARLY = 1.001  # the run meets an exact cycle to a thousandth
REST = "rest"
K, PHI = float(CARD["SMC: K"][0]), float(CARD["phi"])


@dataclass(frozen=True)
class Prediction:
    """The predictions of one lag and one period: the balance of a relay, its exact cycles, and the balance of the
    layer.
    """

    relay: wb.chattering.Oscillation
    cycles: tuple[wb.chattering.Cycle, ...]
    layer: wb.chattering.Balance


@dataclass(frozen=True)
class Row:
    """One lag and one period: balance and simulation of a relay and of the layer, and the relay's exact cycle.

    There is no cycle where the simulated oscillation is not regular.
    """

    lag: float
    period: float
    relay: tuple[wb.chattering.Oscillation, wb.chattering.RecordedOscillation]
    cycle: wb.chattering.Cycle | None
    layer: tuple[wb.chattering.Balance, wb.chattering.RecordedOscillation]

    @staticmethod
    def of(
        pair: tuple[float, float],
        foreseen: Prediction,
        relay: wb.chattering.RecordedOscillation,
        layer: wb.chattering.RecordedOscillation,
    ) -> Row:
        """The predictions of a lag and a period beside both runs."""
        lag, period = pair
        samples = round(np.pi / (relay.frequency or np.inf) / period)
        regular = (relay.scatter or 0) < REGULAR
        cycle = next((c for c in foreseen.cycles if regular and c.samples == samples), None)
        return Row(lag, period, (foreseen.relay, relay), cycle, (foreseen.layer, layer))

    @property
    def layer_agrees(self) -> bool:
        """The layer comes to rest where it is wider than the least of the balance, and oscillates where it is not."""
        balance, run = self.layer
        return (balance.least_phi < PHI) is (run.amplitude <= QUIET)


def loop(lag: float, period: float, switch: str) -> wb.DigitalLoop:
    """The first joint's loop: SMC of the card, pushed off the folded rest point."""
    actuator = wb.arms.FirstOrderLag(lag) if lag else wb.arms.DirectDrive()
    plant = wb.Manipulator(ARM, q=FOLDED_POSE, qd=PUSH, actuator=actuator)
    law = replace(RIVALS["SMC"], saturation=SWITCHES[switch])
    return wb.DigitalLoop(wb.ClosedLoop(plant, wb.ArmFullState(2), law, wb.Constant("q", "rad", FOLDED_POSE)), period)


def substeps(lag: float, period: float) -> int:
    """The number of Runge-Kutta steps in a period."""
    return int(np.ceil(2 * period / lag)) if lag else 1


def linear_part(lag: float, period: float) -> wb.chattering.LinearPart:
    """From the switched torque of the first joint to its s, where the second joint switches nothing."""
    step = loop(lag, period, "layer").ode().step(substeps(lag, period))
    p = step.parameters.default.copy()
    p[step.parameters.labels.index("controller.K[1]")] = 0.0
    return wb.chattering.linear_part_of(step, step.states.pack({"plant.qd": np.zeros(2)}), p)


def predict(pair: tuple[float, float]) -> Prediction:
    """The predictions of a lag and a period, in s."""
    W = linear_part(*pair)
    balance = next(o for o in wb.chattering.harmonic_balance(W, wb.chattering.Relay(K)).oscillations if o.stable)
    return Prediction(
        balance,
        wb.chattering.relay_cycles(W, K),
        wb.chattering.harmonic_balance(W, wb.chattering.BoundaryLayer(K, PHI)),
    )


def case(lag: float, period: float, switch: str) -> wb.Case:
    """A run with a switch, whose s is kept at each instant of the computer."""
    run = wb.Run(loop(lag, period, switch), (), UNTIL, period, period / substeps(lag, period))
    return wb.Case(words(lag, period), switch, run)


def words(lag: float, period: float) -> str:
    """A lag and a period in words."""
    return f"lag of {1e3 * lag:g} ms, period of {1e3 * period:g} ms"


def record_oscillation(outcome: wb.study.Outcome) -> wb.chattering.RecordedOscillation:
    """The oscillation of s of the first joint in a run."""
    late = outcome.t >= LATE
    return wb.chattering.record_oscillation(outcome.t[late], outcome.signal("s", 0)[late])


def other_starts(
    pair: tuple[float, float],
) -> tuple[tuple[wb.chattering.RecordedOscillation, wb.chattering.RecordedOscillation], ...]:
    """The oscillations of s of the first joint under relay and layer, from each of the other starts."""
    by_switch = []
    for switch in SWITCHES:
        step = loop(*pair, switch).ode().step(substeps(*pair))
        starts = np.vstack([step.states.pack({"plant.qd": np.array(push)}) for push in STARTS])
        out = wb.simulate(step, None, starts, until=UNTIL, every=pair[1])
        late = out.t >= LATE
        by_switch.append([wb.chattering.record_oscillation(out.t[late], s[late, 0]) for s in out["s"]])
    return tuple(zip(*by_switch, strict=True))


def rows_of(results: wb.Results) -> list[list[Row]]:
    """A row for each lag and period: from the start of the cases, then from each of the others."""
    first, others = [], []
    for pair, foreseen in zip(PAIRS, results.work("predictions"), strict=True):
        runs = (record_oscillation(results[words(*pair), switch]) for switch in SWITCHES)
        first.append(Row.of(pair, foreseen, *runs))
    for i in range(len(STARTS)):
        every = zip(PAIRS, results.work("predictions"), results.work("starts"), strict=True)
        others.append([Row.of(pair, foreseen, *runs[i]) for pair, foreseen, runs in every])
    return [first, *others]
