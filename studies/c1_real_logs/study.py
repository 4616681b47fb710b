"""Measured logs of three machines: ours beside the published models, on data that the fits did not see.

Needs the folder of the logs in LOGS, as in `make reports LOGS=FOLDER`. Runs in about three minutes on two cores.
"""

from __future__ import annotations

import workbench as wb
from studies.c1_real_logs.logs import EXCITATIONS, POOR_LOGS
from studies.c1_real_logs.loop_sections import (
    is_near,
    loop_fit_section,
    positioning_section,
    tank_fit_section,
    tank_section,
)
from studies.c1_real_logs.nested_choice import LEFT_OUT, VARIANTS, errors_without
from studies.c1_real_logs.pendulum import fold, refusal_of
from studies.c1_real_logs.pendulum_section import both_beaten, folds, is_beaten, nested_choices, pendulum_section
from studies.c1_real_logs.positioning import PUBLISHED, WAYS, estimate
from studies.c1_real_logs.tanks import tank_fit


def sections(results: wb.Results) -> wb.Page:
    """The whole page."""
    every = folds(results)
    beaten = sum(is_beaten(*pair) for pair in zip(nested_choices(results), every, strict=True))
    near, in_loop = (sum(is_near(way, word) for word in PUBLISHED) for way in results.work("positioning")[:2])
    return wb.Page(
        answer=f"In {beaten} of {len(every)} unseen logs of a double pendulum, both torques are predicted better than "
        "by three published models. A positioning system's published numbers are met to 1 %: "
        f"{near} of {len(PUBLISHED)} by regression, {in_loop} by output errors.",
        findings=(pendulum_finding(results, beaten), carriage_finding(results, near, in_loop)),
        sections=(
            pendulum_section(results),
            positioning_section(results),
            loop_fit_section(results),
            tank_section(results),
            tank_fit_section(results),
        ),
    )


def pendulum_finding(results: wb.Results, beaten: int) -> wb.Finding:
    """The excitations in which both torques are nearer than those of the published models."""
    every = folds(results)
    count = sum(map(both_beaten, every))
    return wb.Finding(
        name="double_pendulum",
        statement=f"In {beaten} of {len(every)} excitations that were held out, both torques are nearer to the "
        "measured ones than those of three published models.",
        evidence=f"The model is chosen among {len(VARIANTS)} inside the other four logs, which alone are fitted.",
        statistic="Root mean square of the error of each measured torque, where the filter has settled.",
        sample=f"{len(every)} excitations of 10 s.",
        information="Measured positions and torques.",
        assumptions="Rigid bodies, and frictions of the variants.",
        fitted_numbers="Up to 17 numbers of bodies and joints, and a delay.",
        answer="all" if beaten == len(every) else "some",
        variations=(
            wb.Variation(
                "one model, chosen with all five logs in view",
                "all" if count == len(every) else "some",
                f"{count} of {len(every)}",
            ),
        ),
        limitations="A frame that vibrates, torque that is a current times a constant, and stiction.",
    )


def carriage_finding(results: wb.Results, near: int, in_loop: int) -> wb.Finding:
    """The published numbers that are met."""
    free = sum(is_near(results.work("positioning")[2], word) for word in PUBLISHED)
    return wb.Finding(
        name="positioning_system",
        statement=f"By inverse dynamics {near} of {len(PUBLISHED)} published numbers are met to 1 %, and by output "
        f"errors of position and command in the loop, {in_loop}.",
        evidence="Both are tried on a second log with pulses of force.",
        statistic="The relative difference from the published numbers.",
        sample="One motion of 24.8 s, and one with pulses.",
        information="Measured position, reference and command.",
        assumptions="The gains that the file states, and in the loop the published controller.",
        fitted_numbers="Mass, two frictions and an offset; in the loop the speed at which friction turns and two "
        "initial states, too.",
        answer="all" if min(near, in_loop) == len(PUBLISHED) else "some",
        variations=(
            wb.Variation(
                "the delays of the controller are fitted, too",
                "all" if free == len(PUBLISHED) else "some",
                f"{free} of {len(PUBLISHED)}",
            ),
        ),
        limitations="Viscous and Coulomb friction trade with each other.",
    )


study = wb.Study(
    name="c1_real_logs",
    title="Real logs: a double pendulum, a positioning system and two tanks",
    question="What do fits of measured logs reach on data that they did not see, beside the models that are published?",
    method=(
        "The double pendulum and the positioning system: regression of torques on base parameters, with weights by "
        "joint, rigid bodies by pseudo-inertia matrices, and hold-outs. The model of the pendulum is chosen inside "
        "each training set. The positioning system and the tanks: output errors by exact sensitivities. A log that "
        "does not tell its numbers is refused by name."
    ),
    works=(
        wb.Work("pendulum", fold, EXCITATIONS, seconds=8.0),
        wb.Work("nested", errors_without, LEFT_OUT, seconds=4.0),
        wb.Work("poor", refusal_of, POOR_LOGS, seconds=2.0),
        wb.Work("positioning", estimate, WAYS, seconds=30.0),
        wb.Work("tanks", tank_fit, ("both records",), seconds=8.0),
    ),
    sections=sections,
)
