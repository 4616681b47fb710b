"""Tables of all that was chosen in b3: starts, horizons, weights, gains, and the numbers of the plants."""

from __future__ import annotations

import numpy as np

import workbench as wb
from studies.b3_any_plant.loops import COARSE, SUBSTEPS
from studies.b3_any_plant.settings import SETTINGS, Setting, digits


def choice_tables() -> tuple[wb.document.ReportTable, ...]:
    """All of them."""
    return starts_table(), weights_table(), gains_table(), pid_table(), numbers_table()


def duration_words(seconds: float) -> str:
    """A time with its unit."""
    return f"{1e3 * seconds:g} ms" if seconds < 1 else f"{seconds:,g} s"


def starts_table() -> wb.document.ReportTable:
    """The initial state, the reference, the horizon and the steps."""
    rows = []
    for setting in SETTINGS:
        entries = zip(setting.plant.states.entries, setting.open.states.default, strict=True)
        start = ", ".join(f"{e.name} = {digits(x)} {e.unit}".strip() for e, x in entries)
        wanted = ", ".join(f"{name} = {digits(y)}" for name, y in setting.operating_outputs.items())
        steps = (duration_words(setting.period / parts) for parts in (SUBSTEPS, COARSE))
        rows.append((setting.name, start, wanted, duration_words(setting.until), *steps))
    heads = ("plant", "start", "reference", "horizon", "step of a run", "step with varied parameters")
    notes = (
        "The observer of LQG starts with the true outputs, and with all other states at the operating point. The "
        "integrals of PID start at zero; its derivative filters start at the first reading.",
    )
    return wb.document.ReportTable(
        "starts", "Starts, references and horizons.", tuple(map(wb.document.TableColumn, heads)), tuple(rows), notes
    )


def weights_table() -> wb.document.ReportTable:
    """The sizes that make the weights of LQG, and the noise for which its filter is designed."""
    rows = []
    for setting in SETTINGS:
        named = zip(setting.plant.states.names, setting.states, strict=True)
        sizes = ", ".join(f"{name} {digits(size)}" for name, size in named if np.isfinite(size))
        sizes += f"; {', '.join(setting.plant.inputs.names)} {digits(setting.inputs[0])}"
        noise = ", ".join(f"{name} {value:g}" for name, value in setting.noise.items())
        rows.append((setting.name, sizes, f"{setting.push:g}", noise, duration_words(setting.period)))
    heads = ("plant", "scales of states; inputs", "input noise w", "reading noise v", "period T")
    notes = (
        "The regulator minimises the integral of the sum of (x / scale)\N{SUPERSCRIPT TWO} and (u / "
        "scale)\N{SUPERSCRIPT TWO} (Bryson's rule); a state that is not named costs nothing. The filter is designed "
        "for white noise of "
        "intensity w\N{SUPERSCRIPT TWO} T at each input, and of intensity v\N{SUPERSCRIPT TWO} T at each reading. "
        "Scales have the units of the states and inputs, w that of the input, and v those of the outputs.",
    )
    return wb.document.ReportTable(
        "weights", "The weights of LQG.", tuple(map(wb.document.TableColumn, heads)), tuple(rows), notes
    )


def gains_table() -> wb.document.ReportTable:
    """The gains of regulator and filter."""
    rows = [(s.name, digits(s.design.regulator.K), digits(s.design.estimator.K)) for s in SETTINGS]
    columns = (
        wb.document.TableColumn("plant"),
        wb.document.TableColumn("K of the regulator"),
        wb.document.TableColumn("L of the filter"),
    )
    notes = (
        "u = u_0 \N{MINUS SIGN} K (x_hat \N{MINUS SIGN} x_0), where K has a row for each input; x_hat' = A (x_hat "
        "\N{MINUS SIGN} x_0) + B (u \N{MINUS SIGN} u_0) + L (y \N{MINUS SIGN} y_hat), where L has a row for each "
        "state. Units follow from those of states, inputs and outputs.",
    )
    return wb.document.ReportTable(
        "gains",
        ("The gains of LQG, from the weights of ", wb.document.CrossReference("weights"), "."),
        columns,
        tuple(rows),
        notes,
    )


def pid_table() -> wb.document.ReportTable:
    """The second law of each plant with its gains and their origin."""
    rows = tuple((s.name, s.pid.words, s.pid.origin, s.pid.gains(s)) for s in SETTINGS)
    notes = (
        (
            "PI and PID: u = u_0 + Kp e + Ki times the integral of e, minus Kd times the derivative of y, filtered by "
            "1 / (1 + s / N); e = reference \N{MINUS SIGN} y. Two PI controllers: each is Kp (e + integral of e / Ti). "
            "Those of LQG's regulator: the gain K of ",
            wb.document.CrossReference("gains"),
            ", with filtered derivatives in place of velocities. Both laws then differ in their filters alone.",
        ),
    )
    heads = ("plant", "PID is", "gains", "numbers")
    return wb.document.ReportTable(
        "pid", "The PID law of each plant.", tuple(map(wb.document.TableColumn, heads)), rows, notes
    )


def numbers_table() -> wb.document.ReportTable:
    """The numbers of each plant, and those that are varied."""
    rows = tuple((s.name, numbers(s), ranges(s)) for s in SETTINGS)
    heads = ("plant", "numbers", "varied by")
    notes = (
        "Varied: each number is drawn independently and uniformly within this share of its value. Both laws keep the "
        "nominal numbers.",
    )
    return wb.document.ReportTable(
        "numbers", "The numbers of the plants.", tuple(map(wb.document.TableColumn, heads)), rows, notes
    )


def numbers(setting: Setting) -> str:
    """The parameters of a plant with their units."""
    entries = [e for e in setting.open.parameters.entries if e.name not in setting.plant.inputs.names]
    return ", ".join(f"{e.name.removeprefix('plant.')} = {digits(e.default)} {e.unit}".strip() for e in entries)


def ranges(setting: Setting) -> str:
    """The parameters that are varied, with their share."""
    shares = {f"\N{PLUS-MINUS SIGN}{100 * (high - 1):.0f} %" for _, high in setting.spread.values()}
    return f"{', '.join(setting.spread)}: {', '.join(sorted(shares))}"
