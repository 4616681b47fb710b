"""Filters beside a law: a notch for a resonance, and a prefilter of the reference for a bandwidth."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import finite, positive, refusal
from workbench.core.validation.signatures import check_arguments
from workbench.design.control_system import System
from workbench.design.frequency.bandwidth import bandwidth as bandwidth_of
from workbench.design.frequency.hinf_norm import hinf_norm
from workbench.design.frequency.margin_records import StabilityMargins
from workbench.design.matrices import DesignError, one_thread
from workbench.design.pid_design.pi_optimum import checked_process
from workbench.design.pid_design.pid_designs import certificate_of

if TYPE_CHECKING:
    import control

RESONANT = 0.5  # poles with less damping are resonances
BISECTIONS = 100
CLOSE = 1e-9  # of the bandwidth


@dataclass(frozen=True, eq=False)
@show
class NotchDesign:
    """A notch in series with a law: `notch` is the filter, and `law` the given law times the notch.

    `frequency` in rad/s is the centre of the notch, and `certificate` has the margins of the plant with `law`.
    """

    notch: System
    law: System
    frequency: float
    certificate: StabilityMargins


@dataclass(frozen=True, eq=False)
@show
class PrefilterDesign:
    """A lag F, the `prefilter` of the reference: `response` is F T, with its `bandwidth` in rad/s and its `peak`."""

    prefilter: System
    response: System
    bandwidth: float
    peak: float


@check_arguments
def notch(
    plant: control.TransferFunction | control.StateSpace,
    law: control.TransferFunction,
    width: float = 0.5,
    frequency: float | None = None,
    damping: float | None = None,
    delay: float = 0.0,
) -> NotchDesign:
    """The notch (s^2 + 2 z w s + w^2) / (s^2 + 2 width w s + w^2) in series with a law, and the margins of the loop.

    Parameters
    ----------
    plant, delay
        As for `pi_optimum`.
    law
        The law of the error, a `TransferFunction`, such as `PidDesign.loop_filter` or that of `lead_lag`.
    width
        The damping of the poles of the notch, above that of its zeros. A larger one makes the notch wider, and costs
        more phase below it.
    frequency, damping
        w in rad/s and z of its zeros; by default those of the least damped pole of the plant.

    Raises
    ------
    ValueError
        If an argument is not as above.
    DesignError
        If the plant has no resonance and `frequency` is left out, or the loop is not stable.

    References
    ----------
    Franklin, Powell and Emami-Naeini (2019), Feedback Control of Dynamic Systems.

    Examples
    --------
    >>> import control
    >>> plant = control.tf([1], [1, 0.02, 1])
    >>> design = wb.pid_design.notch(plant, control.tf([0.2], [1, 0]))
    >>> round(design.frequency, 3), design.certificate.stable
    (1.0, True)
    """
    process = checked_process("notch", plant, delay)
    compensator = _checked_law("notch", law)
    wide = positive("notch(width=...)", width)
    w, z = _resonance(process.roots[1]) if frequency is None else (0.0, 0.0)
    w = w if frequency is None else positive("notch(frequency=...)", frequency, " of rad/s")
    z = z if damping is None else finite("notch(damping=...)", damping, low=0)
    if not z < wide:
        raise ValueError(
            f"`notch(width=...)` must be above the damping {z:.3g} of its zeros, or it is no notch; got {wide:g}."
        )
    return _notched(plant, law, process.delay, compensator, (w, z, wide))


def _notched(
    plant: control.LTI,
    law: control.TransferFunction,
    delay: float,
    compensator: tuple[np.ndarray, np.ndarray],
    numbers: tuple[float, float, float],
) -> NotchDesign:
    import control

    w, z, wide = numbers
    zeros, poles = [1, 2 * z * w, w * w], [1, 2 * wide * w, w * w]
    names = {"inputs": law.input_labels, "outputs": law.output_labels}
    both = control.tf(
        np.polymul(compensator[0], zeros), np.polymul(compensator[1], poles), name=f"{law.name} with notch", **names
    )
    with one_thread():
        certificate = certificate_of(plant, delay, both)
    if not certificate.stable:
        raise DesignError(
            f"`notch(plant, law)`: the loop with a notch at {w:.4g} rad/s is not stable. Take a lower gain, or another "
            "width."
        )
    return NotchDesign(control.tf(zeros, poles, name="notch"), both, w, certificate)


@check_arguments
def prefilter(
    plant: control.TransferFunction | control.StateSpace, law: control.TransferFunction, bandwidth: float
) -> PrefilterDesign:
    """The lag F = 1 / (1 + s / a) for which F T, from the reference to the output, has a given bandwidth.

    F T is F P C / (1 + P C). The lag acts on the reference alone, so margins and the response to loads stay as they
    are.

    Parameters
    ----------
    plant
        The plant P without delay, as for `pi_optimum`.
    law
        The law C of the error, a `TransferFunction`.
    bandwidth
        The frequency in rad/s at which |F T| has fallen by 3 dB below its value at rest; lower than that of T.

    Raises
    ------
    ValueError
        If an argument is not as above.
    DesignError
        If the loop is not stable, or T itself has less bandwidth.

    References
    ----------
    Astrom and Hagglund (2006), Advanced PID Control.

    Examples
    --------
    >>> import control
    >>> plant = control.tf([1], [1, 3, 3, 1])
    >>> law = wb.tune_pid(plant).loop_filter
    >>> round(wb.pid_design.prefilter(plant, law, bandwidth=0.4).bandwidth, 6)
    0.4
    """
    import control

    checked_process("prefilter", plant, 0.0)
    num, den = _checked_law("prefilter", law)
    wanted = positive("prefilter(bandwidth=...)", bandwidth, " of rad/s")
    with one_thread():
        if not certificate_of(plant, 0.0, law).stable:
            raise DesignError("`prefilter(plant, law)`: the loop is not stable, so its reference has no response.")
        P = control.tf(plant)
        p, q = np.polymul(P.num[0][0], num), np.polymul(P.den[0][0], den)
        closed = p, np.polyadd(p, q)
        own = bandwidth_of(control.tf(*closed)).frequency.value
        if not own > wanted:
            raise DesignError(
                f"`prefilter(bandwidth={wanted:g})`: the loop itself has a bandwidth of {own:.4g} rad/s, which a lag "
                "only lowers. Ask for less, or tune the loop faster."
            )
        return _lag_for(closed, wanted)


def _lag_for(closed: tuple[np.ndarray, np.ndarray], wanted: float) -> PrefilterDesign:
    """The lag by bisection of its corner, with the certified figures of the response."""
    import control

    low, high, system = 1e-3 * wanted, 1e6 * wanted, None
    for _ in range(BISECTIONS):
        corner = math.sqrt(low * high)
        system = control.tf(corner * closed[0], np.polymul(closed[1], [1, corner]), name="F T")
        reached = bandwidth_of(system).frequency.value
        if abs(reached - wanted) <= CLOSE * wanted or high <= low * (1 + 1e-14):
            break
        low, high = (corner, high) if reached < wanted else (low, corner)
    peak = hinf_norm(control.ss(system)).gain.value
    return PrefilterDesign(control.tf([corner], [1, corner], name="prefilter"), system, reached, peak)


def _checked_law(call: str, law: object) -> tuple[np.ndarray, np.ndarray]:
    import control

    if not isinstance(law, control.TransferFunction) or not law.issiso() or law.isdtime(strict=True):
        raise refusal(f"{call}(law=...)", "a `TransferFunction` in continuous time with one input and one output", law)
    num, den = np.trim_zeros(law.num[0][0], "f"), np.trim_zeros(law.den[0][0], "f")
    if not num.size or len(num) > len(den) or not (np.isfinite(num).all() and np.isfinite(den).all()):
        raise refusal(f"{call}(law=...)", "proper, with finite numbers that are not all zero", law)
    return num, den


def _resonance(poles: np.ndarray) -> tuple[float, float]:
    """The frequency and the damping of the least damped pole."""
    size = np.abs(poles)
    damping = np.where(size > 0, -poles.real / np.maximum(size, 1e-300), 1.0)
    if not damping.size or damping.min() >= RESONANT or damping.min() < 0:
        raise DesignError(
            f"`notch(plant, law)`: the plant has no stable pole with a damping below {RESONANT:g}. Give `frequency` "
            "and `damping`."
        )
    at = int(damping.argmin())
    return float(size[at]), float(damping[at])
