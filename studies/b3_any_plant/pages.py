"""How b3 reads: the plants and their laws, one summary, and a picture and Sobol bars of each plant."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from studies.b3_any_plant.findings import findings, indices
from studies.b3_any_plant.loops import COMPUTER, LAWS, LQG, called, loop, margins
from studies.b3_any_plant.settings import SETTINGS, Setting
from workbench.loop import roles
from workbench.study import Figure, Results, Section, Table, sobol_bars
from workbench.study.document.document import Cell, Column, Measured, Panel, Series
from workbench.study.study import Outcome

SHORT = 0.1  # s: shorter runs are told in ms


def sections(results: Results) -> Sequence[Section]:
    """The whole page."""
    summary = Section("All plants", (summary_table(results), laws_table(), computers_table(results), plants_table()))
    return (findings(results), summary, *(plant_section(setting, results) for setting in SETTINGS))


def headlines(results: Results) -> Sequence[str]:
    """The findings in a line each."""
    return tuple(str(one.statement) for one in findings(results).blocks if hasattr(one, "statement"))


def summary_table(results: Results) -> Table:
    """Margins, errors and settling times, two rows a plant."""
    columns = (
        Column("plant"),
        Column("law"),
        Column("disk margin", align="right", digits=3),
        Column("delay", "periods", "right", digits=2),
        Column("RMSE", align="right"),
        Column("sampled", align="right"),
        Column("settling", align="right"),
        Column("sampled", align="right"),
    )
    rows = [summary_row(setting, law, results) for setting in SETTINGS for law in LAWS]
    notes = (
        f"Sampled: {COMPUTER}, with one draw of the noise. Below a plant's name: the output that is looked at with the "
        "unit of its RMSE, over the whole run, and that of the settling time, until the error stays within 5 % of that "
        "of the start; errors are those by twice the step.",
        "Margins at the inputs of the plant: the disk margin of all inputs at once, and the delay of the worst "
        "input by itself in periods of the computer, which takes one and a half. Any: its gain is always below one.",
    )
    return Table("summary", "Two laws on each plant.", columns, tuple(rows), notes)


def summary_row(setting: Setting, law: str, results: Results) -> tuple[Cell, ...]:
    """A law on a plant."""
    own, runs = margins(setting, law), (results[setting.name, law], results[setting.name, f"{law} {COMPUTER}"])
    fast = setting.until < SHORT
    units = f"{setting.main} [{setting.plant.outputs[setting.main].unit}], [{'ms' if fast else 's'}]"
    return (
        setting.name if law == LQG else units,
        law,
        own.disk.alpha,
        own.delay / setting.period if np.isfinite(own.delay) else "any",
        *(score(run, f"RMSE of {setting.main}") for run in runs),
        *(score(run, f"settling time of {setting.main}", 1e3 if fast else 1.0) for run in runs),
    )


def score(outcome: Outcome, metric: str, scale: float = 1.0) -> Cell:
    """A metric of the first number with its error."""
    value, error = outcome.score(metric, 0)
    return Measured(scale * value, scale * error) if np.isfinite(value) and np.isfinite(error) else "never"


def plants_table() -> Table:
    """What is linearised where, and the certificate of its gains."""
    columns = (
        Column("plant"),
        Column("operating point"),
        Column("poles", "1/s"),
        Column("zeros", "1/s"),
        Column("slowest pole with LQG", "1/s"),
        Column("condition of the Riccati equations", align="right", digits=1),
    )
    rows = tuple(
        (
            setting.name,
            operating(setting),
            spots(setting.model.poles()),
            spots(setting.model.zeros()) if setting.model.ninputs == setting.model.noutputs else None,
            _spot(max(setting.design.poles, key=lambda pole: pole.real)),
            setting.design.certificate.condition,
        )
        for setting in SETTINGS
    )
    notes = (
        "States that are not named are zero there. Poles and zeros are named once, however often they come; zeros are "
        "those of plants with as many outputs as inputs. The published zeros of P\N{MINUS SIGN}, "
        "\N{MINUS SIGN}0.0172 and \N{MINUS SIGN}0.0580 1/s, are those at levels that are rounded.",
    )
    return Table("plants", "The plants where they are linearised.", columns, rows, notes)


def operating(setting: Setting) -> str:
    """The states and the inputs of the operating point that are not zero, with their units."""
    plant, point = setting.plant, setting.point
    entries = zip((*plant.states.entries, *plant.inputs.entries), (*point.x, *point.u), strict=True)
    named = [f"{entry.name} = {value:.4g} {entry.unit}".strip() for entry, value in entries if abs(value) > 1e-9]
    return ", ".join(named) or "zero"


def spots(values: np.ndarray[tuple[int], np.dtype[np.complex128]]) -> str | None:
    """Complex numbers with three digits, each pair once, the largest real part first."""
    upper = sorted((v for v in values if v.imag >= -1e-9), key=lambda v: -v.real)
    words = [_spot(v) for v in upper]
    return ", ".join(dict.fromkeys(words)) or None


def _spot(value: complex) -> str:
    real, imaginary = (0.0 if abs(part) < 1e-9 * (1 + abs(value)) else part for part in (value.real, value.imag))
    words = f"{_short(real)} ± {_short(imaginary)}i" if imaginary else _short(real)
    return words.replace("-", "\N{MINUS SIGN}")


def _short(number: float) -> str:
    return f"{number:,.0f}" if abs(number) >= 1000 else f"{number:.3g}"


def laws_table() -> Table:
    """What either law is given on each plant, as its equations say."""
    heads = ("plant", "outputs", "to LQG, PID", "model", "states", "PID is")
    notes = (
        "Of LQG, then of PID: how the outputs come, which model acts, how many states there are. Read: a reading acts "
        "at its own instant; estimated: the Kalman filter makes it; f: the equations of the plant. LQG is given these "
        "linear, with the plant's true numbers; PID is given no model, but gains that were chosen with one: by hand, "
        "those of the publication (the four tanks), or those of the regulator itself, with filtered derivatives in the "
        "place of velocities (PD). Both begin with the outputs at the start; the filter believes the other states at "
        "the operating point.",
    )
    return Table(
        "laws", "What the two laws are given.", tuple(map(Column, heads)), tuple(map(laws_row, SETTINGS)), notes
    )


def laws_row(setting: Setting) -> tuple[Cell, ...]:
    """What both laws read, and how."""
    given = [roles(loop(setting, law)) for law in LAWS]
    ways = (dict.fromkeys(way for ways in one.readings.values() for way in ways) for one in given)
    models = ("".join(part for parts in one.models.values() for part in parts) or "none" for one in given)
    states = (f"{one.law_states + one.observer_states}" for one in given)
    return (
        setting.name,
        ", ".join(setting.noise),
        ", ".join(" and ".join(held) for held in ways),
        ", ".join(models),
        ", ".join(states),
        setting.words,
    )


def computers_table(results: Results) -> Table:
    """The computer of each plant, and how much the commands move in it."""
    columns = (
        Column("plant"),
        Column("period", align="right"),
        Column("noise"),
        Column("limits"),
        *(Column(f"TV of {law}", "1/s", "right", digits=3) for law in LAWS),
    )
    notes = (
        "Noise: the standard deviation of each reading. TV: total variation per second of the first input, in the unit "
        "of its limits, at the instants of the computer, with one draw of the noise.",
    )
    rows = tuple(computers_row(setting, results) for setting in SETTINGS)
    return Table("computers", "The computer of each plant, and how its commands move.", columns, rows, notes)


def computers_row(setting: Setting, results: Results) -> tuple[Cell, ...]:
    """One computer."""
    plant, (low, high), port = setting.plant, setting.limit, setting.plant.inputs.entries[0]
    noise = dict.fromkeys(f"{value:g} {plant.outputs[name].unit}" for name, value in setting.noise.items())
    return (
        setting.name,
        f"{1e3 * setting.period:g} ms" if setting.period < 1 else f"{setting.period:g} s",
        ", ".join(noise),
        f"{port.name} {low:g} to {high:g} {port.unit}".strip().replace("-", "\N{MINUS SIGN}"),
        *(results[setting.name, f"{law} {COMPUTER}"].score("TV", 0)[0] for law in LAWS),
    )


def plant_section(setting: Setting, results: Results) -> Section:
    """The picture and the Sobol bars of a plant."""
    return Section(setting.name[0].upper() + setting.name[1:], (picture(setting, results), bars(setting, results)))


def picture(setting: Setting, results: Results) -> Figure:
    """The main output and the first input of both laws, in continuous time and in a computer."""
    fast = setting.until < SHORT
    scale, axis = (1e3, "time [ms]") if fast else (1.0, "time [s]")
    inputs = setting.plant.inputs.entries[0]
    panels = []
    for name, unit, look in (
        (setting.main, setting.plant.outputs[setting.main].unit, "line"),
        (inputs.name, inputs.unit, "steps"),
    ):
        for where in ("", f" {COMPUTER}"):
            runs = [(law, results[setting.name, f"{law}{where}"]) for law in LAWS]
            steps = look if where else "line"
            series = [
                Series(law, scale * run.t, run.signal(name, 0), run.case.style, look=steps)  # type: ignore[arg-type]
                for law, run in runs
            ]
            if name == setting.main:
                t = scale * runs[0][1].t[[0, -1]]
                series.append(Series("wanted", t, np.full(2, setting.wanted[name]), "reference"))
            label = f"{name} [{unit}]" if unit else name
            panels.append(Panel(label, tuple(series), axis, title=where.strip() or "in continuous time"))
    caption = f"{setting.name}: from off the operating point, which is wanted. PID: {setting.words}."
    return Figure(f"runs_{called(setting, '').strip('_')}", caption[0].upper() + caption[1:], tuple(panels), columns=2)


def bars(setting: Setting, results: Results) -> Figure:
    """Sobol indices of the error under both laws."""
    found = indices(setting, results)
    note = "; ".join(
        f"{law}: {results.sample(called(setting, law)).note_of(f'RMSE of {setting.main}')}" for law in LAWS
    )
    ranges = {f"{100 * (high - 1):.0f} %" for _, high in setting.spread.values()}
    caption = (
        f"{setting.name[0].upper()}{setting.name[1:]}: parts of the variance of the RMSE of {setting.main} in "
        f"continuous time, where each parameter of the plant is within {', '.join(sorted(ranges))} of its own value."
    )
    return sobol_bars(f"sobol_{called(setting, '').strip('_')}", caption, found, note)
