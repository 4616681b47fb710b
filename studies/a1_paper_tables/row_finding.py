"""The finding of a1 on the printed values of the first scenario, which several sets of repairs meet."""

from collections.abc import Iterator

import numpy as np

import workbench as wb
from studies.a1_paper_tables import row
from studies.a1_paper_tables.repairs import ALL_FOUR, AS_PRINTED, FREE, ONE_CHANGE, PAIRS, SLIPS, SMALL_Q, WITH_ORACLE
from studies.a1_paper_tables.row import CLOSE, FITTED_WEIGHTS, HALF_DIGIT, WITNESS, multiple, nearest
from studies.a1_paper_tables.scope import ASSUMPTIONS, INFORMATION, OURS, VARIED_CHOICES
from studies.paper.card import CARD, PROPOSED_LAW, PUBLISHED_COLUMNS
from studies.paper.unstated_choices import assumptions, names, omitted_choices

FIT_OF_CARD = CARD["FS: horizon"]


def two_repair_runs(results: wb.Results) -> dict[tuple[str, float], wb.study.Outcome]:
    """The runs with (3) and (28) repaired alone, by the shape of (33) and Q, each once and with the longest horizon."""
    runs = {(run.case.law, Q): run for pair, Q in PAIRS.items() for run in results.scenario(pair)}
    for run in results.scenario(WITNESS):
        shape = run.case.law.partition(",")[0]
        runs.setdefault((shape, FITTED_WEIGHTS[shape][0]), run)
    return runs


def row_of_fs(results: wb.Results) -> wb.Finding:
    """The printed values of the first scenario, which several repairs meet."""
    runs = two_repair_runs(results)
    misses = {key: nearest(run).miss for key, run in runs.items()}
    (shape, Q), least = min(misses.items(), key=lambda item: item[1])
    four = results["FS", PROPOSED_LAW]
    of_four = max(abs(percent) for percent in excess(four)) / 100
    other = nearest(results[row.OTHER_PAIR, "outer"]).miss
    one = nearest(runs[shape, Q])
    return wb.Finding(
        "row_of_fs",
        f"The printed RMSE values of {PROPOSED_LAW} in the first scenario do not identify the law. They are met within "
        f"{row.limit(least)} % by repairs of (3) and (28), within {row.limit(other)} % by repairs of (3) and (33), and "
        f"within {row.limit(of_four)} % by all four repairs.",
        "The longer the run, the smaller the sampled RMSE, and the paper does not state the duration of its runs. This "
        "horizon, Q and the shape of (33) were therefore fitted, and for the last two sets R too. The fits are, "
        f"for (3) and (28): shape '{shape}', Q = {multiple(Q)}, R = I, horizon {one.horizon:.2f} s; for (3) and (33): "
        f"shape 'outer', Q = {row.OTHER_Q:g} I, R = {row.OTHER_R:g} I, horizon {row.OTHER_HORIZON:g} s; for four: "
        f"shape '{CARD['reading of (33)']}', Q = {CARD['Q'][0, 0]:g} I, R = {CARD['R'][0, 0]:g} I, horizon "
        f"{FIT_OF_CARD:g} s.",
        statistic="The relative difference between the sampled RMSE, (43), and its printed value, the larger of both "
        f"joints. The printed values are met if this is at most {100 * CLOSE:g} %.",
        sample="One run without noise for each repair. The horizon is each sample of (43) from "
        f"{row.SHORTEST:g} s to {FREE:g} s, or to the end of the run.",
        information=INFORMATION,
        assumptions=ASSUMPTIONS,
        fitted_numbers=f"With four repairs: {assumptions(OURS, of_fit=True)}. With (3) and (28) repaired: Q, the "
        f"shape of (33) "
        "and the horizon, to the printed values. With (3) and (33) repaired: the same and R.",
        answer=_met(least),
        variations=tuple(_other_rows(results)),
        limitations=names(omitted_choices((*VARIED_CHOICES, "D_hat in (10)"), OURS)),
        cites=("a6_unstated_choices/row_of_fs",),
    )


def _met(miss: float, within: float = CLOSE) -> str:
    return "met" if miss <= within else "not met"


def _miss(miss: float) -> str:
    return f"misses by {wb.document.percent(miss)}" if np.isfinite(miss) else "diverges"


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
        why = ", half of the last printed digit" if within == HALF_DIGIT else ""
        words = f"two repairs with a tolerance of {100 * within:.2g} %{why}"
        yield wb.Variation(words, _met(least, within), _miss(least))
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
