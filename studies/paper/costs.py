"""The cost of a run in the scenarios of the paper's arm, and laws judged by it draw by draw."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

import workbench as wb
from studies.paper.scenarios import HELD_OUT, TERMS, Term, cost

Samples = Mapping[str, wb.study.Sample]  # by the names of laws
ACCEPTABLE = float(len(TERMS))  # a cost at which all terms are acceptable, or make up for each other
PRIMARY = wb.evidence.Mean()
OTHERS = (wb.evidence.Median(), wb.evidence.Quantile(0.9), wb.evidence.Tail(0.9), wb.evidence.Success(ACCEPTABLE))
MARGIN = 0.02  # of the smaller value: what is closer is no difference to an engineer, however sure
FAMILY = 0.95  # that all intervals of a measure hold at once, in all held-out scenarios
CONFIDENCE = 1 - (1 - FAMILY) / len(HELD_OUT)  # of those of one scenario (Bonferroni)
RESAMPLES, SEED = 4000, 88
WEIGHTS = {
    "error alone": (1.0, 1.0, 0.0, 0.0),
    "late error four times": (1.0, 4.0, 1.0, 1.0),
    "chattering four times": (1.0, 1.0, 4.0, 1.0),
    "effort four times": (1.0, 1.0, 1.0, 4.0),
    "late error alone": (0.0, 1.0, 0.0, 0.0),
    "chattering alone": (0.0, 0.0, 1.0, 0.0),
}


def cost_of(
    samples: Samples, terms: tuple[Term, ...] = TERMS, metric: str = "cost", unit: str = ""
) -> wb.evidence.PairedSamples:
    """The cost of each run; its error is the largest of the runs that were run again."""
    values = {law: cost(sample, terms) for law, sample in samples.items()}
    repeated = {
        law: np.sum([step_errors(s, t.metric) / t.acceptable for t in terms], axis=0) for law, s in samples.items()
    }
    errors = {law: float(np.max(off[~np.isnan(off)], initial=-np.inf)) for law, off in repeated.items()}
    errors = {law: off if off >= 0 else float("nan") for law, off in errors.items()}  # no run was run again
    return wb.evidence.pair_samples(
        values, metric=metric, unit=unit, errors=errors, samples=samples, step_errors=repeated
    )


def step_errors(sample: wb.study.Sample, metric: str) -> wb.Array:
    """The error of a metric of both joints by the step, (N,), NaN for a run that was not run again, or diverged."""
    found = sample.measurement
    places = [i for i, one in enumerate(found.columns) if one.metric == metric]
    off = np.hypot(*found.errors[:, -1, places].T)
    errors = np.full(len(sample), np.nan)
    errors[found.looked_at] = np.where(np.isnan(off), np.inf, off)  # half of the step failed, and the step did not
    return np.where(np.isnan(sample.diverged_at), errors, np.nan)


def weighted_cost(samples: Samples, weights: tuple[float, ...]) -> wb.evidence.PairedSamples:
    """The cost with other weights: a term that counts w times has 1 / w of its acceptable value."""
    terms = (replace(term, acceptable=term.acceptable / w) for term, w in zip(TERMS, weights, strict=True) if w)
    return cost_of(samples, tuple(terms))


def judge_laws(
    values: wb.evidence.PairedSamples,
    others: Sequence[wb.evidence.Median | wb.evidence.Quantile | wb.evidence.Tail | wb.evidence.Success] = OTHERS,
) -> wb.evidence.LawJudgement:
    """Laws by the mean and by all else, sure enough for verdicts over all scenarios."""
    return wb.evidence.judge(
        values, PRIMARY, others, confidence=CONFIDENCE, margin=MARGIN, resamples=RESAMPLES, seed=SEED
    )


def judge_means(values: wb.evidence.PairedSamples) -> wb.evidence.LawJudgement:
    """Laws by the mean alone."""
    return judge_laws(values, ())
