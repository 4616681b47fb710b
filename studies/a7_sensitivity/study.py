"""Which numbers decide how well each law tracks, how much its torque varies and what it costs?

Runs in about ten minutes on two cores.
"""

from collections.abc import Mapping, Sequence

import numpy as np

import workbench as wb
from studies.a7_sensitivity import findings, late_errors, sweeps
from studies.a7_sensitivity.fitted_derivatives import derivatives_of_fit
from studies.a7_sensitivity.gradients import gradient_finding
from studies.a7_sensitivity.results import (
    FLOOR,
    WORST,
    LawResults,
    Stress,
    derivatives,
    interval,
    measure_stress,
    output_name,
    results_of,
    worst_runs,
)
from studies.a7_sensitivity.second_looks import look_later, redraw, redrawn_gains, redrawn_words, suspects
from studies.a7_sensitivity.stray_runs import later_by_law, strays
from studies.a7_sensitivity.sweeps import METRICS, PROPOSED_LAW, SCENARIO, loop
from studies.a7_sensitivity.torque_variation import torque_variation
from studies.a7_sensitivity.varied_numbers import varied_section
from studies.paper.citation import introduction
from studies.paper.factors import GROUPS, SEED, factor_phrase, group_of
from studies.paper.fitted_arm import FIT
from studies.paper.fitted_page import fitted_page, fitted_study
from studies.paper.rest import REST, rest_section

LEAST_PAIR_INDEX = 0.02  # of the variance, below which a pair is not worth a word
FIGURE_METRICS = ("RMSE", "late error", "TV")
KNOB_WORDS = (
    "Each law has the numbers of the card. On the HTML page of this report the factors of the sweeps are knobs; each "
    "is a share of its number."
)


def indices_figure(one: LawResults, joint: int) -> wb.document.Figure:
    return wb.sobol_bars(
        f"aosmc_rgs_sobol_q{joint + 1}",
        f"Sobol indices of {one.law}, joint {joint + 1}.",
        one.shares_of([(metric, joint) for metric in FIGURE_METRICS]),
        tuple(one.indices.source(metric, joint, one.law) for metric in FIGURE_METRICS),
        labels=labels(one.indices.factors),
    )


def bands_figure(laws: Mapping[str, LawResults]) -> wb.document.Figure:
    first = laws[PROPOSED_LAW].random
    lost = ", ".join(f"{law} {one.random.diverged_count}" for law, one in laws.items())
    return wb.pictures.quantile_bands(
        "bands",
        f"The error of joint 1 in each window of {sweeps.EVERY:g} s, over random draws of all factors. Errors below "
        f"{1e3 * FLOOR:g} mrad are drawn as {1e3 * FLOOR:g} mrad, as rounding hides them.",
        first.t - sweeps.EVERY / 2,
        {law: one.bands(0) for law, one in laws.items()},
        f"For each law: {first.note_of('ISE', 0)} (the errors are those of {PROPOSED_LAW}). Failed runs: {lost}",
        "log10 of the error [rad]",
    )


def proposed_section(one: LawResults) -> wb.Section:
    effects = one.effects_on([("RMSE", 0), ("RMSE", 1)])
    tornado = wb.pictures.tornado_figure(
        "aosmc_rgs_tornado",
        f"The RMSE of joint 1 of {PROPOSED_LAW} with one factor at a time at each end of its range.",
        one.tornado_of("RMSE", 0),
        one.single.source("RMSE", 0, one.law),
        "rad",
        labels=labels(one.single.factors),
    )
    plane = wb.pictures.morris_plane(
        "aosmc_rgs_morris",
        f"Elementary effects on the RMSE of {PROPOSED_LAW}.",
        effects,
        tuple(one.screening.source("RMSE", joint, one.law) for joint in (0, 1)),
        "rad",
        labels=labels(effects.factors),
    )
    texts = wb.Paragraph(findings.idle_gains(one)), wb.Paragraph(acting_pairs(one.shares))
    return wb.Section(f"{PROPOSED_LAW} in full", (indices_figure(one, 1), plane, tornado, *texts))


def labels(names: Sequence[str]) -> dict[str, tuple[str | wb.notation.Formula, ...]]:
    return {name: factor_phrase(name) for name in names}


def _together(indices: wb.uncertainty.SobolIndices, output: str) -> wb.uncertainty.Estimate:
    """The indices of the pairs of factors, which the base of a design with pairs gives."""
    pairs = indices[output].S2
    if pairs is None:
        raise ValueError("The indices of a7 need a design with pairs of factors.")
    return pairs


def acting_pairs(indices: wb.uncertainty.SobolIndices) -> str:
    """The pairs of factors that act together, as far as the runs can tell."""
    names = [f"{indices.factors[i]} and {indices.factors[j]}" for i, j in indices.pairs]
    pairs = [
        f"{names[place]} ({output})"
        for output in indices.names
        for place in np.flatnonzero(_together(indices, output).low > LEAST_PAIR_INDEX)
    ]
    outputs = len(indices.names)
    reach = sum(int((_together(indices, output).high > LEAST_PAIR_INDEX).sum()) for output in indices.names)
    surely = (
        f"lies wholly above {LEAST_PAIR_INDEX:g} for {', '.join(pairs)}"
        if pairs
        else f"does not lie wholly above {LEAST_PAIR_INDEX:g}"
    )
    return (
        f"The index S2 is the part of the variance that two factors cause by acting together. For each of {outputs} "
        f"outputs, {len(names)} pairs were examined. The interval of S2, which holds for all pairs of an output at "
        f"once, {surely}{'' if pairs else ' for any pair'}. It reaches beyond {LEAST_PAIR_INDEX:g} for {reach:,} of "
        f"{outputs * len(names):,} pairs; for these a larger part is not ruled out."
    )


def groups_table(laws: Mapping[str, LawResults]) -> wb.document.ReportTable:
    """First-order parts of gains, arm and model, and what is left for factors that act together."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for law, one in laws.items():
        has = {group_of(factor) for factor in one.shares.factors}
        for metric, joint in ((metric.name, joint) for metric in METRICS for joint in (0, 1)):
            shares = one.shares[output_name(metric, joint)]
            whole = shares.of_group("all")
            cells = (interval(shares.of_group(group)) if group in has else None for group in GROUPS)
            rest = interval(wb.uncertainty.Estimate(1 - whole.value, whole.half))
            rows.append((law, metric, joint + 1, f"{float(shares.deviation):.2g}", *cells, rest))
    return wb.document.ReportTable(
        "groups",
        "The parts of the variance of each metric that gains, arm and model cause alone (sums of S1, intervals of "
        "95 %), and the rest, which is due to factors that act together. Standard deviations are in rad, but in N m/s "
        f"for the TV and in N m for the effort. An interval wider than {sweeps.NARROW:g} decides nothing here.",
        (
            *map(wb.document.TableColumn, ("law", "metric", "joint")),
            *(wb.document.TableColumn(head, align="right") for head in ("standard deviation", *GROUPS, "together")),
        ),
        tuple(rows),
    )


def trust_section(laws: Mapping[str, LawResults], stress: Mapping[str, Stress]) -> wb.Section:
    """Runs, failures, steps, and the runs with the largest TV beside the limit of stability."""
    runs = sum(len(sample) for one in laws.values() for sample in one.samples)
    text = (
        f"{runs:,} runs of {sweeps.UNTIL:g} s, seed {SEED}. A sample with a failed run has no indices. One run in "
        f"{sweeps.HALF_STEP_EVERY} is repeated at half of the step. The error of the step is largest in runs whose "
        f"gains grow most, and their torque varies most: so the {WORST} runs of each joint with the largest TV are "
        "repeated. A step beyond the limit of stability would itself cause a part of the TV."
    )
    rows = []
    for law, one in laws.items():
        worst = stress[law]
        within = f"{1e3 * worst.limit:.3g}{'' if sweeps.STEPS[law] <= worst.limit else ', passed'}"
        rows.append((law, one.indices.note_of("TV"), within, f"{worst.error:.1g}"))
    heads = (
        wb.document.TableColumn("limit", "ms", "right"),
        wb.document.TableColumn("error of the largest TV", align="right"),
    )
    steps = wb.document.ReportTable(
        "steps",
        "The runs of the indices; the longest stable step along the runs with the largest TV, and the error of that "
        "TV by the step, relative to its standard deviation over the runs.",
        (wb.document.TableColumn("law"), wb.document.TableColumn("runs of the indices"), *heads),
        tuple(rows),
    )
    return wb.Section("Can the numbers be trusted?", (wb.Paragraph(text), steps))


def rest(results: wb.Results) -> wb.Section:
    """The linear pictures of the proposed law, which the factors of the sweeps move."""
    knobs = (
        "On the HTML page the knobs move these pictures together with the runs. P(0), Q, R and D have no part in the "
        "pictures. The rate l of (24) moves only the pole of (24)."
    )
    return rest_section(
        results[REST, PROPOSED_LAW], results[SCENARIO, PROPOSED_LAW], "It has the four repairs of report a1.", knobs
    )


def works(results: wb.Results) -> tuple[wb.Work, ...]:
    """The derivatives of each law, and runs again: those with the largest TV, those that stray, and the heaviest."""
    laws = {law: results_of(results, law) for law in sweeps.LAWS}
    worst = tuple(map(worst_runs, laws.values()))
    astray = tuple(runs for one in laws.values() for runs in suspects(one))
    return (
        wb.Work("derivatives", derivatives if FIT is None else derivatives_of_fit, sweeps.LAWS, seconds=5.0),
        wb.Work("stress", measure_stress, worst, seconds=1.0),
        wb.Work("later", look_later, astray, seconds=20.0),
        wb.Work("redrawn", redraw, (redrawn_gains(laws[PROPOSED_LAW]),), seconds=20.0),
    )


def sections(results: wb.Results) -> wb.Page:
    laws = {law: results_of(results, law) for law in sweeps.LAWS}
    near = dict(zip(sweeps.LAWS, results.work("derivatives"), strict=True))
    later, (redrawn,) = later_by_law(laws, results.work("later")), results.work("redrawn")
    own = {
        one.case.law: max(float(one.score("late error", joint).value[0]) for joint in (0, 1))
        for one in results.scenario(SCENARIO)
    }
    ours = laws[PROPOSED_LAW]
    pictures = indices_figure(ours, 0), bands_figure(laws)
    words = f"{late_errors.heaviest(ours.indices)} {redrawn_words(ours, redrawn)}"
    heavy = wb.Paragraph(words), late_errors.heavy_table(ours.indices)
    page = wb.Page(
        findings.answer(laws),
        (
            findings.deciding_gain(ours, near[PROPOSED_LAW]),
            late_errors.late_error_of(ours, redrawn),
            torque_variation(ours),
            strays(laws, later, redrawn, own),
            gradient_finding(laws, near),
        ),
        (
            wb.Section("Indices and bands", (*pictures, findings.leaders_table(laws))),
            wb.Section("The runs behind the late error", heavy),
            proposed_section(ours),
            wb.Section("Gains, arm or model", (groups_table(laws),)),
            varied_section(laws),
            trust_section(laws, dict(zip(sweeps.LAWS, results.work("stress"), strict=True))),
            wb.pictures.loops_section("One run of each law", KNOB_WORDS, results.scenario(SCENARIO)),
            rest(results),
        ),
    )
    return fitted_page(page)


study = wb.Study(
    name="a7_sensitivity",
    title="AOSMC-RGS and its rivals: which numbers decide",
    question=(
        "Which numbers decide the errors, the variation of the torque and the effort of AOSMC-RGS and of each of its "
        "rivals, alone and together: the design gains, the arm, or the law's model of the arm? Does the exact "
        "derivative at the numbers of report a1 predict this?"
    ),
    method=(
        f"{introduction(24, 33, 34)} All factors are screened in the first scenario by Morris's elementary effects. "
        "For the factors with an effect, Sobol indices of first and total order are estimated, and for AOSMC-RGS also "
        "of second order, with a quadratic polynomial as control variate. A conclusion rests only on intervals "
        "narrower than 0.1. Random runs give bands over time, and the equations give exact derivatives."
    ),
    sections=sections,
    fingerprints={law: loop(law).ode().fingerprint[:16] for law in sweeps.LAWS},
    seed=SEED,
    cases=sweeps.own_numbers(),
    works=works,
    sweeps=tuple(sweep for law in sweeps.LAWS for sweep in sweeps.sweeps(law).values()),
)
study = fitted_study(study)
