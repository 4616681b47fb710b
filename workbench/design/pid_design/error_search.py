"""The PID gains with the least integral of |e| after a step of load, under limits of the peaks of S and T.

The integral of |e| is at least the one of e, 1/ki. So with a law at hand that has an IAE, only gains with a ki above
1/IAE can have less: these are sampled, for each derivative gain and each k below the highest ki that the limits leave,
and boxes about the best samples are sampled again, ever smaller.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.design.matrices import Complex, DesignError
from workbench.design.pid_design.derivative_action import DerivativeAction, law_polynomials
from workbench.design.pid_design.gain_plane import GainPlane
from workbench.design.pid_design.gain_search import highest_gains, nodes
from workbench.design.pid_design.integral_gain import GainOptimum, IntegralGain
from workbench.design.pid_design.load_response import (
    WORST,
    LoadResponse,
    absolute_error,
    first_span,
    response_frequencies,
    times,
)
from workbench.design.pid_design.optimum_contacts import ContactEquations, contacts_of, is_stable, worst_contact
from workbench.design.pid_design.process import Process

COARSE_TIMES = 300
SPANS = 3.0  # times the span of the law with the largest ki
SAMPLES = (0.4, 1.0)  # shares of the frequencies of an IAE: the first that is enough
AGREE = 1e-2  # with the integral of the first law
DERIVATIVES = np.concatenate([[0.0], np.geomspace(0.15, 2.5, 12)])  # of a first search, over that of the largest ki
SMALLEST = 1e-3  # the derivative gains of a process whose largest ki has none, over |k| / omega of a contact
KS = 24  # values of k for each derivative gain
SHARES = np.array([0.55, 0.7, 0.8, 0.88, 0.94, 1.0])  # of the highest ki
STARTS, APART = 3, 0.15  # starts of the refinement, and how much they differ in a gain
SIDES = np.linspace(-1, 1, 5)
ROUNDS, SHRINK = 11, 0.6
SETTLING, NARROW = 9, 0.02  # rounds of a last search, and its first width over the gains
FINE = 4.0  # times the frequencies of a search, in the last one
TIGHTER = (3e-4, 1e-3, 5e-3, 2e-2)  # shares of the limits above 1 by which a last search is inside them
ROUNDING = 1e-9
TOUCHED = 1e-2  # the slack of a contact, which is not met exactly


@dataclass(frozen=True, eq=False)
class ErrorSearch:
    """The problem for a process, limits and a filter, with the law of the largest ki to start from."""

    process: Process
    Ms: float
    Mt: float
    N: float
    kd: float
    gains: GainOptimum
    response: LoadResponse
    reach: float
    omega: Array
    inverse: Complex

    @staticmethod
    def of(
        process: Process, limits: tuple[float, float], derivative: DerivativeAction, gains: GainOptimum
    ) -> ErrorSearch:
        """The problem, with times and frequencies that give the integral of the first law in some accuracy."""
        law = law_polynomials(gains.k, gains.ki, derivative)
        exact = absolute_error(process, *law)
        if not exact.error <= WORST * exact.value:
            raise DesignError(
                f"`pid_optimum(criterion='IAE')`: the integral of |e| is {exact.value:.4g} with an error of about "
                f"{exact.error:.1g}, too large for a search. Take `criterion='IE'`, or more robust limits."
            )
        most = replace(derivative, kd=float(DERIVATIVES[-1]) * derivative.kd)
        reach = IntegralGain(process, *limits, most).reach_of(gains)
        near = process.frequencies(1.0, reach, derivative.N)
        for share in SAMPLES:
            omega = response_frequencies(process, derivative.corner, share)
            span = SPANS * first_span(process, omega, np.polyval(law[0], 1j * omega) / np.polyval(law[1], 1j * omega))
            response = LoadResponse.of(process, omega, times(span, int(COARSE_TIMES * share / SAMPLES[0])))
            search = ErrorSearch(
                process, *limits, derivative.N, derivative.kd, gains, response, reach, near, process.inverse(near)
            )
            if abs(float(search.integrals(search._start)[0]) - exact.value) <= AGREE * exact.value + exact.error:
                break
        return search

    @property
    def _start(self) -> Array:
        return np.array([[self.kd, self.gains.k, self.gains.ki]])

    def _laws(self, omega: Array, rows: Array) -> Complex:
        s = 1j * omega
        kd, k, ki = (column[:, np.newaxis] for column in rows.T)
        return np.asarray(k + ki / s + kd * s / (1 + s / self.N))

    def best(self) -> Array:
        """The derivative gain, k and ki with the least integral that the search finds."""
        found = [self._refined(row, widths) for row, widths in self._starts()]
        return min(found, key=lambda pair: pair[1])[0]

    def _starts(self) -> list[tuple[Array, Array]]:
        """The best samples of all gains that can have less than the law of the largest ki, some apart."""
        least = 1 / float(self.integrals(self._start)[0])
        unit = self.kd or SMALLEST * abs(self.gains.k) / self.gains.contacts[0].omega
        rows = [self._column(kd, least) for kd in (unit * DERIVATIVES).tolist()]
        every = np.concatenate([self._start, *rows])
        values = self.integrals(every)
        picked: list[tuple[Array, Array]] = []
        for row in every[np.argsort(values)]:
            widths = np.array([0.2 * max(row[0], unit), 0.15 * abs(row[1]) + 0.02 * abs(self.gains.k), 0.15])
            if all((np.abs(row - other) > APART * (np.abs(other) + 1e-3 * np.abs(row))).any() for other, _ in picked):
                picked.append((row, widths))
            if len(picked) == STARTS:
                break
        return picked

    def _column(self, kd: float, least: float) -> Array:
        """Samples with one derivative gain, whose ki is at least as large as the best integral asks for."""
        plane = self._plane(kd)
        k = nodes(plane)
        top, _ = highest_gains(plane, k)
        fit = np.nonzero(top >= least)[0]
        if not fit.size:
            return np.zeros((0, 3))
        ends = k[max(fit[0] - 1, 0)], k[min(fit[-1] + 1, len(k) - 1)]
        return self._below(plane, kd, np.linspace(*ends, KS), SHARES, least)

    def _below(self, plane: GainPlane, kd: float, k: Array, shares: Array, least: float = 0.0) -> Array:
        """Gains with one derivative gain, some k and some shares of the highest ki, that meet the limits."""
        top, stable = highest_gains(plane, k)
        at = np.nonzero(top > 0)[0]
        rows = [(float(k[i]), ki, i) for i in at for ki in (shares * top[i]).tolist() if ki >= least]
        rows = [row for row in rows if any(low < row[1] < high for low, high in stable[row[2]])]
        if not rows:
            return np.zeros((0, 3))
        gains = np.array([(kd, *row[:2]) for row in rows])
        law = self._laws(plane.omega, gains)
        distance = np.abs(law + plane.g)
        inside = (distance * self.Ms >= (1 - ROUNDING) * np.abs(plane.g)).all(axis=1)
        if math.isfinite(self.Mt):
            inside &= (distance * self.Mt >= (1 - ROUNDING) * np.abs(law)).all(axis=1)
        return np.asarray(gains[inside])

    def integrals(self, rows: Array) -> Array:
        """The integrals of |e| for rows of kd, k and ki, over the times of the search, none below 1/ki."""
        sums = self.response.integrals(self._laws(self.response.omega, rows))
        return np.asarray(np.maximum(sums, 1 / rows[:, 2]))

    def _plane(self, kd: float) -> GainPlane:
        action = DerivativeAction(kd, self.N).response(self.omega)
        return GainPlane(self.process, self.omega, self.inverse, action, self.Ms, self.Mt)

    def settle(self, row: Array) -> Array:
        """The best gains near some that may be a little beyond the limits."""
        omega = self.process.frequencies(FINE, self.reach, self.N)
        inner = replace(self, omega=omega, inverse=self.process.inverse(omega))
        widths = NARROW * np.array([row[0], abs(row[1]), 1.0])
        return inner._refined(row, widths, math.inf, SETTLING)[0]

    def _refined(
        self, row: Array, widths: Array, best: float | None = None, rounds: int = ROUNDS
    ) -> tuple[Array, float]:
        """The best gains from a start on: boxes that move while they find better ones, and else shrink."""
        best, share = float(self.integrals(row[np.newaxis])[0]) if best is None else best, 1.0
        for _ in range(rounds):
            kds = np.unique(np.maximum(row[0] + widths[0] * SIDES, 0.0))
            parts = []
            for kd in kds.tolist():
                shares = np.unique(np.minimum(share + widths[2] * SIDES, 1.0))
                parts.append(self._below(self._plane(kd), kd, row[1] + widths[1] * SIDES, shares))
            rows = np.concatenate(parts)
            if rows.size:
                values = self.integrals(rows)
                at = int(values.argmin())
                if values[at] < best:
                    moved = np.abs(rows[at, :2] - row[:2]) > 0.9 * widths[:2]
                    row, best = rows[at], float(values[at])
                    share = min(1.0, float(row[2] / highest_gains(self._plane(row[0]), row[1:2])[0][0]))
                    widths = widths * np.where([*moved, False], 1.0, SHRINK)
                    continue
            widths = SHRINK * widths
        return row, best


def least_error(
    process: Process, limits: tuple[float, float], derivative: DerivativeAction, gains: GainOptimum
) -> tuple[DerivativeAction, GainOptimum]:
    """The gains with the least integral of |e|; those of the largest ki if none are better."""
    search = ErrorSearch.of(process, limits, derivative, gains)
    found = _within_limits(search)
    old, new = (absolute_error(process, *law_polynomials(g.k, g.ki, d)).value for d, g in ((derivative, gains), found))
    return found if new < old else (derivative, gains)


def _within_limits(search: ErrorSearch) -> tuple[DerivativeAction, GainOptimum]:
    """The best gains; if they are beyond a limit between the frequencies of the search, those of tighter limits."""
    row = search.best()
    for tightness in TIGHTER:
        inner = replace(search, Ms=_tightened(search.Ms, tightness), Mt=_tightened(search.Mt, tightness))
        row = inner.settle(row)
        kd, k, ki = (float(x) for x in row)
        problem = IntegralGain(search.process, search.Ms, search.Mt, DerivativeAction(kd, search.N))
        equations = ContactEquations(problem.plane(FINE, search.reach), problem.derivative)
        if worst_contact(equations, k, ki)[0] >= 0 and is_stable(equations.plane, k, ki):
            contacts = contacts_of(equations, k, ki, TOUCHED)
            return problem.derivative, replace(search.gains, k=k, ki=ki, contacts=contacts)
    return DerivativeAction(search.kd, search.N), search.gains


def _tightened(limit: float, share: float) -> float:
    return 1 + (limit - 1) * (1 - share)
