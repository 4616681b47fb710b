"""Ports of predictive laws: the estimate of a disturbance, the signals of a design, and the safe command."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import casadi as ca
import numpy as np

from workbench.blocks.loop.contracts import AbstractPlant
from workbench.core import Entry, Layout, Signals
from workbench.core.units import ANY
from workbench.core.validation.refusals import Array, finite, known_name

DISTURBANCE = "d"
LARGEST = 1e300
NO_SIGNALS = Layout()


def disturbance_port(count: int) -> Layout:
    """The estimate d of constant disturbances, as an observer gives it and a law reads it."""
    return Layout((Entry(DISTURBANCE, np.zeros(count), ANY),))


def column(signals: Signals, port: Layout) -> ca.SX:
    """The signals of a port as one column, (n, 1)."""
    return port.flatten({name: ca.SX(signals[name]) for name in port.names})


def all_finite(numbers: ca.SX) -> ca.SX:
    """1 if all numbers (n, 1) are finite, else 0."""
    known = ca.fabs(numbers) <= LARGEST  # false for NaN, too
    count = ca.sum1(ca.if_else(known, 1.0, 0.0))
    return count == numbers.numel()


def refuse_other_signals(
    call: str, plant: AbstractPlant, names: tuple[tuple[str, ...], tuple[str, ...]], beside: Layout = NO_SIGNALS
) -> None:
    """Refuse a design for other states or inputs than the plant's, but for states `beside` them."""
    states = Layout(tuple(entry for entry in plant.states.entries if entry.name not in beside))
    for port, own in zip((states, plant.inputs), names, strict=True):
        if port.labels != own:
            raise ValueError(
                f"`{call}` must get a design for the plant's own signals, {', '.join(port.labels)}; it is for "
                f"{', '.join(own)}."
            )


def safe_inputs(call: str, port: Layout, safe: Mapping[str, float] | None, low: Array, high: Array) -> Array | None:
    """The safe command (nu,) of inputs by name; one that is missing or passes a limit (nu,) is refused."""
    if safe is None:
        return None
    for name in safe:
        known_name(name, port.labels, "inputs of the plant")
    if missing := [name for name in port.labels if name not in safe]:
        raise ValueError(f"`{call}(safe_command=...)` must name each input; '{missing[0]}' is missing.")
    values = [finite(f"{call}(safe_command={{{name!r}: ...}})", safe[name]) for name in port.labels]
    for name, value, least, most in zip(port.labels, values, low, high, strict=True):
        if not least <= value <= most:
            raise ValueError(
                f"`{call}(safe_command=...)` must keep the limits of '{name}', {least:g} and {most:g}; got {value:g}."
            )
    return np.array(values)


class About(NamedTuple):
    """The state e and the rest (at, push) that is wanted, as deviations, and 1 if all numbers read are finite."""

    e: ca.SX
    at: ca.SX
    push: ca.SX
    valid: ca.SX | None
