"""Phase: one part of a plan with its own duration, limits, cost and values at its end."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import casadi as ca

from workbench.core import Signals
from workbench.core.validation.signatures import check_arguments

Cost = str | Callable[..., object] | ca.SX
NamedNumbers = Mapping[str, object]


@dataclass(frozen=True, eq=False)
@check_arguments
class Phase:
    """A part of a plan in its own terms; those that `wb.plan` is given hold in every phase.

    Parameters
    ----------
    until
        The duration in s, or its least and greatest one; None for no greatest one.
    limits
        By the name of a state, input, output or signal, the least and the greatest value: numbers, arrays of one number
        for each component, or None for no limit.
    rate_limits
        The same for the rates of inputs per second. The inputs are then straight lines between nodes, without jumps.
    end
        The values of states, inputs, outputs and signals at the end, by name; what is not named is free.
    values
        Parameters of the system at other values. An input with a value in the call keeps it and is not planned.
    cost
        What is integrated: "time", "energy" (the sum of the squares of the inputs), a function (t, x, u) that returns
        an expression, or an expression in the symbols of the `Ode`. x and u are `Signals`, as in a plant's `rate`. By
        default it is the cost of the call.
    jump
        A function of the states at the end that returns those that jump, by name, with their values at the begin of the
        next phase. All others are continuous.
    name
        The name in messages; by default the number of the phase.

    Examples
    --------
    >>> wb.planning.Phase(until=(0.1, 2.0), limits={"F": (-1.0, 1.0)}).until
    (0.1, 2.0)
    """

    until: object
    limits: NamedNumbers = field(default_factory=dict)
    rate_limits: NamedNumbers = field(default_factory=dict)
    end: NamedNumbers = field(default_factory=dict)
    values: Mapping[str, float] = field(default_factory=dict)
    cost: Cost | None = None
    jump: Callable[[Signals], Mapping[str, ca.SX]] | None = None
    name: str = ""
