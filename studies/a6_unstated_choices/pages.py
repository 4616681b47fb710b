"""How a6 reads: the answers, what is open, the nearest fits, how many there are, and who wins."""

from collections.abc import Mapping, Sequence

import numpy as np

from studies.a6_unstated_choices.draws import LONGEST, OF_CARD, PRIORS, SHORTEST, factors_of, named, slug
from studies.a6_unstated_choices.fits import CLOSE, COMMON, EVALUATIONS, FINE, SAMPLE, SEED, horizons, misses, nearest
from studies.a6_unstated_choices.loops import PROPOSED, SCENARIOS, SQUARE, STIFF, unit
from studies.a6_unstated_choices.priors import (
    Ranked,
    favoured,
    first_verdict,
    of_all_priors,
    pairs_verdict,
    priors_section,
)
from studies.a6_unstated_choices.ranking import deciding_section, ranking_section, shaken
from studies.a6_unstated_choices.results import Found, found_for, said, wide_factors, words
from studies.a6_unstated_choices.shared_choices import Shared, shared, shared_table, shared_verdict
from studies.a6_unstated_choices.tables import CELLS, counts_section, fits_section
from studies.paper.card import LAWS
from workbench.study.document.document import Cell, Column, Itemize, Paragraph, Section, Table, Verdict
from workbench.study.document.phrases import raised
from workbench.study.sample import Sample
from workbench.study.study import Results

USUAL = next(name for name, prior in PRIORS.items() if prior == OF_CARD)
_SETS = (*(("random", prior) for prior in PRIORS.values()), ("paired", OF_CARD))
OF_A_FIT = (
    f"The largest miss of the cells, of runs with the boundary layer of the paper at {1e3 * FINE:.3g} ms, their change "
    f"to half of it added; searches of {EVALUATIONS} choices, whatever the prior."
)
RANGES = f"A plus in (33), R from {STIFF:g} on, any horizon from {SHORTEST} to {LONGEST} s"
OF_A_WITNESS = "A run of the printed numbers at a finer step that misses by more."
LONGER = "A longer search: what was not found may be there."
FINER = "A finer step for the runs of what is near, or a longer search."


def sections(results: Results) -> Sequence[Section]:
    """What the report says."""
    found, ranked, one = {law: found_for(results, law) for law in LAWS}, of_all_priors(results), shared(results)
    return (
        Section("What was found", findings(results, found, ranked, one)),
        open_section(results),
        fits_section(found),
        Section("One experiment for all six laws", (shared_table(one),)),
        counts_section(found),
        priors_section(ranked),
        ranking_section(results, ranked[USUAL]),
        deciding_section(results),
        trust_section(results, found),
    )


def headlines(results: Results) -> Sequence[str]:
    """The findings in a line each."""
    found = {law: found_for(results, law) for law in LAWS}
    every = findings(results, found, of_all_priors(results), shared(results))
    return tuple(f"{one.kind}: {one.statement}" for one in every)


def findings(results: Results, found: Mapping[str, Found], ranked: Ranked, one: Shared) -> tuple[Verdict, ...]:
    """All of them, who is first before what fits."""
    step = shaken(results, PRIORS.values())
    return (
        first_verdict(ranked, favoured(results), step),
        pairs_verdict(ranked, step),
        *verdicts(found),
        horizon_verdict(results),
        shared_verdict(one),
    )


def verdicts(found: Mapping[str, Found]) -> tuple[Verdict, ...]:
    """What the fits say; what a search did not find may be there all the same."""
    ours = found[PROPOSED].fits["FS"]
    fits = [found[law].fits[cell] for law in LAWS for cell in CELLS]
    both = [found[law].fits["both"] for law in LAWS]
    worst = max(both, key=lambda one: one.miss)
    met, together = sum(one.met for one in fits), sum(one.met for one in both)
    return (
        Verdict(
            "found" if ours.met else "open",
            f"The nearest choice of what is not stated misses the printed row of {PROPOSED} in the first scenario by "
            f"{_percent(ours.miss)}, at the farther of its two cells.",
            f"It is {said(ours, square=False)}, and a horizon of {ours.horizon['FS']:.1f} s.",
            OF_A_FIT,
            f"{RANGES}.",
            OF_A_WITNESS if ours.met else LONGER,
        ),
        Verdict(
            "found" if met == len(fits) else "open",
            f"{met} of the {len(fits)} printed cells are met within {_percent(CLOSE)}, each taken alone.",
            f"The farthest is missed by {_percent(max(one.miss for one in fits))}.",
            OF_A_FIT,
            f"{RANGES}; numbers, a square wave and a horizon of its own for each cell.",
            OF_A_WITNESS if met == len(fits) else LONGER,
        ),
        Verdict(
            "found" if together == len(both) else "open",
            f"For {together} of {len(both)} laws one choice meets all four cells of the law within {_percent(CLOSE)}.",
            f"{worst.law} misses most, by {_percent(worst.miss)}; without the change to half of the fine step, which "
            f"is added, a choice of it misses by {_percent(worst.at_step)}. At the step of the search "
            f"{_close(found[worst.law])} of its choices come within {_percent(CLOSE)}.",
            OF_A_FIT,
            f"{RANGES}; one set of gains for both scenarios, and a square wave and two horizons of its own for each "
            "law.",
            OF_A_WITNESS if together == len(both) else FINER,
        ),
        _determined(found),
    )


def _determined(found: Mapping[str, Found]) -> Verdict:
    """How many numbers differ widely among the choices that meet the first scenario."""
    wide = {law: wide_factors(one) for law, one in found.items()}
    known = all(len(one.close["FS"]) > 1 for one in found.values())
    said_of = "; ".join(f"of {law} {', '.join(names) or 'none'}" for law, names in wide.items())
    return Verdict(
        "found" if any(wide.values()) or known else "open",
        f"{sum(map(len, wide.values()))} of the {sum(len(factors_of(law, 'FS')) for law in found)} numbers and "
        "readings of the six laws take values from more than half of their ranges among the choices that meet the "
        f"first scenario within {_percent(CLOSE)}.",
        f"They are {said_of}.",
        "The distance from the least to the largest value in all choices within 1 % of both joints, of draws and "
        "searches together, at the steps of the search.",
        f"{RANGES}; each law by itself.",
        "A table with more digits, or with a second statistic beside RMSE.",
    )


def horizon_verdict(results: Results) -> Verdict:
    """How near one horizon brings all laws in the first scenario, as one experiment must."""
    least = []
    for law in LAWS:
        samples = [results.sample(named(kind, law, "FS", prior)) for kind, prior in _SETS]
        sought = [results.tuned(slug(kind, law)).samples["fs"] for kind in ("search", "common")]
        every = (*samples, *sought)
        least.append(np.min([misses(law, "FS", horizons(one)[1]).min(axis=0) for one in every], axis=0))
    worst = np.max(least, axis=0)
    at = int(np.argmin(worst))
    law = LAWS[int(np.argmax([one[at] for one in least]))]
    horizon = horizons(results.sample(named("random", PROPOSED, "FS")))[0]
    met = sum(bool(one[at] <= CLOSE) for one in least)
    return Verdict(
        "found" if met == len(LAWS) else "open",
        f"At one horizon for all laws, {horizon[at]:.1f} s, {met} of {len(LAWS)} rows of the first scenario come "
        f"within {_percent(CLOSE)}.",
        f"{law} is the farthest, within {_percent(float(worst[at]))}.",
        "The larger miss of the two cells of a law, the least over all runs of draws and searches, at their steps and "
        f"without a run at a finer one; among them a search of {EVALUATIONS // 2} choices for each law at "
        f"{COMMON:g} s (seed {SEED}), where a longer one by hand had found all laws nearest.",
        "The same horizon, and gains of its own for each law.",
        f"{LONGER[:-1]}; runs at a finer step, for rows that are met.",
    )


def _close(found: Found) -> int:
    """How many choices of the search meet all four cells at its step."""
    return int((found.sought["both"] <= CLOSE).sum())


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
                    f"the plus in (33): with the minus that is printed {_lost(minus)} draws of the rest diverge; "
                    f"the others have a root mean square error of at most {late(minus):.2g} rad from {SHORTEST} s on, "
                    f"and the nearest of them is off the printed row by {_percent(nearest_minus)}; no search was made "
                    "with the minus, so the shares below leave it out;",
                    f"exact measurements for PID: beside observer (10) {_lost(beside)} draws diverge;",
                    "no limit of torques, no noise, no sampling; the sample time of (43); zero derivatives of the "
                    "square wave.",
                )
            ),
        ),
    )


def late(sample: Sample) -> float:
    """The largest root mean square error, of runs that did not diverge and both joints, from the shortest horizon to
    the longest.
    """
    t, rmse = horizons(sample)
    sums = rmse**2 * (t + SAMPLE)[:, np.newaxis]
    return float(np.sqrt(np.nanmax(sums[:, -1] - sums[:, 0]) / (t[-1] - t[0])))


def _lost(sample: Sample) -> str:
    return f"{sample.failed} of {len(sample)}"


def trust_section(results: Results, found: Mapping[str, Found]) -> Section:
    """Steps, their errors, and failed runs."""
    rows: list[tuple[Cell, ...]] = []
    for law in LAWS:
        tuned = results.tuned(slug("search", law))
        for scenario in SCENARIOS:
            random = results.sample(named("random", law, scenario))
            check = results.sample(slug("check", law, scenario))
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
