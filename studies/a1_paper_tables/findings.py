"""The findings of a1: the law as printed, its repairs, the printed row that they meet, and the order of the laws."""

from collections.abc import Iterable, Iterator

import numpy as np

import workbench as wb
from studies.a1_paper_tables import grid, pairs, repairs, row
from studies.a1_paper_tables.repairs import (
    ALL_FOUR,
    AS_PRINTED,
    FREE,
    NEAR,
    ONE_CHANGE,
    PAIRS,
    SHORT,
    SLIPS,
    SMALL,
    SMALL_Q,
    TRACKING,
    WITH_ORACLE,
    late,
    tracks,
)
from studies.a1_paper_tables.row import CLOSE, FITTED_WEIGHTS, HALF_DIGIT, WITNESS, multiple, nearest
from studies.paper.card import CARD, PROPOSED_LAW, PUBLISHED_COLUMNS
from studies.paper.comparison import LATE
from studies.paper.unstated_choices import assumptions, choices_of, names, omitted_choices

INFORMATION = "Positions, the exact model and, by (24), the true disturbance."
OURS = choices_of(PROPOSED_LAW, "FS")
# The choices that the runs of this page vary, in this finding or in another one.
VARIED_CHOICES = (
    "sign of (33)",
    "velocity in (28)",
    "D_hat of (24)",
    "C of (3)",
    "shape of (33)",
    "Q",
    "R",
    "horizon of FS",
)
ASSUMPTIONS = assumptions(omitted_choices(VARIED_CHOICES, OURS))
LIMITATIONS = names(omitted_choices((*VARIED_CHOICES, "observer (10)", "D_hat in (10)"), OURS))
FIT_OF_CARD = CARD["FS: horizon"]


def _tracking(flag: bool) -> str:
    return "tracking" if flag else "no tracking"


def _errors(run: wb.study.Outcome) -> str:
    if run.diverged_at is not None:
        return f"diverges at {run.diverged_at:.2f} s"
    return "late errors {:.2g} and {:.2g} rad".format(*late(run))


def two_repair_runs(results: wb.Results) -> dict[tuple[str, float], wb.study.Outcome]:
    """The runs with (3) and (28) repaired alone, by the shape of (33) and Q, each once and with the longest horizon."""
    runs = {(run.case.law, Q): run for pair, Q in PAIRS.items() for run in results.scenario(pair)}
    for run in results.scenario(WITNESS):
        shape = run.case.law.partition(",")[0]
        runs.setdefault((shape, FITTED_WEIGHTS[shape][0]), run)
    return runs


def as_printed(results: wb.Results) -> wb.Finding:
    """The law as printed, over Q, R and the shapes of (33)."""
    errors, points = grid.late_errors(results), grid.points()
    runs = [run for name in (AS_PRINTED["FS"], SMALL_Q) for run in results.scenario(name)]
    least = min(*(float(each.min()) for each in errors.values()), *(max(late(run)) for run in runs))
    least = float(np.floor(10 * least) / 10)
    total = sum(map(len, errors.values()))  # the further runs repeat points of the grid, over other horizons
    lost, left = repairs.times_lost(results[AS_PRINTED["FS"], "outer"])
    best = dict(zip(points, np.min(list(errors.values()), axis=0), strict=True))
    variations = []
    for letter, part in (("Q", 0), ("R", 1)):
        for value in dict.fromkeys(point[part] for point in points):
            own = min(float(error) for point, error in best.items() if point[part] == value)
            variations.append(wb.Variation(f"{letter} = {value:g} I", _tracking(own <= NEAR), _least(own)))
    for shape, each in errors.items():
        own = min(float(each.min()), *(max(late(run)) for run in runs if run.case.law == shape))
        variations.append(wb.Variation(f"shape '{shape}' alone", _tracking(own <= NEAR), _least(own)))
    second = results.scenario(AS_PRINTED["SS"])
    variations.append(
        wb.Variation("second scenario, Q = R = I", _tracking(any(map(tracks, second))), _least(_worst(second)))
    )
    variations += [
        wb.Variation(
            f"observer (10) out of the loop, shape '{shape}', Q = {SMALL:g} I, R = {repairs.SMALL_R:g} I",
            _tracking(tracks(run)),
            _errors(run),
        )
        for shape, run in zip(errors, results.scenario(repairs.WITHOUT_OBSERVER), strict=True)
    ]
    return wb.Finding(
        "as_printed",
        f"As printed, with observer (10), the law does not track the first scenario at any of {total} choices of Q, R "
        f"and the shape of (33): the late error of its worse joint is {least:g} rad or more.",
        f"With Q = R = I and the shape 'outer' of (33), K is no longer positive definite at {lost} s, and an error "
        f"exceeds {repairs.FAR:g} rad at {left} s.",
        statistic=f"{TRACKING} A run that diverges does not track.",
        sample=f"One run of {grid.UNTIL:g} s without noise for each shape of (33) and each point of a grid: Q from "
        f"{grid.Q.low:g} I to {grid.Q.high:g} I, R from {grid.R.low:g} I to {grid.R.high:g} I. Further runs: with "
        f"Q = R = I over {SHORT:g} s, and with Q = {SMALL:g} I over {repairs.LONG:g} s.",
        information=INFORMATION,
        assumptions=ASSUMPTIONS,
        answer=_tracking(least <= NEAR),
        variations=tuple(variations),
        limitations=LIMITATIONS,
    )


def _worst(runs: Iterable[wb.study.Outcome]) -> float:
    return min(max(late(run)) for run in runs)


def _least(error: float) -> str:
    return f"late error {error:.3g} rad" if np.isfinite(error) else "every run diverges"


def two_repairs(results: wb.Results) -> wb.Finding:
    """The law with (3) and (28) repaired alone."""
    runs = two_repair_runs(results)
    kept = [run for run in runs.values() if tracks(run)]
    worst = [max(late(run)[joint] for run in kept) if kept else np.inf for joint in (0, 1)]
    lost = " and ".join(f"shape '{shape}', Q = {multiple(Q)}" for (shape, Q), run in runs.items() if not tracks(run))
    minus = results[ONE_CHANGE, SLIPS["(33)"]]
    fitted = f"(24) repaired too, Q = {CARD['Q'][0, 0]:g} I, R = {CARD['R'][0, 0]:g} I"
    variations = [
        wb.Variation(f"shape '{shape}', Q = {multiple(Q)}", _tracking(tracks(run)), _errors(run))
        for (shape, Q), run in runs.items()
    ]
    variations.append(wb.Variation(fitted, _tracking(tracks(minus)), _errors(minus)))
    single = results.scenario(repairs.ONE_REPAIR)
    variations += [
        wb.Variation(
            f"{run.case.law.replace(', ', ' alone, shape ')}, Q = {SMALL:g} I", _tracking(tracks(run)), _errors(run)
        )
        for run in single
    ]
    return wb.Finding(
        "two_repairs",
        f"With (3) and (28) repaired and nothing else, the law tracks the first scenario in {len(kept)} of "
        f"{len(runs)} runs, with late errors of at most {worst[0]:.3f} rad and {worst[1]:.3f} rad at joints 1 and 2.",
        f"(24) and the minus of (33) are as printed. K falls, and stops being positive definite only with {lost}. "
        f"{_single_words(single)}",
        statistic=TRACKING,
        sample=(
            f"One run without noise for each shape of (33) and each Q, R = I: over {FREE:g} s with Q = {SMALL:g} I and "
            "Q = I, and with other Q over the horizon of ",
            wb.document.CrossReference("witness"),
            f". With one repair: over {repairs.LONG:g} s.",
        ),
        information=INFORMATION,
        assumptions=ASSUMPTIONS,
        answer=_tracking(len(kept) > len(runs) / 2),
        variations=tuple(variations),
        limitations=LIMITATIONS,
    )


def _single_words(single: Iterable[wb.study.Outcome]) -> str:
    """The runs with (3) repaired alone that track, and those with another slip repaired alone."""
    of_three = [run for run in single if run.case.law.startswith("(3),")]
    others = [run for run in single if run not in of_three]
    return (
        f"With only (3) repaired it tracks in {sum(map(tracks, of_three))} of {len(of_three)} runs, with larger late "
        f"errors ({_worst(of_three):.3g} rad or more). With one other slip repaired alone it tracks in "
        f"{sum(map(tracks, others)) or 'none'} of {len(others)} runs."
    )


def row_of_fs(results: wb.Results) -> wb.Finding:
    """The printed row of the first scenario, which several repairs meet."""
    runs = two_repair_runs(results)
    misses = {key: nearest(run).miss for key, run in runs.items()}
    (shape, Q), least = min(misses.items(), key=lambda item: item[1])
    four = results["FS", PROPOSED_LAW]
    of_four = max(abs(percent) for percent in excess(four)) / 100
    other = nearest(results[row.OTHER_PAIR, "outer"]).miss
    one = nearest(runs[shape, Q])
    return wb.Finding(
        "row_of_fs",
        "The printed row of the first scenario does not identify the law: it is met within "
        f"{row.limit(least)} % by repairs of (3) and (28), within {row.limit(other)} % by repairs of (3) and (33), and "
        f"within {row.limit(of_four)} % by all four repairs.",
        "The sampled RMSE falls with the unstated horizon. The fits are, "
        f"for (3) and (28): shape '{shape}', Q = {multiple(Q)}, R = I, horizon {one.horizon:.2f} s; for (3) and (33): "
        f"shape 'outer', Q = {row.OTHER_Q:g} I, R = {row.OTHER_R:g} I, horizon {row.OTHER_HORIZON:g} s; for four: "
        f"shape '{CARD['reading of (33)']}', Q = {CARD['Q'][0, 0]:g} I, R = {CARD['R'][0, 0]:g} I, horizon "
        f"{FIT_OF_CARD:g} s.",
        statistic="The relative difference between the sampled RMSE, (43), and its printed value, the larger of both "
        f"joints. The row is met if this is at most {100 * CLOSE:g} %.",
        sample="One run without noise for each repair. The horizon is each sample of (43) from "
        f"{row.SHORTEST:g} s to {FREE:g} s, or to the end of the run.",
        information=INFORMATION,
        assumptions=ASSUMPTIONS,
        fitted_numbers=f"With four repairs: {assumptions(OURS, of_fit=True)}. With (3) and (28) repaired: Q, the shape "
        "of (33) and the horizon, to the printed row. With (3) and (33) repaired: the same and R.",
        answer=_met(least),
        variations=tuple(_other_rows(results)),
        limitations=names(omitted_choices((*VARIED_CHOICES, "D_hat in (10)"), OURS)),
        cites=("a6_unstated_choices/row_of_fs",),
    )


def _met(miss: float, within: float = CLOSE) -> str:
    return "met" if miss <= within else "not met"


def _miss(miss: float) -> str:
    return f"by {wb.document.percent(miss)}" if np.isfinite(miss) else "diverges"


def _other_rows(results: wb.Results) -> Iterator[wb.Variation]:
    """The row under other horizons, tolerances and repairs, over all runs of each."""
    runs = two_repair_runs(results)
    for longest in (30.0, 40.0):
        miss = min(nearest(run, longest).miss for run in runs.values())
        yield wb.Variation(f"two repairs with a horizon of at most {longest:g} s", _met(miss), _miss(miss))
    miss = min(nearest(run, FIT_OF_CARD, FIT_OF_CARD).miss for run in runs.values())
    yield wb.Variation(
        f"two repairs with the horizon fitted with four repairs, {FIT_OF_CARD:g} s", _met(miss), _miss(miss)
    )
    least = min(nearest(run).miss for run in runs.values())
    for within in (1e-3, HALF_DIGIT):
        yield wb.Variation(f"two repairs with a tolerance of {100 * within:.2g} %", _met(least, within), _miss(least))
    for part, label in ((0, "shape '{}'"), (1, "Q = {}")):
        for value in dict.fromkeys(key[part] for key in runs):
            miss = min(nearest(run).miss for key, run in runs.items() if key[part] == value)
            words = label.format(value if part == 0 else multiple(float(value)))
            yield wb.Variation(f"two repairs, only {words}, R = I", _met(miss), _miss(miss))
    miss = nearest(results[row.OTHER_PAIR, "outer"]).miss
    yield wb.Variation("two other repairs, of (3) and (33)", _met(miss), _miss(miss))
    for slip, change in SLIPS.items():
        miss = nearest(results[ONE_CHANGE, change]).miss
        yield wb.Variation(
            f"three repairs with {slip} as printed, Q and R as with four repairs", _met(miss), _miss(miss)
        )
    for words, change in (("four repairs", ALL_FOUR), ("four repairs, and D_hat given to (10)", WITH_ORACLE)):
        miss = nearest(results[ONE_CHANGE, change]).miss
        yield wb.Variation(words, _met(miss), _miss(miss))
    printed = [run for name in (AS_PRINTED["FS"], SMALL_Q) for run in results.scenario(name)]
    miss = min(nearest(run).miss for run in printed)
    yield wb.Variation("no repair", _met(miss), _miss(miss))


def excess(outcome: wb.study.Outcome) -> list[float]:
    """Sampled RMSE of either joint above its printed value in the first scenario, in %."""
    printed = [PUBLISHED_COLUMNS["FS", joint].values[PROPOSED_LAW] for joint in (1, 2)]
    return [100 * (outcome.score("sampled RMSE", j).pair[0] / printed[j] - 1) for j in (0, 1)]


def late_error(results: wb.Results) -> wb.Finding:
    """The error that a repaired law keeps, and the observer that causes it."""
    runs = {
        f"(3) and (28) repaired, shape '{shape}', Q = {multiple(Q)}": run
        for (shape, Q), run in two_repair_runs(results).items()
    }
    runs |= {run.case.law: run for run in results.scenario(ONE_CHANGE) if run.case.law != ALL_FOUR}
    errors, mended = late(results["FS", PROPOSED_LAW]), late(results[ONE_CHANGE, WITH_ORACLE])
    return wb.Finding(
        "late_error",
        f"With four repairs, the law keeps a late error of {errors[0]:.3f} rad (joint 1) and {errors[1]:.3f} rad "
        "(joint 2) in the first scenario; observer (10) causes most of it.",
        "Observer (10) leaves the disturbance out. If it is given the estimate D_hat, the late errors are "
        f"{mended[0]:.3f} rad and {mended[1]:.3f} rad.",
        statistic=f"The late error: the largest |e_i| from {LATE:g} s on. The answer is its value at joint 2.",
        sample=f"One run without noise for each repair, over up to {FREE:g} s.",
        information=INFORMATION,
        assumptions=ASSUMPTIONS,
        fitted_numbers=assumptions(OURS, of_fit=True),
        answer=f"{errors[1]:.2f} rad",
        variations=tuple(wb.Variation(words, _late(run), _errors(run)) for words, run in runs.items()),
        limitations=f"Other gains L1, L2 of (10), which the paper states and a4 varies; "
        f"{names(omitted_choices((*VARIED_CHOICES, 'D_hat in (10)'), OURS))}.",
    )


def _late(run: wb.study.Outcome) -> str:
    return "divergence" if run.diverged_at is not None else f"{late(run)[1]:.2f} rad"


def answer_line(results: wb.Results) -> str:
    """The answer of the page in one line."""
    four = max(abs(percent) for percent in excess(results["FS", PROPOSED_LAW])) / 100
    two = min(nearest(run).miss for run in two_repair_runs(results).values())
    largest = max(four, two, nearest(results[row.OTHER_PAIR, "outer"]).miss)
    tracking = any(min(each) <= NEAR for each in grid.late_errors(results).values())
    return (
        f"As printed, with observer (10), the law {'tracks in some runs' if tracking else 'does not track'}. Three "
        f"sets of repairs each meet the printed RMSE of the first scenario within {row.limit(largest)} %, so this row "
        "does not identify the law."
    )


def findings(results: wb.Results) -> tuple[wb.Finding, ...]:
    """The five findings of the page."""
    return tuple(make(results) for make in (as_printed, two_repairs, row_of_fs, late_error, pairs.order_of_laws))
