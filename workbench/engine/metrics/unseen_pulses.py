"""Pulses of an output between two steps, which a metric that looks at the steps alone does not see."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from workbench.core import StepMap
from workbench.core.switches import NEAR, find_switches
from workbench.core.validation.refusals import Array
from workbench.engine.metrics.contract import AbstractMetric


def unseen_pulses(step: StepMap, metrics: Sequence[AbstractMetric], p: Array, until: float) -> tuple[str, ...]:
    """A sentence for each metric without a grid of its own that may miss a pulse of what it watches in runs p (B, np).

    In a computer, a metric looks once a period.
    """
    flow, sentences = step.flow, []
    for metric in metrics:
        if metric.grid is not None or not metric.memory(1).size:
            continue
        rows = [i for name in metric.watches for i in flow.outputs.indices(name)]
        switches = find_switches(flow.rate, flow.t, flow.x, flow.p, flow.output[rows, 0])
        if any(_meet_in_a_step(instants, step.h) for instants in switches.until(p, until)):
            sentences.append(
                f"'{metric.name}' looks at the ends of steps of {step.h:.3g} s alone, and a pulse of "
                f"'{metric.watches[0]}' may lie between two of them"
            )
    return tuple(sentences)


def _meet_in_a_step(instants: Array, h: float) -> bool:
    """True if two instants [s] lie within one step, its end not among them."""
    steps = np.floor(np.sort(instants) / h * (1 + NEAR) + NEAR)
    return bool((np.diff(steps) == 0).any())
