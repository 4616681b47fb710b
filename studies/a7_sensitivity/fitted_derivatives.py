"""The exact derivatives of a law where some factors are directions of a fit, which move several numbers together."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

import workbench as wb
from studies.a7_sensitivity.results import Derivatives, numbers_of
from studies.a7_sensitivity.sweeps import METRICS, STEPS, UNTIL, equal_ranges, free, loop
from studies.paper.fitted_arm import FIT


def derivatives_of_fit(law: str) -> Derivatives:
    """The derivatives of a law with respect to factors of which some are directions of a fit."""
    ode, some_factors = loop(law).ode(), free(law)
    labels = [factor.paths if factor.direction else tuple(numbers_of(ode, factor)) for factor in some_factors]
    names = list(dict.fromkeys(name for some in labels for name in some))
    found = wb.uncertainty.local_sensitivities(ode, METRICS, names, until=UNTIL, h=STEPS[law])
    moves = np.zeros((len(some_factors), len(found.labels)))
    for row, factor, some in zip(moves, some_factors, labels, strict=True):
        at = [found.labels.index(name) for name in some]
        row[at] = factor.direction.changes if factor.direction else found.at[at]
    return Derivatives(tuple(factor.name for factor in some_factors), found, moves, deviations_of(some_factors))


def deviations_of(some_factors: Sequence[wb.Factor]) -> wb.Array:
    """The standard deviations (d,) of factors."""
    u = (np.arange(4000) + 0.5) / 4000
    return np.array([factor.distribution.quantile(u).std() for factor in some_factors])


def with_equal_ranges(law: str, near: Derivatives) -> Derivatives:
    """The derivatives with the same relative range for every factor that is a share."""
    return near.equal if FIT is None else replace(near, deviations=deviations_of(equal_ranges(law)))
