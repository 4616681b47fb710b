"""The page of d0: the runs that a reader can turn, and its sections."""

from __future__ import annotations

from studies.a1_paper_tables.study import PROPOSED_STEP, STEPS
from studies.d0_frequency import figures, tables
from studies.d0_frequency.findings import answer, findings
from studies.d0_frequency.loops import CARD, DRAWN, step_of_reference
from workbench.metrics import rmse, settling_time, total_variation
from workbench.study import Case, Page, Results, Run, Section, Window, traces
from workbench.study.document.document import Paragraph
from workbench.study.live.knob import Knob

STEP = 0.1  # rad, of the reference of both joints
JUMP = f"a step of {STEP:g} rad"
UNTIL, KEPT = 3.0, 0.01  # s
METRICS = (settling_time("q", 0.05), rmse(), total_variation(1e-3))
LIVE = (
    Knob("phi", "controller.phi", 0.001, 0.5, log=True, origin="stated"),
    Knob("Lambda", "controller.Lambda", 1.0, 20.0, origin="stated"),
    Knob("first gain K", "controller.K", 0.2, 10.0, log=True, share=True),
    Knob("mass of link 2", "plant.arm.links[1].mass", 0.5, 2.0, origin="stated"),
    Knob("observer (10)", ("observer.state.L1", "observer.state.L2"), 0.2, 2.0, log=True, origin="stated", share=True),
    Knob("PID", ("controller.Kp", "controller.Ki", "controller.Kd"), 0.2, 2.0, log=True, origin="derived", share=True),
)


def cases() -> tuple[Case, ...]:
    """A step of the reference of both joints, from the hanging arm at rest."""
    made = []
    for style, law in enumerate(DRAWN):
        h = STEPS.get(law, PROPOSED_STEP) / 2
        run = Run(step_of_reference(law, STEP), METRICS, UNTIL, KEPT, h)
        made.append(Case(JUMP, law, run, style))
    return tuple(made)


def sections(results: Results) -> Page:
    """The whole page."""
    return Page(
        answer=answer(results),
        findings=findings(results),
        sections=(
            period_section(results),
            size_section(results),
            Section("The limit cycle in the layer", (*figures.cycle_figures(results), tables.cycles_table(results))),
            frequency_section(results),
            several_section(results),
            Section("The same over draws", (*figures.envelopes(results), tables.draws_table(results))),
            Section(
                "What was chosen",
                (CARD.table("assumed", "chosen", "Numbers that this study adds to those of a1."),),
            ),
        ),
    )


def period_section(results: Results) -> Section:
    """The longest period, predicted and in runs."""
    about = (
        "The computer reads exactly, steps its memories as a9 does, and its torque acts one period late. At the period "
        "at which a pole of the linear map of the period leaves the unit circle, a run that starts within the layer "
        "begins to chatter. The observer of AOSMC-RGS counts on the torque that acts."
    )
    blocks = (figures.limit_figure(results), Paragraph(about), tables.limits_table(results))
    return Section("The longest period", blocks)


def size_section(results: Results) -> Section:
    """Settling times by size, and a step to turn."""
    runs = [results[JUMP, law] for law in DRAWN]
    caption = f"Position of joint 1 after a step of its reference by {STEP:g} rad, from the hanging arm at rest."
    step = traces("step", caption, runs, "q", 0, "q1 [rad]", (Window(0.0, UNTIL),), "q_ref")
    return Section("The size of a motion", (figures.size_figure(results), tables.sizes_table(results), step))


def frequency_section(results: Results) -> Section:
    """The loops of one joint over frequency."""
    about = (
        "L goes from the torque that moves a joint to minus the torque that its law commands, the loop of the other "
        "joint closed and the adapting gains held at K(0). A margin of one joint is no margin of both: the disk "
        "margin of both at once stands beside it."
    )
    plots = (
        *(figures.bode(results, joint) for joint in (0, 1)),
        *(figures.nyquist(results, joint) for joint in (0, 1)),
        figures.bode(results, 1, late=True),
    )
    return Section(
        "One joint over frequency",
        (Paragraph(about), *plots, tables.margins_table(results), tables.ranges_table(results)),
    )


def several_section(results: Results) -> Section:
    """Both joints at once."""
    return Section(
        "Both joints at once",
        (*figures.several_channels(results), figures.poles(results), figures.gang_of_six(results)),
    )
