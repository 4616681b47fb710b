"""The front door of PID design: one call from a plant and limits to gains, filter and weights."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from workbench.core.validation.refusals import finite, one_of
from workbench.core.validation.signatures import check_arguments
from workbench.design.matrices import DesignError
from workbench.design.pid_design.pi_optimum import pi_optimum
from workbench.design.pid_design.pid_designs import PidDesign
from workbench.design.pid_design.pid_optimum import pid_optimum

if TYPE_CHECKING:
    import control

FILTER = 10.0  # N over the frequency at which the PI law meets its limit


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
    reference_peak: float = 1.05,
) -> PidDesign:
    """The PI or PID law with the largest |ki| for which max |S| <= Ms and max |T| <= Mt, with its weights.

    `wb.PID.of(design)` is the law, and `design.certificate` has the margins of the loop with their bounds.

    Parameters
    ----------
    system
        The plant, a `TransferFunction` or `StateSpace` in continuous time with one channel, as that of `linearize`.
    delay
        Its delay in s.
    Ms, Mt
        The limits, infinite for none. Mt is by default the same as Ms.
    form
        "PI" or "PID".
    N, noise_gain
        As for `pid_optimum`; by default N is 10 times the frequency at which the PI law meets its limit.
    reference_peak
        The limit of the peak from the reference to the output, at least 1, for which b in [0, 1] is chosen; c is 0.

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
    one_of("tune_pid(form=...)", form, ("PI", "PID"))
    peak = finite("tune_pid(reference_peak=...)", reference_peak, low=1)
    T_limit = Ms if Mt is None else Mt
    if form == "PI" and (N is not None or noise_gain is not None):
        raise ValueError("`tune_pid(N=..., noise_gain=...)` are those of a derivative; take `form='PID'` for one.")
    if form == "PID" and N is None and noise_gain is None:
        N = _usual_filter(system, Ms, T_limit, delay)
    if form == "PI":
        design = pi_optimum(system, Ms, T_limit, delay)
    else:
        design = pid_optimum(system, Ms, T_limit, delay, N, noise_gain)
    return design.with_weights(design.reference_response.weight_for(peak), 0.0)


def _usual_filter(system: control.LTI, Ms: float, Mt: float, delay: float) -> float:
    """The bandwidth of a filter that costs little phase at the frequency where a PI law meets the limits."""
    try:
        contacts = pi_optimum(system, Ms, Mt, delay).contacts
    except DesignError:
        contacts = ()
    if not contacts or not math.isfinite(contacts[0].frequency):
        raise DesignError(
            "`tune_pid(N=...)` is chosen from the PI law of the same limits, and no PI law meets them. Give N, some 10 "
            "times the crossover frequency."
        )
    return FILTER * contacts[0].frequency
