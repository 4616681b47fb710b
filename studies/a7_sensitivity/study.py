"""Which numbers decide how well each law tracks, how much it chatters and what it costs?

Runs in about two minutes on two cores.
"""

from collections.abc import Sequence
from functools import cache

from studies.a7_sensitivity import findings
from studies.a7_sensitivity.pages import (
    bands_figure,
    groups_table,
    indices_figure,
    proposed_section,
    trust_section,
    varied_section,
)
from studies.a7_sensitivity.results import Derivatives, LawResults, derivatives, results_of
from studies.a7_sensitivity.sweeps import LAWS, PROPOSED, SEED, loop, sweeps
from workbench.study.document.document import Section, Verdict
from workbench.study.study import Results, Study


@cache
def near() -> dict[str, Derivatives]:
    """The derivatives of every law."""
    return {law: derivatives(law) for law in LAWS}


@cache
def laws_of(results: Results) -> dict[str, LawResults]:
    """The results of every law."""
    return {law: results_of(results, law) for law in LAWS}


def verdicts(results: Results) -> tuple[Verdict, ...]:
    """The findings."""
    laws, ours = laws_of(results), laws_of(results)[PROPOSED]
    return (
        findings.deciding_gain(ours),
        findings.idle_gains(ours),
        findings.late_error_of(ours),
        findings.chattering(ours),
        findings.strays(laws),
        findings.foretold(laws, near()),
    )


def sections(results: Results) -> Sequence[Section]:
    """The sections of the report."""
    laws, ours = laws_of(results), laws_of(results)[PROPOSED]
    pictures = indices_figure(ours, 0), bands_figure(laws)
    return (
        Section("What was found", (*pictures, *verdicts(results), findings.leaders_table(laws))),
        proposed_section(ours),
        Section("Gains, arm or model", (groups_table(laws),)),
        varied_section(laws),
        trust_section(laws),
    )


def headlines(results: Results) -> Sequence[str]:
    """The findings in a line each."""
    return tuple(f"{verdict.kind}: {verdict.statement}" for verdict in verdicts(results))


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
    headlines=headlines,
    fingerprints={law: loop(law).ode().fingerprint[:16] for law in LAWS},
    seed=SEED,
    sweeps=tuple(sweep for law in LAWS for sweep in sweeps(law).values()),
)
