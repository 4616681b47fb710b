"""The sockets of a control loop, and how blocks in them become one `Ode`, or one `Sampled`."""

from workbench.loop.arm import AbstractArmController, AbstractArmObserver
from workbench.loop.assemble import ClosedLoop, open_loop
from workbench.loop.contracts import AbstractController, AbstractObserver, AbstractPlant, Follows, Inputs, Parts, Reads
from workbench.loop.defaults import Readings, Rest
from workbench.loop.instruments import Instruments
from workbench.loop.linear import LinearLaw, LinearPlant
from workbench.loop.linear_filter import LinearFilter
from workbench.loop.roles import roles
from workbench.loop.surroundings import AbstractDisturbance, AbstractInstruments, AbstractReference

__all__ = [
    "AbstractArmController",
    "AbstractArmObserver",
    "AbstractController",
    "AbstractDisturbance",
    "AbstractInstruments",
    "AbstractObserver",
    "AbstractPlant",
    "AbstractReference",
    "ClosedLoop",
    "Follows",
    "Inputs",
    "Instruments",
    "LinearLaw",
    "LinearFilter",
    "LinearPlant",
    "Parts",
    "Readings",
    "Reads",
    "Rest",
    "open_loop",
    "roles",
]
