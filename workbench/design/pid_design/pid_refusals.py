"""The reasons for which no PI law is the best one: named, with the least that is feasible."""

from __future__ import annotations

import math
from typing import NoReturn

from workbench.design.matrices import DesignError
from workbench.design.pid_design.derivative_action import DerivativeAction
from workbench.design.pid_design.integral_gain import LARGEST_PEAK, NO_ACTION, IntegralGain, least_peak
from workbench.design.pid_design.process import Process


def refuse_zero_at_rest(call: str, process: Process) -> None:
    """Refuse a process with a zero at the origin, which the integral would cancel."""
    if process.num[-1] == 0:
        raise DesignError(
            f"`{call}`: the plant has a zero at s = 0, so integral action would cancel it and no law with an integral "
            "stabilises. Take another output, or a law without integral, such as `lead_lag`."
        )


def refuse_two_integrators(call: str, process: Process, Mt: float) -> None:
    """Refuse a plant with an integrator where |T| shall have no peak."""
    if Mt == 1 and process.den[-1] == 0:
        raise DesignError(
            f"`{call}`: Mt = 1 is infeasible for a plant with an integrator, as |T| of a loop with two integrators has "
            "a peak above 1; the least Mt is only approached as ki goes to 0. Ask for an Mt above 1."
        )


def refuse_endless_gain(call: str, process: Process, Ms: float, Mt: float) -> None:
    """Refuse a process for which ki has no largest value: high gain without delay that keeps every margin."""
    zeros, _ = process.roots
    if process.delay or process.relative_degree > 1 or not (zeros.real < 0).all() or Mt == 1:
        return
    limits = ", ".join(f"{name} = {value:g}" for name, value in (("Ms", Ms), ("Mt", Mt)) if math.isfinite(value))
    raise DesignError(
        f"`{call}`: there is no largest ki: this plant without delay takes any gain, and ki is unbounded for {limits}. "
        "Add the delay or the fast poles that the hardware has, or take `lambda_tuning`."
    )


def refuse_infeasible(
    call: str, process: Process, Ms: float, Mt: float, derivative: DerivativeAction = NO_ACTION
) -> NoReturn:
    """Say which part of a specification no law meets, and the least that is feasible."""
    law = "PID with this derivative" if derivative.kd else "PI"
    sides = [process if s > 0 else process.mirror() for s in (1, -1)]
    sides = [p for p in sides if p.num[-1] * p.den[0] > 0 or not (p.relative_degree or p.delay)]
    if not any(IntegralGain(p, math.inf, math.inf, derivative).stabilisable() for p in sides):
        raise DesignError(
            f"`{call}`: no {law} law stabilises this plant, with either sign of its gains, so no specification is "
            "feasible. Take a law with derivative action, or `lqg`."
        )
    parts = []
    for name, limit, of_S in (("Ms", Ms, True), ("Mt", Mt, False)):
        if math.isfinite(limit) and (least := min(least_peak(p, of_S, derivative=derivative) for p in sides)) > limit:
            near = " and only approached" if least < (1 + 1e-3) * limit else ""
            figure = f"is {least:.4g}{near}" if math.isfinite(least) else f"is above {LARGEST_PEAK:g}"
            parts.append(f"{name} = {limit:g} is infeasible by itself, the least {name} of any {law} law {figure}")
    if not parts:
        least = min(least_peak(p, True, Mt, derivative) for p in sides)
        parts = [f"Ms = {Ms:g} and Mt = {Mt:g} are infeasible together, the least Ms with this Mt is {least:.4g}"]
    raise DesignError(f"`{call}`: {'; '.join(parts)}. Ask for at least that, or take `lqg`.")
