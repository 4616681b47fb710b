"""The live page of a fit: the model runs along the log in the browser, with the bits of the engine."""

import json
import re

import casadi as ca
import numpy as np
import pytest

import workbench as wb
from studies.performance.chromium import open_page
from tests.support.browsers import needs_chromium
from tests.support.compilers import needs_llvmlite
from tests.support.fitted_motor import MOTOR, T, motor_log
from tests.support.turned_pages import BYTES, numbers, opened, turned
from workbench.engine.metrics.value_program import MetricProgram
from workbench.identification.summaries.compared_run import FIT, ComparedRun

pytestmark = needs_llvmlite
FREE = ["J", "b", "R", "scale of omega", "offset of i", "omega(0)"]
TURNED = ["J", "R", "scale of omega", "offset of i"]
LOG = motor_log()
LATE = np.delete(np.arange(121), [7, 30, 31])
UNEVEN = wb.Dataset.of(
    T[LATE] + 1e-3 * np.sin(LATE),  # a clock that jitters
    {name: LOG[name][LATE] for name in ("v", "omega", "i")},
    {"v": "V", "omega": "rad/s", "i": "A"},
    name="uneven",
)


@pytest.fixture(scope="module")
def fit():
    return wb.fit(MOTOR, LOG.with_experiments(UNEVEN), FREE, answers={"gap": "samples were lost"})


@pytest.fixture(scope="module")
def live(fit):
    return wb.fit_page(fit, "A motor").live


@pytest.fixture(scope="module")
def values(live):
    """Numbers to which the knobs are turned, within their ranges."""
    ends = {knob["name"]: (knob["low"], knob["high"]) for knob in live["knobs"]}
    return {name: ends[name][0] + 0.7 * (ends[name][1] - ends[name][0]) for name in TURNED}


def inputs(loop, data, values):
    p, x0 = (np.array([float(number) for number in loop[name]]) for name in ("p", "x0"))
    for move in loop["moves"]:
        value = values.get(data["knobs"][move["knob"]]["name"])
        if value is not None:
            p[move["p"]], x0[move["x"]] = value, value
    return p, x0


@pytest.mark.parametrize("place", [0, 1])
def test_a_browser_finds_the_bits_of_the_engine_at_any_numbers(fit, live, values, place):
    from tests.support.wasm_runs import Kernel, unpacked

    loop = live["loops"][place]
    p, x0 = inputs(loop, live, values)
    for name, is_halved in (("whole", False), ("half", True)):
        march = loop[name]
        record = np.frombuffer(unpacked(live["records"][march["record"]])).reshape(-1, march["recorded"])
        kernel = Kernel(unpacked(live["modules"][march["module"]]), march, loop["rows"], record)
        x = kernel.run(p, x0, loop["rows"])
        z = kernel.run(p, x[-1], 1, begin=loop["rows"] * march["stride"], stride=1)
        run = ComparedRun.of(fit, place, is_halved).at(values)
        states = run.states()
        np.testing.assert_array_equal(x, states[run.stride : -1 : run.stride])
        np.testing.assert_array_equal(z[0], states[-1])
        program = MetricProgram(
            *(tuple(map(tuple, loop["metrics"][0]["program"][key])) for key in ("inputs", "nodes")),
            tuple(loop["metrics"][0]["program"]["results"]),
        )
        np.testing.assert_array_equal(program.evaluate(x[-1:], z)[0], run.root_mean_squares()[FIT])


@needs_chromium
def test_a_turned_number_moves_the_curve_and_its_errors_with_the_bits_of_the_engine(fit, values, browser, tmp_path):
    path = wb.fit_page(fit, "A motor").write(tmp_path / "motor") / "index.html"
    with open_page(path, browser=browser) as page:
        opened(page)
        assert page.value("document.querySelectorAll('.bench-track.has-interval').length") == len(fit.names)
        before = page.value("document.querySelector('[data-figure=fit_outputs] svg').innerHTML")
        names = [knob["name"] for knob in wb.fit_page(fit).live["knobs"]]
        turned(page, **{f"knob{names.index(name)}": value for name, value in values.items()})
        assert page.value("document.querySelector('[data-figure=fit_outputs] svg').innerHTML") != before
        for place in (0, 1):
            told = page.value(BYTES % place)
            run, half = (ComparedRun.of(fit, place, is_halved).at(values) for is_halved in (False, True))
            states, ny = run.states(), len(fit.model.outputs)
            np.testing.assert_array_equal(numbers(told["x"], states.shape[1]), states[: -1 : run.stride])
            y = numbers(told["y"], ny)
            np.testing.assert_array_equal(y[:, 1], states[: -1 : run.stride, 1] + values["offset of i"])
            np.testing.assert_array_equal(y[:, 0], values["scale of omega"] * states[: -1 : run.stride, 0])
            whole, finer = (one.root_mean_squares()[FIT] for one in (run, half))
            assert [pair[0] for pair in told["scores"][0]] == whole.tolist()
            assert [pair[1] for pair in told["scores"][0]] == (2 * np.abs(whole - finer)).tolist()
        said = page.value("document.querySelector('.bench-results').textContent")
        assert "RMSE of the fit" in said
        assert f"{whole[0]:.4g}" in said
        assert not page.complaints


def blow_up(times):
    """The fit of x' = a (x^3 - x) + u from a start below 1, above which x ends in a finite time."""
    t, x, p = ca.SX.sym("t"), ca.SX.sym("x"), ca.SX.sym("p", 2)
    ode = wb.Ode("cubic", wb.layout(x="1"), wb.layout(a=("1", 1.0), u=("1", 0.0)), wb.layout(y="1"), t, x, p,
                 p[0] * (x**3 - x) + p[1], x)  # fmt: skip
    u = wb.Dataset.of(times, {"u": 0.05 * np.sign(np.sin(9.0 * times))}, {"u": "1"})
    y = wb.identification.simulate_log(ode, u, ["y"], values={"x": 0.9})["y"]
    y = y + 0.01 * np.random.default_rng(0).standard_normal(len(times))
    log = wb.Dataset.of(times, {"u": u["u"], "y": y}, {"u": "1", "y": "1"})
    return wb.fit(ode, log, ["a", "x(0)"], start={"x": 0.8})


@needs_chromium
@pytest.mark.parametrize("times", [T, T + 2e-3 * np.sin(7.0 * np.arange(121))], ids=["even", "uneven"])
def test_a_run_that_ends_says_at_which_time_of_the_log(browser, tmp_path, times):
    fit = blow_up(times)
    page = wb.fit_page(fit)
    value = page.live["knobs"][1]["high"]
    run = ComparedRun.of(fit, 0).at({"x(0)": value})
    lost = np.argmin(np.isfinite(run.states()).all(axis=1))
    with open_page(page.write(tmp_path / "cubic") / "index.html", browser=browser) as shown:
        opened(shown)
        turned(shown, knob1=value)
        assert shown.value("livePage.views.get(0).divergedAt") == pytest.approx(run.t[lost], rel=1e-9)
        assert "diverged at" in shown.value("document.querySelector('.bench-results').textContent")


@needs_chromium
def test_the_curve_of_an_uneven_log_stands_at_its_own_times(fit, browser, tmp_path):
    path = wb.fit_page(fit, "A motor").write(tmp_path / "motor") / "index.html"
    with open_page(path, browser=browser) as page:
        opened(page)
        turned(page, knob0=0.02)
        program = "[...numbersOfCurve(livePage.data.curves[2], livePage.views.get(1), livePage.data.loops[1]).x]"
        np.testing.assert_array_equal(page.value(program), ComparedRun.of(fit, 1).kept_times)


def test_a_knob_stands_at_the_estimate_with_its_interval_within_its_range(fit, live):
    for knob in live["knobs"]:
        low, high = np.clip(fit.intervals()[knob["name"]], knob["low"], knob["high"])
        assert knob["value"] == fit.values[knob["name"]]
        assert knob["interval"] == [low, high]
        assert knob["low"] < knob["value"] < knob["high"]


def test_the_printed_errors_are_those_of_the_portable_arithmetic(fit, live):
    scores = live["loops"][1]["scores"]
    assert [value for value, _ in scores[0]] == ComparedRun.of(fit, 1).root_mean_squares()[FIT].tolist()


def test_a_delay_is_no_knob_and_a_page_of_a_delay_alone_is_printed():
    fit = wb.fit(MOTOR, LOG, ["J", "delay of v"], start={"delay of v": 0.01})
    page = wb.fit_page(fit)
    assert [knob["name"] for knob in page.live["knobs"]] == ["J"]
    alone = wb.fit_page(wb.fit(MOTOR, LOG, ["delay of v"], start={"delay of v": 0.01}))
    assert alone.live is None
    assert "delay" in alone.no_live_reason
    assert "Nothing can be turned on this page" in alone.text
    assert "<script" not in alone.text


def test_a_summary_alone_is_printed_and_that_of_another_fit_is_refused(fit):
    summary = wb.identification.FitSummary.of(fit)
    assert wb.fit_page(summary).live is None
    assert wb.fit_page(fit, summary=summary).live is not None
    with pytest.raises(ValueError, match="must have one summary"):
        wb.fit_page(summary, summary=summary)
    with pytest.raises(ValueError, match="summary of this fit"):
        wb.fit_page(wb.fit(MOTOR, LOG, ["J"]), summary=summary)


def test_no_name_of_a_log_ends_the_data_of_its_page():
    evil = "</script><b>"
    log = wb.Dataset.of(T, {"v": LOG["v"], evil: LOG["omega"]}, {"v": "V", evil: "rad/s"}, name=evil)
    page = wb.fit_page(wb.fit(MOTOR, log, ["J", "R"], signals={evil: "omega"}))
    assert evil not in page.text
    data = json.loads(re.search(r'<script type="application/json" id="live">(.*?)</script>', page.text, re.S)[1])
    assert data["loops"][0]["sensors"] == [f"{evil} [rad/s]"]
