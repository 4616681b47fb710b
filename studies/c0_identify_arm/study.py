"""The paper's arm with friction, identified from logs of its own: what do they tell, and what is it worth?

Takes four to five minutes of processor time, on two cores at once.
"""

from __future__ import annotations

import workbench as wb
from studies.c0_identify_arm.answers import FEW, REPEATED, Basis, batches, designed_log, law_log, law_logs
from studies.c0_identify_arm.arm import FREE, ODD, PERIOD, PLAYED, SPAN
from studies.c0_identify_arm.estimates import CUTOFFS
from studies.c0_identify_arm.findings import bias, excitation, largest_share, mean_ratio, told_by_the_law
from studies.c0_identify_arm.judgement import Evidence, digits, gather
from studies.c0_identify_arm.logs import LAW_LOG
from studies.c0_identify_arm.repeated_section import coverage_section
from studies.c0_identify_arm.sections import conditions_section, log_section, untold_section
from studies.c0_identify_arm.worth import DRAWS, SEED, TRIALS, sweeps
from studies.c0_identify_arm.worth_findings import cost, log_costs, nominal_costs, specification
from studies.c0_identify_arm.worth_section import specification_section, worth_section
from studies.paper.citation import introduction


def answer(evidence: Evidence) -> str:
    """The answer of the page in at most forty words."""
    share = digits(100 * largest_share(evidence))
    costs, rest = nominal_costs(evidence), log_costs(evidence)
    worst = max(costs, key=lambda law: costs[law].value)
    more, left = f"{100 * costs[worst].value:.0f} %", f"{digits(100 * rest[worst])} %"
    return (
        f"{SPAN:g} s under AOSMC-RGS tell an assumed arm's {len(FREE)} numbers with standard errors up to {share} %; a "
        f"designed excitation's are {mean_ratio(evidence):.1f} times smaller. {worst[:1].upper()}{worst[1:]} with the "
        f"paper's numbers has {more} more error, with either log's {left}."
    )


def sections(results: wb.Results) -> wb.Page:
    """The whole page."""
    evidence = gather(results, TRIALS)
    return wb.Page(
        answer(evidence),
        (told_by_the_law(evidence), excitation(evidence), bias(evidence), cost(evidence), specification(evidence)),
        (
            log_section(evidence),
            worth_section(evidence),
            specification_section(evidence),
            coverage_section(evidence),
            untold_section(evidence),
            conditions_section(evidence),
        ),
    )


study = wb.Study(
    name="c0_identify_arm",
    title="The paper's arm, identified from its own logs",
    question=(
        "An arm has friction, and other masses and lengths than the paper states. What does a log under the "
        "paper's law tell of it, what does a designed excitation tell, what can no log tell, and what does it cost not "
        "to have known?"
    ),
    method=(
        f"{introduction(10, 34, rivals=False)} The arm is simulated under AOSMC-RGS in a computer with a period of "
        f"{1e3 * PERIOD:g} ms and coarse encoders, for {SPAN:g} s. Its numbers are fitted by output errors with exact "
        "sensitivities. For the arm that is found, an excitation is designed within limits, a local optimum from one "
        f"start. It is run, and its log is fitted. Both logs are repeated {REPEATED} times with "
        f"new noise, and {FEW} times under each of {len(ODD)} other conditions. A "
        f"regression of the torques with {len(CUTOFFS)} filters stands beside the fits. Then three laws are made for "
        "the arm of the paper, for those of the logs and for the true one, and run on the true arm and on arms that "
        f"the logs allow, with {DRAWS} draws each. Limits on margins, damping and overshoot are checked on these arms."
    ),
    works=(
        wb.Work("designed_log", designed_log, (Basis(True, PLAYED), Basis(False)), seconds=90.0),
        wb.Work("law_log", law_log, (LAW_LOG,), seconds=13.0),
        wb.Work("law_logs", law_logs, batches(ODD), seconds=10.0),
    ),
    sweeps=sweeps,
    sections=sections,
    seed=SEED,
)
