"""Chattering of the paper's arm under SMC: harmonic balance and exact cycles beside simulation.

Runs in about twenty seconds on two cores.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

import workbench as wb
from studies.b1_chattering.findings import findings, spans
from studies.b1_chattering.loops import (
    PAIRS,
    PERIODS,
    PHI,
    QUIET,
    REST,
    SWITCHES,
    K,
    Row,
    case,
    other_starts,
    predict,
    rows_of,
)


def sections(results: wb.Results) -> wb.Page:
    """The findings, the picture, and both tables."""
    every = rows_of(results)
    rest, relay, cycle = findings(every)
    frequency, amplitude = spans(every)
    agreed = rest.answer.replace("all", f"all {len(every[0])}")
    return wb.Page(
        answer=f"In {agreed} pairs of lag and period, harmonic balance predicts correctly whether a boundary layer "
        f"of {PHI:g} rad/s ends chattering. For a relay, its median error is {frequency} % in frequency and "
        f"{amplitude} % in amplitude.",
        findings=(rest, relay, cycle),
        sections=(
            wb.Section("Predicted and simulated amplitude", (picture(every[0]),)),
            wb.Section("Predicted and simulated numbers", (relay_table(every[0]), layer_table(every[0]))),
        ),
    )


def picture(rows: Sequence[Row]) -> wb.document.Figure:
    """Amplitude of the relay by the balance and in the simulation, over the lag."""
    series = []
    for style, period in enumerate(PERIODS):
        some = [r for r in rows if r.period == period]
        lags, name = np.array([1e3 * r.lag for r in some]), f"{1e3 * period:g} ms"
        balance, run = (np.array([r.relay[i].amplitude for r in some]) for i in (0, 1))
        series += [
            wb.document.Series(f"balance, {name}", lags, balance, style=style),
            wb.document.Series(f"simulated, {name}", lags, run, style, "marks"),
        ]
    panel = wb.document.Panel("amplitude of s [rad/s]", tuple(series), xlabel="lag of the drive [ms]")
    caption = (
        "Amplitude of the chattering of joint 1 under a relay: lines by harmonic balance, marks by simulation, one "
        "colour for each sampling period."
    )
    return wb.document.Figure("relay", caption, (panel,))


def relay_table(rows: Sequence[Row]) -> wb.document.ReportTable:
    """Frequency and amplitude of each pair under a relay."""
    heads = (
        *(("lag", "ms"), ("period", "ms"), ("balance", "Hz"), ("balance", "rad/s"), ("exact, least", "rad/s")),
        *(("exact, largest", "rad/s"), ("simulated", "Hz"), ("simulated", "rad/s")),
    )
    cells = []
    for r in rows:
        balance, run = r.relay
        exact = (r.cycle.amplitude, r.cycle.highest) if r.cycle else (None, None)
        cells.append((*place(r), *numbers(balance), *exact, *numbers(run)))
    caption = (
        "Frequency and amplitude of s of joint 1 under a relay: by harmonic balance, by the exact cycle at the "
        "simulated switching period, and by simulation."
    )
    note = "A dash: there is no exact cycle, since the simulated oscillation is not symmetric, or its periods differ."
    return wb.document.ReportTable(
        "relay_numbers",
        caption,
        tuple(wb.document.TableColumn(*head, "right", digits=3) for head in heads),
        tuple(cells),
        (note,),
    )


def layer_table(rows: Sequence[Row]) -> wb.document.ReportTable:
    """The least width of the layer, and the oscillation within it."""
    heads = (
        *(("lag", "ms"), ("period", "ms"), ("least width", "rad/s"), ("balance", "Hz"), ("balance", "rad/s")),
        *(("simulated", "Hz"), ("simulated", "rad/s")),
    )
    cells = []
    for r in rows:
        layer, run = r.layer
        stable = next((o for o in layer.oscillations if o.stable), None)
        seen = run if run.amplitude > QUIET else None
        cells.append((*place(r), layer.least_phi, *numbers(stable), *numbers(seen)))
    caption = (
        f"Frequency and amplitude of s of joint 1 under a boundary layer of {PHI:g} rad/s. Least width: for "
        "wider layers, harmonic balance has no oscillation."
    )
    return wb.document.ReportTable(
        "layer_numbers",
        caption,
        tuple(wb.document.TableColumn(*head, "right", digits=3) for head in heads),
        tuple(cells),
    )


def place(row: Row) -> tuple[wb.document.Cell, wb.document.Cell]:
    """Lag and period in ms."""
    return round(1e3 * row.lag), round(1e3 * row.period)


def numbers(
    one: wb.chattering.Oscillation | wb.chattering.RecordedOscillation | None,
) -> tuple[wb.document.Cell, wb.document.Cell]:
    """Frequency in Hz and amplitude in rad/s; the word for rest where there is no oscillation."""
    if one is None:
        return wb.document.MissingCell(REST), wb.document.MissingCell(REST)
    return (one.frequency or 0.0) / (2 * np.pi), one.amplitude


study = wb.Study(
    name="b1_chattering",
    title="Chattering, predicted and simulated",
    question=(
        "With which amplitude and frequency does the switching of SMC make the arm oscillate when its drives lag and "
        "the law is sampled? And how wide must the boundary layer be to end this chattering?"
    ),
    method=(
        f"SMC with K = {K:g} N m holds the folded arm, where M is diagonal and each joint is a separate loop. For "
        "the prediction, the loop of joint 1 is cut at the switching. Harmonic balance and the exact cycles of a "
        "sampled relay are compared with simulations of the whole arm, for several lags of the drives and sampling "
        "periods."
    ),
    cases=tuple(case(*pair, switch) for pair in PAIRS for switch in SWITCHES),
    works=(wb.Work("predictions", predict, PAIRS, seconds=0.5), wb.Work("starts", other_starts, PAIRS, seconds=1.0)),
    sections=sections,
    live=None,
)
