"""The findings of a1: the law as printed, its repairs, the printed row that they meet, and the order of the laws."""

from collections.abc import Iterable

import numpy as np

import workbench as wb
from studies.a1_paper_tables import grid, pairs, repairs, row
from studies.a1_paper_tables.repairs import (
    ALL_FOUR,
    AS_PRINTED,
    FREE,
    NEAR,
    ONE_CHANGE,
    SHORT,
    SLIPS,
    SMALL,
    SMALL_Q,
    TRACKING,
    WITH_ORACLE,
    late,
    tracks,
)
from studies.a1_paper_tables.row import multiple, nearest
from studies.a1_paper_tables.row_finding import excess, row_of_fs, two_repair_runs
from studies.a1_paper_tables.scope import AS_PRINTED_INFORMATION, ASSUMPTIONS, INFORMATION, OURS, VARIED_CHOICES
from studies.paper.card import CARD, PROPOSED_LAW
from studies.paper.comparison import LATE
from studies.paper.unstated_choices import assumptions, names, omitted_choices


def _tracking(flag: bool) -> str:
    return "tracking" if flag else "no tracking"


def _errors(run: wb.study.Outcome) -> str:
    if run.diverged_at is not None:
        return f"diverges at {run.diverged_at:.2f} s"
    return "late errors {:.2g} and {:.2g} rad".format(*late(run))


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
        (
            f"With Q = R = I and the shape 'outer' of (33), K is no longer positive definite at {lost} s, and an error "
            f"exceeds {repairs.FAR:g} rad at {left} s. The note of ",
            wb.document.CrossReference("printed_runs"),
            " explains the four shapes of (33).",
        ),
        statistic=f"{TRACKING} A run that diverges does not track.",
        sample=f"One run of {grid.UNTIL:g} s without noise for each shape of (33) and each point of a grid: Q from "
        f"{grid.Q.low:g} I to {grid.Q.high:g} I, R from {grid.R.low:g} I to {grid.R.high:g} I. Further runs: with "
        f"Q = R = I over {SHORT:g} s, and with Q = {SMALL:g} I over {repairs.LONG:g} s.",
        information=AS_PRINTED_INFORMATION,
        assumptions=ASSUMPTIONS,
        answer=_tracking(least <= NEAR),
        variations=tuple(variations),
        limitations=names(omitted_choices((*VARIED_CHOICES, "observer (10)"), OURS)),
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
        f"{len(runs)} runs, with late errors of at most {_up(worst[0])} rad and {_up(worst[1])} rad at joints 1 and 2.",
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
        limitations=names(omitted_choices(VARIED_CHOICES, OURS)),
    )


def _up(error: float) -> str:
    """An error rounded up to a thousandth of a rad, as a bound."""
    return f"{np.ceil(1e3 * error - 1e-9) / 1e3:.3f}"


def _single_words(single: Iterable[wb.study.Outcome]) -> str:
    """The runs with (3) repaired alone that track, and those with another slip repaired alone."""
    of_three = [run for run in single if run.case.law.startswith("(3),")]
    others = [run for run in single if run not in of_three]
    return (
        f"With only (3) repaired it tracks in {sum(map(tracks, of_three))} of {len(of_three)} runs, with larger late "
        f"errors ({_worst(of_three):.3g} rad or more). With one other slip repaired alone it tracks in "
        f"{sum(map(tracks, others)) or 'none'} of {len(others)} runs."
    )


def late_error(results: wb.Results) -> wb.Finding:
    """The error that a repaired law keeps, and the observer that causes it."""
    runs = {
        f"(3) and (28) repaired, shape '{shape}', Q = {multiple(Q)}": run
        for (shape, Q), run in two_repair_runs(results).items()
    }
    others = (run for run in results.scenario(ONE_CHANGE) if run.case.law != ALL_FOUR)
    runs |= {repairs.display_name(run.case.law): run for run in others}
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
        f"sets of repairs each meet the printed RMSE of {PROPOSED_LAW} in the first scenario within "
        f"{row.limit(largest)} %. These values therefore do not show which law was run."
    )


def findings(results: wb.Results) -> tuple[wb.Finding, ...]:
    """The five findings of the page."""
    return tuple(make(results) for make in (as_printed, two_repairs, row_of_fs, late_error, pairs.order_of_laws))
