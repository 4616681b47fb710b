"""The late error of the proposed law: the part of the gains in its variance, and the few runs on which that rests."""

from collections.abc import Mapping

import numpy as np

import workbench as wb
from studies.a7_sensitivity.results import ROBUST, LawResults, interval, leaders, narrow, output_name, percent
from studies.a7_sensitivity.second_looks import Later, heaviest_run, late_errors_of, redrawn_words
from studies.a7_sensitivity.sweeps import HELD_FACTORS, LATE, PROPOSED_LAW, UNTIL
from studies.paper.factors import factor_phrase, group_of
from studies.paper.fitted_arm import FIT

FEW = 3  # leaders that a cell still names, and runs of a joint in the table
BODY = "the largest 1 % of the runs lowered to the rest"  # the runs without their tail
LITTLE = 0.1  # of a variance, a part that is little
EXACT = "The rivals have exact positions and velocities; AOSMC-RGS estimates its velocities from exact positions"
OURS = "The law as repaired in report a1. Its observer has exact positions and the filtered true disturbance."
RANGES = (
    "The ranges: links and masses of arm and model vary by 10 % up and down, independently of each other."
    if FIT is None
    else "The ranges: the arm varies as its fit says, and links and masses of the model vary by 10 % up and down."
)
INDICES = (
    "from a Sobol design with a quadratic control variate, with 95 % intervals by the jackknife over its scrambles"
)


def late_parts(ours: LawResults) -> dict[str, tuple[float, wb.uncertainty.SobolIndices]]:
    """An upper bound of the part of the gains in the variance of the late error, as it is and with fewer heavy runs."""

    def bound(shares: wb.uncertainty.SobolIndices) -> float:
        # what gains do together counts in the total index of each, so their sum bounds from above
        return max(float(shares[output_name("late error", joint)].of_group("gains", True).high) for joint in (0, 1))

    every = {"": ours.shares} | {words: ours.shares_by("late error", change) for words, change in ROBUST.items()}
    return {words: (bound(shares), shares) for words, shares in every.items()}


def late_error_of(ours: LawResults, redraws: Later) -> wb.Finding:
    """The part of the variance of the late error that the gains have."""

    def answer_for(part: float) -> str:
        return f"below {100 * LITTLE:g} %" if part < LITTLE else f"{100 * LITTLE:g} % or more"

    parts = late_parts(ours)
    high, shares = parts[""]
    body = parts[BODY][0]
    total = [shares[output_name("late error", joint)].of_group("gains", True) for joint in (0, 1)]
    settled = narrow(*total, *(shares[output_name("late error", joint)].ST for joint in (0, 1)))
    kept = [factor for factor in HELD_FACTORS[PROPOSED_LAW] if group_of(factor) == "gains"]
    return wb.Finding(
        "late_error",
        f"Apart from the few runs with the largest late error, the gains of {PROPOSED_LAW} cause at most "
        f"{100 * body:.1f} % of the variance of its late error over these ranges."
        f"{'' if settled else ' With these runs included, the part of the gains is open.'}",
        f"{heaviest(ours.indices)} {redrawn_words(ours, redraws)} {beside(ours)} Over all "
        f"runs the total indices of the gains sum to {interval(total[0], 3)} and {interval(total[1], 3)} at joints 1 "
        f"and 2. {leading_factors(parts)}",
        statistic=f"The sum of ST over the gains, for the largest |e| from {LATE:g} to {UNTIL:g} s, {INDICES}.",
        sample=f"{len(ours.indices):,} runs of the first scenario. Gains that vary: {', '.join(ours.groups['gains'])}; "
        f"{', '.join(kept)} stay at their values, as the screening found little effect.",
        information=OURS,
        assumptions=RANGES,
        answer=answer_for(high),
        variations=tuple(
            wb.Variation(words, answer_for(part), f"at most {100 * part:.1f} %")
            for words, (part, _) in parts.items()
            if words
        ),
        limitations="A better model: the smaller its errors, the larger the part of the gains.",
        is_decided=settled,
    )


def leading_factors(parts: Mapping[str, tuple[float, wb.uncertainty.SobolIndices]]) -> str:
    """The factors with the largest total index of the late error, by joint: the same in all readings, or open."""
    found = {
        joint: {leaders(shares.factors, shares[output_name("late error", joint)].ST)[0] for _, shares in parts.values()}
        for joint in (0, 1)
    }
    words = " and ".join(f"{' or '.join(sorted(names))} at joint {joint + 1}" for joint, names in found.items())
    if all(len(names) == 1 for names in found.values()):
        return f"However these runs count, {words} has the largest total index."
    return f"Depending on how these runs count, the largest total index belongs to {words}: this is also open."


def heaviest(sample: wb.study.Sample) -> str:
    """The part of the variance of the late error that the largest runs have, at the joint where one has most."""
    values = late_errors_of(sample).T
    squares = (values - values.mean(axis=1, keepdims=True)) ** 2
    part = squares.max(axis=1) / squares.sum(axis=1)
    run, joint = heaviest_run(sample)
    second, first = np.sort(values[joint])[-2:]
    few = np.sort(squares[joint])[-max(1, len(sample) // 100) :].sum() / squares[joint].sum()
    return (
        f"Run {run + 1:,} of {len(sample):,} causes {percent(part[joint])} of the variance at joint {joint + 1} "
        f"({first:.2f} rad; the next largest is {second:.2f} rad); the heaviest 1 % of the runs cause {percent(few)}."
    )


def beside(ours: LawResults) -> str:
    """The number of runs that differ from the heaviest one in a single gain, which total indices of gains compare."""
    sample, gains = ours.indices, ours.groups["gains"]
    apart = sample.factor_values != sample.factor_values[heaviest_run(sample)[0]]
    of_gains = apart[:, [sample.factors.index(name) for name in gains]]
    count = int(((apart.sum(axis=1) == 1) & of_gains.any(axis=1)).sum())
    if count:
        return f"{count} other runs of the design differ from that run in only one gain."
    return "No other run of the design differs from that run in only one gain, so the indices of the gains miss it."


def heavy_table(sample: wb.study.Sample) -> wb.document.ReportTable:
    """The runs on which the variance of the late error rests most, with the links of arm and model."""
    names = [name for name in ("l1", "l2", "model l1", "model l2") if name in sample.factors]
    rows: list[tuple[wb.document.Cell, ...]] = []
    for joint in (0, 1):
        values = sample.score("late error", joint).value
        squares = (values - values.mean()) ** 2
        for run in np.argsort(-squares)[:FEW].tolist():
            links = (f"{sample.factor_values[run, sample.factors.index(name)]:.3f}" for name in names)
            share = f"{100 * squares[run] / squares.sum():.2g}"
            rows.append((joint + 1, f"{run + 1:,}", f"{values[run]:.2f}", share, *links))
    heads = ("joint", "run", "late error [rad]", "part of the variance [%]")
    return wb.document.ReportTable(
        "heavy",
        f"The runs of {PROPOSED_LAW} with the largest parts of the variance of the late error. The lengths of the "
        "links of the arm and of the law's model are given as shares of their values on the card.",
        (
            *(wb.document.TableColumn(head, align="right") for head in heads),
            *(wb.document.TableColumn(factor_phrase(name), align="right") for name in names),
        ),
        tuple(rows),
    )
