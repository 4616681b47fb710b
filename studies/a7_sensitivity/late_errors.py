"""The late error of the proposed law: the part of the gains in its variance, and the few runs on which that rests."""

from collections.abc import Mapping

import numpy as np

from studies.a7_sensitivity.results import ROBUST, LawResults, interval, leaders, named, narrow, percent
from studies.a7_sensitivity.sweeps import HELD, LATE, PROPOSED, UNTIL, group_of, written
from workbench.study.document.document import Cell, Column, Finding, Table, Variation
from workbench.study.sample import Sample
from workbench.study.uncertainty import SobolIndices

FEW = 3  # leaders that a cell still names, and runs of a joint in the table
BODY = "the largest 1 % of the runs lowered to the rest"  # the runs without their tail
LITTLE = 0.1  # of a variance, a part that is little
EXACT = "Exact positions and velocities for the rivals, while AOSMC-RGS observes its own from positions"
OURS = "The law as repaired in a1, with its observer on exact positions and the true disturbance, filtered"
INDICES = "of a Sobol design with a quadratic control variate, intervals by the jackknife over its scrambles, 95 %"


def late_parts(ours: LawResults) -> dict[str, tuple[float, SobolIndices]]:
    """An upper bound of the part of the gains in the variance of the late error, as it is and with fewer heavy runs."""

    def bound(shares: SobolIndices) -> float:
        # what gains do together counts in the total index of each, so their sum bounds from above
        return max(float(shares[named("late error", joint)].of_group("gains", True).high) for joint in (0, 1))

    every = {"": ours.shares} | {words: ours.shares_by("late error", change) for words, change in ROBUST.items()}
    return {words: (bound(shares), shares) for words, shares in every.items()}


def late_error_of(ours: LawResults) -> Finding:
    """The part of the variance of the late error that the gains have."""

    def said(part: float) -> str:
        return f"below {100 * LITTLE:g} %" if part < LITTLE else f"{100 * LITTLE:g} % or more"

    parts = late_parts(ours)
    high, shares = parts[""]
    body = parts[BODY][0]
    total = [shares[named("late error", joint)].of_group("gains", True) for joint in (0, 1)]
    kept = [factor for factor in HELD[PROPOSED] if group_of(factor) == "gains"]
    return Finding(
        "late_error",
        f"A few stray runs aside, gains explain at most {100 * body:.1f} % of the variance of the late error of "
        f"{PROPOSED} over these ranges.",
        f"The total indices of the gains sum to {interval(total[0], 3)} and {interval(total[1], 3)} at joints 1 and 2 "
        f"over all runs, which do not settle the share. {heaviest(ours.indices)} Intervals by the scrambles do not see "
        f"a tail that one run makes. Which number of arm or model has most, is {leading(parts)}.",
        statistic=f"The sum of ST over the gains, for the largest |e| from {LATE:g} to {UNTIL:g} s, {INDICES}.",
        sample=f"{len(ours.indices):,} runs of the first scenario. Gains that vary: {', '.join(ours.groups['gains'])}; "
        f"{', '.join(kept)} stay at their values, as the screening found little effect.",
        given=OURS,
        chosen="The ranges: links and masses of arm and model 10 % off either way, independently of each other.",
        answer=said(high),
        variations=tuple(
            Variation(words, said(part), f"at most {100 * part:.1f} %") for words, (part, _) in parts.items() if words
        ),
        untried="A better model: the smaller its errors, the larger the part of the gains.",
        settled=narrow(*total, *(shares[named("late error", joint)].ST for joint in (0, 1))),
    )


def leading(parts: Mapping[str, tuple[float, SobolIndices]]) -> str:
    """The factors with the largest total index of the late error, by joint: the same in all readings, or open."""
    found = {
        joint: {leaders(shares.factors, shares[named("late error", joint)].ST)[0] for _, shares in parts.values()}
        for joint in (0, 1)
    }
    words = [f"{' or '.join(sorted(names))} at joint {joint + 1}" for joint, names in found.items()]
    alike = all(len(names) == 1 for names in found.values())
    return f"{', '.join(words)}{'' if alike else ', as a few runs decide: open'}"


def heaviest(sample: Sample) -> str:
    """The part of the variance of the late error that the largest runs have, at the joint where one has most."""
    values = np.stack([sample.score("late error", joint).value for joint in (0, 1)])
    squares = (values - values.mean(axis=1, keepdims=True)) ** 2
    part = squares.max(axis=1) / squares.sum(axis=1)
    joint = int(part.argmax())
    second, first = np.sort(values[joint])[-2:]
    few = np.sort(squares[joint])[-max(1, len(sample) // 100) :].sum() / squares[joint].sum()
    return (
        f"One of {len(sample):,} runs has {percent(part[joint])} of the variance at joint {joint + 1} "
        f"({first:.2f} rad; the next is {second:.2f}), and the heaviest 1 % of them {percent(few)}."
    )


def heavy_table(sample: Sample) -> Table:
    """The runs on which the variance of the late error rests most, with the links of arm and model."""
    names = [name for name in ("l1", "l2", "model l1", "model l2") if name in sample.factors]
    rows: list[tuple[Cell, ...]] = []
    for joint in (0, 1):
        values = sample.score("late error", joint).value
        squares = (values - values.mean()) ** 2
        for run in np.argsort(-squares)[:FEW].tolist():
            links = (f"{sample.drawn[run, sample.factors.index(name)]:.3f}" for name in names)
            share = f"{100 * squares[run] / squares.sum():.2g}"
            rows.append((joint + 1, f"{run + 1:,}", f"{values[run]:.2f}", share, *links))
    heads = ("joint", "run", "late error [rad]", "part of the variance [%]")
    return Table(
        "heavy",
        f"The runs of {PROPOSED} with the largest parts in the variance of the late error, and the links of the arm "
        "and of the model there, as shares of their values.",
        (*(Column(head, align="right") for head in heads), *(Column(written(name), align="right") for name in names)),
        tuple(rows),
    )
