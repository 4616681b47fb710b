"""The sockets of a control loop, and how blocks in them become one `Ode`, or one `Sampled`."""

from workbench.loop.arm import AbstractArmController, AbstractArmObserver
from workbench.loop.assemble import ClosedLoop, open_loop
from workbench.loop.contracts import (
    AbstractController,
    AbstractDisturbance,
    AbstractInstruments,
    AbstractObserver,
    AbstractPlant,
    AbstractReference,
    Follows,
    Inputs,
    Parts,
    Reads,
)
from workbench.loop.defaults import Readings, Rest
from workbench.loop.instruments import Instruments
from workbench.loop.linear import LinearLaw, LinearObserver, LinearPlant
from workbench.loop.roles import roles

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
    "LinearObserver",
    "LinearPlant",
    "Parts",
    "Readings",
    "Reads",
    "Rest",
    "open_loop",
    "roles",
]
