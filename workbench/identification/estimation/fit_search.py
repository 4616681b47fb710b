"""The search of a fit: whole runs, segments of the log, random starts, and the noise of the sensors."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.identification.estimation.identifiability import Identifiability
from workbench.identification.estimation.least_squares import Minimum, least_squares
from workbench.identification.estimation.multiple_shooting import shoot_in_segments
from workbench.identification.estimation.weighed_data import WeighedData

FIRST_NOISE = 0.05  # of a sensor's spread, before anything is known of its noise
LEAST_NOISE = 1e-9  # of a sensor's spread: below it a log has no noise but that of numbers
NOISE_OF_A_LOG = 1e-6  # of a sensor's spread: below it the noise is that of rounding and integration
NOISE_ROUNDS, NOISE_CHANGE = 30, 1e-9
POOR_FIT = 1.5  # root mean square of the residuals, in standard deviations of noise that is known, or
UNEXPLAINED = 0.1  # the share of a sensor's variance that is left, beyond which a minimum may be a false one
SMALL = 1e-3  # of a sensor's spread: hardly any sensor has less noise
SMOOTH = 0.5  # sum of squared differences over the sum of squares: 2 for white noise
SAME = 1e-6  # relative difference of two sums of squares that are one minimum
RESCUES = 4  # random starts of a search that ended in a doubtful minimum
EXAMINED = 64  # random starts for each that is followed to its minimum


@dataclass(frozen=True)
class SearchEnd:
    """The best minimum of a search, and what else it met."""

    z: Array
    sigma: Array  # (ny,), known or estimated
    minimum: Minimum
    starts: int  # searches that ended in a minimum
    agreeing: int  # of these, the ones that ended in the best one
    shooting: str  # the way from the start to it, in words


def search(data: WeighedData, sigma: Array | None, starts: int, generator: np.random.Generator) -> SearchEnd | None:
    """The best minimum from the start of the model, from segments of the log, and from random starts around it.

    A search from one start that ends in a doubtful minimum, or in none, is followed by some from random starts.
    `sigma` (ny,) is the noise of the sensors if it is known. None is returned if no search has a run that lasts.
    """
    weights = sigma if sigma is not None else FIRST_NOISE * spread(data)
    first = data.model.starts
    ends: list[tuple[Minimum, str]] = []
    single = follow(data, weights, first)
    if single is not None:
        ends.append((single, "runs over the whole log"))
    if single is None or is_poor(data, single.z, sigma):
        inner = shoot_in_segments(data, first, weights)
        again = None if inner is None else follow(data, weights, inner)
        if again is not None:
            ends.append((again, "segments of the log, then runs over the whole log"))
    if starts == 1 and (not ends or _is_doubtful(data, min(ends, key=_cost)[0].z, sigma, weights)):
        starts += RESCUES
    for start in random_starts(data, weights, starts - 1, generator):
        other = follow(data, weights, start)
        if other is not None:
            ends.append((other, "a random start"))
    if not ends:
        return None
    best, way = min(ends, key=_cost)
    agreeing = sum(end.cost <= best.cost * (1 + SAME) + 1e-12 for end, _ in ends)
    end = SearchEnd(best.z, weights, best, len(ends), agreeing, way)
    return end if sigma is not None else with_noise(data, end)


def _cost(end: tuple[Minimum, str]) -> float:
    return end[0].cost


def _is_doubtful(data: WeighedData, z: Array, sigma: Array | None, weights: Array) -> bool:
    """True if a minimum may be a false one.

    It explains the data badly, or the data tell less there than they might, or the residuals are far below the noise of
    sensors and yet smooth, as those of another minimum of a log without noise are.
    """
    if is_poor(data, z, sigma) or (sigma is None and _is_smooth(data, z)):
        return True
    names = tuple(number.name for number in data.model.numbers)
    return not Identifiability.of(names, z, data.linearize(z, weights)[1], data.model.starts).is_complete


def _is_smooth(data: WeighedData, z: Array) -> bool:
    """True if the residuals of a sensor are small beside its spread, and smooth by von Neumann's ratio."""
    errors = data.errors(z)
    for j, size in enumerate(spread(data)):
        columns = [error[mask[:, j], j] / size for error, mask in zip(errors, data.weighs, strict=True)]
        total = sum(float(column @ column) for column in columns)
        ratio = sum(float(np.sum(np.diff(column) ** 2)) for column in columns) / max(total, 1e-300)
        if NOISE_OF_A_LOG**2 < total / data.counts[j] < SMALL**2 and ratio < SMOOTH:
            return True
    return False


def follow(data: WeighedData, sigma: Array, start: Array) -> Minimum | None:
    """The minimum that is nearest to a start."""
    numbers = data.model.numbers
    low, high = (np.array([getattr(number, end) for number in numbers]) for end in ("low", "high"))
    return least_squares(partial(data.residuals, sigma=sigma), partial(data.linearize, sigma=sigma), start, low, high)


def with_noise(data: WeighedData, end: SearchEnd) -> SearchEnd:
    """The minimum of the likelihood whose noise is estimated too: sigma of each sensor from its own residuals."""
    floor, z, sigma, minimum = LEAST_NOISE * spread(data), end.z, end.sigma, end.minimum
    for _ in range(NOISE_ROUNDS):
        now = np.maximum(np.sqrt(data.sum_of_squares(z) / data.counts), floor)
        change = float(np.max(np.abs(now / sigma - 1)))
        sigma = now
        if change < NOISE_CHANGE or (sigma <= floor).all():
            break
        again = follow(data, sigma, z)
        if again is None:
            break
        z, minimum = again.z, again
    return replace(end, z=z, sigma=sigma, minimum=minimum)


def spread(data: WeighedData) -> Array:
    """(ny,), the standard deviation of the samples of each sensor that count; 1 for a sensor that is constant."""
    columns = [
        np.concatenate([samples[mask[:, j], j] for samples, mask in zip(data.samples, data.weighs, strict=True)])
        for j in range(len(data.counts))
    ]
    sizes = np.array([np.std(column) if column.size else 0.0 for column in columns])
    return np.where(sizes > 0, sizes, 1.0)


def has_noise(data: WeighedData, sigma: Array) -> bool:
    """True if the errors are those of sensors, and not those of rounding and integration alone."""
    return bool((sigma > NOISE_OF_A_LOG * spread(data)).any())


def is_poor(data: WeighedData, z: Array, sigma: Array | None) -> bool:
    """True if the residuals are so large that the minimum may be a false one."""
    left = data.sum_of_squares(z) / data.counts
    limit = (POOR_FIT * sigma) ** 2 if sigma is not None else UNEXPLAINED * spread(data) ** 2
    return bool((left > limit).any())


def random_starts(data: WeighedData, sigma: Array, count: int, generator: np.random.Generator) -> list[Array]:
    """The best of many random numbers around the start, in one batch: each from half to twice its start."""
    if count < 1:
        return []
    model = data.model
    low, high = (np.array([getattr(number, end) for number in model.numbers]) for end in ("low", "high"))
    factors = 2.0 ** generator.uniform(-1, 1, (EXAMINED * count, len(model.starts)))
    drawn = np.clip(np.where(model.starts == 0, np.log2(factors), model.starts * factors), low, high)
    cost = np.zeros(len(drawn))
    for i, (samples, mask) in enumerate(zip(data.samples, data.weighs, strict=True)):
        error = (model.values(drawn, i) - samples) / sigma
        with np.errstate(all="ignore"):
            cost += np.sum(np.where(mask, error, 0.0) ** 2, axis=(1, 2))
    order = np.argsort(np.where(np.isfinite(cost), cost, np.inf))
    return [drawn[i] for i in order[:count] if np.isfinite(cost[i])]
