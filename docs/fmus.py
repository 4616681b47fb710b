"""FMUs with reference runs in the form of the FMI standard's cross-check: `python docs/fmus.py` makes docs/_fmus.

Each is a folder VERSION/cs/NAME with NAME.fmu, NAME_in.csv, NAME_ref.csv and NAME_ref.opt. A tool that runs the FMU on
the inputs with the options must get the outputs of the reference, which are those of `simulate` in its portable
arithmetic, to the last bit.
"""

import csv
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

import casadi as ca  # noqa: E402
import numpy as np  # noqa: E402

import workbench as wb  # noqa: E402
from docs.loops import gallery_loop  # noqa: E402
from workbench.core import Entry, Layout, StepMap  # noqa: E402
from workbench.handover.fmi import Fmu, fmu  # noqa: E402

FOLDER = ROOT / "docs" / "_fmus"
STEPS = 500
LAWS = "AOSMC-RGS", "PID + gravity", "super-twisting", "computed torque", "RISE", "LQG, DC motor", "LQG, cart-pole"
PLANTS = (
    "PID",
    "LQG, DC motor",
    "LQG, cart-pole",
    "LQG, quadruple tank P+",
    "LQG, planar quadrotor",
    "LQG, stirred tank",
)
LOOPS = "AOSMC-RGS", "ASMC", "LQG, DC motor", "PID, Furuta pendulum", "LQG, planar quadrotor"
COMPUTERS = "PID + gravity", "super-twisting", "PID, cart-pole"  # loops with a computer


class Example(NamedTuple):
    """An FMU to be, the step of its equations, its inputs (N, ...) and the outputs (N + 1, ...) that must come."""

    name: str
    what: Any
    h: float | None
    step: float  # s, of communication
    inputs: Layout
    given: np.ndarray
    outputs: Layout
    expected: np.ndarray


def examples(first: int = 0, every: int = 1) -> Iterator[Example]:
    """All examples, or some: laws on readings of their own loops, plants under constant inputs, and closed loops."""
    kinds = (of_law, LAWS), (of_plant, PLANTS), (of_loop, LOOPS), (of_computer, COMPUTERS)
    laws_and_plants = [(of, name) for of, names in kinds for name in names]
    yield from (of(name, gallery_loop(name)) for of, name in laws_and_plants[first::every])


def of_law(name: str, shown: Any, reference: str = "input") -> Example:
    """The law of a computer, which is handed the readings of its loop and, unless it has one, the reference."""
    loop, period = shown.loop, 2 * shown.h
    digital = loop.digital(period)
    law = digital.law(reference, truths=tuple(x for x in loop.plant.truths.names if x in loop.observer.reads))
    taken = Layout(tuple(Entry(path, np.zeros(value.numel())) for path, value in digital.computer_input_values.items()))
    values = ca.vertcat(*[ca.vec(value) for value in digital.computer_input_values.values()])
    step = digital.step(2).with_memory(taken, taken.symbols(), values)
    run = wb.simulate(step, until=round(STEPS * period, 12), arithmetic="portable")

    def columns(prefix: str, names: tuple[str, ...]) -> list[np.ndarray]:
        return [run.x[0][:, step.states.slice(f"{prefix}{name}")] for name in names]

    inputs = law.readings.with_prefix("y.") + law.references.with_prefix("r.")
    given = np.hstack(columns("y.", law.readings.names) + columns("r.", law.references.names))[1:]
    commands = np.hstack(columns("hold.", law.commands.names))
    commands[0] = law.commands.default
    return Example(f"law {name}", law, None, period, inputs, given, law.commands.with_prefix("u."), commands)


def of_plant(name: str, shown: Any) -> Example:
    """The plant of a loop under constant inputs, from where the plant starts."""
    ode = wb.open_loop(shown.loop.plant)
    inputs = Layout(tuple(ode.parameters[name] for name in ode.inputs))
    values = inputs.default + 0.1 * (1.0 + np.arange(inputs.size))
    entries = inputs.unpack(values)
    p = ode.parameters.pack(entries)
    step = wb.rk4(ode, shown.h)
    given = np.tile(values, (STEPS, 1))
    return Example(f"plant {name}", ode, shown.h, shown.h, inputs, given, step.outputs, outputs_of(step, STEPS, p))


def of_loop(name: str, shown: Any) -> Example:
    """A loop whose law is continuous."""
    ode = shown.loop.ode()
    step = wb.rk4(ode, shown.h)
    none = np.zeros((STEPS, 0))
    return Example(f"loop {name}", ode, shown.h, shown.h, Layout(), none, step.outputs, outputs_of(step, STEPS))


def of_computer(name: str, shown: Any) -> Example:
    """A loop with a computer, whose commands come a period late."""
    digital = shown.loop.digital(2 * shown.h, delay=True)
    step = digital.step(2)
    none = np.zeros((STEPS, 0))
    fields = (Layout(), none, step.outputs, outputs_of(step, STEPS))
    return Example(f"computer {name}", digital, shown.h, step.h, *fields)


def outputs_of(step: StepMap, steps: int, p: np.ndarray | None = None, x0: np.ndarray | None = None) -> np.ndarray:
    """The outputs of a run (N + 1, ny) in the portable arithmetic: kept as memory, each is there one step later."""
    names = step.outputs.with_prefix("output ")
    kept = step.with_memory(names, names.symbols(), ca.densify(step.rule.output))
    start = None if x0 is None else np.concatenate([np.ravel(x0), names.default])
    run = wb.simulate(kept, p, start, until=round((steps + 1) * step.h, 12), arithmetic="portable")
    return run.x[0][1:, step.states.size :]


def write(example: Example, folder: Path, version: str, unit: Fmu | None = None) -> Path:
    """The files of an example, or of its `unit` that is there, in a folder of its own, which is returned."""
    unit = unit or fmu(example.what, version, example.name, h=example.h)
    own = folder / version / "cs" / unit.identifier
    own.mkdir(parents=True, exist_ok=True)
    unit.write(own / f"{unit.identifier}.fmu")
    times = np.arange(len(example.expected)) * example.step
    if example.inputs.size:
        _table(own / f"{unit.identifier}_in.csv", times[:-1], example.inputs.labels, example.given)
    _table(own / f"{unit.identifier}_ref.csv", times, example.outputs.labels, example.expected)
    options = {"StartTime": 0.0, "StopTime": float(times[-1]), "StepSize": example.step, "RelTol": 0.0}
    lines = [f"{name}, {value!r}" for name, value in options.items()]
    (own / f"{unit.identifier}_ref.opt").write_text("\n".join([*lines, ""]), encoding="utf-8")
    return own


def _table(path: Path, times: np.ndarray, names: tuple[str, ...], rows: np.ndarray) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["time", *names])
        table.writerows([map(repr, row) for row in np.column_stack([times, rows]).tolist()])


def main() -> None:
    """Write all examples for both versions."""
    for example in examples():
        for version in ("2.0", "3.0"):
            write(example, FOLDER, version)


if __name__ == "__main__":
    main()
