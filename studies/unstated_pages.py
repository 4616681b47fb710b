"""How a6 reads: the answers, what is open, the nearest fits, how many there are, and who wins."""

from collections.abc import Mapping, Sequence

import numpy as np
from paper_card import LAWS
from unstated_draws import factors_of, slug
from unstated_fits import CLOSE, COMMON, horizons, misses, nearest
from unstated_found import Found, found_for, said, wide_factors, words
from unstated_loops import PROPOSED, SCENARIOS, SQUARE, STIFF, unit
from unstated_ranking import deciding_section, ranking_section, rankings, winner_verdict
from unstated_tables import CELLS, counts_section, fits_section

from workbench.study.cells import raised
from workbench.study.document import Cell, Column, Itemize, Paragraph, Section, Table, Verdict
from workbench.study.sample import Sample
from workbench.study.study import Results


def sections(results: Results) -> Sequence[Section]:
    """What the report says."""
    found = {law: found_for(results, law) for law in LAWS}
    ranked = rankings(results)
    return (
        Section("What was found", (*verdicts(found), horizon_verdict(results), winner_verdict(ranked))),
        open_section(results),
        fits_section(found),
        counts_section(found),
        ranking_section(results, ranked),
        deciding_section(results),
        trust_section(results, found),
    )


def headlines(results: Results) -> Sequence[str]:
    """The findings in a line each."""
    found = {law: found_for(results, law) for law in LAWS}
    every = (*verdicts(found), horizon_verdict(results), winner_verdict(rankings(results)))
    return tuple(f"{one.statement} {one.kind.capitalize()}: {one.evidence}" for one in every)


def verdicts(found: Mapping[str, Found]) -> tuple[Verdict, ...]:
    """What the fits say; what a search did not find may be there all the same."""
    ours = found[PROPOSED].fits["FS"]
    fits = [found[law].fits[cell] for law in LAWS for cell in CELLS]
    both = [found[law].fits["both"] for law in LAWS]
    worst = max(both, key=lambda one: one.miss)
    met = sum(one.met for one in fits)
    return (
        Verdict(
            "holds" if ours.met else "open",
            f"Numbers and readings that are not stated give the printed row of {PROPOSED} in the first scenario.",
            f"The nearest is off by {_percent(ours.miss)} at most, the error of the step included: "
            f"{said(ours, square=False)}, and a horizon of {ours.horizon['FS']:.1f} s.",
        ),
        Verdict(
            "holds" if met == len(fits) else "open",
            "Numbers and readings that are not stated give each of the 24 printed cells by itself.",
            f"{met} of {len(fits)} cells are met within {_percent(CLOSE)}.",
        ),
        Verdict(
            "holds" if all(one.met for one in both) else "open",
            "One choice for each law gives all four cells of that law, each scenario at a horizon of its own.",
            f"Within {_percent(CLOSE)} one was found for {sum(one.met for one in both)} of {len(both)} laws; "
            f"{worst.law} misses most, "
            f"by {_percent(worst.miss)}. Each law then has a square wave and horizons of its own.",
        ),
        _determined(found),
    )


def _determined(found: Mapping[str, Found]) -> Verdict:
    """Whether the choices that meet the first scenario are nearly the same."""
    wide = {law: wide_factors(one) for law, one in found.items()}
    known = all(len(one.close["FS"]) > 1 for one in found.values())
    said_of = "; ".join(f"of {law} {', '.join(names) or 'none'}" for law, names in wide.items())
    return Verdict(
        "fails" if any(wide.values()) else "holds" if known else "open",
        "The printed table of the first scenario determines the numbers that are not stated.",
        f"Among the choices that meet both joints of a law within {_percent(CLOSE)} these lie over more than half of "
        f"their ranges: {said_of}.",
    )


def horizon_verdict(results: Results) -> Verdict:
    """Whether one horizon serves all laws in the first scenario, as one experiment must."""
    least = []
    for law in LAWS:
        samples = (results.sample(slug("random", law, "FS")), results.sample(slug("paired", law, "FS")))
        sought = [results.tuned(slug(kind, law)).samples["fs"] for kind in ("search", "common")]
        every = (*samples, *sought)
        least.append(np.min([misses(law, "FS", horizons(one)[1]).min(axis=0) for one in every], axis=0))
    worst = np.max(least, axis=0)
    at = int(np.argmin(worst))
    law = LAWS[int(np.argmax([one[at] for one in least]))]
    horizon = horizons(results.sample(slug("random", PROPOSED, "FS")))[0]
    met = sum(bool(one[at] <= CLOSE) for one in least)
    return Verdict(
        "holds" if worst[at] <= CLOSE else "open",
        "One horizon for all six laws, as one experiment has, gives the table of the first scenario.",
        f"Over all runs, among them a search for each law at {COMMON:g} s, where a longer one by hand had found all "
        f"laws nearest, the best is {horizon[at]:.1f} s: {met} of {len(LAWS)} rows come "
        f"within {_percent(CLOSE)}, and {law}, the furthest, within {_percent(float(worst[at]))}.",
    )


def _percent(part: float) -> str:
    return f"{100 * part:.2g} %"


def open_section(results: Results) -> Section:
    """What is searched, and what is not."""
    laws: dict[str, list[str]] = {}
    rows: dict[str, tuple[Cell, ...]] = {}
    for law in LAWS:
        for factor in factors_of(law, "SS"):
            laws.setdefault(factor.name, []).append(law)
            of = "all, in the second scenario" if factor in SQUARE else ", ".join(laws[factor.name])
            rows[factor.name] = (factor.name, of, words(factor), raised(unit(law, factor)) or None)
    minus, beside = results.sample("minus"), results.sample("observed_pid")
    nearest_minus = float(nearest(PROPOSED, "FS", {"FS": minus}).min())
    return Section(
        "What is open",
        (
            Paragraph(
                "The ranges are those of the card of a1; a number known by its order of magnitude only is spread over "
                "its logarithm. Where two laws have a number of one name, it is the same for both. The horizon, 5 to "
                "30 s, needs no run of its own: a run gives RMSE at every time."
            ),
            Table(
                "open",
                "What the paper leaves open, and over what it is searched and drawn.",
                (Column("number or reading"), Column("of"), Column("over"), Column("unit")),
                tuple(rows.values()),
                ("RMSE is (43) over samples every 10 ms.",),
            ),
            Paragraph("Taken as given, though the paper does not state it:"),
            Itemize(
                (
                    f"R from {STIFF:g} on instead of the card's 0.001: below, (34) falls from P(0) so fast, at 720 / R "
                    "1/s, that a run at 1 ms diverges by its step alone;",
                    f"the plus in (33): with the minus that is printed {_lost(minus)} draws of the rest diverge, "
                    f"and the nearest of the others is off the printed row by {_percent(nearest_minus)};",
                    f"exact measurements for PID: beside observer (10) {_lost(beside)} draws diverge;",
                    "no limit of torques, no noise, no sampling; the sample time of (43); zero derivatives of the "
                    "square wave.",
                )
            ),
        ),
    )


def _lost(sample: Sample) -> str:
    return f"{sample.failed} of {len(sample)}"


def trust_section(results: Results, found: Mapping[str, Found]) -> Section:
    """Steps, their errors, and failed runs."""
    rows: list[tuple[Cell, ...]] = []
    for law in LAWS:
        tuned = results.tuned(slug("search", law))
        for scenario in SCENARIOS:
            random, check = (results.sample(slug(kind, law, scenario)) for kind in ("random", "check"))
            change = [random.step_error("RMSE (43)", joint) for joint in (0, 1)]
            fine = [check.step_error("RMSE (43)", joint) for joint in (0, 1)]
            failed = int(np.isfinite(tuned.samples[scenario.lower()].diverged_at).sum())
            rows.append(
                (
                    scenario,
                    law,
                    f"{1e3 * random.h:g}",
                    f"{random.failed} of {len(random)}",
                    f"{failed} of {tuned.tuning.size}",
                    max(change),
                    f"{check.failed} of {len(check)}",
                    max(fine),
                )
            )
    columns = (
        Column("scenario"),
        Column("law"),
        Column("step", "ms", "right"),
        Column("draws that diverged", align="right"),
        Column("of the search", align="right"),
        Column("step error of draws", "rad", "right", digits=2),
        Column("checks that diverged", align="right"),
        Column("step error of checks", "rad", "right", digits=2),
    )
    return Section(
        "How far these numbers can be trusted",
        (
            Paragraph(
                "The error of the step is the largest change of RMSE at 30 s from the step to half of it, over one "
                "draw of 32, and over all checks. Of a rival that switches by a computer it is that of the motion "
                "between two instants; how far the computer is from the boundary layer the checks show. The chattering "
                "of a boundary layer makes every method one of first order: the change tells the size of the error and "
                "bounds nothing. A choice whose run diverged is no fit, and is counted."
            ),
            Table("steps", "Steps, their errors, and runs that diverged.", columns, tuple(rows)),
        ),
    )
