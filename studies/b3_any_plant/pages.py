"""The page of b3: the findings, the pictures of the plants, one summary, and all that was chosen."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal

import numpy as np

import workbench as wb
from studies.b3_any_plant.choices import choice_tables
from studies.b3_any_plant.findings import answer, findings, mass_claim
from studies.b3_any_plant.frequency_pages import frequency_blocks, frequency_table
from studies.b3_any_plant.loops import COMPUTER, DIGITAL, LAWS, all_margins, indices, laws_of, loop, sweep_name
from studies.b3_any_plant.settings import HARD, SETTINGS, Setting
from studies.b3_any_plant.tank_findings import tanks_table
from studies.b3_any_plant.tanks import SIDES

SHORT = 0.1  # s: shorter runs are shown in ms
LATER = 1.25  # of the longest settling time, where a picture ends


def sections(results: wb.Results) -> wb.Page:
    """The whole page."""
    pictures = [wb.Section(capital(setting.name), blocks(setting, results)) for setting in SETTINGS]
    first = [one for one, setting in zip(pictures, SETTINGS, strict=True) if setting.name == HARD]
    rest = [one for one in pictures if one not in first]
    tanks = wb.Section("The four tanks at P\N{MINUS SIGN} and P+", (tanks_table(results),))
    tables = (summary_table(results), laws_table(), computers_table(results), plants_table(), frequency_table(results))
    return wb.Page(
        answer=answer(results),
        findings=findings(results),
        sections=(
            *first,
            wb.Section("All plants", tables),
            tanks,
            *rest,
            wb.Section("What was chosen", choice_tables()),
        ),
    )


def blocks(setting: Setting, results: wb.Results) -> tuple[wb.document.Block, ...]:
    """The proof of a plant, if it has one, then its pictures: runs, Sobol bars, and loops over frequency.

    Figures come last, so that none of them leaves the section of its plant in the PDF.
    """
    proofs = (mass_claim(results),) if setting.name == "two masses" else ()
    own = (*proofs, picture(setting, results), bars(setting, results))
    made = (*own, *frequency_blocks(setting, results))
    return tuple(sorted(made, key=lambda block: isinstance(block, wb.document.Figure)))


def capital(words: str) -> str:
    """The words with a first capital letter, the others as they are."""
    return words[0].upper() + words[1:]


def scale_of(setting: Setting) -> tuple[float, str]:
    """The unit of the times of a plant, and how many of it are a second."""
    return (1e3, "ms") if setting.until < SHORT else (1.0, "s")


def summary_table(results: wb.Results) -> wb.document.ReportTable:
    """Margins, errors and settling times, with two rows for each plant."""
    rows = []
    for setting in SETTINGS:
        scale, second = scale_of(setting)
        units = f"{setting.main} [{setting.plant.outputs[setting.main].unit}], [{second}]"
        for name, law in zip((setting.name, units), LAWS, strict=True):
            own, both = all_margins(results)[setting.name, law], (law, f"{law} {COMPUTER}")
            periods: wb.document.Cell = own.delay / setting.period if np.isfinite(own.delay) else "no limit"
            runs = [results[setting.name, each] for each in both]
            errors = (wb.study.cell(run, f"RMSE of {setting.main}") for run in runs)
            settling = (wb.study.cell(run, f"settling time of {setting.main}", 0, scale, second) for run in runs)
            rows.append((name, law, own.disk, periods, *errors, *settling))
    columns = (
        wb.document.TableColumn("plant"),
        wb.document.TableColumn("law"),
        wb.document.TableColumn("disk margin", align="right", digits=3),
        wb.document.TableColumn("delay margin", "periods", "right", digits=2),
        wb.document.TableColumn("RMSE", align="right"),
        wb.document.TableColumn("RMSE, digital", align="right"),
        wb.document.TableColumn("settling time", align="right"),
        wb.document.TableColumn("settling time, digital", align="right"),
    )
    notes = (
        "The line below a plant's name gives the output with the unit of its RMSE, then the unit of the settling "
        "time. RMSE: over the whole run. Settling time: until the error stays within 5 % of the error at the start. An "
        "error in brackets is twice the change of the value when the step is halved. Digital: with "
        "a digital controller and one sequence of noise.",
        "Margins at the inputs of the plant: the disk margin of all inputs at once, and the delay margin of the worst "
        "input, in periods of the digital controller, which itself uses 1.5 of them. No limit: the loop gain is always "
        "below one.",
    )
    return wb.document.ReportTable("summary", "Two laws on each plant.", columns, tuple(rows), notes)


def laws_table() -> wb.document.ReportTable:
    """The information of either law on each plant, as its equations say."""
    rows = []
    for setting in SETTINGS:
        given = [wb.loop.roles(loop(setting, law)) for law in LAWS]
        ways = (" and ".join(dict.fromkeys(way for held in one.readings.values() for way in held)) for one in given)
        models = ("".join(part for parts in one.models.values() for part in parts) or "none" for one in given)
        states = (f"{one.law_states + one.observer_states}" for one in given)
        second = setting.pid.words, setting.pid.origin
        rows.append((setting.name, ", ".join(setting.noise), *map(", ".join, (ways, models, states)), *second))
    heads = (
        "plant",
        "outputs",
        "how the outputs reach LQG, PID",
        "model in LQG, PID",
        "states of LQG, PID",
        "PID is",
        "gains of PID",
    )
    notes = (
        "Read: the law uses the reading at the instant at which it is taken. Estimated: the Kalman filter estimates "
        "the output. f: the equations of the plant; LQG has them linearised, with the plant's nominal numbers. PID "
        "has no model inside. Its gains are chosen by hand with the model known, or published, or those of LQG's "
        "regulator with filtered derivatives for velocities.",
    )
    return wb.document.ReportTable(
        "laws", "The information of each law.", tuple(map(wb.document.TableColumn, heads)), tuple(rows), notes
    )


def computers_table(results: wb.Results) -> wb.document.ReportTable:
    """The computer of each plant, and how much the commands move in it."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for setting in SETTINGS:
        plant, (low, high), port = setting.plant, setting.limit, setting.plant.inputs.entries[0]
        noise = dict.fromkeys(f"{value:g} {plant.outputs[name].unit}" for name, value in setting.noise.items())
        period = f"{1e3 * setting.period:g} ms" if setting.period < 1 else f"{setting.period:g} s"
        limits = f"{port.name} {low:g} to {high:g} {port.unit}".strip().replace("-", "\N{MINUS SIGN}")
        moves = (results[setting.name, f"{law} {COMPUTER}"].score("TV").pair[0] for law in LAWS)
        rows.append((setting.name, period, ", ".join(noise), limits, *moves))
    plain = (
        wb.document.TableColumn("plant"),
        wb.document.TableColumn("period", align="right"),
        wb.document.TableColumn("noise"),
        wb.document.TableColumn("limits"),
    )
    columns = (
        *plain,
        *(wb.document.TableColumn(f"TV of {law}", "unit of the limits per s", "right", digits=3) for law in LAWS),
    )
    notes = (
        "Noise: the standard deviation of each reading. TV: the total variation of the first input per second, at the "
        "sampling instants, with one sequence of noise.",
    )
    return wb.document.ReportTable(
        "computers",
        "The digital controller of each plant, and the total variation of its commands.",
        columns,
        tuple(rows),
        notes,
    )


def plants_table() -> wb.document.ReportTable:
    """The operating point of each plant, its poles and zeros there, and the certificate of its gains."""
    rows = []
    for setting in SETTINGS:
        model, plant, point = setting.model, setting.plant, setting.point
        entries = zip((*plant.states.entries, *plant.inputs.entries), (*point.x, *point.u), strict=True)
        named = [f"{entry.name} = {value:.4g} {entry.unit}".strip() for entry, value in entries if abs(value) > 1e-9]
        zeros = spots(model.zeros()) if model.ninputs == model.noutputs else None
        slowest = spots([max(setting.design.poles, key=lambda pole: (pole.real, pole.imag))])
        condition = setting.design.certificate.condition
        rows.append((setting.name, ", ".join(named) or "zero", spots(model.poles()), zeros, slowest, condition))
    columns = (
        wb.document.TableColumn("plant"),
        wb.document.TableColumn("operating point"),
        *(wb.document.TableColumn(head, "1/s") for head in ("poles", "zeros", "slowest pole with LQG")),
        wb.document.TableColumn("condition of the Riccati equations", align="right", digits=1),
    )
    notes = (
        "States that are not named are zero at the operating point. Equal poles or zeros are named once. Zeros are "
        "given for plants with as many outputs as inputs. The published zeros of P\N{MINUS SIGN}, "
        "\N{MINUS SIGN}0.0172 and \N{MINUS SIGN}0.0580 1/s, belong to rounded levels.",
    )
    return wb.document.ReportTable(
        "plants", "The plants at their operating points, where they are linearised.", columns, tuple(rows), notes
    )


def spots(values: Iterable[complex]) -> str | None:
    """Complex numbers with three digits, each pair once, the largest real part first."""
    words = []
    for value in sorted((v for v in values if v.imag >= -1e-9), key=lambda v: -v.real):
        parts = (0.0 if abs(part) < 1e-9 * (1 + abs(value)) else part for part in (value.real, value.imag))
        real, imaginary = (f"{part:,.0f}" if abs(part) >= 1000 else f"{part:.3g}" for part in parts)
        words.append((f"{real} ± {imaginary}i" if imaginary != "0" else real).replace("-", "\N{MINUS SIGN}"))
    return ", ".join(dict.fromkeys(words)) or None


def ending(setting: Setting, results: wb.Results) -> float:
    """The time in s at which the picture of a plant ends: some time after the last of its runs has settled."""
    runs = [results[setting.name, f"{law}{where}"] for law in laws_of(setting) for where in ("", f" {COMPUTER}")]
    times = [run.score(f"settling time of {setting.main}").pair[0] for run in runs]
    longest = LATER * max((time for time in times if np.isfinite(time)), default=np.inf)
    return float(min(float(f"{longest:.1g}") if longest < setting.until else np.inf, setting.until))


def picture(setting: Setting, results: wb.Results) -> wb.document.Figure:
    """The main output and the first input of each law, in continuous time and in a computer."""
    (scale, second), port, end = scale_of(setting), setting.plant.inputs.entries[0], ending(setting, results)
    window, panels = wb.pictures.Window(0.0, end), []
    outputs = setting.plant.outputs.names if setting.name in SIDES else (setting.main,)
    shown = [(name, setting.plant.outputs[name].unit) for name in outputs]
    for name, unit in (*shown, (port.name, port.unit)):
        for where in ("", f" {COMPUTER}"):
            runs = [(law, results[setting.name, f"{law}{where}"]) for law in laws_of(setting)]
            look: Literal["line", "steps"] = "steps" if where and name == port.name else "line"
            seconds = (scale, second)
            series = [
                wb.pictures.curve(run, name, 0, window, law, run.case.style, look=look, seconds=seconds)
                for law, run in runs
            ]
            if name in outputs:
                wanted = np.full(2, setting.operating_outputs[name])
                series.append(wb.document.Series("reference", np.array([0.0, scale * end]), wanted, "reference"))
            label, title = f"{name} [{unit}]" if unit else name, DIGITAL if where else "in continuous time"
            panels.append(wb.document.Panel(label, tuple(series), f"time [{second}]", (0.0, scale * end), title=title))
    cut = f" The runs last {scale * setting.until:,g} {second}; the figure ends after {scale * end:,g} {second}."
    caption = (
        f"{capital(setting.name)}: {' and '.join(outputs)}, and the first input, from a start off the operating point. "
        f"PID is {setting.pid.words}; its gains are {setting.pid.origin}.{cut if end < setting.until else ''}"
    )
    return wb.document.Figure(f"runs_{sweep_name(setting, '').strip('_')}", caption, tuple(panels), columns=2)


def bars(setting: Setting, results: wb.Results) -> wb.document.Figure:
    """Sobol indices of the error under both laws."""
    samples = {law: results.sample(sweep_name(setting, law)) for law in LAWS}
    sources = tuple(sample.source(f"RMSE of {setting.main}", 0, law) for law, sample in samples.items())
    ranges = {f"{100 * (high - 1):.0f} %" for _, high in setting.spread.values()}
    caption = (
        f"{capital(setting.name)}: the parts of the variance of the RMSE of {setting.main} in continuous time that "
        f"each parameter causes. Each parameter varies within {', '.join(sorted(ranges))} of its nominal value."
    )
    return wb.sobol_bars(f"sobol_{sweep_name(setting, '').strip('_')}", caption, indices(setting, results), sources)
