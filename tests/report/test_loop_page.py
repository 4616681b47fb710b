"""The page of a single loop: from Python, from runs, from the command line, and in a notebook's frame."""

import json
import re
import sys
import time
from importlib import import_module

import casadi as ca
import numpy as np
import pytest

import workbench as wb
from studies.paper.laws import proposed_repaired
from studies.performance.chromium import PATIENCE, open_page
from tests.support.browsers import needs_chromium
from workbench.report.live.loop_study import knobs_of, loop_study
from workbench.study import case_runs

MOTOR = wb.DCMotor()
IDLE = "livePage.flight && !livePage.flight.fine.size && !livePage.held"


def loop(**gains):
    law = wb.PID(MOTOR.outputs, MOTOR.inputs, **{"Kp": 100.0, "Ki": 200.0, "low": -24.0, "high": 24.0} | gains)
    return wb.ClosedLoop(MOTOR, controller=law, reference=wb.Step("omega", "rad/s", 1.0, time=0.1))


def odd():
    t, x, a = (ca.SX.sym(name) for name in "txa")
    return wb.Ode("odd", wb.layout(x="1"), wb.layout(a=("1", 1.0)), wb.layout(y="1"), t, x, a, ca.erf(a - x), x)


def data_of(page):
    found = re.search(r'<script type="application/json" id="live">(.*?)</script>', page.text, re.S)
    return json.loads(found[1]) if found else None


def names_of(page):
    return [knob["name"] for knob in data_of(page)["knobs"]]


def test_the_knobs_of_a_law_come_first_and_those_of_models_last():
    plant = wb.CartPole(phi=0.1)
    observer = wb.LinearObserver(plant, np.ones((4, 2)))
    law = wb.StateFeedback.of(plant, [[-70.0, -38.0, 105.0, 21.0]], follow=("x",))
    names = names_of(wb.live(wb.ClosedLoop(plant, observer, law, wb.Step("x", "m", 0.2)), until=0.1))
    blocks = [name.split(".")[0] for name in names if ".model." not in name]
    assert list(dict.fromkeys(blocks)) == ["controller", "plant", "reference", "observer"]
    models = [".model." in name for name in names]
    assert models == sorted(models)
    assert any(models)
    assert "plant.phi" in names  # where the plant starts


def test_a_number_that_nothing_shown_depends_on_has_no_knob():
    t, x, p = ca.SX.sym("t"), ca.SX.sym("x"), ca.SX.sym("p", 2)
    ode = wb.Ode(
        "two", wb.layout(x="m"), wb.layout(a=("1/s", 1.0), idle=("1", 2.0)), wb.layout(x="m"), t, x, p, -p[0] * x, x
    )
    assert [knob.name for knob in knobs_of(wb.rk4(ode, 0.1))] == ["a"]


def test_a_number_of_unknown_unit_is_turned_by_a_share_and_at_zero_not_at_all():
    t, x, p = ca.SX.sym("t"), ca.SX.sym("x"), ca.SX.sym("p", 2)
    numbers = wb.layout(a=("?", 3.0), zero=("?", 0.0))
    ode = wb.Ode("two", wb.layout(x="m"), numbers, wb.layout(x="m"), t, x, p, -p[0] * x + p[1], x)
    assert [(knob.name, knob.share) for knob in knobs_of(wb.rk4(ode, 0.1))] == [("a", True)]


def test_a_knob_keeps_away_from_a_bound_that_its_number_must_not_reach():
    @wb.block
    class Power(wb.Plant):
        """x' = -x^gamma."""

        gamma: float = wb.parameter(default=1.25, unit="1", low=1, high=2, strict=True)
        x: float = wb.initial(default=1.0, unit="m")
        inputs, outputs = wb.layout(u="m/s"), wb.layout(x="m")

        def rate(self, t, x, u):
            return {"x": u.u - x.x**self.gamma}

    gamma, _ = knobs_of(wb.rk4(wb.open_loop(Power()), 0.1))
    assert (gamma.low, gamma.high) == pytest.approx((1.05, 1.85))  # a fifth of the way from either bound is left


def test_a_share_of_a_vector_ends_where_the_first_of_its_numbers_does():
    @wb.block
    class Valves(wb.Plant):
        """x' = u - (a_1 + a_2) x."""

        a: object = wb.parameter(default=[0.25, 0.5], unit="1/s", low=0, high=1, shape=("2",))
        x: float = wb.initial(default=1.0, unit="m")
        inputs, outputs = wb.layout(u="m/s"), wb.layout(x="m")

        def rate(self, t, x, u):
            return {"x": u.u - ca.sum1(self.a) * x.x}

    valves, *_ = knobs_of(wb.rk4(wb.open_loop(Valves()), 0.1))
    assert (valves.share, valves.low, valves.high) == (True, 0.2, 2.0)


@pytest.fixture(scope="module")
def repaired():
    """The repaired law of the paper, and its page."""
    closed = proposed_repaired("FS")
    return closed, wb.live(closed, until=0.1)


@pytest.mark.heavy
def test_a_long_name_keeps_its_block_and_its_end_where_it_is_still_the_only_one(repaired):
    names = names_of(repaired[1])
    assert {"plant.links[0].mass", "controller.links[0].mass", "observer.links[0].mass"} <= {*names}
    assert len({*names}) == len(names)


def test_signals_of_one_number_have_no_name_in_the_legend():
    study = loop_study(loop(), until=0.08, h=1e-3)  # before the step, behind which nothing is warned of
    section, _ = study.sections(case_runs.run(study))
    *figures, _ = section.blocks
    panels = [panel for figure in figures for panel in figure.panels]
    assert [[series.label for series in panel.series] for panel in panels] == [["", "reference"], [""]]
    assert [panel.ylabel for panel in panels] == ["omega [rad/s]", "v_applied [V]"]
    assert [figure.title for figure in figures] == ["omega", "v_applied"]


@pytest.mark.heavy
def test_a_law_with_a_dagger_has_its_reason_below_the_table(repaired):
    closed, page = repaired
    notes = closed.ode().notes
    assert notes
    assert ("†" in data_of(page)["loops"][0]["label"], notes[0] in page.text) == (True, True)


def test_a_plant_alone_has_a_page_without_a_table():
    page = wb.live(wb.open_loop(MOTOR), until=1.0)
    assert (len(data_of(page)["curves"]), data_of(page)["cells"]) == (1, [])
    assert "Table 1" not in page.text


def test_runs_give_the_page_of_their_loop_until_their_horizon():
    runs = wb.simulate(wb.rk4(loop().ode(), 2e-3), until=0.4)
    assert runs.live().text == wb.live(loop().ode(), until=0.4, h=2e-3).text


def test_a_loop_that_no_browser_can_run_has_a_printed_page_that_says_why():
    page = wb.live(odd(), until=1.0)
    assert "ERF" in page.no_live_reason
    assert repr(page).startswith("<printed page")
    assert "Nothing can be turned in this loop" in page.text
    assert "<script" not in page.text
    assert "<svg" in page.text


def test_a_loop_without_numbers_has_a_printed_page_that_says_so():
    t, x = ca.SX.sym("t"), ca.SX.sym("x")
    ode = wb.Ode("bare", wb.layout(x="m"), wb.layout(), wb.layout(x="m"), t, x, ca.SX(0, 1), -x, x)
    page = wb.live(ode, until=1.0)
    assert page.no_live_reason == "Nothing can be turned in this loop: no number moves what is shown."
    assert "<script" not in page.text


def test_without_llvmlite_a_page_is_printed_and_says_so(monkeypatch):
    monkeypatch.setitem(sys.modules, "workbench.engine.kernel.webassembly", None)
    monkeypatch.delattr(import_module("workbench.engine.kernel"), "webassembly", raising=False)
    page = wb.live(loop(), until=0.1)
    assert page.no_live_reason.endswith("llvmlite, which compiles it for a browser, is not installed.")
    assert "<script" not in page.text


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"until": 2.0, "h": 3e-3}, r"`live\(until=...\)` must be a multiple of the step 0.003 s"),
        ({"until": 0.0}, r"`live\(until=...\)` must be a positive, finite number of seconds; got 0.0"),
        ({"until": float("nan")}, r"`live\(until=...\)` must be a positive, finite number of seconds; got nan"),
        ({"until": 1.0, "h": -1.0}, r"`live\(h=...\)` must be a positive, finite number of seconds; got -1.0"),
    ],
)
def test_times_that_do_not_fit_are_refused_in_one_sentence(given, says):
    with pytest.raises(ValueError, match=says):
        wb.live(loop(), **given)


@pytest.mark.parametrize("given", [3, None, "loop", MOTOR])
def test_a_loop_that_is_none_is_refused_in_one_sentence(given):
    with pytest.raises(ValueError, match=r"`loop` must be an `Ode`, a `SampledSystem`, or a loop, .*; got"):
        wb.live(given, until=1.0)


def test_a_page_is_written_only_into_a_folder_that_is_there(tmp_path):
    page = wb.live(loop(), until=0.1)
    assert page.write(tmp_path / "a.html").read_text("utf-8") == page.text
    with pytest.raises(LookupError, match="must be in a folder that is there"):
        page.write(tmp_path / "none" / "a.html")
    with pytest.raises(LookupError, match="must be the path of a file"):
        page.write(tmp_path)


class Frame:
    """The page inside the first frame of a page, wherever the browser keeps it."""

    def __init__(self, outer):
        self.outer = outer
        outer.call("Target.setAutoAttach", autoAttach=True, waitForDebuggerOnStart=False, flatten=True)
        outer.until("document.readyState === 'complete'")
        attached = [told for told in outer.events("Target.attachedToTarget") if told["targetInfo"]["type"] == "iframe"]
        contexts = [told["context"] for told in outer.events("Runtime.executionContextCreated")]
        inside = [one["id"] for one in contexts if one["auxData"]["frameId"] != contexts[0]["auxData"]["frameId"]]
        self.session = attached[0]["sessionId"] if attached else outer.session
        self.given = {} if attached else {"contextId": inside[-1]}

    def value(self, expression):
        told = self.outer.browser.call(
            "Runtime.evaluate", self.session, expression=expression, returnByValue=True, awaitPromise=True, **self.given
        )
        assert "exceptionDetails" not in told, told
        return told["result"].get("value")

    def until(self, expression):
        end = time.monotonic() + PATIENCE
        while not self.value(expression):
            assert time.monotonic() < end, expression
            time.sleep(0.02)


@pytest.mark.heavy
@needs_chromium
def test_a_page_in_the_frame_of_a_notebook_is_live(tmp_path):
    path = tmp_path / "notebook.html"
    shown = wb.live(loop(), until=0.5)._repr_html_()
    path.write_text(f"<!DOCTYPE html><meta charset=utf-8><title>Notebook</title>{shown}", encoding="utf-8")
    with open_page(path) as outer:
        frame = Frame(outer)
        frame.value("document.querySelector('.bench-handle').click()")
        frame.until("livePage.data")
        frame.value("livePage.bench.knobs[0].turn(2 * livePage.data.knobs[0].value)")
        frame.until(f"livePage.failed || {IDLE}")
        assert not frame.value("livePage.failed")
        printed = frame.value("livePage.data.loops[0].scores[0][0][0]")
        assert 0 < frame.value("livePage.views.get(0).scores[0][0][0]") < printed
        assert outer.complaints == []
