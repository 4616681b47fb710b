"""States that pass the bounds that their block declares, as a sentence beside a run."""

from __future__ import annotations

import numpy as np

from workbench.core import StepMap
from workbench.core.validation.refusals import Array


def excursions(step: StepMap, t: Array, x: Array) -> tuple[str, ...]:
    """A sentence for each state whose values x (B, N, nx) pass a bound of its declaration, at the kept times t (N,)."""
    sentences = []
    for entry in step.states.entries:
        low, high = entry.bounds.low, entry.bounds.high
        if not (np.isfinite(low) or np.isfinite(high)):
            continue
        values = x[..., step.states.slice(entry.name)]
        beyond = np.asarray(((values < low) | (values > high)).any(axis=-1))
        if not beyond.any():
            continue
        runs = np.flatnonzero(np.any(beyond, axis=1))
        first = int(runs[np.argmin(np.argmax(beyond[runs], axis=1))])
        place = int(np.argmax(beyond[first]))
        part = values[first, place]
        value = float(part[np.argmax(np.maximum(part - high, low - part))])
        whose = "" if len(x) == 1 else f" in {len(runs)} of {len(x)} runs, first in run {first},"
        sentences.append(
            f"'{entry.name}' of '{step.flow.name}' passes its bound of {high if value > high else low:.3g}{whose} at "
            f"{t[place]:.4g} s with {value:.3g}"
        )
    return tuple(sentences)
