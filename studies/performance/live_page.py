"""The speed of live pages in headless Chromium: from a turned knob to the new pictures, and of the kernel alone.

`python -m studies.performance.live_page` measures a turned specification alone.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter

import numpy as np

import workbench as wb
from studies.paper.card import PROPOSED_LAW
from studies.paper.laws import RIVALS, proposed_repaired, rival
from studies.paper.linearization import LEVEL, POSES, still
from studies.paper.workload import HORIZON, H, loop
from studies.performance.chromium import Page, open_page, program
from studies.performance.inner_parts import Job, html, live_data, loop_study, native
from studies.performance.measurements import Effort, Row

EVERY = 0.01  # s, between two points of a curve
LINEAR = "AOSMC-RGS with its linear answers"
TURNS = {"one loop of W": 60, "the seven laws of a1": 30, LINEAR: 60}  # of a knob, each to another place
SPECIFIED = {"a turned specification, PI": 2, "a turned specification, PID": 3}  # and the gains that follow it
SCRIPT = Path(__file__).with_name("live_page.js")


def live_rows(effort: Effort) -> tuple[Row, ...]:
    """The rows of live pages; without Chromium they are not measured."""
    names = ("one loop of W", LINEAR, "the seven laws of a1")
    if program() is None:
        return tuple(
            Row(name, bar, unit=unit, at_most=True, note="no Chromium here") for name, bar, unit in _bars(names)
        )
    w, linear, laws = names
    with open_bench(page_of_w(), "phi") as page:
        spans = turn_times(page, "phi", 0.002, 0.1, TURNS[w])
        ours, theirs = kernels(page, effort)
    with open_bench(page_of_laws(), "mass") as page:
        seven = turn_times(page, "mass", 0.5, 2.0, TURNS[laws])
    with open_bench(page_at_rest(), "phi") as page:
        answers = turn_times(page, "phi", 0.002, 0.1, TURNS[linear])
        painted = median(page.value("painted"))
    with open_bench(page_at_rest(linear=False), "phi") as page:
        without = median(turn_times(page, "phi", 0.002, 0.1, TURNS[linear]))
    said = f"median of {TURNS[w]} turns, until the pictures of all {HORIZON:g} s at {1e3 * H:g} ms are drawn"
    ratio = (
        f"{median(answers) / without:.2f} times as long as the same bench without them, {without:.3g} ms; "
        f"Chromium, without a graphics card, has painted them after {painted:.3g} ms"
    )
    kernel = f"{ours:.1f} ms, and {theirs:.1f} ms native, one run, in the portable arithmetic, by turns"
    notes = (said, "", f"{said}; {ratio}", "", said.replace(f"{TURNS[w]}", f"{TURNS[laws]}"), kernel)
    found = (*median_and_95th(spans), *median_and_95th(answers), median(seven), ours / theirs)
    return tuple(
        Row(name, bar, value, unit, at_most=True, note=note)
        for (name, bar, unit), value, note in zip(_bars(names), found, notes, strict=True)
    )


def specification_rows(turns: int = 50) -> tuple[Row, ...]:
    """The rows of a turned specification of a motor in Chromium: the median, and the worst of some turns."""
    if program() is None:
        return tuple(Row(name, 200.0, unit="ms", at_most=True, note="no Chromium here") for name in SPECIFIED)
    rows: list[Row] = []
    with open_bench(page_with_specification(), "Kp") as page:
        for name, count in SPECIFIED.items():
            page.value(f"specified(1.3, 2.0, 3, {count})")
            spans = page.value(f"specified(1.3, 2.0, {turns}, {count})")
            said = f"of {turns} turns, until all pictures of the loop with its new gains are drawn"
            rows.append(Row(name, 200.0, median(spans), "ms", at_most=True, note=f"median {said}"))
            rows.append(Row(f"{name}, worst", 200.0, max(spans), "ms", at_most=True, note=f"worst {said}"))
    return tuple(rows)


def page_with_specification() -> str:
    """The bench of a motor under a PID with its linear pictures, whose gains follow limits of S and T."""
    motor = wb.DCMotor()
    law = wb.PID(motor.outputs, motor.inputs, Kp=2.0, Ki=5.0, Kd=0.02, low=-24.0, high=24.0)
    closed = wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0, time=0.1))
    gains = (("Kp", 0.1, 500.0), ("Ki", 0.1, 5000.0), ("Kd", 1e-3, 5.0))
    knobs = [wb.Knob(name, f"controller.{name}", low, high, log=True) for name, low, high in gains]
    return wb.live(closed, until=2.0, knobs=(*knobs, wb.PidSpecification("robustness"))).text


def _bars(names: tuple[str, str, str]) -> tuple[tuple[str, float, str], ...]:
    """The name, the bar and the unit of each row."""
    w, linear, laws = (f"a turned knob, {name}" for name in names)
    return (
        (w, 40.0, "ms"),
        (f"{w}, 95th percentile", 80.0, "ms"),
        (linear, 40.0, "ms"),
        (f"{linear}, 95th percentile", 80.0, "ms"),
        (laws, 150.0, "ms"),
        ("kernel of W in a browser, beside the native one", 1.5, "x"),
    )


def median_and_95th(spans: list[float]) -> tuple[float, float]:
    """The median of some times, and their 95th percentile."""
    return median(spans), float(np.percentile(spans, 95))


def page_of_w() -> str:
    """W alone, at first shown at its step."""
    case = wb.Case("W", "W", wb.Run(loop(), (wb.effort("tau"),), HORIZON, EVERY, H))
    return page_of((case,), wb.Knob("phi", "phi", 0.002, 0.1, log=True), "tau")


def page_of_laws() -> str:
    """The laws of a1 in the first scenario, over the horizon of W and at its step."""
    loops: dict[str, wb.ClosedLoop] = {"AOSMC-RGS": proposed_repaired("FS")} | {law: rival("FS", law) for law in RIVALS}
    cases = tuple(
        wb.Case("FS", law, wb.Run(closed, (wb.rmse(),), HORIZON, EVERY, H), style=i)
        for i, (law, closed) in enumerate(loops.items())
    )
    return page_of(cases, wb.Knob("mass", "plant.arm.links[1].mass", 0.5, 2.0), "e")


def page_at_rest(linear: bool = True) -> str:
    """The bench of the repaired law of the paper at rest, cut at the torques, with or without its linear pictures."""
    knob = wb.Knob("phi", "controller.phi", 0.002, 0.1, log=True)
    bench = loop_study(still(PROPOSED_LAW, POSES[LEVEL]), HORIZON, H, (wb.rmse(),), (knob,))

    def without(results: wb.Results) -> list[wb.Section]:
        sections = bench.sections(results)
        assert isinstance(sections, tuple)
        return [sections[0]]

    return page_of_study(bench if linear else replace(bench, sections=without), bench=True)


def page_of(cases: tuple[wb.Case, ...], knob: wb.Knob, signal: str) -> str:
    """A page of loops, each with its curves and its scores."""
    study = wb.Study(
        "live",
        "A live page",
        "How fast is it?",
        "A knob is turned.",
        lambda results: [wb.pictures.loops_section("Loops", "All of them.", results.outcomes, signal)],
        cases=cases,
        live=(knob,),
    )
    return page_of_study(study)


def page_of_study(study: wb.Study, bench: bool = False) -> str:
    """The page of a study with its data, of a single loop as a bench."""
    results = wb.study.run(study)
    document = wb.study.writeup.document(study, results, "")
    return html(document, live=live_data(study, results, document), bench=bench)


@contextmanager
def open_bench(text: str, knob: str) -> Iterator[Page]:
    """A page in Chromium with its bench open, and a knob turned once, so that all is compiled."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "page.html"
        path.write_text(text, encoding="utf-8")
        with open_page(path, width=1300, height=1000) as page:
            page.value(SCRIPT.read_text("utf-8"))
            page.value("openBench()")
            turn_times(page, knob, 0.6, 0.7, 3)
            yield page


def turn_times(page: Page, knob: str, low: float, high: float, turns: int) -> list[float]:
    """The time in ms from each turn of a knob to the frame in which all new curves and numbers are drawn."""
    found: list[float] = page.value(f"turned({json.dumps(knob)}, {low}, {high}, {turns})")
    return found


def kernels(page: Page, effort: Effort) -> tuple[float, float]:
    """The median times in ms of a run of W by the kernel in a page and by the native one, of one run each, by turns."""
    step = wb.rk4(loop(), H)
    job = Job(
        step, step.parameters.default[np.newaxis], round(EVERY / H), 0, np.zeros(1, dtype=np.int64), 0, "portable"
    )
    x: wb.Array = np.empty((1, round(HORIZON / EVERY) + 1, step.states.size))
    x[:, 0] = step.states.default

    def alone() -> float:
        begin = perf_counter()
        native.march(job, x, lambda share: None, width=1)
        return 1e3 * (perf_counter() - begin)

    page.value("prepared(0)")
    times = [(float(page.value("marched()")), alone()) for _ in range(20 + 4 * effort.repetitions)][10:]
    return median(mine for mine, _ in times), median(theirs for _, theirs in times)


if __name__ == "__main__":
    for row in specification_rows():
        value = "not measured" if row.value is None else f"{row.value:.0f} {row.unit}"
        sys.stdout.write(f"{row.name}: {value}, {row.note}\n")
