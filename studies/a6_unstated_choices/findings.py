"""The findings of a6 on what fits: the printed row of the proposed law, and one experiment for all laws."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

import workbench as wb
from studies.a6_unstated_choices import experiments, fits, rows
from studies.a6_unstated_choices.experiments import COMMON, Experiment
from studies.a6_unstated_choices.fits import CLOSE, Fit, horizons, misses
from studies.a6_unstated_choices.loops import LONGEST, NAMES, PROPOSED_LAW, SHORTEST, STIFF, factors_of, in_words, slug
from studies.a6_unstated_choices.rows import MINUS, PLUS, TWO, Row
from studies.a6_unstated_choices.scope import OMITTED_CHOICES, REST
from studies.paper.card import LAWS
from studies.paper.unstated_choices import assumptions

MET_WORD, MISSED_WORD = "met", "not met"
ROW = f"the printed row of {PROPOSED_LAW} in the first scenario"
BOTH_SIGNS = f"Both signs of (33) meet {ROW} within {100 * CLOSE:g} %: the row does not identify the law."
SHORT_ROW = "Both signs of (33) reproduce its printed RMSE of the first scenario, so it identifies no law."
SHORT = 30.0  # s, the longest horizon of an earlier search
FINE_RUNS = (
    "Runs are in continuous time with the boundary layer of the paper, with a step of "
    f"{1e3 * fits.FINE:.3g} ms and half of it. The error by the step is added to the miss."
)
OWN_RANGES = f"R from {STIFF:g} N m/(rad s) on, horizons from {SHORTEST} to {LONGEST} s"
FIXED_CHOICES = f"Not varied: {assumptions(OMITTED_CHOICES)}."
LONGER = f"longer searches; {REST}"


def met_words(miss: float) -> str:
    return MET_WORD if miss <= CLOSE else MISSED_WORD


def share_of(miss: float) -> str:
    """A miss in percent with two digits."""
    return f"{100 * miss:.2g} %" if np.isfinite(miss) else "no finite run"


def fit_words(law: str, target: str, numbers: wb.Array) -> str:
    """The numbers of a fit in words, less those of the square wave where the target is of the first scenario."""
    factors = factors_of(law, "FS" if target.startswith("FS") else "SS")
    return in_words(factors, numbers[: len(factors)])


def row_finding(results: wb.Results, every: Sequence[Row]) -> wb.Finding:
    """The signs of (33) that meet the printed row of the proposed law in the first scenario."""
    near = {
        sign: min((row for row in every if row.sign == sign), key=lambda row: row.fit.miss)
        for sign in rows.FIXED_READINGS
    }
    count = {sign: sum(row.is_met for row in every if row.sign == sign) for sign in rows.FIXED_READINGS}
    signs = [sign for sign in (PLUS, MINUS) if near[sign].is_met or (sign == MINUS and near[TWO].is_met)]
    two = near[TWO]
    shapes = len(every) // len(rows.FIXED_READINGS)
    return wb.Finding(
        name="row_of_fs",
        statement=_row_statement(signs),
        evidence=f"With the plus {count[PLUS]} of {shapes} shapes of (33) meet the row, with the minus {count[MINUS]}. "
        f"With the minus and only (3) and (28) repaired, {count[TWO]} shapes meet it. The nearest of these, shape "
        f"'{two.shape}', misses it by {share_of(two.fit.miss)} at a horizon of {two.fit.horizon['FS']:.1f} s.",
        statistic=f"The larger miss of the two cells at the best horizon. {FINE_RUNS} The answer is 'met' if some "
        f"choice is within {100 * CLOSE:g} %.",
        sample=f"{len(every)} searches by differential evolution (seed {rows.SEED}), one for each sign and shape of "
        f"(33), with {rows.EVALUATIONS[PLUS]} choices each, or {rows.EVALUATIONS[TWO]} with only two repairs. The "
        f"{rows.AGAIN} nearest choices of each search are run again.",
        information="The law has the exact model, except for (3), and D(t) itself where D_hat needs it.",
        assumptions=f"{OWN_RANGES}. {FIXED_CHOICES}",
        fitted_numbers="Q, R, l, the horizon and the other readings, to the two printed numbers of the row.",
        answer=MET_WORD if any(row.is_met for row in every) else MISSED_WORD,
        variations=tuple(row_variations(results, every)),
        limitations=LONGER,
        is_decided=bool(signs),
        cites=("a1_paper_tables/row_of_fs",),
    )


def _row_statement(signs: Sequence[str]) -> str:
    """The answer of the row by the signs of (33) that meet it."""
    if len(signs) == 2:
        return BOTH_SIGNS
    if signs:
        return f"Of the signs of (33) only the {signs[0]} meets {ROW} within {100 * CLOSE:g} %."
    return f"No choice of the searches meets {ROW} within {100 * CLOSE:g} %."


def row_variations(results: wb.Results, every: Sequence[Row]) -> Iterator[wb.Variation]:
    """The answer for each sign and shape, and for each sign with horizons that a shorter run has."""
    for row in every:
        detail = f"{share_of(row.fit.miss)} at {row.fit.horizon['FS']:.1f} s"
        yield wb.Variation(f"{row.sign}, {row.shape}", met_words(row.fit.miss), detail)
    for sign in rows.FIXED_READINGS:
        samples = [results.tuning(rows.search_name(sign, row.shape)).samples["fs"] for row in every if row.sign == sign]
        least = np.inf
        for sample in samples:
            t, rmse = horizons(sample)
            least = min(least, float(misses(PROPOSED_LAW, "FS", rmse[:, t <= SHORT + 1e-9]).min()))
        words = f"{sign}, horizons up to {SHORT:g} s, at the step of the search"
        yield wb.Variation(words, met_words(least), share_of(least))


def tables_finding(
    results: wb.Results, law_fits: Mapping[tuple[str, str], Fit], first: Experiment, second: Experiment
) -> wb.Finding:
    """The rows that one experiment for all laws gives in each scenario, and the other sets of cells that are met."""
    counts = [sum(miss <= CLOSE for miss in one.miss.values()) for one in (first, second)]
    farthest = [max(one.miss, key=one.miss.__getitem__) for one in (first, second)]
    settled = all(count == len(LAWS) for count in counts)
    moved = " and ".join(
        f"{100 * (now / then - 1):+.1f} %"
        for now, then in zip(experiments.AMPLITUDES, experiments.BY_HAND, strict=True)
    )
    return wb.Finding(
        name="printed_tables",
        statement=f"One experiment for each scenario gives {sum(counts)} of the {2 * len(LAWS)} printed rows within "
        f"{100 * CLOSE:g} %.",
        evidence=f"At one horizon, {first.horizon:.1f} s, {counts[0]} of {len(LAWS)} rows of the first scenario come "
        f"within {100 * CLOSE:g} %. With one square wave and one horizon, {second.horizon:.1f} s, {counts[1]} of "
        f"{len(LAWS)} rows of the second scenario come within {100 * CLOSE:g} %. The farthest rows are those of "
        f"{farthest[0]} in the first scenario, with {share_of(first.miss[farthest[0]])}, and of {farthest[1]} in the "
        f"second, with {share_of(second.miss[farthest[1]])}.",
        statistic=f"The larger miss of the two cells of a law. {FINE_RUNS} The answer is 'met' if all rows are within "
        f"{100 * CLOSE:g} %.",
        sample=f"A search for each law (seed {fits.SEED}). In the first scenario it has {experiments.OF_COMMON} "
        f"choices at each of the horizons {', '.join(map(str, COMMON))} s, in the second {fits.EVALUATIONS}. The "
        f"{experiments.COMMON_AGAIN} and {experiments.SHARED_AGAIN} nearest choices are run again.",
        information="Each law has separate gains in each scenario. In the second scenario the rivals that switch have "
        f"the measurements of (10), PID has exact ones, and {PROPOSED_LAW} has those of its reading.",
        assumptions="The square wave was found by hand, outside of this study: a search of 32 square waves at once, "
        f"each with gains for every law, over 194 generations (seed 0) ended at a1 = {experiments.BY_HAND[0]:g} rad, "
        f"a2 = {experiments.BY_HAND[1]:g} rad, f = {experiments.FREQUENCY:g} Hz. Both amplitudes were then moved by "
        f"hand, by {moved}, to {experiments.AMPLITUDES[0]:g} and {experiments.AMPLITUDES[1]:g} rad. The horizon of "
        f"{experiments.HORIZON:g} s also comes from that search. {FIXED_CHOICES}",
        fitted_numbers=f"All others of the {len(NAMES)} unstated numbers, to the printed rows.",
        answer=MET_WORD if settled else MISSED_WORD,
        variations=tuple(tables_variations(results, law_fits, first, second)),
        limitations=f"Other square waves; {LONGER}",
        is_decided=settled,
    )


def tables_variations(
    results: wb.Results, law_fits: Mapping[tuple[str, str], Fit], first: Experiment, second: Experiment
) -> Iterator[wb.Variation]:
    """The answer for parts of the tables, with horizons and gains of their own, and at each horizon searched."""
    both = {law: max(first.miss[law], second.miss[law]) for law in LAWS}
    groups = {"the first scenario alone": first.miss, "the second scenario alone": second.miss}
    groups |= {f"all laws but {law}": {other: both[other] for other in LAWS if other != law} for law in LAWS}
    for target, words in (
        ("FS", "the first scenario"),
        ("SS", "the second scenario"),
        ("both", "all cells, same gains"),
    ):
        groups[f"{words}, a separate horizon for each law"] = {law: law_fits[law, target].miss for law in LAWS}
    cells = {(law, target): law_fits[law, target].miss for law in LAWS for target in fits.CELLS}
    groups["each of the 24 cells by itself"] = {law: max(cells[law, t] for t in fits.CELLS) for law in LAWS}
    for words, misses_of in groups.items():
        law = max(misses_of, key=misses_of.__getitem__)
        yield wb.Variation(words, met_words(misses_of[law]), f"{law} is the farthest, {share_of(misses_of[law])}")
    for horizon in COMMON:
        worst = 0.0
        for law in LAWS:
            sample = results.tuning(slug("common", law, str(horizon))).samples["fs"]
            worst = max(worst, float(misses(law, "FS", sample.values[:, -1]).min()))
        yield wb.Variation(
            f"the first scenario at {horizon} s, at the step of the search", met_words(worst), share_of(worst)
        )
