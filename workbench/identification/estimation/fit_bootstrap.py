"""Bootstrap: the fit repeated on logs with other noise, for intervals that do not rest on linear outputs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from workbench.core.validation.refusals import Array, Integers, finite, known_name, one_of, whole
from workbench.core.validation.refusals import seed as check_seed
from workbench.core.validation.signatures import check_arguments
from workbench.identification.estimation.refit import Deviance, refit

KINDS = {
    "parametric": "normal noise of each sensor's standard deviation, added to the outputs of the fit",
    "residual": "residuals of each sensor, drawn with replacement, added to the outputs of the fit",
}

HALF_STEP = 0.05  # standard errors by which half the step may move a draw


@dataclass(frozen=True, eq=False)
class Bootstrap:
    """Estimates from logs that the fitted model could as well have given.

    Each log has the outputs of the fit plus noise drawn anew for each sensor, and is fitted from the estimate on.

    Parameters
    ----------
    names
        The nz numbers.
    theta
        (nz,), the estimates of the fit.
    draws
        (count, nz), the estimates of the drawn logs; NaN for a fit that did not converge.
    kind
        A name of the kind of noise.
    shares_at_bounds
        By name, the share of draws that lie on a bound of the number.
    to_minimum, by_half_step
        In standard errors, the largest next step of a converged fit, and the largest change by half the integration
        step of the draws with the least and the largest value of each number.
    parameters
        The names of those numbers that are parameters of the system.

    References
    ----------
    Efron and Tibshirani (1993), An Introduction to the Bootstrap, sections 6.5 (parametric), 9.4 (residuals) and 13.3
    (percentile intervals).

    Examples
    --------
    >>> motor = wb.open_loop(wb.DCMotor())
    >>> run = wb.simulate(motor, motor.parameters.pack({"v": 12.0}), until=2.0, every=0.02)
    >>> noise = 0.1 * np.random.default_rng(1).standard_normal(101)
    >>> signals = {"v": np.full(101, 12.0), "omega": run["omega"][0] + noise}
    >>> log = wb.Dataset.of(run.t, signals, {"v": "V", "omega": "rad/s"})
    >>> draws = wb.fit(motor, log, ["J", "R"], answers={"constant signal": "a step"}).bootstrap(100, seed=1)
    >>> draws.draws.shape, draws.share_failed
    ((100, 2), 0.0)
    """

    names: tuple[str, ...]
    theta: Array
    draws: Array
    kind: str
    shares_at_bounds: Mapping[str, float]
    to_minimum: float
    by_half_step: float
    parameters: tuple[str, ...]

    @property
    def is_passed(self) -> bool:
        """True if all fits converged, and half the step moves no draw by more than 5 % of a standard error."""
        return not self.share_failed and self.by_half_step <= HALF_STEP

    @cached_property
    def share_failed(self) -> float:
        """The share of fits that did not converge."""
        return float(np.mean(np.isnan(self.draws).any(axis=1)))

    @check_arguments
    def intervals(self, level: float = 0.95) -> dict[str, tuple[float, float]]:
        """Percentile intervals by name: from the (1 - level) / 2 quantile of the draws to the one of (1 + level) / 2.

        A fit that did not converge counts as beyond both ends, so that an interval is infinite if too many did not.

        Raises
        ------
        ValueError
            If the level is not between 0 and 1, or there are too few draws for it.
        """
        level = finite("Bootstrap.intervals(level=...)", level)
        if not 0 < level < 1:
            raise ValueError(f"`Bootstrap.intervals(level=...)` must lie between 0 and 1; got {level:g}.")
        count, share = len(self.draws), (1 - level) / 2
        place = int(np.floor((count + 1) * share + 1e-9))
        if place < 1:
            least = int(np.ceil(1 / share - 1e-9)) - 1
            raise ValueError(
                f"`Bootstrap.intervals(level=...)` of {level:g} needs at least {least} draws, so that some lie beyond "
                f"its ends; got {count}: draw more, or take a lower level."
            )
        low, high = (np.sort(np.where(np.isnan(self.draws), far, self.draws), axis=0) for far in (-np.inf, np.inf))
        ends = zip(self.names, low[place - 1].tolist(), high[count - place].tolist(), strict=True)
        return {name: (a, b) for name, a, b in ends}

    @property
    def standard_errors(self) -> dict[str, float]:
        """The standard deviations of the draws by name; NaN if a fit did not converge, as its draw is not known."""
        return dict(zip(self.names, np.std(self.draws, axis=0, ddof=1).tolist(), strict=True))

    @check_arguments
    def column(self, name: str) -> Array:
        """(count,), the draws of a number."""
        return np.asarray(self.draws[:, self.names.index(known_name(name, self.names, "numbers of this fit"))])

    @check_arguments
    def plants(self, path: str = "") -> tuple[dict[str, float], ...]:
        """The parameters of each draw by name after `path`, such as "plant.", as `wb.tune(plants=...)` takes them.

        Raises
        ------
        ValueError
            If a fit did not converge, as the plants that are left would be the easy ones, or no number is a parameter.
        """
        if self.share_failed or not self.parameters:
            failed = f"{100 * self.share_failed:.3g} % of the fits did not converge, and {len(self.parameters)}"
            raise ValueError(
                "`Bootstrap.plants(...)` must have draws that all converged, and numbers that are parameters of the "
                f"system; {failed} of {len(self.names)} numbers are parameters."
            )
        places = [self.names.index(name) for name in self.parameters]
        labels = [f"{path}{name}" for name in self.parameters]
        return tuple(dict(zip(labels, row, strict=True)) for row in self.draws[:, places].tolist())

    def __repr__(self) -> str:
        failed = f"; {100 * self.share_failed:.3g} % of the fits did not converge" if self.share_failed else ""
        shares = (f"{name} in {100 * share:.3g} %" for name, share in self.shares_at_bounds.items() if share)
        bounds = ", ".join(shares)
        at = f"; at a bound: {bounds}" if bounds else ""
        if self.by_half_step > HALF_STEP:
            at += f"; half the step moves a draw by {self.by_half_step:.2g} standard errors"
        return f"<Bootstrap: {len(self.draws):,} {self.kind} draws of {', '.join(self.names)}{failed}{at}>"


def draw_bootstrap(deviance: Deviance, theta: Array, sigma: Array, count: int, seed: int, kind: str) -> Bootstrap:
    """`count` fits from the estimate theta (nz,); `sigma` (ny,) is the noise of the sensors for "parametric" draws."""
    count = whole("Fit.bootstrap(count=...)", count, of=" of draws")
    one_of("Fit.bootstrap(kind=...)", kind, KINDS)
    generator = np.random.default_rng(check_seed("Fit.bootstrap(seed=...)", seed))
    first = deviance.linearize(theta)
    places, free = deviance.sensors, np.arange(len(theta))
    draws, largest = np.full((count, len(theta)), np.nan), 0.0
    pools = _pools(first.errors, places, len(theta)) if kind == "residual" else ()
    for row in draws:
        noise = _resample(pools, places, generator) if pools else sigma[places] * generator.standard_normal(len(places))
        end = refit(deviance, theta, free, -first.errors - noise, first)
        if end.is_converged:
            row[:], largest = end.z, max(largest, end.to_minimum)
    done = draws[np.isfinite(draws).all(axis=1)]
    extremes = np.unique([done.argmin(axis=0), done.argmax(axis=0)]) if len(done) else ()
    change = max((deviance.shift_by_half_step(done[i]) for i in extremes), default=np.inf)
    numbers = deviance.data.model.numbers
    low, high = deviance.bounds
    shares = np.mean((draws <= low) | (draws >= high), axis=0).tolist()
    names = tuple(number.name for number in numbers)
    own = tuple(number.name for number in numbers if number.kind == "parameter")
    return Bootstrap(names, theta, draws, kind, dict(zip(names, shares, strict=True)), largest, change, own)


def _pools(errors: Array, places: Integers, numbers: int) -> tuple[Array, ...]:
    """The residuals of each sensor without their mean, as large as the noise: a fit of nz numbers makes them smaller.

    Davison and Hinkley (1997), Bootstrap Methods and their Application, section 6.2.3, with the mean leverage for all.
    """
    factor = np.sqrt(len(errors) / (len(errors) - numbers))
    each = (errors[places == j] for j in range(int(places.max()) + 1))
    return tuple(factor * (one - one.mean()) for one in each)


def _resample(pools: tuple[Array, ...], places: Integers, generator: np.random.Generator) -> Array:
    noise = np.empty(len(places))
    for j, pool in enumerate(pools):
        own = np.flatnonzero(places == j)
        noise[own] = pool[generator.integers(len(pool), size=len(own))]
    return noise
