"""Exact derivatives of the metrics of a7 at the numbers of the card, factor by factor."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from studies.a7_sensitivity.sweeps import METRICS, STEPS, UNTIL, free, loop
from workbench.core import Ode
from workbench.study.uncertainty.factors import Factor
from workbench.study.uncertainty.local import LocalSensitivities, local_sensitivities
from workbench.validation.refusals import Array


@dataclass(frozen=True, eq=False)
class Local:
    """Derivatives at the numbers of the card with respect to d factors that are shares of m numbers.

    Attributes
    ----------
    moves
        (d, m): by how much a factor moves each number, where it rises by its whole value.
    deviations
        (d,), the standard deviations of the factors.
    """

    factors: tuple[str, ...]
    found: LocalSensitivities
    moves: Array
    deviations: Array

    def elasticities(self, metric: str, joint: int) -> tuple[Array, Array, Array]:
        """By how many percent a metric changes by each percent of a factor, (d,) each.

        By the gradient, and by runs over 0.01 % and over 1 % of each number.
        """
        found = self.found
        value = found.value[metric][joint]
        kinds = (held[metric][joint] for held in (found.gradient, found.slope, found.wide_slope))
        first, second, third = (self.moves @ kind / value for kind in kinds)
        return first, second, third

    def shares(self, metric: str, joint: int) -> Array:
        """The parts of the variance (d,) if the metric were linear."""
        return np.asarray(self.found.linear_shares(metric, self.deviations[:, np.newaxis] * self.moves)[joint])

    def held(self, metric: str) -> tuple[int, int]:
        """For how many derivatives of a metric, of how many, the gradient is the slope of the runs."""
        holds = self.found.holds(metric)
        return int(holds.sum()), holds.size


def local(law: str) -> Local:
    """The derivatives of a law with respect to the factors of its Sobol indices."""
    ode, moved = loop(law).ode(), free(law)
    labels = [numbers_of(ode, factor) for factor in moved]
    names = [name for some in labels for name in some]
    found = local_sensitivities(ode, METRICS, names, until=UNTIL, h=STEPS[law])
    moves = np.array([np.where(np.isin(found.labels, some), found.at, 0.0) for some in labels])
    return Local(tuple(factor.name for factor in moved), found, moves, np.array([deviation(f) for f in moved]))


def numbers_of(ode: Ode, factor: Factor) -> Sequence[str]:
    """The numbers of a loop that a share of them moves: not the zeros of a matrix."""
    found = []
    for path in factor.paths:
        layout = ode.parameters if path in ode.parameters else ode.states
        found += [layout.labels[i] for i in layout.indices(path) if layout.default[i] != 0]
    return found


def deviation(factor: Factor, cells: int = 4000) -> float:
    """The standard deviation of a factor, from the middles of cells of its unit interval."""
    return float(factor.distribution.quantile((np.arange(cells) + 0.5) / cells).std())
