"""Measured logs of three machines: ours beside the published models, on data that the fits did not see.

Needs the folder of the logs in LOGS, as in `make reports LOGS=FOLDER`. Runs in about two minutes on two cores.
"""

from __future__ import annotations

import workbench as wb
from studies.c1_real_logs.logs import EXCITATIONS, POOR_LOGS
from studies.c1_real_logs.pendulum import fold, refusal_of
from studies.c1_real_logs.positioning import PUBLISHED, estimate
from studies.c1_real_logs.sections import (
    WAYS,
    both_beaten,
    folds,
    is_near,
    pendulum_section,
    positioning_section,
    tank_section,
)
from studies.c1_real_logs.tanks import tank_fit


def sections(results: wb.Results) -> wb.Page:
    """The whole page."""
    every, ways = folds(results), results.work("positioning")
    beaten = sum(map(both_beaten, every))
    near = sum(is_near(ways[0], word) for word in PUBLISHED)
    in_loop = sum(is_near(ways[2], word) for word in PUBLISHED)
    error = results.work("tanks")[0].hold_out_error
    pendulum = wb.Finding(
        name="double_pendulum",
        statement=f"In {beaten} of {len(every)} excitations that were held out, both torques are nearer than those of "
        "three published models.",
        evidence="Each fit sees the other four logs; rigid bodies have all of its numbers.",
        statistic="Root mean square of the error of each measured torque, where the filter has settled.",
        sample=f"{len(every)} excitations of 10 s.",
        information="Measured positions and torques.",
        assumptions="The cutoff, and the slow samples without weight. Both were chosen among more than 200 variants "
        "with all five logs in view, so the errors on the logs held out are flattered.",
        fitted_numbers="Eleven base parameters and a delay.",
        answer="all" if beaten == len(every) else "some",
        limitations="A frame that vibrates, torque that is a current times a constant, and stiction.",
    )
    carriage = wb.Finding(
        name="positioning_system",
        statement=f"By inverse dynamics {near} of {len(PUBLISHED)} published numbers are met to 1 %; by output errors "
        f"in the loop with fitted gains, {in_loop}.",
        evidence="The regression is tried on a second log with pulses of force.",
        statistic="The relative difference from the published numbers.",
        sample="One motion of 24.8 s, and one with pulses.",
        information="Measured position, reference and command.",
        assumptions="The gain of the drive that the file states.",
        fitted_numbers="Mass, two frictions and an offset; in the loop its gains and initial states, too.",
        answer="all" if near == len(PUBLISHED) else "some",
        limitations="Viscous and Coulomb friction trade with each other.",
    )
    return wb.Page(
        answer=f"Beaten on unseen data in both torques: {beaten} of {len(every)} excitations of a double pendulum. "
        f"{near} of {len(PUBLISHED)} published numbers of a positioning system are met to 1 %. Tanks: {error:.2g} V "
        "are left.",
        findings=(pendulum, carriage),
        sections=(pendulum_section(results), positioning_section(results), tank_section(results)),
    )


study = wb.Study(
    name="c1_real_logs",
    title="Real logs: a double pendulum, a positioning system and two tanks",
    question="What do fits of measured logs reach on data that they did not see, beside the models that are published?",
    method=(
        "The double pendulum and the positioning system: regression of torques on base parameters, with weights by "
        "joint, rigid bodies by pseudo-inertia matrices, and hold-outs. The positioning system and the tanks: output "
        "errors by exact sensitivities. A log that does not tell its numbers is refused by name."
    ),
    works=(
        wb.Work("pendulum", fold, EXCITATIONS, seconds=8.0),
        wb.Work("poor", refusal_of, POOR_LOGS, seconds=2.0),
        wb.Work("positioning", estimate, WAYS, seconds=20.0),
        wb.Work("tanks", tank_fit, ("both records",), seconds=8.0),
    ),
    sections=sections,
)
