"""Chattering of the paper's arm under SMC: is what harmonic balance foresees what a simulation shows?

Question  How far and how fast does the switching of SMC make the arm oscillate, where its drives lag and a computer
          closes the loop? And how wide must the boundary layer be to end that?
Method    The loop of joint 1 is cut at a rest point where M is diagonal; harmonic balance and the exact cycles of a
          relay run by a computer are compared with runs of the whole arm, over the lag and the period.
Runs in   about ten seconds on two cores.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from paper_card import CARD
from paper_laws import ARM, RIVALS

from workbench.core import Step
from workbench.design.chattering import (
    Balance,
    BoundaryLayer,
    Cycle,
    LinearPart,
    Measured,
    Oscillation,
    Relay,
    cut,
    harmonic_balance,
    measured,
    relay_cycles,
)
from workbench.loop import ClosedLoop
from workbench.observers import FullState
from workbench.plants import Manipulator
from workbench.plants.actuator import DirectDrive, FirstOrderLag
from workbench.signals import Hold
from workbench.simulate import simulate
from workbench.study.document import Cell, Column, Paragraph, Section, Table
from workbench.study.study import Results, Study

LAGS, PERIODS = (0.0, 2e-3, 1e-2, 2e-2), (1e-3, 2e-3, 5e-3)  # s
FOLDED = np.array([0.0, np.pi])  # here M is diagonal: each joint chatters by itself
PUSH = np.array([0.3, -0.2])  # rad/s, from which a run starts
UNTIL, LATE = 6.0, 4.0  # s: what is measured is after `LATE`
QUIET = 1e-6  # rad/s: s at rest, but for what still decays
K, PHI = float(CARD["SMC: K"][0]), float(CARD["phi"])


@dataclass(frozen=True)
class Row:
    """One lag and one period: of a relay and of the layer, what is foreseen and what is seen."""

    lag: float
    period: float
    relay: tuple[Oscillation, Measured]
    cycle: Cycle | None
    layer: tuple[Balance, Measured]


def sampled(lag: float, period: float, saturation: str) -> Step:
    """The first joint's loop: SMC of the card at the folded rest point."""
    actuator = FirstOrderLag(lag) if lag else DirectDrive()
    plant = Manipulator(ARM, q=FOLDED, actuator=actuator)
    loop = ClosedLoop(plant, FullState(2), replace(RIVALS["SMC"], saturation=saturation), Hold(FOLDED))
    return loop.sampled(period, substeps=int(np.ceil(2 * period / lag)) if lag else 1)


def linear_part(lag: float, period: float) -> LinearPart:
    """From the switched torque of the first joint to its s, where the second joint switches nothing."""
    step = sampled(lag, period, "clip")
    p = step.parameters.default
    p[step.parameters.labels.index("controller.K[1]")] = 0.0
    return cut(step, step.states.default, p)


def seen(lag: float, period: float, saturation: str) -> Measured:
    """The oscillation of s of the first joint in a run."""
    step = sampled(lag, period, saturation)
    run = simulate(step, x0=step.states.pack({"plant.qd": PUSH}), until=UNTIL, every=period)
    late = run.t >= LATE
    return measured(run.t[late], run["s"][0, late, 0])


def row(lag: float, period: float) -> Row:
    """Both predictions beside both runs."""
    W, run = linear_part(lag, period), seen(lag, period, "sign")
    balance = next(o for o in harmonic_balance(W, Relay(K)).oscillations if o.stable)
    samples = round(np.pi / (run.frequency or np.inf) / period)
    cycle = next((c for c in relay_cycles(W, K) if c.samples == samples), None)
    layer = harmonic_balance(W, BoundaryLayer(K, PHI)), seen(lag, period, "clip")
    return Row(lag, period, (balance, run), cycle, layer)


def sections(results: Results) -> Sequence[Section]:
    """What the report says."""
    del results
    return (section([row(lag, period) for lag in LAGS for period in PERIODS]),)


def section(rows: Sequence[Row]) -> Section:
    """The table, and where the balance is wrong."""
    columns = (
        Column("lag", "ms", "right"),
        Column("period", "ms", "right"),
        Column("relay: balance", "Hz, rad/s", "right"),
        Column("exact", "rad/s", "right"),
        Column("simulated", "Hz, rad/s", "right"),
        Column("least layer", "rad/s", "right"),
        Column("layer: balance", "Hz, rad/s", "right"),
        Column("simulated", "Hz, rad/s", "right"),
    )
    return Section(
        "Foreseen and simulated",
        (
            Paragraph(
                f"SMC with K = {K:g} N m holds the folded arm, where M is diagonal. Behind a lag its relay oscillates "
                "at a whole number of periods; which one depends on the start, and the balance, which knows the phase "
                f"of W alone, says about which. With the layer of {PHI:g} rad/s the runs oscillate where the layer is "
                "thinner than the least, and come to rest where it is wider. Where M couples the joints and both "
                "switch, the loop of one joint is not the loop any more: for the stretched arm the amplitude of joint "
                "1 is more than twice what is foreseen here."
            ),
            Table(
                "chattering",
                "Frequency and amplitude of s of joint 1: by harmonic balance, by the exact cycle of as many periods "
                "as simulated (least to highest amplitude), and simulated.",
                columns,
                tuple(map(cells, rows)),
                ("No exact amplitude: the simulated oscillation is not symmetric, or of several lengths in turn.",),
            ),
        ),
    )


def cells(found: Row) -> tuple[Cell, ...]:
    """One line of the table."""
    balance, run = found.relay
    layer, quiet = found.layer
    regular = found.cycle is not None and (run.scatter or 0) < 1e-6
    foreseen = next((o for o in layer.oscillations if o.stable), None)
    return (
        f"{1e3 * found.lag:g}",
        f"{1e3 * found.period:g}",
        _pair(balance.frequency, balance.amplitude),
        f"{found.cycle.amplitude:.4f} to {found.cycle.highest:.4f}" if found.cycle and regular else None,
        _pair(run.frequency, run.amplitude),
        f"{layer.least_phi:.4f}",
        _pair(foreseen.frequency, foreseen.amplitude) if foreseen else "rest",
        _pair(quiet.frequency, quiet.amplitude) if quiet.amplitude > QUIET else "rest",
    )


def _pair(frequency: float | None, amplitude: float) -> str:
    return f"{(frequency or 0.0) / (2 * np.pi):.1f}, {amplitude:.4f}"


study = Study(
    name="b1_chattering",
    title="Chattering, foreseen and simulated",
    question=__doc__.split("Question  ")[1].split("Method")[0],
    method=__doc__.split("Method    ")[1].split("Runs in")[0],
    sections=sections,
)
