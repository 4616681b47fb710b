from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

import workbench as wb
from workbench.core import layout
from workbench.study import evidence
from workbench.study import uncertainty as sensitivity
from workbench.study.uncertainty import LatinHypercube, Listed, MonteCarlo, MorrisDesign, OneAtATime, SobolDesign

from .study import sample

MODULES = ("workbench.study.uncertainty", "workbench.study.evidence")
RANDOM, PATHS, PAIRS, ALONE = MonteCarlo(2, 40), MorrisDesign(2, 8), SobolDesign(2, 16, True), OneAtATime(2)
NAMES, FACTORS = ("a", "b"), ("k", "m")


def outputs(design: Any) -> Any:
    """Two outputs that both factors move."""
    u, v = design.points().T
    return np.stack([u + 2 * v, u * v], axis=1)


EFFECTS = sensitivity.morris(PATHS, outputs(PATHS), NAMES, factors=FACTORS)
INDICES = sensitivity.sobol(PAIRS, outputs(PAIRS), NAMES, factors=FACTORS)
QUANTILES = sensitivity.quantiles(RANDOM, outputs(RANDOM), NAMES)
TORNADO = sensitivity.tornado(ALONE, outputs(ALONE), NAMES, factors=FACTORS)
PAIRED = evidence.paired(dict(zip(NAMES, outputs(RANDOM).T, strict=True)), metric="error", unit="rad")
COMPARISON = evidence.compare(PAIRED, resamples=100)
JUDGEMENT = evidence.judge(PAIRED, evidence.Mean(), (evidence.Median(),), resamples=100)


def motor_law(gain: float) -> Any:
    """The loop of a motor at a gain."""
    law = wb.PID2(wb.DCMotor().outputs, wb.DCMotor().inputs, Kp=gain, Ki=2.0 * gain)
    return wb.ClosedLoop(wb.DCMotor(), controller=law, reference=wb.Hold([1.0], "omega", "rad/s"))


LIMITS = evidence.LoopLimits(motor_law, lambda gain: (wb.rmse(),), {"RMSE": 0.9}, 0.1, 1e-2)


def mean_of(values: evidence.Paired) -> evidence.Judgement:
    """A judgement by the mean alone."""
    return evidence.judge(values, evidence.Mean(), resamples=100)


def of_computers() -> dict[str, Any]:
    """Calls of the margins of a loop for the imperfections of its computer."""
    loop = motor_law(10.0).digital(0.01).disturbed()
    effects = evidence.computer_effects(loop, 1e-3, 0.1)
    run = wb.Run(loop, (wb.rmse(),), until=0.1)
    return {
        "ComputerEffect": partial(evidence.ComputerEffect, "jitter", ("computer.jitter",), (1e-3,), 1e-3, "s", 0.0),
        "ComputerMargin": evidence.ComputerMargin,
        "ComputerMargins": evidence.ComputerMargins,
        "computer_effects": partial(evidence.computer_effects, loop, 1e-3, 0.1),
        "computer_margins": evidence.computer_margins,
        "computer_sweep": partial(evidence.computer_sweep, "motor", run, effects, (), 2),
        "computer_table": evidence.computer_table,
        "worst_ratio": partial(evidence.worst_ratio, np.ones((2, 2)), np.ones((2, 2))),
        "Causes": partial(evidence.Causes, {"fine": np.array([0, 1])}),
        "causes_in_sweep": evidence.causes_in_sweep,
        "order": partial(evidence.order, (1.0, 0.1), (2.0, 0.1), 0.02),
    }


def calls() -> dict[str, Any]:
    two, flat = np.ones(2), np.ones((2, 2))
    level, square = evidence.Intervals(two, two, two), evidence.Intervals(flat, flat, flat)
    part = sensitivity.Estimate(flat, flat)
    told = {"a": outputs(RANDOM)[:, 0], "b": outputs(RANDOM)[:, 1]}
    return {
        "Factor": partial(sensitivity.Factor, "k", ("k",), sensitivity.Uniform(0.5, 4.0), "stated", True),
        "LogNormal": partial(sensitivity.LogNormal, 1.0, 0.5, 0.1, 4.0),
        "LogUniform": partial(sensitivity.LogUniform, 0.5, 4.0),
        "Normal": partial(sensitivity.Normal, 1.0, 0.5, 0.1, 4.0),
        "Space": partial(sensitivity.Space, (), layout(k="1/s"), layout(x="m")),
        "Triangular": partial(sensitivity.Triangular, 0.5, 1.0, 4.0),
        "Uniform": partial(sensitivity.Uniform, 0.5, 4.0),
        "factor_table": partial(
            sensitivity.factor_table, sensitivity.Space((), layout(k="1/s"), layout(x="m")), "drawn", "What is drawn."
        ),
        **of_computers(),
        "AbstractDesign": RANDOM,
        "AbstractDistribution": sensitivity.AbstractDistribution,
        "local_sensitivities": sensitivity.local_sensitivities,
        "LatinHypercube": partial(LatinHypercube, 2, 24, 3),
        "Listed": partial(Listed, [[0.5, 0.25], [0.0, 1.0]]),
        "MonteCarlo": partial(MonteCarlo, 2, 24, 3),
        "MorrisDesign": partial(MorrisDesign, 2, 8, 4, 3),
        "OneAtATime": partial(OneAtATime, 2, (0.05, 0.95), 0.5),
        "SobolDesign": partial(SobolDesign, 2, 16, True, 3),
        "Comparison": partial(evidence.Comparison, PAIRED, evidence.Mean(), 0.95, level, square, 0.02),
        "Estimate": partial(sensitivity.Estimate, [1.0, 2.0], [0.1, 0.2]),
        "Intervals": partial(evidence.Intervals, two, two, two),
        "Judgement": partial(evidence.Judgement, {"mean": JUDGEMENT.by["mean"]}),
        "LargestSetting": partial(
            evidence.LargestSetting, evidence.Threshold((1.0,), (True,)), ((evidence.LoopTrial({}, {}),),)
        ),
        "LoopLimits": partial(evidence.LoopLimits, motor_law, lambda gain: (wb.rmse(),), {"RMSE": 0.9}, 0.1, 1e-2, 1),
        "LoopTrial": partial(evidence.LoopTrial, {"RMSE": np.ones(1)}, {"RMSE": np.ones(1)}),
        "largest_setting": partial(evidence.largest_setting, LIMITS, (1.0, 2.0), ratio=1.5, between=None, patience=2),
        "Mean": evidence.Mean,
        "Median": evidence.Median,
        "MorrisEffects": partial(sensitivity.MorrisEffects, NAMES, FACTORS, part, part, part, {}, ()),
        "Paired": partial(evidence.Paired, "error", "rad", NAMES, flat, two, [0, 1], "a note"),
        "Quantile": partial(evidence.Quantile, 0.6),
        "Quantiles": partial(sensitivity.Quantiles, NAMES, (0.1, 0.9), flat, flat, flat, [0, 1]),
        "Ranks": partial(evidence.Ranks, PAIRED, 0.95, square, square),
        "Share": partial(sensitivity.Share, 0.5, 0.25, 0.75, 20, 0),
        "SobolIndices": partial(
            sensitivity.SobolIndices,
            NAMES,
            FACTORS,
            part,
            part,
            sensitivity.Estimate([[0.1], [0.2]], [[0.1], [0.2]]),
            two,
            {},
            ("a remark",),
        ),
        "Standings": partial(evidence.Standings, {"paper": JUDGEMENT}),
        "Success": partial(evidence.Success, 1.0),
        "Tail": partial(evidence.Tail, 0.6),
        "Threshold": partial(evidence.Threshold, (1.0, 2.0), (True, False)),
        "Tornado": partial(sensitivity.Tornado, NAMES, FACTORS, (0.1, 0.9), two, np.ones((2, 2, 2)), {}),
        "Pooled": partial(evidence.Pooled, "geometric mean", {"s": PAIRED}, JUDGEMENT, {"s": JUDGEMENT}),
        "pool": partial(evidence.pool, {"s": PAIRED}, "arithmetic mean"),
        "leave_one_out": partial(evidence.leave_one_out, {"s": PAIRED, "t": PAIRED}, mean_of, "arithmetic mean"),
        "change_without": partial(evidence.change_without, COMPARISON, "b", "a"),
        "level_of": partial(evidence.level_of, COMPARISON, "a"),
        "ablation_table": partial(evidence.ablation_table, "t", "c", (COMPARISON,), "a", ("a note",)),
        "bisect": partial(evidence.bisect, lambda x: x < 1.5, 1.0, 2.0, ratio=1.1, between=None),
        "find_largest": partial(
            evidence.find_largest, lambda x: x < 1.5, (1.0, 2.0), ratio=1.1, between=None, patience=2
        ),
        "compare": partial(
            evidence.compare, PAIRED, evidence.Tail(0.6), confidence=0.9, margin=0.02, resamples=100, seed=1
        ),
        "comparison_table": partial(evidence.comparison_table, "t", "c", (COMPARISON,), ("a note",)),
        "judge": partial(
            evidence.judge,
            PAIRED,
            evidence.Success(1.0),
            (evidence.Mean(),),
            confidence=0.9,
            margin=0.02,
            resamples=100,
            seed=1,
        ),
        "morris": partial(
            sensitivity.morris,
            PATHS,
            outputs(PATHS),
            NAMES,
            factors=FACTORS,
            errors=1e-6 * outputs(PATHS),
            confidence=0.9,
        ),
        "paired": partial(evidence.paired, told, metric="error", unit="rad", errors={"a": 0.1, "b": 0.0}, note="n"),
        "quantiles": partial(sensitivity.quantiles, RANDOM, outputs(RANDOM), NAMES, levels=(0.1, 0.9), confidence=0.9),
        "ranks": partial(evidence.ranks, PAIRED, 0.9),
        "same_draws": partial(evidence.same_draws, {"a": sample(), "b": sample()}),
        "share": partial(sensitivity.share, [1.0, 0.0, np.nan], 0.9),
        "sobol": partial(
            sensitivity.sobol,
            PAIRS,
            outputs(PAIRS),
            NAMES,
            factors=FACTORS,
            errors=1e-6 * outputs(PAIRS),
            confidence=0.9,
        ),
        "least_base": partial(sensitivity.least_base, 12, True),
        "least_draws": partial(evidence.least_draws, (evidence.Mean(), evidence.Tail(0.9))),
        "statistics_table": partial(evidence.statistics_table, "t", "c", JUDGEMENT, ("a note",)),
        "tornado": partial(sensitivity.tornado, ALONE, outputs(ALONE), NAMES, factors=FACTORS),
    }


def arguments() -> dict[str, Any]:
    return {"law": lambda thing: "a", "a": lambda thing: "a", "b": lambda thing: "b"}
