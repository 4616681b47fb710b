"""The PID law with the largest integral gain under limits of the peaks of S and T, for a filter of the derivative."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from workbench.core.validation.refusals import one_of, positive
from workbench.core.validation.signatures import check_arguments
from workbench.design.matrices import DesignError, one_thread
from workbench.design.pid_design.derivative_action import DerivativeAction, law_polynomials
from workbench.design.pid_design.error_search import least_error
from workbench.design.pid_design.integral_gain import GainOptimum, IntegralGain
from workbench.design.pid_design.noise_gain import largest_noise_gain
from workbench.design.pid_design.pi_optimum import LARGEST_KI, bounded_process, checked_limits, confirm_optimum
from workbench.design.pid_design.pid_designs import PidDesign
from workbench.design.pid_design.pid_refusals import (
    refuse_infeasible,
)
from workbench.design.pid_design.process import Process

if TYPE_CHECKING:
    import control

RATIO = 1.6  # between the derivative gains of the first search
FIRST, LAST = 0.02, 20.0  # the first and the last derivative gain, over 1/|G| over the frequency of a PI law's limit
GOLDEN = (math.sqrt(5) - 1) / 2
ACCURACY, COARSE = 1e-4, 3e-3  # of the derivative gain, and while a filter is looked for
FILTERS, NOISE_ACCURACY = 25, 3e-3  # filters that are tried for a noise gain, and how closely it is met
FILTERS_OF_ERROR, ERROR_NOISE = 6, 0.03  # the same for the least IAE
MISSES = 3  # derivative gains in a row without a larger ki that end the first search


@check_arguments
def pid_optimum(
    plant: control.TransferFunction | control.StateSpace,
    Ms: float = 1.4,
    Mt: float = math.inf,
    delay: float = 0.0,
    N: float | None = None,
    noise_gain: float | None = None,
    criterion: str = "IE",
) -> PidDesign:
    """The PID law k + ki/s + kd s/(1 + s/N) with the least |IE|, or IAE, after a step of load; kd has the sign of ki.

    The least |IE| belongs to the largest |ki|. For each kd it is found globally, as by `pi_optimum`; kd is searched on
    a grid and refined. IAE, the integral of |e|, is at least 1/|ki|, so only gains with a |ki| above 1/IAE of a known
    law can have less. These are sampled, and boxes about the best samples are refined until no neighbour is better.
    This search is no proof, and its law stays inside the limits by up to some 0.1 %. `bound` is an upper bound of |ki|
    for the kd of the law with the largest |ki|: no law of this form with that kd has an IAE below 1/`bound`.

    Parameters
    ----------
    plant, Ms, Mt, delay
        As for `pi_optimum`.
    N
        The bandwidth of the filter of the derivative in rad/s.
    noise_gain
        In place of N, the limit of the peak of |C S|, the gain from noise of the measurement to u in the unit of u over
        that of y; N is then the largest that keeps it. Exactly one of N and `noise_gain` must be given: without a
        filter, ki is unbounded for many plants.
    criterion
        "IE" or "IAE". The law for "IAE" oscillates less, and its noise gain may be up to 3 % below the limit.

    Raises
    ------
    ValueError
        If `plant` is not such a system, or a number is out of its range.
    DesignError
        If no PID law stabilises the plant or meets the limits, or if ki has no largest value.

    References
    ----------
    Panagopoulos, Astrom, Hagglund (2002), Design of PID controllers based on constrained optimisation, IEE Proc. 149.

    Examples
    --------
    >>> import control
    >>> design = wb.pid_design.pid_optimum(control.tf([1], [1, 3, 3, 1]), Ms=1.4, N=20.0)
    >>> design.form, design.ki > 2 * wb.pid_design.pi_optimum(design.plant, Ms=1.4).ki
    ('PID', True)
    """
    one_of("pid_optimum(criterion=...)", criterion, ("IE", "IAE"))
    return least_pid_error("pid_optimum", "plant", plant, (Ms, Mt), delay, (N, noise_gain), criterion)


def least_pid_error(
    name: str,
    port: str,
    plant: control.LTI,
    limits: tuple[float, float],
    delay: float,
    filters: tuple[float | None, float | None],
    criterion: str,
) -> PidDesign:
    """The PID law of `pid_optimum`, whose refusals name a function and its argument for the plant."""
    Ms, Mt = checked_limits(name, *limits)
    _refuse_no_filter(name, *filters)
    process = bounded_process(name, port, plant, delay, Ms, Mt)
    with one_thread():
        return _optimum((name, port), plant, process, (Ms, Mt), filters, criterion)


def _optimum(
    door: tuple[str, str],
    plant: control.LTI,
    process: Process,
    limits: tuple[float, float],
    filters: tuple[float | None, float | None],
    criterion: str,
) -> PidDesign:
    sign = 1 if process.num[-1] * process.den[0] > 0 else -1
    upright = process if sign > 0 else process.mirror()
    (name, port), (N, noise_gain) = door, filters
    call = f"{name}({port}, ...)"
    if noise_gain is None:
        best = best_derivative(upright, *limits, positive(f"{name}(N=...)", N, " of rad/s"))
    else:
        best = filter_for_noise(call, upright, *limits, positive(f"{name}(noise_gain=...)", noise_gain))
    if best is None:
        refuse_infeasible(call, process, *limits)
    if criterion == "IAE":
        best = _least_error(upright, limits, best, noise_gain)
    problem = IntegralGain(upright, *limits, best[0])
    return confirm_optimum(call, plant, problem, sign, best[1], "least IAE" if criterion == "IAE" else LARGEST_KI)


def _least_error(
    process: Process,
    limits: tuple[float, float],
    start: tuple[DerivativeAction, GainOptimum],
    noise_limit: float | None,
) -> tuple[DerivativeAction, GainOptimum]:
    """The law with the least IAE, its filter slowed or hastened to the limit of the noise gain, if there is one."""
    found = least_error(process, limits, *start)
    kept, N = start, start[0].N
    if noise_limit is None:
        return found
    for _ in range(FILTERS_OF_ERROR):
        excess = largest_noise_gain(process, *law_polynomials(found[1].k, found[1].ki, found[0])) / noise_limit
        if excess <= 1:
            kept = found
            if excess > 1 - ERROR_NOISE:
                break
        N *= (1 - ERROR_NOISE / 3) / excess
        at_N = best_derivative(process, *limits, N)
        if at_N is None:
            break
        found = least_error(process, limits, *at_N)
    return kept


def _refuse_no_filter(name: str, N: float | None, noise_gain: float | None) -> None:
    if (N is None) == (noise_gain is None):
        raise ValueError(
            f"`{name}(N=..., noise_gain=...)` needs exactly one of the two: without a filter the largest ki is "
            "unbounded for many plants. Take an N of 5 to 20 times the crossover frequency, or the noise that u may "
            "carry."
        )


def best_derivative(
    process: Process, Ms: float, Mt: float, N: float, near: float | None = None
) -> tuple[DerivativeAction, GainOptimum] | None:
    """The derivative action with the largest ki, and that optimum; None if no gains meet the limits.

    With `near`, the derivative gain is looked for within a factor 2 of it alone.
    """
    optima: dict[float, GainOptimum | None] = {}

    def largest(kd: float, least: float = 0.0) -> float:
        if kd not in optima:
            optima[kd] = IntegralGain(process, Ms, Mt, DerivativeAction(kd, N)).solve(least)
        optimum = optima[kd]
        return -math.inf if optimum is None else optimum.ki

    if near is None:
        largest(0.0)
        grid = _first_grid(process, largest, optima[0.0])
        at = max(range(len(grid)), key=lambda i: largest(grid[i]))
        low, high = grid[max(at - 1, 0)], grid[min(at + 1, len(grid) - 1)]
    else:
        low, high = near / 2, 2 * near
    if all(optimum is None for optimum in optima.values()) and near is None:
        return None
    _refine(largest, low, high, ACCURACY if near is None else COARSE)
    kd = max(optima, key=largest)
    best = optima[kd]
    return None if best is None else (DerivativeAction(kd, N), best)


def filter_for_noise(
    call: str, process: Process, Ms: float, Mt: float, limit: float
) -> tuple[DerivativeAction, GainOptimum] | None:
    """The optimum with the largest filter bandwidth whose noise gain is below a limit."""
    first = IntegralGain(process, Ms, Mt).solve()
    if first is None or not first.contacts:
        raise DesignError(
            f"`{call}`: a filter for a noise gain is looked for about the frequency at which a PI law meets the "
            "limits, and none meets them here. Give N."
        )
    least = largest_noise_gain(process, np.array([first.k, first.ki]), np.array([1.0, 0.0]))
    if not limit > least:
        raise DesignError(
            f"`{call}`: noise_gain = {limit:g} leaves no room for a derivative, as the PI law of these limits has "
            f"{least:.4g}. Ask for more, or for less robust limits."
        )
    return _search_filter(process, Ms, Mt, limit, 10 * first.contacts[0].omega)


def _search_filter(
    process: Process, Ms: float, Mt: float, limit: float, N: float
) -> tuple[DerivativeAction, GainOptimum] | None:
    """Bisection of the logarithm of N, by secants, from the first N."""
    kept: tuple[DerivativeAction, GainOptimum] | None = None
    low, high, near = 0.0, math.inf, None
    for _ in range(FILTERS):
        best = best_derivative(process, Ms, Mt, N, near)
        if best is None:
            return kept
        action, gains = best
        near = action.kd or near
        excess = largest_noise_gain(process, *law_polynomials(gains.k, gains.ki, action)) / limit
        if excess <= 1:
            kept, low = best, N
            if excess > 1 - NOISE_ACCURACY:
                break
        else:
            high = N
        guess = N / excess
        if not low * 1.0001 < guess < high * 0.9999:
            guess = math.sqrt(low * high) if low and high < math.inf else N * (0.25 if excess > 1 else 4.0)
        N = guess * (1 - 0.3 * NOISE_ACCURACY)
    return kept


def _first_grid(process: Process, largest: Callable[..., float], start: GainOptimum | None) -> list[float]:
    """Derivative gains from 0 up, about 1/|G| over the frequency at which a PI law meets its limit, if there is one."""
    omega = process.frequencies()[1:]
    sizes = np.abs(process.inverse(omega)) / omega
    low, high = float(sizes.min()), float(sizes.max())
    if start is not None and start.contacts:
        middle = float(np.interp(start.contacts[0].omega, omega, sizes))
        low, high = FIRST * middle, LAST * middle
    grid, best, misses = [0.0], largest(0.0), 0
    for kd in np.geomspace(low, high, 2 + int(np.log(high / low) / np.log(RATIO))).tolist():
        top = largest(kd, max(best, 0.0))
        grid.append(kd)
        misses = 0 if top > best else misses + 1
        best = max(best, top)
        if misses >= MISSES and best > 0 and kd > 0.5 * high / LAST:
            break
    return grid


def _refine(largest: Callable[..., float], low: float, high: float, accuracy: float) -> None:
    """Golden section for the derivative gain between two of them."""
    inner = [high - GOLDEN * (high - low), low + GOLDEN * (high - low)]
    while high - low > accuracy * high:
        if largest(inner[0]) >= largest(inner[1]):
            high = inner[1]
            inner = [high - GOLDEN * (high - low), inner[0]]
        else:
            low = inner[0]
            inner = [inner[1], low + GOLDEN * (high - low)]
