"""The closed loop: the contracts of its blocks, their ports, and how they become one `Ode` or one `Sampled`.

The room knows plants, observers, laws and references by their contracts alone, and of arms only their ports; it knows
no simulation and no design. Read `closed_loop.py` first, then `contracts.py`.
"""

from workbench.loop.arm_ports import AbstractArmController, AbstractArmObserver
from workbench.loop.closed_loop import ClosedLoop, open_loop
from workbench.loop.coloured_noise import AbstractNoise, GaussMarkov, RandomWalk, SecondOrderNoise
from workbench.loop.contracts import AbstractController, AbstractObserver, AbstractPlant, Follows, Inputs, Parts, Reads
from workbench.loop.dependence import roles
from workbench.loop.digital_loop import DigitalLoop
from workbench.loop.instruments import Instruments
from workbench.loop.linear_blocks import LinearLaw, LinearPlant
from workbench.loop.linear_filter import LinearFilter
from workbench.loop.surroundings import AbstractDisturbance, AbstractInstruments, AbstractReference, Readings, Rest

__all__ = [
    "AbstractArmController",
    "AbstractArmObserver",
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
    "Rest",
    "SecondOrderNoise",
    "open_loop",
    "roles",
]
