"""A step of a `SampledSystem` along given instants, some of which are sampling instants of its computer."""

from __future__ import annotations

from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from workbench.core.recorded_step import SignalRecord, recorded_step
from workbench.core.sampled_system import SampledSystem
from workbench.core.step import StepMap
from workbench.core.validation.refusals import Array, Integers
from workbench.core.validation.signatures import check_arguments


@dataclass(frozen=True, eq=False)
@check_arguments
class SampledRecord:
    """Numbers over time as a `SignalRecord` has them, some of whose N intervals end at a sampling instant.

    Parameters
    ----------
    signals
        The numbers between the instants of the record.
    jumps
        (N,), the number k of the sampling instant at the end of each interval, or -1 where there is none.
    readings
        (N, nd), the numbers that the computer reads there.

    Raises
    ------
    ValueError
        If the shapes do not fit each other.
    """

    signals: SignalRecord
    jumps: Integers
    readings: Array

    def __post_init__(self) -> None:
        shape = self.signals.begins.shape
        if self.jumps.shape != shape[:1] or self.readings.shape != shape:
            raise ValueError(
                f"`SampledRecord(jumps=..., readings=...)` must have shapes {shape[:1]} and {shape}, a row for each "
                f"interval; got {self.jumps.shape} and {self.readings.shape}."
            )

    @property
    def t(self) -> Array:
        """(N + 1,), the instants in s."""
        return self.signals.t

    @property
    def labels(self) -> tuple[str, ...]:
        """The labels of the nd numbers."""
        return self.signals.labels

    @property
    def rows(self) -> Array:
        """(N, 4 + 3 nd): those of the signals, 1 or 0 for a jump or none, its number k, and the readings."""
        numbers = np.maximum(self.jumps, 0)
        return np.column_stack([self.signals.rows, self.jumps >= 0, numbers, self.readings])


@check_arguments
def recorded_sampled_step(system: SampledSystem, recording: SampledRecord) -> StepMap:
    """A Runge-Kutta step of the flow from each instant of a recording to the next, and the jump there, if there is one.

        x+ = g(k, z, p, u_k) at a sampling instant, else x+ = z,   z the step of `recorded_step` from x

    The recorded numbers stand in the place of parameters of the flow, and u_k of those of the jump. Random numbers of
    the system are 0. An interval of no length has the jump alone, as at the begin of a run.

    Raises
    ------
    LookupError
        If a label is no parameter of the flow.
    """
    step, flow = recorded_step(system.flow, recording.signals), system.flow
    places = [place for label in recording.labels for place in flow.parameters.indices(label)]
    more = ca.SX.sym("jump", 2 + len(places))
    z, m = step.rule.next, system.jump.numel()
    symbols = ca.vertcat(system.k, flow.x, *(flow.p[place] for place in places), system.w)
    values = ca.vertcat(more[1], z, more[2:], ca.SX.zeros(system.w.numel(), 1))
    after = ca.substitute(system.jump, symbols, values)
    update = ca.if_else(more[0] > 0, ca.vertcat(after, z[m:]), z)
    rule = replace(step.rule, rate=ca.SX(0, 1), update=update, d=ca.vertcat(step.rule.d, more))
    return replace(step, rule=rule, recorded_numbers=recording.rows)
