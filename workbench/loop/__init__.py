"""The sockets of a control loop, and how blocks in them become one `Ode`, or one `Sampled`."""

from workbench.loop.assemble import ClosedLoop, open_loop
from workbench.loop.contracts import (
    AbstractController,
    AbstractDisturbance,
    AbstractObserver,
    AbstractPlant,
    AbstractReference,
)
from workbench.loop.instruments import Instruments
from workbench.loop.ports import Estimate, Measurement, Motion, Parts
from workbench.loop.roles import roles

__all__ = [
    "AbstractController",
    "AbstractDisturbance",
    "AbstractObserver",
    "AbstractPlant",
    "AbstractReference",
    "ClosedLoop",
    "Estimate",
    "Instruments",
    "Measurement",
    "Motion",
    "Parts",
    "open_loop",
    "roles",
]
