"""The page of d0: the runs that a reader can turn, and its sections."""

from __future__ import annotations

import workbench as wb
from studies.d0_frequency import figures, tables
from studies.d0_frequency.findings import answer, findings
from studies.d0_frequency.loops import CARD, DRAWN_LAWS, step_of_reference
from studies.paper.comparison import PROPOSED_STEP, STEPS

STEP = 0.1  # rad, of the reference of both joints
JUMP = f"a step of {STEP:g} rad"
UNTIL, STATE_INTERVAL = 3.0, 0.01  # s
GAINS = ("Kp", "Ki", "Kd")
METRICS = (wb.settling_time("q", 0.05), wb.rmse(), wb.total_variation(1e-3))
LIVE = (
    wb.Knob("phi", "controller.phi", 0.001, 0.5, log=True, origin="stated"),
    wb.Knob("Lambda", "controller.Lambda", 1.0, 20.0, origin="stated"),
    wb.Knob("first gain K", "controller.K", 0.2, 10.0, log=True, share=True),
    wb.Knob("mass of link 2", "plant.arm.links[1].mass", 0.5, 2.0, origin="stated"),
    wb.Knob(
        "observer (10)", ("observer.state.L1", "observer.state.L2"), 0.2, 2.0, log=True, origin="stated", share=True
    ),
    *(
        wb.Knob(f"{gain} of PID", f"controller.{gain}", 0.2, 5.0, log=True, origin="derived", share=True)
        for gain in GAINS
    ),
)


def cases() -> tuple[wb.Case, ...]:
    """A step of the reference of both joints, from the hanging arm at rest."""
    made = []
    for law in DRAWN_LAWS:
        h = STEPS.get(law, PROPOSED_STEP) / 2
        run = wb.Run(step_of_reference(law, STEP), METRICS, UNTIL, STATE_INTERVAL, h)
        made.append(wb.Case(JUMP, law, run, figures.STYLES[law]))
    return tuple(made)


def sections(results: wb.Results) -> wb.Page:
    """The whole page."""
    return wb.Page(
        answer=answer(results),
        findings=findings(results),
        sections=(
            period_section(results),
            size_section(results),
            wb.Section(
                "The oscillation in the boundary layer", (*figures.cycle_figures(results), tables.cycles_table(results))
            ),
            frequency_section(results),
            turned_section(results),
            several_section(results),
            wb.Section("With numbers drawn at random", (*figures.envelopes(results), tables.draws_table(results))),
            wb.Section(
                "The chosen numbers",
                (CARD.table("assumed", "chosen", "Numbers that this study adds to those of report a1."),),
            ),
        ),
    )


def period_section(results: wb.Results) -> wb.Section:
    """The longest period, predicted and in runs."""
    about = (
        "The computer reads without noise, and its torque acts one period late. At the period at which a pole of the "
        "linear loop leaves the unit circle, a run that starts close to rest begins to chatter. The observer of "
        "AOSMC-RGS gets the torque that acts."
    )
    blocks = (figures.limit_figure(results), wb.Paragraph(about), tables.limits_table(results))
    return wb.Section("The longest sampling period", blocks)


def size_section(results: wb.Results) -> wb.Section:
    """Settling times by size, and a step to turn."""
    runs = [results[JUMP, law] for law in DRAWN_LAWS]
    caption = f"Position of joint 1 after a step of its reference by {STEP:g} rad, from the hanging arm at rest."
    step = wb.pictures.traces("step", caption, runs, "q", 0, "q1 [rad]", (wb.pictures.Window(0.0, UNTIL),), "q_ref")
    return wb.Section(
        "Settling time against the size of the start", (figures.size_figure(results), tables.sizes_table(results), step)
    )


def frequency_section(results: wb.Results) -> wb.Section:
    """The loops of one joint over frequency."""
    about = (
        "The loop gain L is taken from the torque that moves a joint to minus the torque that its law commands. The "
        "loop of the other joint stays closed, and adaptive gains are constant at K(0). A margin of one joint does not "
        "hold for both: the table also has the disk margin of both at once."
    )
    plots = (
        *(figures.bode(results, joint) for joint in (0, 1)),
        *(figures.nyquist(results, joint) for joint in (0, 1)),
        figures.bode(results, 1, late=True),
    )
    return wb.Section(
        "One joint over frequency",
        (wb.Paragraph(about), *plots, tables.margins_table(results), tables.ranges_table(results)),
    )


def turned_section(results: wb.Results) -> wb.Section:
    """The linear pictures of PID, which move with its gains and with the mass of link 2."""
    return wb.Section("The loop of PID with knobs", wb.loop_gain_pictures(results[JUMP, "PID"], "pid", width=0.75))


def several_section(results: wb.Results) -> wb.Section:
    """Both joints at once."""
    return wb.Section(
        "Both joints at once",
        (*figures.several_channels(results), figures.poles(results), figures.gang_of_six(results)),
    )
