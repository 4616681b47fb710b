"""The section of a7 on the numbers that vary, their ranges, and those that the screening left at their values."""

from collections.abc import Mapping

import workbench as wb
from studies.a7_sensitivity import sweeps
from studies.a7_sensitivity.results import LawResults, percent
from studies.a7_sensitivity.sweeps import loop, sweep_name
from studies.paper.factors import SPAN, TOLERANCE
from studies.paper.fitted_arm import FIT

SHARES = "All factors are shares of these numbers, independent of one another."
DIRECTIONS = (
    "The numbers of the fit vary together along the principal axes of their correlation: a direction has a normal "
    "number z, and each of its numbers is the estimate plus its own change times z. All other factors are shares of "
    "these numbers. All factors are independent of one another."
)


def varied_section(laws: Mapping[str, LawResults]) -> wb.Section:
    """The factors, their ranges, and those that the screening left at their values."""
    text = (
        f"The card is the list of numbers in report a1. {SHARES if FIT is None else DIRECTIONS} A number that the "
        f"paper states varies by up to {percent(TOLERANCE)} up and down. An assumed number "
        f"varies by a factor of {SPAN:g} up and down, uniformly on a logarithmic scale, or within the range on the "
        "card if that is narrower. The ranges on the card are mostly wider, up to a factor of 20. Over such ranges the "
        "gains of the adaptive laws grow to several hundred N m. With a boundary layer of 0.01 rad/s, a gain of 300 N "
        "m is stable only for steps below 0.02 ms; with longer steps a run chatters because of the step. So the "
        "indices hold for these ranges, and not for wider ones. The arm and the law's model of it vary independently, "
        "so the laws and the observer of AOSMC-RGS use a wrong model. Gravity is the exception: all models have its "
        f"true value. PID has no model. Each of its three gains varies separately by a factor of {SPAN:g}. The pole "
        "from which they follow would move them together: Kd in proportion, Kp with its square and Ki with its cube."
    )
    return wb.Section("The numbers that vary", (wb.Paragraph(text), left_table(laws), *map(ranges_table, laws)))


def ranges_table(law: str) -> wb.document.ReportTable:
    ode = loop(law).ode()
    space = wb.uncertainty.Space(sweeps.factors(law), ode.parameters, ode.states)
    return wb.uncertainty.factor_table(space, sweep_name(law, "ranges"), f"The numbers of {law} that vary.")


def left_table(laws: Mapping[str, LawResults]) -> wb.document.ReportTable:
    """The factors that the screening left at their values, compared with its rule."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for law, one in laws.items():
        if not sweeps.HELD_FACTORS[law]:
            continue
        size, places = one.effects.mu_star, [one.effects.factors.index(name) for name in sweeps.HELD_FACTORS[law]]
        most = size.value.max(axis=1, keepdims=True)
        share, high = (float((part / most)[:, places].max()) for part in (size.value, size.high))
        kept = "yes" if high < sweeps.SCREENING_SHARE else "no" if share >= sweeps.SCREENING_SHARE else "open"
        rows.append((law, ", ".join(sweeps.HELD_FACTORS[law]), percent(share), percent(high), kept))
    return wb.document.ReportTable(
        "left",
        "The factors that stay at their values in the runs of the Sobol indices, and the largest mu* among them, "
        "relative to the largest mu* of the same output. 'At most' is the upper end of the interval of this ratio; by "
        f"the rule it should be below {percent(sweeps.SCREENING_SHARE)}.",
        tuple(map(wb.document.TableColumn, ("law", "left at its value", "largest mu*", "at most", "rule kept"))),
        tuple(rows),
    )
