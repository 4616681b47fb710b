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
    """A part of a plan that is given in its own terms; those of `wb.plan` hold in every phase.

    Parameters
    ----------
    until
        The duration of the phase in s, or its least and greatest.
    limits, rate_limits, values
        As for `wb.plan`, in this phase alone; they replace those of the call by name.
    end
        States and inputs at the end of the phase, by name.
    cost
        The cost of the phase; by default that of the call.
    jump
        A function of the states at the end that returns those that jump, by name, with their values at the begin of the
        next phase. All others are continuous.
    name
        The name in messages; by default the phase's number.

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
