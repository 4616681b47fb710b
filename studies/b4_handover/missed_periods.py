"""Missed periods: the largest share that each loop tolerates, at its own period and at that of AOSMC-RGS."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import cache

import numpy as np

import workbench as wb
from studies.b4_handover.findings import FITS, INFORMATION, START_WORDS, amount, assumptions
from studies.b4_handover.loops import (
    CARD,
    ERROR,
    LQG,
    NEAR_START,
    PID,
    SEED,
    SMC,
    STATISTICS,
    TWISTING,
    HandoverLoop,
    handover_loops,
)
from studies.b4_handover.margins import BOTH, DRAWS, NEAR, effects_of, loop_of, margins, sample_name, starts
from studies.paper.card import PROPOSED_LAW
from studies.paper.laws import arm_law
from studies.paper.quiet_periods import momentum_loop, on_reference

KEEPS_RATIO = wb.evidence.KEEPS_RATIO
EFFECT = "missed periods"
SHARED_PERIOD = float(
    CARD["period of sliding laws"]
)  # s, of AOSMC-RGS and SMC, at which the other laws of the arm run, too
MS, RAD = f"{1e3 * SHARED_PERIOD:g} ms", "rad"
SMC_WITH_OBSERVER = f"SMC with the observer of {PROPOSED_LAW}"
SMALL_ERROR = 0.1  # of the settled error without effects: a larger error by the step has a note of its own
PART = 0.1  # of a quantisation step, by which an error may grow, in place of a part of itself


def observed_smc() -> wb.ClosedLoop:
    """SMC with the disturbance that the observer of AOSMC-RGS estimates added to its torque."""
    return replace(momentum_loop(), controller=wb.arms.laws.DisturbanceCompensation(arm_law(SMC)))


@cache
def shared_period() -> tuple[HandoverLoop, ...]:
    """The loops of the arm whose own period is longer, at that of AOSMC-RGS, and SMC with the observer of AOSMC-RGS."""
    moved = [replace(one, period=SHARED_PERIOD) for one in handover_loops() if one.name in (TWISTING, PID, LQG)]
    smc = next(one for one in handover_loops() if one.name == SMC)
    observed = replace(
        smc,
        name=SMC_WITH_OBSERVER,
        near=lambda period: on_reference(observed_smc()),
        far=lambda period: observed_smc(),
        information=f"{smc.information}, D by an observer",
    )
    return (*moved, observed)


def missed_period_effect(one: HandoverLoop) -> wb.evidence.ComputerEffect:
    """The effect of missed periods on a loop."""
    return next(effect for effect in effects_of(one) if effect.name == EFFECT)


def shared_sweeps() -> tuple[wb.Sweep, ...]:
    """The loops of `shared_period` with missed periods, from the same starts as those that are handed over."""
    made = []
    for one in shared_period():
        run = wb.Run(loop_of(one, "double"), one.metrics, one.until, h=one.period, seed=SEED)
        made.append(wb.evidence.computer_sweep(name_of(one), run, (missed_period_effect(one),), starts(one), DRAWS))
    return tuple(made)


def name_of(one: HandoverLoop) -> str:
    """The name of the sweep of a loop at the shared period."""
    return f"{one.key}_shared_period"


def at_shared_period(results: wb.Results, metric: str = ERROR) -> dict[str, tuple[wb.evidence.ComputerMargin, float]]:
    """By loop of the arm at the shared period, its margin for missed periods, and its error without them."""
    found = {}
    for one in handover_loops():
        if one.period == SHARED_PERIOD:
            error = margins(results, one, metric=metric).without.mean(axis=0).max()
            found[one.name] = effect_margin(results, one, EFFECT, metric), float(error)
    for one in shared_period():
        own = wb.evidence.computer_margins(results.sample(name_of(one)), (missed_period_effect(one),), metric)
        found[one.name] = own.each[0], float(own.without.mean(axis=0).max())
    return found


def shared_reach(results: wb.Results, left_out: str) -> dict[str, float]:
    """By loop at the shared period but for one, the largest share of missed periods that keeps its error."""
    each = at_shared_period(results)
    return {name: margin.largest(wb.evidence.KEEPS_RATIO) for name, (margin, _) in each.items() if name != left_out}


def frailest(reach: Mapping[str, float]) -> str:
    """The loops with the least level that keeps their error."""
    least = min(reach.values())
    return wb.document.join_names(name for name, level in reach.items() if level == least)


def reach_of(
    results: wb.Results,
    effect: str,
    most: float = wb.evidence.KEEPS_RATIO,
    metric: str = ERROR,
    start: str = NEAR_START,
) -> dict[str, float]:
    """By loop, the largest level of an effect up to which no run has more than `most` times its error."""
    return {
        one.name: effect_margin(results, one, effect, metric, start).largest(most)
        / (one.period if effect == "jitter" else 1)
        for one in handover_loops()
    }


def reach_in_steps(results: wb.Results) -> dict[str, float]:
    """By loop, the largest share of missed periods up to which no error grows by more than `PART` of a step."""
    reach = {}
    for one in handover_loops():
        without, effect = margins(results, one).without, effect_margin(results, one, EFFECT)
        kept = np.asarray((effect.values - without <= PART * one.quantum[one.follows]).all(axis=(1, 2)))
        reach[one.name] = (0.0, *effect.effect.levels)[len(kept) if kept.all() else int(np.argmin(kept))]
    return reach


def effect_margin(
    results: wb.Results, one: HandoverLoop, effect: str, metric: str = ERROR, start: str = NEAR_START
) -> wb.evidence.ComputerMargin:
    """The margin of a loop for one effect."""
    own = margins(results, one, metric=metric, start=start)
    return next(each for each in own.each if each.effect.name == effect)


def two_digits_up(value: float) -> float:
    """A positive number rounded up to two digits."""
    unit = 10.0 ** (np.floor(np.log10(value)) - 1)
    return float(np.ceil(value / unit - 1e-9) * unit)


def far_off(results: wb.Results, start: str) -> tuple[str, ...]:
    """A note on each loop whose largest error by the step is not small: the run that has it, and the other runs."""
    made = []
    for one in handover_loops():
        sample = results.sample(sample_name(one, "double", start))
        found, score = sample.measurement, sample.score(ERROR)
        errors = found.errors[:, -1, [column.metric for column in found.columns].index(ERROR)]
        if np.isnan(errors).all() or np.nanmax(errors) < SMALL_ERROR * margins(results, one, start=start).without.max():
            continue
        at = int(np.nanargmax(errors))
        run, unit = int(found.looked_at[at]), score.unit
        share = sample.factor_values[run, sample.factors.index(EFFECT)]
        made.append(
            f"{one.name}: the error of {errors[at]:.2g} {unit} is that of a run with {100 * share:.3g} % missed "
            f"periods, whose {ERROR} is {score.value[run]:.3g} {unit}. The error of every other run is at most "
            f"{two_digits_up(float(np.nanmax(np.delete(errors, at)))):g} {unit}."
        )
    return tuple(made)


def clock_finding(results: wb.Results) -> wb.Finding:
    """The missed periods that each loop tolerates."""
    reach = reach_of(results, EFFECT)
    frail = frailest(reach)
    shared = shared_reach(results, SMC_WITH_OBSERVER)
    (first, level), *rest = ((name, level) for name, level in shared.items() if name != frail)
    each = at_shared_period(results)
    observed, error = each[SMC_WITH_OBSERVER][0].largest(wb.evidence.KEEPS_RATIO), each[SMC_WITH_OBSERVER][1]
    own = amount(each[PROPOSED_LAW][1], "rad")
    alike = (
        f" {PROPOSED_LAW}, whose error is {own}, has the same limit: it comes from the observer, not from the law."
        * (observed == shared[PROPOSED_LAW])
    )
    levels = ", ".join(f"{100 * level:.3g}" for level in missed_levels())
    within = f"its settled error within {100 * (wb.evidence.KEEPS_RATIO - 1):.0f} %"
    return wb.Finding(
        "missed_periods",
        f"With missed periods, {frail} {kept_words(min(reach.values()), within)}. At {MS}, the period of "
        f"{PROPOSED_LAW}, the limits are: {wb.document.join_names(levels_of([(first, level), *rest]))}.",
        f"At {MS}, {SMC_WITH_OBSERVER} {kept_words(observed, f'its error of {amount(error, RAD)}')}.{alike} "
        "At the declared period of each loop, the largest levels tried that keep the error are: "
        f"{wb.document.join_names(levels_of(reach.items()))}. Nothing was run between neighbouring levels.",
        statistic=f"The largest level tried up to which no run has more than {KEEPS_RATIO:g} times its settled RMSE "
        "without the effect, at the worst joint; each effect by itself, in double precision.",
        sample=f"Six loops at their declared periods, and the loops of the arm at {MS}; {DRAWS} starts within "
        f"{NEAR:g} rad or m of the near start, nine levels.",
        information=INFORMATION,
        assumptions=assumptions(
            f"; the limit of {KEEPS_RATIO:g} times; the levels, {levels} %; periods missed independently."
        ),
        fitted_numbers=FITS,
        answer=frail,
        variations=clock_variations(results),
        limitations="Missed periods in bursts.",
    )


def clock_variations(results: wb.Results) -> tuple[wb.Variation, ...]:
    """The frailest loops by other statistics, starts, limits, periods and effects."""
    asked = [
        (f"{metric}, {START_WORDS[start]}", reach_of(results, EFFECT, wb.evidence.KEEPS_RATIO, metric, start))
        for start in BOTH
        for metric in STATISTICS
        if (start, metric) != (NEAR_START, ERROR)
    ]
    asked += [
        (
            f"error at most {wb.evidence.STANDS_RATIO:g} times as large, not {KEEPS_RATIO:g} times",
            reach_of(results, EFFECT, wb.evidence.STANDS_RATIO),
        ),
        (
            f"error larger by at most {PART:g} steps of the reading, not {KEEPS_RATIO:g} times as large",
            reach_in_steps(results),
        ),
        (f"the laws of the arm at {MS}", shared_reach(results, SMC_WITH_OBSERVER)),
        (
            f"the laws of the arm at {MS}, {SMC_WITH_OBSERVER} in place of {PROPOSED_LAW}",
            shared_reach(results, PROPOSED_LAW),
        ),
    ]
    others = (
        wb.Variation(f"{effect} in place of missed periods", frailest(reach_of(results, effect)))
        for effect in ("jitter", "coarser readings")
    )
    return (*(wb.Variation(words, frailest(each), level_words(min(each.values()))) for words, each in asked), *others)


def levels_of(reach: Iterable[tuple[str, float]]) -> list[str]:
    """Each loop with its largest level."""
    return [f"{name} {100 * level:.3g} %" for name, level in reach]


def missed_levels() -> tuple[float, ...]:
    """The levels of missed periods that are tried, the same for each loop."""
    return missed_period_effect(handover_loops()[0]).levels


def level_words(level: float) -> str:
    """The largest level of missed periods that keeps an error, and the next one tried, which does not."""
    later = [each for each in missed_levels() if each > level]
    if not later:
        return f"up to {100 * level:.3g} %, the largest level tried"
    if not level:
        return f"not at any level tried, from {100 * later[0]:.3g} % on"
    return f"up to {100 * level:.3g} % but not at {100 * later[0]:.3g} %"


def kept_words(level: float, error: str) -> str:
    """A predicate: keeps an error up to a level of missed periods, or does not keep it at any level tried."""
    if level:
        return f"keeps {error} {level_words(level)}"
    return f"does not keep {error} {level_words(level).removeprefix('not ')}"


def shared_table(results: wb.Results) -> wb.document.ReportTable:
    """The loops of the arm with missed periods, all at the period of AOSMC-RGS."""
    shown = missed_levels()[:3]
    rows: list[tuple[wb.document.Cell, ...]] = []
    for name, (margin, error) in at_shared_period(results).items():
        kept = margin.largest(wb.evidence.KEEPS_RATIO)
        later = [level for level in margin.effect.levels if level > kept]
        grown = (100 * float(margin.ratios[margin.effect.levels.index(level)].max() - 1) for level in shown)
        limits = 100 * kept, 100 * later[0] if later else "none tried"
        rows.append((name, amount(error, "rad"), *limits, *("diverged" if np.isinf(g) else g for g in grown)))
    columns = (
        wb.document.TableColumn("law"),
        wb.document.TableColumn(ERROR, align="right"),
        wb.document.TableColumn("kept up to", "%", "right", digits=3),
        wb.document.TableColumn("not kept at", "%", "right", digits=3),
        *(wb.document.TableColumn(f"largest growth at {100 * level:.3g} %", "%", "right", digits=2) for level in shown),
    )
    caption = f"Missed periods at the period of {PROPOSED_LAW}, {MS}: the laws of the arm, and {SMC_WITH_OBSERVER}."
    notes = (
        f"{ERROR[0].upper()}{ERROR[1:]}: without missed periods. Kept: no run has more than {KEEPS_RATIO:g} times its "
        f"error. "
        f"Largest growth: of {DRAWS} runs about the near start. {SMC_WITH_OBSERVER} adds the estimate of the "
        "disturbance to its torque. LQG is designed for this period.",
    )
    return wb.document.ReportTable("missed_shared", caption, columns, tuple(rows), notes)
