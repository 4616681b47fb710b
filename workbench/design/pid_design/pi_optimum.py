"""The PI law with the largest integral gain under limits of the peaks of S and T."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

from workbench.core.validation.refusals import as_number, finite, refusal
from workbench.core.validation.signatures import check_arguments
from workbench.design.frequency.margin_records import StabilityMargins
from workbench.design.matrices import DesignError, one_thread
from workbench.design.pid_design.integral_gain import GainOptimum, IntegralGain
from workbench.design.pid_design.pid_designs import PeakContact, PidDesign, certificate_of, law_of_error
from workbench.design.pid_design.pid_refusals import (
    refuse_endless_gain,
    refuse_infeasible,
    refuse_two_integrators,
    refuse_zero_at_rest,
)
from workbench.design.pid_design.process import Process

if TYPE_CHECKING:
    import control

LARGEST_KI = "largest ki"
BACK_OFF = 1e-9  # by how much ki, or then a limit, is lowered if rounding takes the loop beyond the limit


@check_arguments
def pi_optimum(
    plant: control.TransferFunction | control.StateSpace, Ms: float = 1.4, Mt: float = math.inf, delay: float = 0.0
) -> PidDesign:
    """The PI law k + ki/s with the largest |ki|, so with the least |IE|, for which max |S| <= Ms and max |T| <= Mt.

    The optimum is global: intervals of k are bounded from above and halved, and Newton's method takes the best of them
    to full accuracy. `certificate` has the margins, proved by `stability_margins`.

    Parameters
    ----------
    plant
        A `TransferFunction` or `StateSpace` in continuous time with one input and one output, proper; it may be
        unstable.
    Ms, Mt
        The limits of the peaks of S and T; Ms above 1 and Mt at least 1, or infinite for no limit. One of them must be
        finite.
    delay
        The delay of the plant in s.

    Raises
    ------
    ValueError
        If `plant` is not such a system, or a number is out of its range.
    DesignError
        If no PI law stabilises the plant or meets the limits, or if ki has no largest value.

    References
    ----------
    Astrom, Panagopoulos, Hagglund (1998), Design of PI controllers based on non-convex optimization, Automatica 34.

    Examples
    --------
    >>> import control
    >>> design = wb.pid_design.pi_optimum(control.tf([1], [1, 3, 3, 1]), Ms=1.4, Mt=1.4)
    >>> round(design.k, 4), round(design.ki, 4), design.certificate.Ms.gain.value <= 1.4
    (0.633, 0.3253, True)
    """
    return largest_pi_gain("pi_optimum", "plant", plant, Ms, Mt, delay)


def largest_pi_gain(name: str, port: str, plant: control.LTI, Ms: float, Mt: float, delay: float) -> PidDesign:
    """The PI law of `pi_optimum`, whose refusals name a function and its argument for the plant."""
    Ms, Mt = checked_limits(name, Ms, Mt)
    process, call = bounded_process(name, port, plant, delay, Ms, Mt), f"{name}({port}, ...)"
    with one_thread():
        sign, gains = best_sign(process, Ms, Mt)
        if gains is None:
            refuse_infeasible(call, process, Ms, Mt)
        upright = process if sign > 0 else process.mirror()
        return confirm_optimum(call, plant, IntegralGain(upright, Ms, Mt), sign, gains)


def checked_limits(call: str, Ms: float, Mt: float) -> tuple[float, float]:
    """Ms and Mt, each a number or infinity."""
    limits = []
    for name, value in (("Ms", Ms), ("Mt", Mt)):
        number = as_number(value)
        if number is None or math.isnan(number):
            raise refusal(f"{call}({name}=...)", "a number, or infinite for no limit", value)
        limits.append(number)
    if not limits[0] > 1:
        raise DesignError(
            f"`{call}(Ms=...)`: no loop meets Ms = {limits[0]:g}, as |S| has a peak above 1 by Bode's integral; the "
            "specification is infeasible. Ask for an Ms above 1, such as 1.4."
        )
    if not limits[1] >= 1:
        raise DesignError(
            f"`{call}(Mt=...)`: no loop with integral action meets Mt = {limits[1]:g}, as T is 1 at rest; the "
            "specification is infeasible. Ask for an Mt of at least 1."
        )
    if math.isinf(limits[0]) and math.isinf(limits[1]):
        raise ValueError(f"`{call}(Ms=..., Mt=...)` must limit one of them: without a limit nothing is robust.")
    return limits[0], limits[1]


def checked_process(call: str, plant: object, delay: float, port: str = "plant") -> Process:
    """The process of a plant and its delay, which a function takes as its argument `port`."""
    import control

    from workbench.design.frequency.axis_loop import exact_delay

    if not isinstance(plant, control.StateSpace | control.TransferFunction) or not plant.issiso():
        raise refusal(
            f"{call}({port}=...)", "a `StateSpace` or `TransferFunction` with one input and one output", plant
        )
    exact_delay(call, delay, None)
    return Process.of(call, plant, finite(f"{call}(delay=...)", delay, " of s", low=0))


def bounded_process(name: str, port: str, plant: object, delay: float, Ms: float, Mt: float) -> Process:
    """The process of a plant and its delay, for which ki has a largest value within the limits."""
    process, call = checked_process(name, plant, delay, port), f"{name}({port}, ...)"
    refuse_zero_at_rest(call, process)
    refuse_two_integrators(call, process, Mt)
    refuse_endless_gain(call, process, Ms, Mt)
    return process


def best_sign(process: Process, Ms: float, Mt: float) -> tuple[int, GainOptimum | None]:
    """The sign of ki with the larger optimum, and the optimum for a process with that sign taken into its gain."""
    sign = 1 if process.num[-1] * process.den[0] > 0 else -1
    signs = (sign,) if process.relative_degree or process.delay else (sign, -sign)
    found = [(s, IntegralGain(process if s > 0 else process.mirror(), Ms, Mt).solve()) for s in signs]
    return max(found, key=lambda pair: -1.0 if pair[1] is None else pair[1].ki)


def confirm_optimum(
    call: str,
    plant: control.LTI,
    problem: IntegralGain,
    sign: int,
    gains: GainOptimum,
    method: str = LARGEST_KI,
) -> PidDesign:
    """The design of an optimum, backed off where rounding has taken the loop beyond a limit."""
    Ms, Mt, action, delay = problem.Ms, problem.Mt, problem.derivative, problem.process.delay
    N = action.N if math.isfinite(action.N) else None
    for inner in _backed_off(problem, gains):
        k, ki, kd = (sign * gain for gain in (inner.k, inner.ki, action.kd))
        certificate = certificate_of(plant, delay, law_of_error(k, ki, kd, N, plant))
        if certificate.stable and excess_of(certificate, Ms, Mt) <= 0:
            contacts = tuple(PeakContact("ST"[c.kind], c.omega) for c in inner.contacts)
            return PidDesign(method, k, ki, kd, N, 1.0, 0.0, Ms, Mt, certificate, gains.bound, contacts, plant, delay)
    raise DesignError(
        f"`{call}`: the optimum k = {sign * gains.k:.6g}, ki = {sign * gains.ki:.6g} is not confirmed by the margins "
        "of its loop, so doubles do not decide it. Scale the plant, or ask for larger limits."
    )


def _backed_off(problem: IntegralGain, gains: GainOptimum) -> Iterator[GainOptimum]:
    """The optimum; the same with a ki that is a little lower; and optima for limits that are a little tighter."""
    yield gains
    yield replace(gains, ki=gains.ki * (1 - BACK_OFF))
    for share in (BACK_OFF, 1e-6):
        Ms, Mt = (1 + (limit - 1) * (1 - share) for limit in (problem.Ms, problem.Mt))
        inner = replace(problem, Ms=Ms, Mt=Mt).solve()
        if inner is not None:
            yield inner


def excess_of(certificate: StabilityMargins, Ms: float, Mt: float) -> float:
    """By how much the peaks of a stable loop are beyond their limits, relative to these."""
    return max(certificate.Ms.gain.value / Ms - 1, certificate.Mt.gain.value / Mt - 1)
