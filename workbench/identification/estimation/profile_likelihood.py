"""Profile likelihoods: how far one number can go if all others are fitted again."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np
from scipy import stats

from workbench.core.validation.refusals import Array, finite, known_name
from workbench.identification.estimation.refit import Deviance, Refit, refit
from workbench.identification.estimation.step_refinement import halve

POINTS = 4  # of a side of the curve up to its limit, if the outputs are linear
MOST_POINTS = 80  # of a side
REACH = 10.0  # half widths of the linear interval to which the search goes if no limits are given
OF_LIMIT = 1e-2  # change of a ratio by half the step, relative to the limit
MOST_HALVINGS = 7  # of the step of the fit
AT_END = 1e-4  # relative error of the root of the ratio at an end of the interval
MOST_ROOT_ROUNDS, MOST_SHORTER = 30, 6
BETTER = 1e-2  # fall of the deviance below that of the estimate that is another minimum

Limits = tuple[float, float] | None
Reason = Literal["reached", "open", "bound", "not converged"]


class ProfileEnd(NamedTuple):
    """An end of an interval: its value, and why it is there."""

    value: float
    reason: Reason


class ProfilePoint(NamedTuple):
    """A point of a curve.

    It has all numbers z (nz,), the log-likelihood ratio, the next step in standard errors, the change of the ratio by
    half the integration step, and how often that step was halved for it.
    """

    z: Array
    ratio: float
    to_minimum: float
    by_half_step: float
    halvings: int


@dataclass(frozen=True, eq=False)
class ProfileLikelihood:
    """The log-likelihood ratio of one number, with all others fitted again at each of its values.

        D(v) = 2 log L(all at the estimate) - 2 log L(number = v, others at their best for it)

    The values with D below `limit` are the interval. It is the linear interval if the outputs are linear in the
    numbers, keeps to the curved valley if they are not, and does not depend on the choice of the parameters.

    Parameters
    ----------
    name, unit, estimate, level
        The number, and the probability with which its interval holds it.
    values
        (M,), increasing, with the estimate among them.
    ratios
        (M,), D at the values.
    numbers
        (M, nz), all numbers at the values, the valley that the profile follows.
    limit
        The largest D of the interval. For known noise it is the quantile of chi-square with one degree of freedom. For
        estimated noise it is N log(1 + t^2 / (N - nz)), t the quantile of Student's distribution with N - nz degrees:
        with one sensor the F test of one number.
    low_end, high_end
        The ends of the interval, each with its reason: "reached", "open" if the ratio stays below its limit as far as
        the search went, "bound" if the number may not go further, or "not converged". An open end is infinite.
    to_minimum, by_half_step
        The largest next step of any point, in standard errors, and the largest change of a ratio up to the limit by
        half the integration step. A point whose ratio changes by more than 1 % of the limit gets a shorter step.

    References
    ----------
    Venzon and Moolgavkar (1988), Applied Statistics 37(1), for the interval.
    Raue et al. (2009), Bioinformatics 25(15), for open ends as a sign of numbers that data cannot tell in practice.

    Examples
    --------
    >>> motor = wb.open_loop(wb.DCMotor())
    >>> run = wb.simulate(motor, motor.parameters.pack({"v": 12.0}), until=2.0, every=0.02)
    >>> noise = 0.1 * np.random.default_rng(1).standard_normal(101)
    >>> signals = {"v": np.full(101, 12.0), "omega": run["omega"][0] + noise}
    >>> log = wb.Dataset.of(run.t, signals, {"v": "V", "omega": "rad/s"})
    >>> profile = wb.fit(motor, log, ["J", "R"], answers={"constant signal": "a step"}).profile("R")
    >>> profile.interval[0] < 1.0 < profile.interval[1]
    True
    """

    name: str
    unit: str
    estimate: float
    level: float
    values: Array
    ratios: Array
    numbers: Array
    limit: float
    low_end: ProfileEnd
    high_end: ProfileEnd
    to_minimum: float
    by_half_step: float

    @property
    def interval(self) -> tuple[float, float]:
        """The interval of the number; an end that is open is infinite, and one that did not converge is NaN."""
        return self.low_end.value, self.high_end.value

    @property
    def remarks(self) -> tuple[str, ...]:
        """Sentences on ends that were not reached, and on a better minimum than the estimate."""
        said = []
        for side, end, at in (("below", self.low_end, 0), ("above", self.high_end, -1)):
            where = f"'{self.name}' is open {side}: at {self.values[at]:.4g} the ratio is {self.ratios[at]:.3g}"
            if end.reason == "open":
                said.append(f"{where}, less than {self.limit:.3g}.")
            elif end.reason == "not converged":
                said.append(f"The fits of '{self.name}' do not converge {side} {self.values[at]:.4g}: no end is known.")
            elif end.reason == "bound":
                said.append(f"The interval of '{self.name}' ends {side} at its bound, {end.value:.4g}.")
        if self.ratios.min() < -BETTER:
            best = int(np.argmin(self.ratios))
            said.append(
                f"There is a better minimum at {self.name} = {self.values[best]:.4g}, lower by "
                f"{-self.ratios[best]:.3g}: fit again from there."
            )
        return tuple(said)

    def __repr__(self) -> str:
        low, high = self.interval
        text = f"{self.name} = {self.estimate:.4g}, {100 * self.level:g} % interval {low:.4g} to {high:.4g}"
        return f"<ProfileLikelihood: {text}{'; ' if self.remarks else ''}{' '.join(self.remarks)}>"


def ratio_limit(level: float, count: float, degrees: float, is_noise_known: bool) -> float:
    """The log-likelihood ratio up to which a value belongs to the interval, for `count` samples."""
    if is_noise_known:
        return float(stats.chi2.ppf(level, 1))
    return float(count * np.log1p(stats.t.ppf((1 + level) / 2, degrees) ** 2 / degrees))


def profile_of(
    deviance: Deviance,
    theta: Array,
    covariance: Array,
    name: str,
    level: float,
    limits: Limits,
) -> ProfileLikelihood:
    """The profile of the number `name` from the estimate theta (nz,) with its covariance (nz, nz)."""
    level = finite("Fit.profile(level=...)", level)
    if not 0 < level < 1:
        raise ValueError(f"`Fit.profile(level=...)` must lie between 0 and 1; got {level:g}.")
    numbers, count = deviance.data.model.numbers, float(deviance.data.counts.sum())
    names = [number.name for number in numbers]
    i = names.index(known_name(name, names, "numbers of this fit"))
    limit = ratio_limit(level, count, count - len(theta), deviance.sigma is not None)
    half = float(np.sqrt(limit * covariance[i, i]))
    low, high = limits if limits is not None else (theta[i] - REACH * half, theta[i] + REACH * half)
    if not -np.inf < low < theta[i] < high < np.inf:
        raise ValueError(
            f"`Fit.profile({name!r}, limits=...)` must be finite, one below and one above the estimate {theta[i]:.6g}; "
            f"got {low:g} and {high:g}."
        )
    reach = max(float(low), numbers[i].low), min(float(high), numbers[i].high)
    search = ProfileSearch(deviance, theta, covariance, i, limit, reach)
    (below, low_end), (above, high_end) = search.side(-1), search.side(1)
    points = [*below[::-1], search.center, *above]
    z, ratios = np.array([point.z for point in points]), np.array([point.ratio for point in points])
    worst = max(point.to_minimum for point in points)
    change = max(point.by_half_step for point in points if point.ratio <= limit * (1 + OF_LIMIT))
    ends, unit = (low_end, high_end), numbers[i].unit
    return ProfileLikelihood(name, unit, float(theta[i]), level, z[:, i], ratios, z, limit, *ends, worst, change)


@dataclass(frozen=True, eq=False)
class ProfileSearch:
    """A walk from the estimate along one number, at the place `place`, up to `limit` of the ratio.

    `theta` (nz,) is the estimate, `covariance` (nz, nz) its covariance, and `reach` the last values on both sides.
    """

    deviance: Deviance
    theta: Array
    covariance: Array
    place: int
    limit: float
    reach: tuple[float, float]

    @cached_property
    def center(self) -> ProfilePoint:
        """The estimate itself."""
        base = self._models[0][1]
        return ProfilePoint(self.theta, 0.0, base.to_minimum, 0.0, 0)

    @cached_property
    def _models(self) -> list[tuple[Deviance, Refit]]:
        """The deviance at the step of the fit, at half of it and so on, as far as needed, each with its least one."""
        return [(self.deviance, refit(self.deviance, self.theta, np.arange(len(self.theta))))]

    def _model(self, halvings: int) -> tuple[Deviance, Refit]:
        while len(self._models) <= halvings:
            last, base = self._models[-1]
            finer = replace(last, data=halve(last.data))
            self._models.append((finer, refit(finer, base.z, np.arange(len(self.theta)))))
        return self._models[halvings]

    def side(self, sign: int) -> tuple[list[ProfilePoint], ProfileEnd]:
        """The points from the estimate outwards, without it, and the end of the interval on this side."""
        i, last = self.place, self.reach[(sign + 1) // 2]
        bound = self.deviance.bounds[(sign + 1) // 2][i]
        top = np.sqrt(self.limit)
        step = top * np.sqrt(self.covariance[i, i]) / POINTS
        points = [self.center]
        shorter = 0
        while len(points) <= MOST_POINTS and sign * (last - points[-1].z[i]) > 0:
            value = points[-1].z[i] + sign * step
            value = last if sign * (value - last) >= 0 else value
            new = self._point(value, points[-1].halvings, self._forecast(points, value), points[-1].z)
            if new is None:
                shorter, step = shorter + 1, step / 4
                if shorter > MOST_SHORTER:
                    return points[1:], ProfileEnd(np.nan, "not converged")
                continue
            points.append(new)
            if new.ratio >= self.limit:
                end = self._root(points[-2], new)
                if end is None:
                    return points[1:-1], ProfileEnd(np.nan, "not converged")
                return [*points[1:-1], end, new], ProfileEnd(float(end.z[i]), "reached")
            gain = np.sqrt(max(new.ratio, 0.0)) - np.sqrt(max(points[-2].ratio, 0.0))
            step *= float(np.clip(top / POINTS / max(gain, 1e-12), 0.5, 2.0))
        if points[-1].z[i] == bound or self.theta[i] == bound:
            return points[1:], ProfileEnd(float(bound), "bound")
        return points[1:], ProfileEnd(sign * np.inf, "open")

    def _forecast(self, points: list[ProfilePoint], value: float) -> Array:
        """All numbers where the last two points, or at first the covariance, lead to."""
        i = self.place
        if len(points) > 1:
            a, b = points[-2].z, points[-1].z
            return np.asarray(b + (b - a) * (value - b[i]) / (b[i] - a[i]))
        slope = self.covariance[:, i] / self.covariance[i, i]
        return np.asarray(self.theta + slope * (value - self.theta[i]))

    def _point(self, value: float, halvings: int, *starts: Array) -> ProfilePoint | None:
        """The best point with the number at a value, from the first start that converges; None if none does.

        The step is halved until half of it changes the ratio no more.
        """
        free = np.delete(np.arange(len(self.theta)), self.place)
        for level in range(halvings, MOST_HALVINGS):
            deviance, base = self._model(level)
            for start in starts:
                z = np.clip(start, *self.deviance.bounds)
                z[self.place] = value
                end = refit(deviance, z, free)
                if not end.is_converged:
                    continue
                ratio, change = end.deviance - base.deviance, self._change(end, level)
                if change <= OF_LIMIT * max(self.limit, ratio):
                    return ProfilePoint(end.z, ratio, end.to_minimum, change, level)
        return None

    def _change(self, end: Refit, halvings: int) -> float:
        """The change of a ratio by half the step; that of the other numbers matters in second order only."""
        base, (finer, later) = self._model(halvings)[1], self._model(halvings + 1)
        ratio = finer.value(finer.errors(end.z)) - later.deviance
        return float(abs(ratio - (end.deviance - base.deviance)))

    def _root(self, inside: ProfilePoint, outside: ProfilePoint) -> ProfilePoint | None:
        """The point with the ratio at its limit, by false position in the root of the ratio, which is nearly straight.

        None is returned if the fits between both points do not converge.
        """
        i, top = self.place, np.sqrt(self.limit)
        for k in range(MOST_ROOT_ROUNDS):
            a, b = (np.sqrt(max(point.ratio, 0.0)) for point in (inside, outside))
            share = (top - a) / (b - a) if k % 3 < 2 else 0.5  # a middle now and then, for a ratio that bends
            z = inside.z + share * (outside.z - inside.z)
            new = self._point(float(z[i]), inside.halvings, z, inside.z)
            if new is None:
                return None
            if abs(np.sqrt(max(new.ratio, 0.0)) - top) <= AT_END * top:
                return new
            inside, outside = (new, outside) if new.ratio < self.limit else (inside, new)
        return None
