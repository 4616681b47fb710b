"""The equations of whatever a call on a log is given: a plant's or a loop's, and those of a loop with a computer."""

from __future__ import annotations

from workbench.core import Ode, SampledSystem
from workbench.core.equations import LOOP, Loop, equations_of, is_loop
from workbench.core.validation.refusals import refusal

PLANT = "a plant becomes one by `wb.open_loop(plant)`"


def system_of(system: Ode | SampledSystem | Loop, call: str) -> Ode | SampledSystem:
    """The equations of a system; what has none is refused in the name of a call."""
    if not is_loop(system):
        is_plant = hasattr(system, "inputs") and hasattr(system, "rate")
        raise refusal(f"{call}(system=...)", LOOP, system, f": {PLANT}" if is_plant else "")
    return equations_of(system, "loop")


def continuous_system(system: Ode | SampledSystem | Loop, call: str) -> Ode:
    """The equations of a system in continuous time; a loop that a computer closes is refused in the name of a call."""
    equations = system_of(system, call)
    if isinstance(equations, SampledSystem):
        raise ValueError(
            f"`{call}(system=...)` must be in continuous time; a computer closes this loop: take the plant alone, "
            "`wb.open_loop(plant)`, whose inputs are the commands."
        )
    return equations


def flow_of(system: Ode | SampledSystem) -> Ode:
    """The equation of a system in continuous time, or its flow between the instants of a computer."""
    return system.flow if isinstance(system, SampledSystem) else system
