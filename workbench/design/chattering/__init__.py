"""Chattering: oscillations of a switching law, caused by a lag or a sampling period that the design neglects.

This package takes a loop that is cut at its switch, as a linear part W; it knows no law. Read `linear_part.py` first,
then `harmonic_balance.py`, which is approximate, and `relay_cycles.py`, which is exact.

Examples
--------
>>> wb.chattering.Relay(1.0)
Relay(K=1)
"""

from workbench.design.chattering.harmonic_balance import Balance, BoundaryLayer, Oscillation, Relay, harmonic_balance
from workbench.design.chattering.linear_part import LinearPart, linear_part_of
from workbench.design.chattering.relay_cycles import Cycle, RecordedOscillation, record_oscillation, relay_cycles

__all__ = [
    "Balance",
    "BoundaryLayer",
    "Cycle",
    "LinearPart",
    "Oscillation",
    "RecordedOscillation",
    "Relay",
    "linear_part_of",
    "harmonic_balance",
    "record_oscillation",
    "relay_cycles",
]
