"""The pictures and the table of the linear loops of b3 over frequency."""

from __future__ import annotations

import numpy as np

import workbench as wb
from studies.b3_any_plant.frequency import ITEMS, FrequencyAnswer, LinearAnswer, answers
from studies.b3_any_plant.loops import COMPUTER, DIGITAL, LQG, laws_of, sweep_name
from studies.b3_any_plant.settings import Setting

UNSTABLE = wb.document.MissingCell("not stable")
LIVE_LOOPS = {"cart-pole": f"{LQG} {COMPUTER}", "two masses": LQG}  # by plant, the law whose pictures move
UNDAMPED_REMARKS = {"two masses": " At the frequency of the plant's undamped mode, L is infinite and its phase jumps."}


def frequency_blocks(setting: Setting, results: wb.Results) -> tuple[wb.document.Block, ...]:
    """The Bode and the Nyquist plot of a plant under its laws, and a sentence for each loop that has none."""
    held = {law: answers(results)[setting.name, law] for law in laws_of(setting)}
    curves = [curve for law, own in held.items() for curve in curves_of(law, own)]
    missing = tuple(
        wb.Paragraph(f"{setting.name}, {law}: no linear answer. {reason}")
        for law, own in held.items()
        for reason in own.reasons
    )
    if not curves:
        return missing
    stem = sweep_name(setting, "").strip("_")
    several = len(setting.inputs) > 1
    where = (
        "each input, with the loop closed at the other input"
        if several
        else f"the input {setting.plant.inputs.names[0]}"
    )
    remark = UNDAMPED_REMARKS.get(setting.name, "")
    words = f"plot of the loop gain of the {setting.name} at {where}, in continuous time.{remark}"
    figures = (
        wb.loop_pictures.bode_figure(f"bode_{stem}", f"Bode {words}", curves),
        wb.loop_pictures.nyquist_figure(f"nyquist_{stem}", f"Nyquist {words}", curves),
    )
    return (*figures, *missing, *live_blocks(setting, results))


def live_blocks(setting: Setting, results: wb.Results) -> tuple[wb.document.Block, ...]:
    """The linear pictures of one loop of a plant, which move with the plant's numbers; none for most plants."""
    law = LIVE_LOOPS.get(setting.name)
    if law is None:
        return ()
    stem = sweep_name(setting, "").strip("_")
    loop = f"the {setting.name} under {f'digital {LQG}' if COMPUTER in law else law}"
    blocks = wb.loop_gain_pictures(results[setting.name, law], f"turned_{stem}", width=0.75, loop=loop)
    names = [block.name for block in blocks if isinstance(block, wb.document.Figure)]
    if not names:
        return blocks
    head = wb.Paragraph(
        (
            wb.document.CrossReference(names[0]),
            " to ",
            wb.document.CrossReference(names[-1]),
            f" are those of {loop}. On the HTML page the knobs change numbers of the plant, and the figures follow.",
        )
    )
    return (head, *blocks)


def curves_of(law: str, own: FrequencyAnswer) -> list[wb.FrequencyCurve]:
    """The loop gain of a law at each input of its plant, with its margins."""
    if own.continuous is None:
        return []
    inputs, several = own.continuous.inputs, len(own.continuous.inputs) > 1
    return [
        wb.FrequencyCurve(
            f"{law}, {name}" if several else law,
            own.omega,
            own.gains[:, place],
            margins=own.continuous.margins[place],
            multiloop_disk_margin=own.continuous.alpha if several else None,
        )
        for place, name in enumerate(inputs)
    ]


def frequency_table(results: wb.Results) -> wb.document.ReportTable:
    """Margins and poles of each loop, in continuous time and in the computer of its plant."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    last = ""
    for name, law in ITEMS:
        own = answers(results)[name, law]
        for place in ("continuous", "computer"):
            found: LinearAnswer | None = getattr(own, place)
            plant, time = name if name != last else "", "digital" if place == "computer" else place
            last = name
            if found is None:
                rows.append((plant, law, time, wb.document.MissingCell("no linear answer"), *(8 * (None,))))
                continue
            for k, margins in enumerate(found.margins):
                head = (plant if not k else "", law if not k else "", time if not k else "", found.inputs[k])
                common: tuple[wb.document.Cell, ...] = (
                    (found.alpha or UNSTABLE, pole_words(found)) if not k else ("", "")
                )
                rows.append((*head, *margin_cells(margins), *common))
    columns = (
        wb.document.TableColumn("plant"),
        wb.document.TableColumn("law"),
        wb.document.TableColumn("time"),
        wb.document.TableColumn("input"),
        wb.document.TableColumn("least gain factor", align="right"),
        wb.document.TableColumn("largest gain factor", align="right"),
        wb.document.TableColumn("phase margin", "deg", "right"),
        wb.document.TableColumn("delay margin", "s", "right"),
        wb.document.TableColumn("Ms", "", "right", digits=3),
        wb.document.TableColumn("disk margin", "", "right", digits=3),
        wb.document.TableColumn("disk margin of all inputs", "", "right", digits=3),
        wb.document.TableColumn("slowest pole"),
    )
    notes = (
        "At rest at the operating point. Each input is cut while the loop stays closed at the others. Digital: the "
        "command acts one period late, and the margins are those that remain. Least and largest gain factor: the loop "
        "stays stable for factors between these two at the input. No limit: no such change makes the loop unstable. "
        "Slowest "
        "pole: in 1/s; of a digital loop, the absolute value of the pole in z.",
    )
    return wb.document.ReportTable(
        "frequency",
        f"Margins and poles of the linear loops, in continuous time and {DIGITAL}.",
        columns,
        tuple(rows),
        notes,
    )


def margin_cells(margins: wb.frequency.StabilityMargins) -> tuple[wb.document.Cell, ...]:
    """Gain, phase and delay margins, Ms and the disk margin of one input."""
    held = margins.margins
    if held is None:
        return (UNSTABLE, *(5 * (None,)))
    high, delay = held.gain_high.value, held.delay_margin.value
    phase = held.phase_margin.value
    return (
        digits(held.gain_low.value if held.gain_low.value > wb.loop_pictures.ROUNDING else 0.0),
        digits(high),
        digits(phase),
        digits(delay),
        held.Ms.gain.value,
        held.disk_margin.value,
    )


def digits(value: float) -> str:
    """A number with three digits, or that there is no limit."""
    return f"{value:.3g}" if np.isfinite(value) else "no limit"


def pole_words(answer: LinearAnswer) -> str:
    """The slowest pole of a loop."""
    pole = answer.largest
    if answer.computer:
        return f"|z| = {abs(pole):.4f}"
    imaginary = f" ± {abs(pole.imag):.3g}i" if pole.imag else ""
    return f"{pole.real:.3g}{imaginary}".replace("-", "\N{MINUS SIGN}")
