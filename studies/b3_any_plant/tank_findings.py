"""The finding and the table of the four tanks: settling times at both settings, and what the zero at P+ fixes."""

from __future__ import annotations

import numpy as np

import workbench as wb
from studies.b3_any_plant.loops import COMPUTER, DIGITAL, LQG, OBSERVER, PID, PLACED, REGULATOR, all_margins
from studies.b3_any_plant.settings import HARD, digits
from studies.b3_any_plant.tanks import EVERY, SIDES, TANKS, Levels, least_swing, predicted_integral, tank, zero_of

PUBLICATION = "about ten"  # Johansson (2000) of the settling times under the PI controllers at P+ and at P-


def all_levels(results: wb.Results) -> dict[tuple[str, str, float], Levels]:
    """The runs of the tanks by setting, law and factor of the placed poles."""
    return dict(zip(TANKS, results.work("tanks"), strict=True))


def tank_finding(results: wb.Results) -> wb.Finding:
    """The settling times of the tanks, and the witness that the zero does not force them."""
    by, hard = all_levels(results), tank(HARD)
    witness, optimal = by[HARD, PLACED, 1.0], by[HARD, LQG, 1.0]
    easy, slow = (by[name, PID, 1.0].settling for name in SIDES)
    z, _ = zero_of(hard)
    low, high = witness.voltages
    return wb.Finding(
        name="settling_of_the_tanks",
        statement="Quadruple tank under the published PI controllers: h_1 takes "
        f"{slow[0] / easy[0]:.1f} times as long to settle at the operating point P+ as at P\N{MINUS SIGN}. The right "
        "half-plane zero of P+ does not force this: a design by pole placement settles both levels in "
        f"{max(witness.settling):.0f} s.",
        evidence=f"This design has no mode slower than {witness.decay:.2g} 1/s and needs {low:.1f} to {high:.1f} V. "
        f"Its disk margin is {witness.disk:.2f}; that of PI is {by[HARD, PID, 1.0].disk:.2f}. The "
        f"zero at {z:+.4f} 1/s bounds the bandwidth and fixes a weighted integral of the levels. The loop of LQG has a "
        f"mode at \N{MINUS SIGN}{optimal.decay:.4f} 1/s, the mirror image of the zero, because its weights make "
        "control cheap.",
        statistic="The settling time of h_1 at P+ over that at P\N{MINUS SIGN}. h_1 is settled where it stays within "
        "5 % of its initial distance from the reference.",
        sample="One start in each setting, in continuous time.",
        information="PI: one level for each controller. LQG and the placed design: both levels and the linear model.",
        assumptions="Starts, weights of LQG, and the poles of the placed design.",
        answer=f"{slow[0] / easy[0]:.1f}",
        variations=ratios(results),
        limitations=f"the experiment of the publication, which reports a ratio of {PUBLICATION}; other starts",
    )


def ratios(results: wb.Results) -> tuple[wb.Variation, ...]:
    """The ratio of P+ to P- by every other statistic of slowness, and under the other law."""
    by, margins = all_levels(results), all_margins(results)
    made = []
    for law in (PID, LQG):
        under = "" if law == PID else f", under {law}"
        pairs = [by[name, law, 1.0].settling for name in SIDES]
        times = {"h_1": [pair[0] for pair in pairs], "both levels": [max(pair) for pair in pairs]}
        ends = [results[name, f"{law} {COMPUTER}"].score("settling time of h_1").pair[0] for name in SIDES]
        times[f"h_1 {DIGITAL}"] = ends
        for words, pair in times.items():
            if law != PID or words != "h_1":
                made.append(ratio(f"settling of {words}{under}", pair))
        made.append(ratio(f"slowest mode{under}", [1 / margins[name, law].decay for name in SIDES], "s"))
    steps = results.work("tank_steps")
    made.append(ratio("settling of h_1 after a step of its reference", [step[0] for step in steps]))
    made.append(ratio("settling of both levels after that step", [max(step) for step in steps]))
    return tuple(made)


def ratio(words: str, pair: list[float], unit: str = "s") -> wb.Variation:
    """The ratio of P+ to P-, with both numbers."""
    ends = [f"{end:.3g} {unit}" if np.isfinite(end) else f"not within {tank(HARD).until:,.0f} s" for end in pair]
    known = f"{pair[1] / pair[0]:.1f}" if np.isfinite(pair[1]) else f"above {tank(HARD).until / pair[0]:.0f}"
    return wb.Variation(words, known, f"{ends[1]} against {ends[0]}")


def tanks_table(results: wb.Results) -> wb.document.ReportTable:
    """Settling, swing, voltages, slowest mode, disk margin and the weighted integral of each run of the tanks."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for (name, law, factor), one in all_levels(results).items():
        law_name = law if law != PLACED or factor == 1.0 else f"{law}, poles times {factor:g}"
        times = (float(t) if np.isfinite(t) else wb.document.MissingCell("never") for t in one.settling)
        volts = (f"{volt:.1f}".replace("-", "\N{MINUS SIGN}") for volt in one.voltages)
        fixed = one.fixed_integral if name == HARD else None
        side = name.removeprefix("quadruple tank ")
        rows.append((f"{side}, {law_name}", *times, one.farthest, " to ".join(volts), one.decay, one.disk, fixed))
    columns = (
        wb.document.TableColumn("setting, law"),
        wb.document.TableColumn("h_1 settles", "s", "right", digits=3),
        wb.document.TableColumn("h_2 settles", "s", "right", digits=3),
        wb.document.TableColumn("largest excursion of h_2", "cm", "right", digits=2),
        wb.document.TableColumn("voltages", "V"),
        wb.document.TableColumn("slowest mode", "1/s", "right", digits=3),
        wb.document.TableColumn("disk margin", "", "right", digits=2),
        wb.document.TableColumn("weighted integral", "cm s", "right", digits=3),
    )
    (z, psi), predicted = zero_of(tank(HARD)), predicted_integral(tank(HARD))
    notes = (
        (
            "Each run begins at the start of ",
            wb.document.CrossReference("starts"),
            ", in continuous time without limits. A level is settled where it stays within 5 % of the initial "
            f"distance of h_1 from its reference. States are stored every {EVERY:g} s. A settling time here is that "
            "of the first stored state inside the band; in ",
            wb.document.CrossReference("summary"),
            f" it is that of the last step outside the band, {EVERY:g} s earlier.",
        ),
        f"Placed: poles of the regulator at {poles_text(REGULATOR)}, of the observer at "
        f"{poles_text(OBSERVER)} 1/s. This design reads the same levels as LQG.",
        f"Weighted integral: the integral over the run of y exp(\N{MINUS SIGN}z t), where y is {digits(psi[0])} times "
        f"h_1 plus {digits(psi[1])} times h_2, each minus its reference, and z = {z:.4f} 1/s is the zero. In the "
        f"linear model, this integral is {predicted:.1f} cm s under every stabilising law; the differences "
        "come from the nonlinear terms. If the levels rest after a time T, |y| therefore reaches at least the integral "
        f"times z / (1 \N{MINUS SIGN} exp(\N{MINUS SIGN}z T)): {least_swing(tank(HARD), 60.0):.2g} cm for T = 60 s, "
        f"{least_swing(tank(HARD), 20.0):.2g} cm for T = 20 s.",
    )
    caption = (
        "The four tanks: how fast both levels settle, and what a fast design costs. Faster placed poles need more "
        "voltage, let h_2 swing farther, and leave less margin."
    )
    return wb.document.ReportTable("tanks", caption, columns, tuple(rows), notes)


def poles_text(poles: tuple[float, ...]) -> str:
    """Real poles in words."""
    return ", ".join(digits(pole) for pole in poles)
