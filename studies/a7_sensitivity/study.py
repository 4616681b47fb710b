"""Which numbers decide how well each law tracks, how much it chatters and what it costs?

Runs in about two minutes on two cores.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from studies.a7_sensitivity import findings, late_errors, sweeps
from studies.a7_sensitivity.results import (
    FLOOR,
    WORST,
    LawResults,
    Stress,
    derivatives,
    interval,
    named,
    percent,
    results_of,
    stressed,
    worst_runs,
)
from studies.a7_sensitivity.sweeps import METRICS, PROPOSED, called, factors, group_of, loop
from workbench.study import Results, Study, Work
from workbench.study.document.document import Cell, Column, Figure, Page, Paragraph, Phrase, Section, Table
from workbench.study.pictures import morris_plane, quantile_bands, sobol_bars, tornado_figure
from workbench.study.pictures.traces import loops_section
from workbench.study.uncertainty import Estimate, SobolIndices
from workbench.study.uncertainty.factors import Space

FELT = 0.02  # of the variance, below which a pair is not worth a word
SHOWN = ("RMSE", "late error", "TV")
TURNED = (
    "Each law with the numbers of the card, run alone. In the page of this report the factors of the sweeps are knobs, "
    "each a share of its number."
)


def indices_figure(one: LawResults, joint: int) -> Figure:
    return sobol_bars(
        f"aosmc_rgs_sobol_q{joint + 1}",
        f"Indices of {one.law}, joint {joint + 1}.",
        one.shares_of([(metric, joint) for metric in SHOWN]),
        tuple(one.indices.source(metric, joint, one.law) for metric in SHOWN),
        labels=labels(one.indices.factors),
    )


def bands_figure(laws: Mapping[str, LawResults]) -> Figure:
    first = laws[PROPOSED].random
    lost = ", ".join(f"{law} {one.random.failed}" for law, one in laws.items())
    return quantile_bands(
        "bands",
        f"The error of joint 1 in each window of {sweeps.EVERY:g} s, over random draws of all factors; errors below "
        f"{1e3 * FLOOR:g} mrad are drawn there, as the integrals behind them round.",
        first.t - sweeps.EVERY / 2,
        {law: one.bands(0) for law, one in laws.items()},
        f"Of each law {first.note_of('ISE', 0)} (the errors are those of {PROPOSED}). Failed runs: {lost}",
        "log10 of the error [rad]",
    )


def proposed_section(one: LawResults) -> Section:
    effects = one.effects_on([("RMSE", 0), ("RMSE", 1)])
    tornado = tornado_figure(
        "aosmc_rgs_tornado",
        f"The RMSE of joint 1 of {PROPOSED} at the ends of the range of each factor by itself.",
        one.tornado_of("RMSE", 0),
        one.swings.source("RMSE", 0, one.law),
        "rad",
        labels=labels(one.swings.factors),
    )
    plane = morris_plane(
        "aosmc_rgs_morris",
        f"Elementary effects on the RMSE of {PROPOSED}.",
        effects,
        tuple(one.screening.source("RMSE", joint, one.law) for joint in (0, 1)),
        "rad",
        labels=labels(effects.factors),
    )
    texts = Paragraph(findings.idle_gains(one)), Paragraph(acting_pairs(one.shares))
    return Section(f"{PROPOSED} in full", (indices_figure(one, 1), plane, tornado, *texts))


def labels(names: Sequence[str]) -> dict[str, Phrase]:
    return {name: sweeps.written(name) for name in names}


def acting_pairs(indices: SobolIndices) -> str:
    """The pairs of factors that act together, as far as the runs can tell."""
    names = [f"{indices.factors[i]} and {indices.factors[j]}" for i, j in indices.pairs]
    pairs = [
        f"{names[place]} ({output})"
        for output in indices.names
        for place in np.flatnonzero(indices[output].S2.low > FELT)
    ]
    return (
        f"Of {len(names)} pairs of factors, whose intervals hold together, S2 exceeds {FELT:g} for "
        f"{', '.join(pairs) or 'none'}."
    )


def groups_table(laws: Mapping[str, LawResults]) -> Table:
    """First-order parts of gains, arm and model, and what is left for factors that act together."""
    rows: list[tuple[Cell, ...]] = []
    for law, one in laws.items():
        has = {group_of(factor) for factor in one.shares.factors}
        for metric, joint in ((metric.name, joint) for metric in METRICS for joint in (0, 1)):
            shares = one.shares[named(metric, joint)]
            whole = shares.of_group("all")
            cells = (interval(shares.of_group(group)) if group in has else None for group in sweeps.GROUPS)
            rest = interval(Estimate(1 - whole.value, whole.half))
            rows.append((law, metric, joint + 1, f"{float(shares.deviation):.2g}", *cells, rest))
    return Table(
        "groups",
        "The parts of the variance of each metric that gains, arm and model have by themselves (sums of S1, intervals "
        "of 95 %), and what is left, which is due to factors that act together. Deviations are in rad, of the TV in "
        f"N m/s, of the effort in N m; an interval wider than {sweeps.NARROW:g} decides nothing here.",
        (
            *map(Column, ("law", "metric", "joint")),
            *(Column(head, align="right") for head in ("standard deviation", *sweeps.GROUPS, "together")),
        ),
        tuple(rows),
    )


def varied_section(laws: Mapping[str, LawResults]) -> Section:
    """The factors, their ranges, and those that the screening left at their values."""
    text = (
        "All factors are shares of the numbers on the card (a1), independent of one another. What the paper states is "
        f"off by up to {percent(sweeps.TOLERANCE)} either way. What is assumed lies within a factor of "
        f"{sweeps.SPAN:g}, evenly on a logarithmic scale, and within the range on the card where that is narrower. The "
        "ranges of the card are mostly wider, up to a factor of 20. Over those the adaptive laws grow gains of several "
        "hundred N m, and behind a layer of 0.01 rad/s a gain of 300 N m is stable for steps below 0.02 ms only: "
        "beyond them a run chatters by the step alone. So the indices hold for these ranges, and say nothing of wider "
        "ones. The arm and the model of it are factors of their own: where one moves and the other does not, the law, "
        "and the observer of AOSMC-RGS, believe in a wrong arm. Gravity is the exception, which all know. PID has no "
        "model; its gains follow from an assumed pole, and are as uncertain as that."
    )
    return Section("What is varied", (Paragraph(text), left_table(laws), *map(ranges_table, laws)))


def ranges_table(law: str) -> Table:
    ode = loop(law).ode()
    space = Space(factors(law), ode.parameters, ode.states)
    return space.table(called(law, "ranges"), f"What is varied of {law}.")


def left_table(laws: Mapping[str, LawResults]) -> Table:
    """The factors that the screening left at their values, held against its rule."""
    rows: list[tuple[Cell, ...]] = []
    for law, one in laws.items():
        if not sweeps.HELD[law]:
            continue
        size, places = one.effects.mu_star, [one.effects.factors.index(name) for name in sweeps.HELD[law]]
        most = size.value.max(axis=1, keepdims=True)
        share, high = (float((part / most)[:, places].max()) for part in (size.value, size.high))
        kept = "yes" if high < sweeps.CLEARED else "no" if share >= sweeps.CLEARED else "open"
        rows.append((law, ", ".join(sweeps.HELD[law]), percent(share), percent(high), kept))
    return Table(
        "left",
        "What the Sobol indices leave at its value, and the largest mu* among it, relative to the largest of the same "
        f"output, with the upper end of its interval. The rule asks for less than {percent(sweeps.CLEARED)}.",
        tuple(map(Column, ("law", "left at its value", "largest mu*", "at most", "rule kept"))),
        tuple(rows),
    )


def trust_section(laws: Mapping[str, LawResults], stress: Mapping[str, Stress]) -> Section:
    """Runs, failures, steps, and the runs that chatter most beside the limit of stability."""
    runs = sum(len(sample) for one in laws.values() for sample in one.samples)
    text = (
        f"{runs:,} runs of {sweeps.UNTIL:g} s, seed {sweeps.SEED}. A sample with a failed run has no indices. One run "
        f"in {sweeps.HALVED} is run at half of the step too. The step errs most in runs whose gains grow largest, "
        f"and these chatter most: so the {WORST} runs of each joint with the largest TV are run again too. A step "
        "beyond the limit of stability would make a TV that is partly its own."
    )
    rows = []
    for law, one in laws.items():
        worst = stress[law]
        within = f"{1e3 * worst.limit:.3g}{'' if sweeps.STEPS[law] <= worst.limit else ', passed'}"
        rows.append((law, one.indices.note_of("TV"), within, f"{worst.error:.1g}"))
    heads = (Column("limit", "ms", "right"), Column("error of the largest TV", align="right"))
    steps = Table(
        "steps",
        "The runs of the indices; the longest stable step along the runs with the largest TV, and the error of that "
        "TV by the step, relative to its standard deviation over the runs.",
        (Column("law"), Column("runs of the indices"), *heads),
        tuple(rows),
    )
    return Section("Can the numbers be trusted?", (Paragraph(text), steps))


def works(results: Results) -> tuple[Work, ...]:
    """The exact derivatives of each law, and its runs that chatter most again."""
    worst = tuple(worst_runs(results_of(results, law)) for law in sweeps.LAWS)
    return Work("derivatives", derivatives, sweeps.LAWS, seconds=5.0), Work("stress", stressed, worst, seconds=1.0)


def sections(results: Results) -> Page:
    laws = {law: results_of(results, law) for law in sweeps.LAWS}
    near = dict(zip(sweeps.LAWS, results.work("derivatives"), strict=True))
    ours = laws[PROPOSED]
    pictures = indices_figure(ours, 0), bands_figure(laws)
    heavy = Paragraph(late_errors.heaviest(ours.indices)), late_errors.heavy_table(ours.indices)
    return Page(
        findings.answer(laws),
        (
            findings.deciding_gain(ours),
            late_errors.late_error_of(ours),
            findings.chattering(ours),
            findings.strays(laws),
            findings.foretold(laws, near),
        ),
        (
            Section("Indices and bands", (*pictures, findings.leaders_table(laws))),
            Section("The runs behind the late error", heavy),
            proposed_section(ours),
            Section("Gains, arm or model", (groups_table(laws),)),
            varied_section(laws),
            trust_section(laws, dict(zip(sweeps.LAWS, results.work("stress"), strict=True))),
            loops_section("The laws, to be turned", TURNED, results.outcomes),
        ),
    )


study = Study(
    name="a7_sensitivity",
    title="AOSMC-RGS and its rivals: which numbers decide",
    question=(
        "Of the design gains, the arm and the law's model of it: which decide the errors, the chattering and the "
        "effort of AOSMC-RGS and of each of its rivals, alone and together? And does the exact derivative at the "
        "numbers of the card foretell that?"
    ),
    method=(
        "First scenario. All factors are screened by Morris's effects; Sobol indices of first, second and total "
        "order follow for those that the screening leaves, with a quadratic polynomial as control variate; a "
        "sentence rests only on intervals narrower than 0.1. Random runs give bands over time, the equations exact "
        "derivatives."
    ),
    sections=sections,
    fingerprints={law: loop(law).ode().fingerprint[:16] for law in sweeps.LAWS},
    seed=sweeps.SEED,
    cases=sweeps.own_numbers(),
    works=works,
    sweeps=tuple(sweep for law in sweeps.LAWS for sweep in sweeps.sweeps(law).values()),
)
