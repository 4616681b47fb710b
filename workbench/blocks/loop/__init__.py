"""The closed loop: the contracts of its blocks, their ports, and how they become one `Ode` or one `SampledSystem`.

This package knows plants, observers, laws and references by their contracts alone; it knows no simulation and no
design. Read `closed_loop.py` first, then `contracts.py`.

Examples
--------
>>> wb.loop.ClosedLoop is wb.ClosedLoop
True
"""

from workbench.blocks.loop.block_roles import roles
from workbench.blocks.loop.closed_loop import ClosedLoop, open_loop
from workbench.blocks.loop.coloured_noise import AbstractNoise, GaussMarkov, RandomWalk, SecondOrderNoise
from workbench.blocks.loop.contracts import (
    AbstractController,
    AbstractObserver,
    AbstractPlant,
    Follows,
    Inputs,
    Parts,
    Reads,
)
from workbench.blocks.loop.digital_loop import DigitalLoop
from workbench.blocks.loop.environment import (
    AbstractDisturbance,
    AbstractInstruments,
    AbstractReference,
    NoReference,
    Readings,
)
from workbench.blocks.loop.instruments import Instruments
from workbench.blocks.loop.linear_blocks import LinearLaw, LinearPlant
from workbench.blocks.loop.linear_filter import LinearFilter

__all__ = [
    "AbstractController",
    "AbstractDisturbance",
    "AbstractInstruments",
    "AbstractNoise",
    "AbstractObserver",
    "AbstractPlant",
    "AbstractReference",
    "ClosedLoop",
    "DigitalLoop",
    "Follows",
    "GaussMarkov",
    "Inputs",
    "Instruments",
    "LinearLaw",
    "LinearFilter",
    "LinearPlant",
    "Parts",
    "RandomWalk",
    "Readings",
    "Reads",
    "NoReference",
    "SecondOrderNoise",
    "open_loop",
    "roles",
]
