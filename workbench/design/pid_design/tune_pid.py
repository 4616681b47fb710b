"""The front door of PID design: one call from a plant and limits to gains, filter and weights."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

from workbench.core.validation.refusals import finite, one_of
from workbench.core.validation.signatures import check_arguments
from workbench.design.matrices import DesignError
from workbench.design.pid_design.pi_optimum import largest_pi_gain
from workbench.design.pid_design.pid_designs import PidDesign
from workbench.design.pid_design.pid_optimum import least_pid_error

if TYPE_CHECKING:
    import control

FILTER = 10.0  # N over the frequency at which the PI law meets its limit
ROUNDING = 1e-9
DOOR = "tune_pid", "system"  # the function and its argument that a refusal names


@check_arguments
def tune_pid(
    system: control.TransferFunction | control.StateSpace,
    *,
    delay: float = 0.0,
    Ms: float = 1.6,
    Mt: float | None = None,
    form: str = "PI",
    N: float | None = None,
    noise_gain: float | None = None,
    criterion: str | None = None,
    reference_peak: float = 1.05,
) -> PidDesign:
    """The PI or PID law with max |S| <= Ms and max |T| <= Mt that has the least error after a step of load.

    `wb.PID.of(design)` is the law, and `design.certificate` has the margins of the loop.

    Parameters
    ----------
    system
        The plant as for `pi_optimum`, such as `linearize` gives.
    delay
        Its delay in s.
    Ms, Mt
        The limits of the peaks, infinite for none. Mt is by default the same as Ms.
    form
        "PI" or "PID".
    N, noise_gain
        As for `pid_optimum`; by default N is 10 times the frequency at which the PI law meets its limit.
    criterion
        "IE" for the least integral of the error, so the largest |ki|, or "IAE" for that of the absolute error. A PI law
        takes "IE" alone. A PID law takes "IAE" by default, as the one for "IE" often oscillates.
    reference_peak
        The limit of the peak of |y/r|, at least 1. c is 0; b is the largest up to 1 that keeps it, or 0 with a remark.

    Raises
    ------
    ValueError
        If `system` is not such a system, or an argument is out of its range.
    DesignError
        As for `pi_optimum` and `pid_optimum`.

    Examples
    --------
    >>> motor = wb.DCMotor()
    >>> design = wb.tune_pid(wb.linearize(wb.open_loop(motor), 0.0, [0.0, 0.0]), delay=0.02, Ms=1.6)
    >>> loop = wb.ClosedLoop(motor, controller=wb.PID.of(design), reference=wb.Step("omega", "rad/s", 1.0))
    >>> loop.controller.memory.names, design.certificate.Ms.gain.value <= 1.6
    (('integral',), True)
    """
    _refuse_odd_form(form, criterion, N, noise_gain)
    peak = finite("tune_pid(reference_peak=...)", reference_peak, low=1)
    T_limit = Ms if Mt is None else Mt
    if form == "PID" and N is None and noise_gain is None:
        N = _usual_filter(system, Ms, T_limit, delay)
    if form == "PI":
        return _weighted(largest_pi_gain(*DOOR, system, Ms, T_limit, delay), peak)
    design = least_pid_error(*DOOR, system, (Ms, T_limit), delay, (N, noise_gain), criterion or "IAE")
    return _weighted(design, peak)


def _weighted(design: PidDesign, peak: float) -> PidDesign:
    """The design with the weight for a peak, and a remark if no weight keeps it."""
    weighted = design.with_weights(design.reference_response.weight_for(peak), 0.0)
    reached = weighted.reference_peak if weighted.b == 0 else 0.0
    if reached <= peak * (1 + ROUNDING):
        return weighted
    remark = (
        f"The peak from the reference to the output is {reached:.4g} even with b = 0, above the {peak:g} asked for. "
        "Smooth the reference, as by `prefilter`, or ask for a smaller Mt."
    )
    return replace(weighted, remarks=(remark,))


def _refuse_odd_form(form: str, criterion: str | None, N: float | None, noise_gain: float | None) -> None:
    one_of("tune_pid(form=...)", form, ("PI", "PID"))
    if form == "PI" and (N is not None or noise_gain is not None):
        raise ValueError("`tune_pid(N=..., noise_gain=...)` are those of a derivative; take `form='PID'` for one.")
    if criterion is not None:
        one_of("tune_pid(criterion=...)", criterion, ("IE", "IAE"))
    if form == "PI" and criterion == "IAE":
        raise ValueError("`tune_pid(criterion='IAE')` is for a PID law; take `form='PID'`, or 'IE' for a PI law.")


def _usual_filter(system: control.LTI, Ms: float, Mt: float, delay: float) -> float:
    """The bandwidth of a filter that costs little phase at the frequency where a PI law meets the limits."""
    try:
        contacts = largest_pi_gain(*DOOR, system, Ms, Mt, delay).contacts
    except DesignError:
        contacts = ()
    if not contacts or not math.isfinite(contacts[0].frequency):
        raise DesignError(
            "`tune_pid(N=...)` is chosen from the PI law of the same limits, and no PI law meets them. Give N, some 10 "
            "times the crossover frequency."
        )
    return FILTER * contacts[0].frequency
