"""Which claims of the AOSMC-RGS paper stand, and which fall?

Runs in about half a minute on two cores.
"""

from collections.abc import Sequence
from functools import cache

from studies.a1_paper_tables.study import comparison
from studies.a2_claims import comparisons as claims_others
from studies.a2_claims import law as claims_law
from studies.a2_claims import model as claims_model
from studies.a2_claims import observers as claims_observers
from studies.a2_claims import theorem as claims_theorem
from studies.a2_claims.pages import answers, the_ledger, two_runs, worth
from studies.a2_claims.pages import headlines as lines
from studies.a2_claims.searches import SEED
from workbench.claims.verdicts import Ledger
from workbench.study.document.document import Section
from workbench.study.study import Results, Study


@cache
def ledger(results: Results) -> Ledger:
    """Every claim checked, in the order of the paper."""
    plain = (claims_model.CHECKS, claims_observers.CHECKS, claims_law.CHECKS, claims_theorem.CHECKS)
    groups = (*plain, claims_others.checks(results))
    return Ledger.of([check for group in groups for check in group])


def sections(results: Results) -> Sequence[Section]:
    """What the report says."""
    found = ledger(results)
    return answers(found), the_ledger(found), two_runs(), worth()


def headlines(results: Results) -> Sequence[str]:
    """The verdicts, one a line."""
    return lines(ledger(results))


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
        "bounds and rest points by interval arithmetic, linear modes by Routh's array in rational arithmetic. What "
        "only a run can break is searched for the worst run within the paper's own assumptions. Comparisons with "
        "the rivals are judged twice: as published, and on the numbers of a1."
    ),
    cases=(*comparison("FS"), *comparison("SS")),
    sections=sections,
    headlines=headlines,
    seed=SEED,
)
