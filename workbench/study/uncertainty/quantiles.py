"""Quantiles and shares over random runs, with intervals that hold for any distribution."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import bdtr, betaincinv

from workbench.core.validation.refusals import Array, Integers, refusal
from workbench.core.validation.signatures import check_arguments
from workbench.study.uncertainty.designs import LatinHypercube, MonteCarlo
from workbench.study.uncertainty.outputs import as_outputs, columns_of, t_quantile


@dataclass(frozen=True, eq=False)
@check_arguments
class Quantiles:
    """Quantiles (k, q) of k outputs at q levels, each within an interval.

    `failures` (k,) are the numbers of failed runs. If an output has some, its value is NaN; its interval holds whatever
    the outputs of these runs would have been. An end is infinite if there are too few runs to bound it.
    """

    names: tuple[str, ...]
    levels: tuple[float, ...]
    value: Array
    low: Array
    high: Array
    failures: Integers


@dataclass(frozen=True)
@check_arguments
class Share:
    """The share of all runs in which something holds, between `low` and `high`; its value is NaN if runs failed."""

    value: float
    low: float
    high: float
    runs: int
    failures: int


@check_arguments
def quantiles(
    design: MonteCarlo | LatinHypercube,
    outputs: object,
    names: Sequence[str] | None = None,
    *,
    levels: tuple[float, ...] = (0.05, 0.5, 0.95),
    confidence: float = 0.95,
) -> Quantiles:
    """Quantiles of every output over random runs, between order statistics that bound them by the binomial law.

        P(y_(l) <= quantile(p) <= y_(u)) >= confidence,  l and u from the binomial law of N runs and p

    The intervals need no assumption on the distribution (David and Nagaraja 2003, Order Statistics, section 7.1); for a
    Latin hypercube they are wider than necessary. `outputs` (N,) or (N, k) are in the order of the design's points. An
    output may be infinite. A NaN is a failed run, whose output could have been anything.

    Raises
    ------
    ValueError
        If an argument has the wrong kind or shape, or a level does not lie between 0 and 1.

    Examples
    --------
    >>> from workbench.study.uncertainty import MonteCarlo, quantiles
    >>> design = MonteCarlo(2, 40)
    >>> found = quantiles(design, design.points(), ("1 s", "2 s"))
    >>> wb.report.pictures.quantile_bands("bands", "Of 40", [1.0, 2.0], {"PID": found}, "40 runs", "error").name
    'bands'
    >>> quantiles(design, design.points(), ("a", "b"), levels=(0.1, 0.9), confidence=0.9).value.round(3)
    array([[0.15 , 0.846],
           [0.092, 0.883]])
    """
    held, columns = columns_of("quantiles", design, outputs, names)
    t_quantile("quantiles", confidence, 1)  # refuses what is no confidence
    if not levels or not all(0 < level < 1 for level in levels):
        raise refusal("quantiles(levels=...)", "numbers between 0 and 1, at least one", levels)
    ranks = np.array([_ranks(level, design.size, (1 - confidence) / 2) for level in levels])
    failed = np.isnan(columns).sum(axis=0)
    ordered = np.sort(columns, axis=0)  # failed runs come last
    # a failed run may lie below all others or above them
    low, high = (_ranked(ordered, ranks[:, i], failed, shift) for i, shift in ((0, True), (2, False)))
    value = np.where(failed[:, None] > 0, np.nan, _ranked(ordered, ranks[:, 1], failed, False))
    return Quantiles(held, levels, value, low, high, failed)


@check_arguments
def share(holds: object, confidence: float = 0.95) -> Share:
    """The share of independent runs in which something holds (Clopper and Pearson 1934, Biometrika 26).

    `holds` (N,) is 1 or True where it does, 0 or False where it does not, and NaN where the run failed.

    Raises
    ------
    ValueError
        If there is no run, or an entry is not one of these.

    Examples
    --------
    >>> from workbench.study.uncertainty import share
    >>> share([1.0, 0.0, 0.0, 1.0], 0.9)
    Share(value=0.5, low=0.0976115, high=0.902389, runs=4, failures=0)
    """
    flags = as_outputs(holds)
    if flags is None or flags.ndim != 1 or not flags.size or not (np.isnan(flags) | (flags == 0) | (flags == 1)).all():
        raise refusal("share(holds)", "one 0, 1 or NaN a run, at least one", holds)
    t_quantile("share", confidence, 1)
    tail, runs = (1 - confidence) / 2, len(flags)
    yes, failed = int(np.nansum(flags)), int(np.isnan(flags).sum())
    most = yes + failed
    low = float(betaincinv(yes, runs - yes + 1, tail)) if yes else 0.0
    high = float(betaincinv(most + 1, runs - most, 1 - tail)) if most < runs else 1.0
    return Share(float("nan") if failed else yes / runs, low, high, runs, failed)


def _ranks(level: float, runs: int, tail: float) -> tuple[int, int, int]:
    """The ranks, from 1, of the lower end, the quantile and the upper end; 0 and runs + 1 are not bounded."""
    below = bdtr(np.arange(runs + 1), runs, level)  # P(at most i runs lie below the quantile)
    low = int(np.searchsorted(below, tail, side="right"))  # the last rank l with P(fewer than l) <= tail
    high = int(np.searchsorted(below, 1 - tail)) + 1
    return low, max(1, int(np.ceil(level * runs))), high


def _ranked(ordered: Array, ranks: Integers, failed: Integers, below: bool) -> Array:
    """The outputs (k, q) of these ranks (q,), with the failed runs below all others or above them."""
    places = ranks[:, np.newaxis] - 1 - (failed if below else 0)
    there = np.clip(places, 0, len(ordered) - 1)
    values = np.take_along_axis(ordered, there, axis=0)
    values = np.where(places < 0, -np.inf, np.where(places >= len(ordered) - failed, np.inf, values))
    return np.asarray(values.T)
