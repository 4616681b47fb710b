"""The loop gain of an outcome: answers over frequency, margins and poles, for pictures and a table of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from workbench.core.validation.refusals import Array
from workbench.design.frequency import StabilityMargins
from workbench.design.linear import DiskMargin
from workbench.design.linear_loop import LinearLoop
from workbench.report.live.linear_data import baseline_of, grid
from workbench.study.document.source import Source
from workbench.study.study_results import Outcome

Complex = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class LoopGain:
    """The loop gain of a loop at the inputs of its plant, about the point of which `about` tells.

    `gains` (m, n) are those of each channel with the loop closed at the others, at the `frequencies` (m,) in rad/s;
    `poles` (nx,) are those of the closed loop, and `cut_poles` those of the loop that is cut at all channels.
    `margins` has None for a channel of which none are known, and so has `disk_margin` of all channels at once.
    """

    channels: tuple[str, ...]
    about: str
    period: float | None
    frequencies: Array
    gains: Complex
    poles: Complex
    cut_poles: Complex
    margins: tuple[StabilityMargins | None, ...]
    disk_margin: DiskMargin | None

    @property
    def sensitivities(self) -> Complex:
        """The sensitivity (m, n) of each channel with the loop closed at the others."""
        return np.asarray(1 / (1 + self.gains))


def loop_gain(outcome: Outcome) -> LoopGain | str:
    """The loop gain of an outcome at its own numbers, or a sentence that says why there is none."""
    try:
        baseline = baseline_of(outcome)
        linear, about, omega = baseline.linear, baseline.sentence, grid(baseline.linear)
        gains = channel_gains(linear.response(omega, "L").values)
        poles, cut_poles = [pole.value for pole in linear.poles], linear.L.poles()
    except (ValueError, LookupError) as error:
        return str(error)
    if not (np.isfinite(gains) & (gains != 0)).any(axis=0).all():
        return "The loop gain is zero at every frequency, so that there is nothing to draw of it."
    roots = np.array(poles), np.asarray(cut_poles, dtype=complex)
    return LoopGain(linear.channels, about, linear.period, omega, gains, *roots, _margins(linear), _disk_margin(linear))


def channel_gains(L: Complex) -> Complex:
    """The gains (m, n) of each channel with the loop closed at the others, of loop gains (m, n, n) cut at all."""
    n = L.shape[1]
    gains = np.empty(L.shape[:2], dtype=complex)
    for i in range(n):
        rest = [k for k in range(n) if k != i]
        across = L[:, rest, i][..., np.newaxis]
        inner = np.eye(n - 1) + L[:, rest][:, :, rest]
        gains[:, i] = L[:, i, i] - (L[:, i, rest][:, np.newaxis] @ np.linalg.solve(inner, across))[:, 0, 0]
    return gains


def linear_source(outcome: Outcome, quantity: str, channel: int = 0, label: str = "", unit: str = "1") -> Source:
    """The source of a linear answer of an outcome at a channel."""
    about = (outcome.label, outcome.notes)
    case = outcome.case
    return Source(case.law, case.scenario, "linear", quantity, channel, label, unit, outcome.digest, None, 1.0, *about)


def _margins(linear: LinearLoop) -> tuple[StabilityMargins | None, ...]:
    try:
        found = linear.margins()
    except ValueError:  # as of blocks at several periods, which have no margins
        return (None,) * len(linear.channels)
    return tuple(found[name] for name in linear.channels)


def _disk_margin(linear: LinearLoop) -> DiskMargin | None:
    try:
        return linear.disk_margin
    except ValueError:  # as of a loop that is not stable
        return None
