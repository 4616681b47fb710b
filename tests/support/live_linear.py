"""The linear answers of a live page for tests: its worker answers in Node, and is held against Python."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import workbench as wb
from tests.support.node import answered
from workbench.report.live.linear_data import linear_data
from workbench.report.live.marches import Modules
from workbench.report.live_page import WORKER
from workbench.study import case_runs

TEMPLATES = Path(__file__).parents[2] / "workbench" / "report" / "templates" / "live"
CLOSE = 1e-9  # of the size of what is compared, as the page promises
SCRIPT = """
const { inflateRawSync } = require("zlib"), { linear, modules, turns } = given;
const compiled = modules.map((one) => new WebAssembly.Module(inflateRawSync(Buffer.from(one, "base64"))));
const answers = new LinearAnswers(linear, compiled), numbers = (row) => Float64Array.from(row, Number);
const found = turns.map(({ p, x }) => answers.answer(numbers(p), numbers(x)));
const plain = (_, value) => ArrayBuffer.isView(value) ? Array.from(value, String)
  : typeof value === "number" && !Number.isFinite(value) ? String(value) : value;
return JSON.parse(JSON.stringify(found, plain));
"""


REPLIES = (
    SCRIPT.replace("answers.answer(numbers(p), numbers(x))", "replyTo(answers, question(p, x, rest))")
    .replace("{ p, x }", "{ p, x, ...rest }")
    .replace(
        "const found",
        "const question = (p, x, { Mt, ...rest }) => ({ ...rest, p: numbers(p), x: numbers(x), Mt: Mt ?? Infinity });\n"
        "const found",
    )
)


@dataclass(frozen=True, eq=False)
class LoopData:
    """A loop of a page: its data `linear`, its packed modules, and the step whose numbers the page turns."""

    loop: Any
    linear: Any
    refused: str
    modules: tuple[str, ...]
    step: Any

    @staticmethod
    def of(loop: Any, h: float = 1e-3, until: float = 0.01) -> LoopData:
        run = wb.Run(loop, (), until=until, h=h)
        study = wb.Study("live", "T", "Q?", "M.", lambda results: [], cases=(wb.Case("s", "l", run),))
        outcome, modules = case_runs.run(study).outcomes[0], Modules()
        made = linear_data(outcome, modules)
        step = outcome.measurement.trajectories.step
        return LoopData(loop, made["linear"], made["linear_refused"], tuple(modules.packed_modules.values()), step)

    def turn(self, **values: Any) -> dict[str, list[str]]:
        """The numbers of the page with parameters and first states by name; `__` stands for a dot."""
        given = {name.replace("__", "."): value for name, value in values.items()}
        p = self.step.parameters.pack({n: v for n, v in given.items() if n in self.step.parameters})[0]
        x = self.step.states.pack({n: v for n, v in given.items() if n in self.step.states})[0]
        return {"p": [str(v) for v in p], "x": [str(v) for v in x]}

    def answers(self, *turns: dict[str, list[str]]) -> list[Any]:
        """What the worker answers to each turn."""
        return self._answered(SCRIPT, turns)

    def replies(self, *questions: dict[str, Any]) -> list[Any]:
        """What the worker replies to each question, which has the numbers of a turn."""
        return self._answered(REPLIES, questions)

    def _answered(self, script: str, turns: Any) -> list[Any]:
        text, names = (
            "\n".join((TEMPLATES / f"{name}.js").read_text("utf-8") for name in WORKER),
            "LinearAnswers, replyTo",
        )
        given = {"linear": self.linear, "modules": self.modules, "turns": turns}
        return list(answered(f"const {{ {names} }} = (() => {{ {text}; return {{ {names} }}; }})();{script}", given))

    def knob(self, path: str, low: float, high: float, value: float) -> dict[str, Any]:
        """A knob of one parameter, as the worker reads it."""
        place = self.step.parameters.slice(path).start
        return {"p": [place], "x": [], "low": low, "high": high, "log": False, "share": False, "value": value}

    def python(self, **values: Any) -> Any:
        """The linear loop at the same numbers, as Python has it."""
        given = {name.replace("__", "."): value for name, value in values.items()}
        substeps = self.step.substeps if self.linear["period"] else None
        held, rests = tuple(self.linear["held"]), self.linear["rests"]
        return wb.linear_loop(self.loop, values=given, freeze=held, at_rest=rests, substeps=substeps)


def complex_of(pair: Any) -> Any:
    return np.array(pair["re"], dtype=float) + 1j * np.array(pair["im"], dtype=float)


def assert_same(answer: Any, linear: Any, poles_within: float = CLOSE) -> None:
    """The answer of a page is that of Python: rest, L, poles, crossovers, margins and peaks."""
    assert answer["rests"], answer["reason"]
    np.testing.assert_allclose(np.array(answer["x0"], float), linear.x0, rtol=CLOSE, atol=CLOSE)
    omega, m = np.array(answer["omega"], float), len(linear.channels)
    ours, theirs = complex_of(answer["L"]).reshape(-1, m, m), linear.response(omega).values
    size = np.abs(theirs).max(axis=(1, 2), keepdims=True)
    assert (np.abs(ours - theirs) <= CLOSE * size).all()
    found, wanted = (np.sort_complex(np.round(p, 12)) for p in (complex_of(answer["poles"]), poles_of(linear)))
    np.testing.assert_allclose(found, wanted, rtol=poles_within, atol=poles_within * np.abs(wanted).max())
    assert answer["stable"] == linear.stable
    for own, margins in zip(answer["margins"], linear.margins().values(), strict=True):
        assert_margins(own, margins)
    if m == 1 and answer["margins"][0]["bandwidth"] is not None:  # else T is zero at rest, or never falls
        assert close(answer["margins"][0]["bandwidth"], linear.bandwidth().frequency.value)
    assert_disk(answer["diskMargin"], linear)


def poles_of(linear: Any) -> Any:
    return np.array([pole.value for pole in linear.poles])


def assert_margins(own: Any, wanted: Any) -> None:
    assert own["stable"] == wanted.stable
    for name, theirs in (("gainCrossovers", wanted.gain_crossovers), ("phaseCrossovers", wanted.phase_crossovers)):
        there = [row for row in theirs if np.isfinite(row.frequency.value)]
        assert len(own[name]) == len(there), (name, own[name], there)
        for ours, row in zip(own[name], there, strict=True):
            assert close(ours["omega"], row.frequency.value)
            assert close(ours["phase" if "phase" in ours else "gain"], row.margin.value)
    if wanted.margins is None:
        assert [own[name] for name in ("phaseMargin", "delayMargin", "Ms", "Mt", "bandwidth")] == [None] * 5
        return
    figures = wanted.margins
    assert close(own["gainMargin"]["low"], figures.gain_low.value or None)
    assert close(own["gainMargin"]["high"], figures.gain_high.value)
    assert close(own["phaseMargin"], figures.phase_margin.value)
    assert close(own["delayMargin"], figures.delay_margin.value)
    for name, peak in (("Ms", figures.Ms), ("Mt", figures.Mt)):
        assert close(own[name], peak.gain.value)
        if abs(peak.gain.value - 1) > CLOSE:  # else the place of a peak of one is anywhere that S or T is one
            assert close(own[f"omega{name}"], peak.frequency, 1e-7), name  # of a flat top


def assert_disk(own: Any, linear: Any) -> None:
    """The disk margin of one channel is that of Python; of several it lies between the bounds that Python proves."""
    if not linear.stable:
        assert own is None
        return
    if len(linear.channels) == 1:
        (margins,) = linear.margins().values()
        assert close(own["alpha"], margins.margins.disk_margin.value)
        return
    disk, within = linear.disk_margin, CLOSE if len(linear.channels) == 2 else 1e-6  # of three a search ends there
    assert disk.alpha * (1 - within) <= own["alpha"] <= disk.alpha_above * (1 + within)


def close(ours: float | None, theirs: float | None, within: float = CLOSE) -> bool:
    """True if two numbers agree, and where there is none, or an infinite one, if both say so."""
    if ours is None or theirs is None:
        return ours is None and (theirs is None or not np.isfinite(theirs))
    return bool(abs(float(ours) - theirs) <= within * max(1e-3, abs(theirs)))
