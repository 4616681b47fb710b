"""Draws of the choices that the paper leaves open, with the errors of given runs."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np

from studies.a6_unstated_choices import draws, fits, loops, rows, shares
from studies.paper.card import LAWS
from tests.support.samples import made_sample


def sampled(t, values):
    """Runs with these values (N, T, 2) of RMSE."""
    columns = (("sampled RMSE", 0, "rad"), ("sampled RMSE", 1, "rad"))
    runs = len(values)
    lost = np.where(np.isnan(values).any(axis=(1, 2)), 1.0, np.nan)
    none = np.empty(0, dtype=int)
    return made_sample(
        "x", (), columns, t, 1e-3, 0, "", np.empty((runs, 0)), values, none, np.empty((0, len(t), 2)), np.empty(0), lost
    )


def made(part, runs=400):
    """Draws in which the proposed law is first in a part of them, and last in the others."""
    rmse = np.tile(np.arange(2.0, 2.0 + len(LAWS)), (runs, 1))
    rmse[:, 0] = np.where(np.arange(runs) < part * runs, 1.0, 9.0)
    return shares.Draws(rmse, np.random.default_rng(0).random((runs, len(loops.NAMES))))


def everywhere(*parts):
    """These draws in all columns, under a prior each, from the first prior on; the last of them under all others."""
    every = zip(draws.PRIORS, [*parts, *[parts[-1]] * len(draws.PRIORS)], strict=False)
    return {(name, column): made(part) for name, part in every for column in shares.COLUMNS}


def again(every, error=0.0):
    """Every draw run at half of the step too, with this error."""
    return {cell: shares.Rerun(one, np.full(len(one.rmse), error)) for cell, one in every.items()}


def fitted(miss):
    """Fits of each law to each target with this miss."""
    numbers = {law: np.array([one.distribution.high for one in loops.factors_of(law, "SS")]) for law in LAWS}
    both = dict.fromkeys(loops.SCENARIOS, np.full(2, 0.3))
    one = fits.Fit(np.empty(0), dict.fromkeys(both, 20.0), both, both, miss, 0, 2)
    return {(law, target): replace(one, numbers=numbers[law]) for law in LAWS for target in fits.TARGETS}


def common_searches(miss=0.5):
    """The searches at one horizon and the searches for one row, with runs that are off by this part."""
    printed = {law: np.array([fits.PUBLISHED_COLUMNS["FS", joint].values[law] for joint in (1, 2)]) for law in LAWS}
    t = np.arange(1.0, loops.LONGEST + 1)

    def tuned(name):
        law = next((law for law in LAWS if name.startswith(loops.slug("common", law))), loops.PROPOSED_LAW)
        values = (1 + miss) * np.broadcast_to(printed[law], (1, len(t), 2))
        return SimpleNamespace(samples={"fs": sampled(t, values)})

    return SimpleNamespace(tuning=tuned)


def row(sign, shape, miss):
    """The nearest of a search, with the readings that the search does not vary, and the first of all others."""
    numbers = [factor.distribution.quantile(np.array([0.01]))[0] for factor in rows.factors(sign, shape)]
    fit = fits.Fit(np.array(numbers), {"FS": 40.0}, {}, {}, miss, 0, 1)
    return rows.Row(sign, shape, fit)
