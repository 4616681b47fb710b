"""Samples of a7 whose outputs are sums of factors with given weights."""

from dataclasses import replace
from functools import cache

import numpy as np

from studies.a7_sensitivity.results import Derivatives, LawResults
from studies.a7_sensitivity.second_looks import Later
from studies.a7_sensitivity.sweeps import PROPOSED_LAW, free, metrics
from studies.paper.factors import factors
from tests.support.samples import made_sample, with_measurement
from workbench.study.uncertainty import Estimate, MonteCarlo, MorrisDesign, SobolDesign
from workbench.study.uncertainty.local_sensitivity import LocalSensitivities

T = 5
EVERY, SOME = ([factor.name for factor in of(PROPOSED_LAW)] for of in (factors, free))
DESIGNS = (EVERY, MorrisDesign(len(EVERY), 60)), (SOME, SobolDesign(len(SOME), 256, True)), (EVERY, MonteCarlo(19, 128))
EQUAL = SOME, SobolDesign(len(SOME), 128)


def sampled(names, design, weights, joint_weights):
    """Runs whose metrics are 1 + 0.01 w . (u - 1/2), by metric and factor."""
    u = design.points() - 0.5
    columns, values = [], []
    for metric in [*(metric.name for metric in metrics(PROPOSED_LAW)), "ISE"]:
        for joint, chosen in enumerate((weights, joint_weights)):
            w = np.array([chosen.get(metric, {}).get(name, 0.1) for name in names])
            columns.append((metric, joint, "rad"))
            values.append(0.1 * (1 + 0.01 * u @ w))
    grown = np.stack(values, axis=1)[:, np.newaxis] * np.linspace(1 / T, 1, T)[:, np.newaxis]
    again = np.arange(0, len(u), 16)
    lost = np.full(len(u), np.nan)
    t, zeros, limits = np.arange(1.0, T + 1), np.zeros((len(again), T, len(columns))), np.full(len(again), np.inf)
    return made_sample(
        "made", tuple(names), tuple(columns), t, 1e-3, 0, "", u, grown, again, zeros, limits, lost, design
    )


def made(weights, joint_weights=None, equal=None):
    """A law whose metrics are linear in its factors; joint 2 and equal ranges have the same weights unless given."""
    samples = [sampled(*each, weights, joint_weights or weights) for each in DESIGNS]
    alike = sampled(*EQUAL, equal or weights, equal or joint_weights or weights)
    return LawResults(PROPOSED_LAW, *samples, None, alike)


def local(weights):
    """Derivatives of the RMSE by the factors, all of one range, which are the slopes of the runs."""
    w = np.array([[weights.get(name, 0.1) for name in SOME]] * 2)
    at, ones = np.ones(len(SOME)), {"RMSE": np.ones(2)}
    found = LocalSensitivities(tuple(SOME), at, ones, {"RMSE": w}, {"RMSE": w}, {"RMSE": w}, ())
    return Derivatives(tuple(SOME), found, np.eye(len(SOME)), np.full(len(SOME), 0.1))


NO_RUNS = Later(np.zeros((4, 2)))


@cache
def usual():
    return made({"RMSE": {"Q": 5.0, "m1": 3.0}})


def with_values(one, kind, change):
    """The same results with other values of a sample: `change` is given the column of the late error of joint 2."""
    sample = getattr(one, kind)
    values = sample.values.copy()
    change(values, sample.measurement.place("late error", 1))
    return replace(one, **{kind: with_measurement(sample, values=values)})


def widened(one, half=0.051):
    """The same results with wider intervals of the indices."""
    parts = {name: getattr(one.shares, name) for name in ("S1", "ST", "sums1", "sumsT")}
    wide = {name: Estimate(e.value, 0 * e.value + half) for name, e in parts.items()}
    other = replace(one)
    vars(other)["shares"] = replace(one.shares, **wide)
    return other
