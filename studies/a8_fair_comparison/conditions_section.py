"""The section of a8 on all that is the same for all laws: measurements, scenarios, draws and the cost."""

from __future__ import annotations

import workbench as wb
from studies.a8_fair_comparison.changes import SEEN_SCENARIOS, quote_names
from studies.a8_fair_comparison.evidence import uncertain
from studies.paper import scenarios
from studies.paper.entrants import ALL_INFORMATION, BOTH, ENTRANTS, PROPOSAL, READINGS
from studies.paper.fitted_arm import FIT, with_fit
from studies.paper.scenarios import HELD_OUT, TERMS

# More than the card of the cost says; its own words are part of the objective of finished searches.
MEANINGS = {
    "effort": "torque: twice the torque of both joints that holds the model's arm at a level of the paper's second "
    "scenario, 25 N m"
}

MODELS = (
    "The model of a law has the paper's masses and lengths. The arm has other masses and lengths, and friction that no "
    "model contains."
)
FITTED_MODELS = (
    "The model of a law has the estimates of the fit. The arm is drawn as the fit says, and has friction that no model "
    "contains."
)


def conditions_section() -> wb.Section:
    """All that is the same for all laws, and the measurements of each."""
    first = HELD_OUT[0]
    loop = with_fit(PROPOSAL.loop(first))
    equation = loop.ode()
    drawn = wb.uncertainty.Space(uncertain(first, loop), equation.parameters, equation.states)
    return wb.Section(
        "What is the same for all laws",
        (
            wb.Paragraph(
                f"{MODELS if FIT is None else FITTED_MODELS} PID is the only law without a model. AOSMC-RGS has the "
                "four repairs of a1. Observer (24) needs the unknown disturbance D and cannot be built; an observer of "
                "the momentum takes its place. Its estimate D_hat is added to the torque of every law behind it. "
                "Observer (10) starts with the true initial positions of the arm, as if its first reading had no noise."
            ),
            wb.Paragraph(
                "The computer integrates the memories of laws and observers by explicit Euler, except for the stiff "
                "ones: equation (34) and observer (10) take a Cayley step, and the filter of the velocity and the leak "
                "of the network are integrated exactly."
            ),
            information(),
            scenario_table(),
            wb.uncertainty.factor_table(
                drawn, "drawn", "The numbers that are drawn in each run of a scenario, shown for the first scenario."
            ),
            objective(),
            wb.Paragraph(
                (
                    "The cost is the sum of the terms, the same for all laws. Each term is linear without an upper "
                    "limit, so a law that gives up the motion for a quiet torque pays for its whole error. The "
                    "acceptable values are our choice; ",
                    wb.document.CrossReference(f"changes_{BOTH.key}"),
                    " and ",
                    wb.document.CrossReference(f"changes_{READINGS.key}"),
                    " have the results with other weights.",
                )
            ),
        ),
    )


def objective() -> wb.document.ReportTable:
    """The terms of the cost."""
    return wb.document.ReportTable(
        "objective",
        "The terms of the cost. Each metric of both joints together is divided by its acceptable value.",
        (
            wb.document.TableColumn("metric"),
            wb.document.TableColumn("acceptable", align="right"),
            wb.document.TableColumn("unit"),
            wb.document.TableColumn("what it stands for"),
        ),
        tuple((term.metric, term.acceptable, term.unit, MEANINGS.get(term.metric, term.why)) for term in TERMS),
        (
            f"In 'jumps', and in 'ss' of the tuning, the square wave also jumps at {scenarios.HORIZON:g} s, "
            "the final sample of a run. The command of this sample already contains the response to the jump, which "
            "enters TV but no other metric. In 'jumps' the response is 8 % of TV and 3 % of the cost of AOSMC-RGS and "
            "of SMC.",
        ),
    )


def information() -> wb.document.ReportTable:
    entrants = {one.name: one for one in ENTRANTS[BOTH.key]}
    others = (
        one for given in ALL_INFORMATION if given != BOTH for one in ENTRANTS[given.key] if one.name in ("SMC", "PID")
    )
    entrants |= {f"{one.name}, {one.information.name}": one for one in others}
    return wb.evidence.information_table(
        "information",
        "The measurements and the model of each law behind both observers, and of two laws with other measurements. "
        "'Luenberger' is observer (10).",
        {name: one.loop(HELD_OUT[0]).loop for name, one in entrants.items()},
        {name: len(one.tuned_numbers) for name, one in entrants.items()},
    )


def scenario_table() -> wb.document.ReportTable:
    usual = HELD_OUT[0]
    limit, viscous, coulomb = (f"{a:g} and {b:g}" for a, b in (scenarios.LIMIT, usual.viscous, usual.coulomb))
    rows = [(one.name, "tuning", one.words) for one in scenarios.TRAINING]
    rows += [(one.name, "comparison", one.words) for one in HELD_OUT]
    return wb.document.ReportTable(
        "scenarios",
        f"The scenarios. No law is tuned in a scenario of the comparison. Some of them have the motion of 'fs': "
        f"{quote_names(SEEN_SCENARIOS)}. 'paper' also has the start of 'fs', and differs from 'fs' in the masses and "
        "in what is drawn.",
        (
            wb.document.TableColumn("name"),
            wb.document.TableColumn("used for"),
            wb.document.TableColumn("desired motion and what is unusual", width=24),
        ),
        tuple(rows),
        (
            f"Where a row says nothing else, joints 1 and 2 have torque limits of {limit} N m. The numbers are drawn "
            f"around the model's masses, viscous friction of {viscous} N m s/rad, Coulomb friction of {coulomb} N m "
            "and the paper's disturbance. The computer has a period of "
            f"{1e3 * scenarios.PERIOD:g} ms. Each reading has new normal "
            f"noise with a standard deviation of {scenarios.NOISE_Q:g} rad and {scenarios.NOISE_QD:g} rad/s. 'A "
            "slower motion' has amplitudes of 0.6 and 0.8 rad at 1.5 and 2.2 rad/s, 'a faster motion' 0.9 and 0.6 rad "
            f"at 3.5 and 5 rad/s. A run takes {scenarios.HORIZON:g} s.",
        ),
    )
