"""The unstated numbers and readings of the AOSMC-RGS paper: which give its tables, and which decide who wins.

Runs in about four minutes on two cores.
"""

from collections.abc import Mapping, Sequence

import workbench as wb
from studies.a6_unstated_choices import (
    deciding_factors,
    draws,
    experiments,
    findings,
    fits,
    loops,
    ranking,
    rows,
    tables,
)
from studies.a6_unstated_choices.loops import PROPOSED_LAW, SCENARIOS, slug
from studies.a6_unstated_choices.shares import Cells, cells, reruns
from studies.paper.card import LAWS
from studies.paper.citation import introduction


def sections(results: wb.Results) -> wb.Page:
    every, limited = cells(results), cells(results, "limited")
    again = reruns(results, every)
    indices, searched = deciding_factors.indices(results), rows.rows_of(results)
    first, second = experiments.common_experiment(results), experiments.shared_experiment(results)
    met = nearest_fits(results, searched)
    found = (
        ranking.first_finding(every, limited, again),
        ranking.below_finding(results, every, limited, again),
        deciding_factors.deciding_finding(indices),
        findings.row_finding(results, searched),
        findings.tables_finding(results, met, first, second),
    )
    decides = deciding_factors.deciding_figure(results, indices), deciding_factors.deciding_table(indices)
    nearest = ROWS, tables.nearest_table(searched), tables.rows_table(searched)
    one_experiment = tables.experiment_table("common", first), tables.experiment_table("shared", second)
    return wb.Page(
        answer=answer(found),
        findings=found,
        sections=(
            wb.Section("Who is first", first_blocks(results, every, limited)),
            wb.Section("What decides", decides),
            wb.Section("The printed row of AOSMC-RGS", nearest),
            wb.Section(
                "The printed tables", (*one_experiment, FIT_METHOD, tables.together(met), tables.cells_table(met))
            ),
            wb.Section("The rankings under four priors", (RANKING, tables.priors_table(every))),
            wb.Section("What is open", (*OPEN, tables.omitted_table(), *map(tables.open_table, LAWS))),
            wb.Section(
                "How far these numbers can be trusted", (TRUST, tables.step_table(again), tables.trust_table(results))
            ),
        ),
    )


def nearest_fits(results: wb.Results, search_rows: Sequence[rows.Row]) -> dict[tuple[str, str], fits.Fit]:
    """The nearest fit of each law to each target; of the proposed law's first row that of the searches for it alone."""
    met = {(law, target): fit for law in LAWS for target, fit in fits.fits_of(results, law).items()}
    best = min((row.fit for row in search_rows), key=lambda fit: fit.miss)
    if best.miss < met[PROPOSED_LAW, "FS"].miss:
        met[PROPOSED_LAW, "FS"] = best
    return met


def first_blocks(results: wb.Results, every: Cells, limited_cells: Cells) -> tuple[wb.document.Block, ...]:
    """The ranks, the answer by column, and the torque limit."""
    columns = ranking.ranks_by_column(every)
    return (
        tables.ranks_figure(results, columns),
        wb.Paragraph(ranking.printed_words(columns)),
        tables.below_table(every, limited_cells),
        tables.limits_table(results),
    )


def answer(page_findings: tuple[wb.Finding, ...]) -> str:
    """The answer of the page in one line, from its findings."""
    first, _, _, row, _ = page_findings
    return f"{first.statement} {findings.SHORT_ROW if row.statement == findings.BOTH_SIGNS else row.statement}"


ROWS = wb.Paragraph(
    f"A search for each sign and shape of (33), in the first scenario alone, at any horizon up to {loops.LONGEST} s. "
    "The third group has the printed minus, the printed (24) and observer (10), with only (3) and (28) repaired. "
    f"The {rows.AGAIN} nearest choices of each search are run again at {1e3 * fits.FINE:.3g} ms and at half of it."
)
RANKING = wb.Paragraph(
    f"Independent draws of everything at once, {draws.RANDOM.runs} for each prior. The six laws of a draw have the "
    "same horizon and the same square wave. A range is not yet a prior: a number can be drawn uniformly, or uniformly "
    f"on a logarithmic scale. The prior of the card is logarithmic for Q, R and l of {PROPOSED_LAW}, of which only the "
    "order of magnitude is known. It is linear for all other numbers. The prior 'exchanged' is the opposite. sigma of "
    "RBF-ASMC, whose range begins at 0, is always drawn uniformly. A run that diverged before its horizon is worse "
    "than any other."
)
FIT_METHOD = wb.Paragraph(
    f"A search for each law evaluates {fits.EVALUATIONS} choices by differential evolution (seed {fits.SEED}). It "
    "looks for one set of gains for both rows of the law, each row with a separate horizon of up to "
    f"{fits.SEARCH_HORIZON:g} s. "
    f"{PROPOSED_LAW}, which has the most readings, has two searches (seeds "
    f"{' and '.join(map(str, fits.SEEDS[PROPOSED_LAW]))}). In the search, a computer with an implicit relay runs the "
    "rivals that switch every 2 ms. The relay keeps s as near to zero as the boundary layer does. The nearest "
    "points, and some from the whole search that are within 0.5 %, are run again. These runs are in continuous time, "
    f"with the boundary layer of the paper, at {1e3 * fits.FINE:.3g} ms and at half of it. Only these runs "
    "are called fits, and the error by the step is added to their miss."
)
OPEN = (
    wb.Paragraph(
        "The ranges are those of the card of report a1, and a number with one name is the same for all laws. The "
        f"horizon, {loops.SHORTEST} to {loops.LONGEST} s, needs no separate run. Other choices are not varied:"
    ),
    wb.document.Itemize(
        (
            f"R is drawn from {loops.STIFF:g} N m/(rad s) on instead of the card's 0.001. With a smaller R, P of (34) "
            "falls from P(0) so fast, at 720 / R 1/s, that a run with a step of 1 ms diverges because of the step.",
            "Torques have a limit only in the draws that state one. There a drive limits them, and observer (10) "
            "gets the limited torques. The integral of PID is held while the torque of PID is beyond the limit.",
        )
    ),
)
TRUST = wb.Paragraph(
    "The error of the step is twice the largest change of RMSE to half of the step. It is taken over one draw of "
    f"{draws.HALF_STEP_EVERY[PROPOSED_LAW]} of {PROPOSED_LAW}, one of {draws.RIVALS_HALF_STEP_EVERY} of the rivals, "
    "and all checks. For a rival that a computer switches, it is the error of the motion between two instants. The "
    "checks show how far the computer is from the boundary layer. With the chattering of a boundary layer every method "
    "is of first order. The change then shows the size of the error, but is not a bound. The last table counts every "
    "run that diverges within the longest horizon. A run that diverges later than the horizon of its draw still has an "
    "RMSE at that horizon."
)


def sweeps(tuning_results: Mapping[str, wb.tuning.TuningResult]) -> tuple[wb.Sweep, ...]:
    """The checks of the searches, and all draws."""
    places = [(law, scenario) for law in LAWS for scenario in SCENARIOS]
    checks = [fits.check(law, tuning_results[slug("search", law)], scenario) for law, scenario in places]
    common = [experiments.common_check(law, tuning_results) for law in LAWS]
    shared = [experiments.shared_check(law, tuning_results[slug("shared", law)]) for law in LAWS]
    priors = [
        draws.draws(kind, *place, prior)
        for kind in ("random", "limited")
        for prior in draws.PRIORS.values()
        for place in places
    ]
    paired = [draws.draws("paired", *place) for place in places]
    torques = [draws.peaks(scenario) for scenario in SCENARIOS]
    once = {one.name: one for one in priors}.values()
    return (rows.check(tuning_results), *checks, *common, *shared, *once, *paired, *torques)


study = wb.Study(
    name="a6_unstated_choices",
    title="AOSMC-RGS: the unstated numbers and readings, and what they decide",
    question=(
        "Which unstated numbers and readings give the published RMSE? How many different choices do so? Does the "
        "published ranking hold for all of them?"
    ),
    method=(
        f"{introduction(3, 10, 24, 28, 33, 43)} Every unstated number is drawn over the range of its card, the list of "
        "numbers in report a1. Every reading of an unclear equation is as likely as the others, both signs of (33) "
        "among them. Independent draws of all numbers and readings give the shares, under four priors and with limited "
        "torques; a Sobol design gives the indices. Searches by differential evolution look for the choices that meet "
        "the printed numbers. The nearest choices are run again with the boundary layer of the paper, with a step of "
        "1/12 ms and with half of it."
    ),
    tunings=(
        *(rows.search(*case) for case in rows.CASES),
        *map(fits.search, LAWS),
        *(experiments.common_search(law, horizon) for horizon in experiments.COMMON for law in LAWS),
        *map(experiments.shared_search, LAWS),
    ),
    sweeps=sweeps,
    sections=sections,
    seed=draws.RANDOM.seed,
)
