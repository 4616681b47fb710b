"""The figures of one linear loop, each with the bounds that are proved or the reason why there is none."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from workbench.design.control_system import System
from workbench.design.frequency import CertifiedPeak, CertifiedValue, StableMargins, bandwidth, hinf_norm
from workbench.design.frequency.certified_values import enclosure, least
from workbench.design.linear.feedback_loops import largest_gain
from workbench.design.matrices import DesignError
from workbench.design.step_response import step_info
from workbench.study.specifications.loop_systems import LoopSystems

ROUNDING = 1e-12  # relative, of a singular value in doubles


@dataclass(frozen=True)
class LoopFigure:
    """A figure between its bounds, None for the reason `why`; what it is `of`, and if its bounds are proved."""

    value: CertifiedValue | None
    of: str = ""
    why: str = ""
    is_proved: bool = True


def point_figure(name: str, systems: LoopSystems) -> LoopFigure:
    """One figure of a stable loop; what refuses it is told as its reason."""
    try:
        return FIGURES[name](systems)
    except ValueError as refused:
        return LoopFigure(None, why=str(refused))


def _margins(systems: LoopSystems) -> list[StableMargins]:
    found = [one.margins for one in systems.margins]
    if any(one is None for one in found):
        raise ValueError("the closed loop is not stable")
    return [one for one in found if one is not None]


def _place(frequency: float) -> str:
    """A frequency in rad/s in words."""
    return f"at {frequency:.4g} rad/s" if math.isfinite(frequency) else "at infinite frequency"


def _proved(systems: LoopSystems) -> bool:
    """True if margins come from exact arithmetic, and not from eigenvalues of a large loop."""
    return not any("estimate" in remark for one in systems.margins for remark in one.remarks)


def _peak(systems: LoopSystems, kind: str) -> LoopFigure:
    """The peak of S or T: of several channels the largest singular value."""
    if systems.channels == 1:
        (own,) = _margins(systems)
        peak: CertifiedPeak = own.Ms if kind == "S" else own.Mt
        return LoopFigure(peak.gain, _place(peak.frequency), is_proved=_proved(systems))
    return largest_gain_figure(systems.system(kind), "of all channels ")


def largest_gain_figure(system: System, of: str) -> LoopFigure:
    """The H-infinity norm; by eigenvalues in doubles where exact arithmetic does not enclose it."""
    try:
        peak = hinf_norm(system)
    except DesignError:
        if system.dt:
            raise
        found = largest_gain(system)
        bounds = CertifiedValue(found.below, found.below * (1 - ROUNDING), found.above)
        return LoopFigure(bounds, f"{of}{_place(found.frequency)}", is_proved=False)
    return LoopFigure(peak.gain, f"{of}{_place(peak.frequency)}")


def _gain_margin(systems: LoopSystems) -> LoopFigure:
    """The least factor by which a gain may grow or shrink."""
    factors = []
    for own in _margins(systems):
        factors.append(own.gain_high)
        if own.gain_low.low > 0:
            factors.append(enclosure(1 / own.gain_low.high, 1 / own.gain_low.low))
    return LoopFigure(least(factors), is_proved=_proved(systems))


def _least_margin(name: str) -> Callable[[LoopSystems], LoopFigure]:
    def figure(systems: LoopSystems) -> LoopFigure:
        return LoopFigure(least(getattr(own, name) for own in _margins(systems)), is_proved=_proved(systems))

    return figure


def _disk_margin(systems: LoopSystems) -> LoopFigure:
    if systems.channels == 1:
        (own,) = _margins(systems)
        return LoopFigure(own.disk_margin, _place(own.disk_frequency), is_proved=_proved(systems))
    found = systems.disk_margin
    middle = (found.alpha + found.alpha_above) / 2
    return LoopFigure(
        CertifiedValue(middle, found.alpha, found.alpha_above), "of all channels at once", is_proved=False
    )


def _noise_gain(systems: LoopSystems) -> LoopFigure:
    return largest_gain_figure(systems.noise, "")


def _bandwidth(systems: LoopSystems) -> LoopFigure:
    return LoopFigure(bandwidth(systems.scalar_answer).frequency, systems.answer_words)


def _step(name: str) -> Callable[[LoopSystems], LoopFigure]:
    def figure(systems: LoopSystems) -> LoopFigure:
        info = step_info(systems.scalar_answer)
        value: CertifiedValue = getattr(info, name)
        if math.isnan(value.value):
            raise ValueError(info.remarks[0])
        return LoopFigure(value, systems.answer_words)

    return figure


FIGURES: dict[str, Callable[[LoopSystems], LoopFigure]] = {
    "Ms": lambda systems: _peak(systems, "S"),
    "Mt": lambda systems: _peak(systems, "T"),
    "bandwidth": _bandwidth,
    "damping": lambda systems: LoopFigure(systems.poles.damping),
    "decay": lambda systems: LoopFigure(systems.poles.decay),
    "gain_margin": _gain_margin,
    "phase_margin": _least_margin("phase_margin"),
    "delay_margin": _least_margin("delay_margin"),
    "disk_margin": _disk_margin,
    "noise_gain": _noise_gain,
    "overshoot": _step("overshoot"),
    "settling_time": _step("settling_time"),
    "rise_time": _step("rise_time"),
}
