"""Chattering: what a switching law makes of a lag and a sampling period that its design left out."""

from workbench.design.chattering.balance import Balance, Oscillation, harmonic_balance
from workbench.design.chattering.cut import cut
from workbench.design.chattering.linear_part import LinearPart
from workbench.design.chattering.measured import Measured, measured
from workbench.design.chattering.relay_cycle import Cycle, relay_cycles
from workbench.design.chattering.switch import BoundaryLayer, Relay, SuperTwist

__all__ = [
    "Balance",
    "BoundaryLayer",
    "Cycle",
    "LinearPart",
    "Measured",
    "Oscillation",
    "Relay",
    "SuperTwist",
    "cut",
    "harmonic_balance",
    "measured",
    "relay_cycles",
]
