"""Which claims of the AOSMC-RGS paper stand, and which fall?

Runs in about half a minute on two cores.
"""

from collections.abc import Sequence
from functools import cache

from studies.a1_paper_tables.study import comparison
from studies.a2_claims import arm, law, observer, pages, rivals, theorem
from studies.a2_claims.searches import SEED
from workbench.claims.verdicts import Ledger
from workbench.study.document.document import Section
from workbench.study.study import Results, Study


@cache
def ledger(results: Results) -> Ledger:
    """Every claim checked, in the order of the paper."""
    lines = (*arm.CHECKS, *observer.CHECKS, *law.CHECKS, *theorem.CHECKS, *rivals.checks(results))
    return Ledger.of([(line.claim, line.check) for line in lines])


def sections(results: Results) -> Sequence[Section]:
    """The answers, the ledger, and the worth of its verdicts."""
    return pages.answers(ledger(results)), pages.the_ledger(ledger(results)), pages.worth()


def headlines(results: Results) -> Sequence[str]:
    """The verdicts, one a line."""
    return pages.headlines(ledger(results))


study = Study(
    name="a2_claims",
    title="AOSMC-RGS: the ledger of claims",
    question=(
        "Of what the paper assumes, states as a theorem, derives, and concludes from its simulations: what is "
        "proved, what is refuted by a witness that anyone can replay, what fails under named numbers alone, and "
        "what cannot be checked as published?"
    ),
    method=(
        "Each claim is data: a statement, its source, its hypotheses. Identities are judged by exact normal forms, "
        "bounds and rest points by interval arithmetic, linear modes by Routh's array in rational arithmetic; what "
        "only a run can break, by a search for the worst run within the paper's assumptions; comparisons with the "
        "rivals twice, as published and on the numbers of a1."
    ),
    cases=(*comparison("FS"), *comparison("SS")),
    sections=sections,
    headlines=headlines,
    seed=SEED,
)
