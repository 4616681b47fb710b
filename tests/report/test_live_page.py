"""A live page in a browser: its runs have the bits of Python, and whatever comes to it, the printed page stays."""

import json
from itertools import pairwise

import numpy as np
import pytest

from studies.performance.chromium import open_page
from tests.support.browsers import needs_chromium
from tests.support.compilers import needs_llvmlite
from tests.support.live_pages import data_of, write_page
from tests.support.turned_pages import BYTES, EVERY, IDLE, KNOBS, LOOPS, UNTIL, H, numbers, opened, python_run, turned

pytestmark = [needs_chromium, needs_llvmlite]


@pytest.fixture(scope="module")
def data():
    return data_of(LOOPS, H, UNTIL, EVERY, KNOBS)


@pytest.fixture(scope="module")
def path(data, tmp_path_factory):
    return write_page(tmp_path_factory.mktemp("live"), data)


@pytest.fixture
def page(path, browser):
    with open_page(path, browser=browser) as page:
        yield page


def test_states_outputs_and_scores_have_the_bits_of_the_portable_arithmetic(page, data):
    opened(page)
    draws = np.random.default_rng(7)
    for _ in range(2):
        phi, K = float(10 ** draws.uniform(-2.9, -0.4)), float(draws.uniform(1, 50))
        turned(page, knob0=phi, knob1=K)
        told = page.value(BYTES % 0)
        runs, score = python_run(LOOPS["FS", "SMC"], {"controller.phi": phi, "controller.K": K})
        np.testing.assert_array_equal(numbers(told["x"], runs.x.shape[2]), runs.x[0])
        y = np.hstack([runs[name][0].reshape(len(runs.t), -1) for name in runs.step.outputs.names[:2]])
        np.testing.assert_array_equal(numbers(told["y"], 3), y[:, :3])
        assert [value for value, _ in told["scores"][0]] == score.tolist()
        half = python_run(LOOPS["FS", "SMC"], {"controller.phi": phi, "controller.K": K}, H / 2)[1]
        assert [error for _, error in told["scores"][0]] == (2 * np.abs(score - half)).tolist()


def test_a_run_that_diverges_says_so_with_the_time_that_python_finds(page):
    opened(page)
    turned(page, knob2=1e6)
    told = page.value(BYTES % 1)
    runs, _ = python_run(LOOPS["FS", "PID"], {"controller.Kd": 1e6})
    assert told["divergedAt"] == runs.diverged_at[0] > 0
    np.testing.assert_array_equal(numbers(told["x"], runs.x.shape[2]), runs.x[0])
    assert "diverged at" in page.value("document.querySelector('.bench-results').textContent")
    assert "diverged at" in page.value("document.querySelector('.bench-voice').textContent")


def test_a_closed_bench_costs_nothing(page):
    assert page.value("livePage.data === undefined && livePage.pool === undefined")
    assert page.value("document.querySelectorAll('input').length") == 0


def test_nothing_is_loaded_and_nothing_complained_of(page, path):
    opened(page)
    turned(page, knob0=0.2)
    page.press("#knob-1", "ArrowRight")
    page.until(IDLE)
    assert page.complaints == []
    assert page.requests == [path.resolve().as_uri()]


def test_the_newest_ticket_wins(page):
    opened(page)
    page.value(
        "(() => { window.heard = []; const hear = livePage.hear.bind(livePage);"
        " livePage.hear = (view) => { heard.push([view.ticket, view.phase, view.done]); hear(view); };"
        " livePage.warm(); })()"
    )
    for K in range(10, 40):
        page.value(f"livePage.bench.knobs[1].turn({K})")
    page.until(IDLE)
    assert page.value("livePage.views.get(0).fine") == "1:39"
    heard = page.value("heard")
    tickets = [ticket for ticket, _, _ in heard]
    assert all(later >= earlier for earlier, later in pairwise(tickets[-2:]))
    done = [ticket for ticket, phase, done in heard if phase == "half" and done]
    assert done[-1] == page.value("livePage.pool.ticket")
    assert len(set(done)) < 30


def test_who_turns_back_at_once_sees_the_run_of_where_they_are(page):
    opened(page)
    turned(page, knob1=7.0)
    there = page.value(BYTES % 0)
    page.value(
        "(() => { const hear = livePage.hear.bind(livePage); livePage.hear = (view) => { hear(view);"
        " if (view.done && livePage.state.values[1] === 40) livePage.bench.knobs[1].turn(7); };"
        " livePage.bench.knobs[1].turn(40); })()"
    )
    page.until(f"livePage.state.values[1] === 7 && {IDLE}")
    page.until("livePage.views.get(0).fine === '1:7'")
    assert page.value(BYTES % 0) == there


def test_a_slider_turns_by_keys_and_stops_at_the_printed_value(page):
    opened(page)
    printed = page.value("livePage.data.knobs[1].value")
    page.press("#knob-1", "ArrowRight", 2)
    page.until(IDLE)
    assert page.value("livePage.state.values[1]") > printed
    assert page.value("document.getElementById('knob-1').getAttribute('aria-valuetext')").endswith("N m")
    assert page.value("Object.keys(shown).length") > 0
    page.press("#knob-1", "ArrowLeft", 2)
    assert page.value("livePage.state.values[1]") == printed
    page.until("Object.keys(shown).length === 0")
    assert page.value("scored.size") == 0


def test_escape_closes_the_bench_and_gives_the_focus_back(page):
    opened(page)
    page.press("#knob-1", "Escape")
    assert page.value("document.activeElement.className") == "bench-handle"
    assert page.value("document.getElementById('bench-panel').hidden")


def test_a_link_shows_what_its_sender_saw(path, browser):
    fragment = "#knobs=phi:0.2,gain%3A%20K:7.5&scenario=SS"
    with open_page(path, fragment, browser=browser) as page:
        page.until(IDLE)
        assert page.value("[...livePage.views.keys()]") == [2]
        assert page.value("livePage.state.values.slice(0, 2)") == [0.2, 7.5]
        assert page.value("document.getElementById('bench-panel').hidden") is False
        page.value("livePage.bench.knobs[0].turn(0.3)")
        page.until("location.hash.includes('0.3')")
        assert page.value("location.hash") == fragment.replace("0.2", "0.3")


@pytest.mark.parametrize(
    ("fragment", "values"),
    [
        ("#knobs=phi:NaN,gain%3A%20K:Infinity", None),
        ("#knobs=phi:1e999", [0.5]),
        ("#knobs=phi:-1e999", [0.001]),
        ("#knobs=phi:0x10,phi:1_0,phi:,phi", None),
        ("#knobs=__proto__:1,constructor:2,%E0%A4%A:3,:4,toString:5", None),
        ("#knobs=<script>alert(1)</script>:1&scenario=<img src=x onerror=alert(1)>&off=<b>", None),
        ("#seed=-1&seed=1e9&scenario=__proto__&off=constructor", None),
        ("#knobs=" + "phi:0.2," * 5000, None),
        ("#knobs=phi:0.2&javascript:alert(1)&&&===&knobs", [0.2]),
    ],
)
def test_a_tampered_address_is_clipped_or_passed_over(page, data, fragment, values):
    printed = [knob["value"] for knob in data["knobs"]]
    page.value(
        "livePage.data = JSON.parse(livePage.text);"
        f" window.read = stateOfAddress({json.dumps(fragment)}, livePage.data)"
    )
    assert page.value("read.values") == ((values or printed[:1]) + printed[1:])
    assert page.value("[read.seed, read.scenario, read.off.size]") == ["0", "FS", 0]


def test_what_is_written_into_the_address_is_read_from_it(page):
    opened(page)
    there = "stateOfAddress(addressOfState(state, livePage.data), livePage.data)"
    state = "({values: [0.1 + 0.2, 7.123456789012345, 1e-7 + 3], seed: '77', scenario: 'every', off: new Set(['PID'])})"
    assert page.value(
        f"(() => {{ const state = {state}, read = {there};"
        " return JSON.stringify([state.values, state.seed, state.scenario, [...state.off]])"
        " === JSON.stringify([read.values, read.seed, read.scenario, [...read.off]]); })()"
    )


def test_a_module_that_is_broken_leaves_the_page_as_printed(data, tmp_path, browser):
    broken = data | {"modules": ["AAAA" for _ in data["modules"]]}
    with open_page(write_page(tmp_path, broken), browser=browser) as page:
        opened(page)
        page.until("livePage.failed")
        assert "stays as it was made" in page.value("document.querySelector('.bench-status').textContent")
        assert page.value("Object.keys(shown).length") == 0


def test_a_worker_that_fails_leaves_the_page_as_printed(path, browser):
    with open_page(path, browser=browser) as page:
        page.value("livePage.source = 'onmessage = () => { throw new Error(1); };'")
        opened(page)
        page.until("livePage.failed")
        assert "stays as it was made" in page.value("document.querySelector('.bench-status').textContent")


def test_a_figure_that_cannot_be_drawn_leaves_the_page_as_printed(page):
    opened(page)
    page.value("window.openFigure = () => { throw new Error('no pen'); }")
    page.value("livePage.bench.knobs[1].turn(7.5)")
    page.until("livePage.failed")
    assert "no pen" in page.value("document.querySelector('.bench-status').textContent")
    page.until("scored.size === 0")


@pytest.mark.parametrize("missing", ["WebAssembly", "DecompressionStream"])
def test_an_old_browser_is_told_so_in_one_sentence(page, missing):
    page.value(f"delete window.{missing}")
    page.click(".bench-handle")
    assert "too old" in page.value("document.querySelector('.bench-status').textContent")
    assert page.complaints == []


def test_a_law_that_is_off_stays_as_printed(page):
    opened(page)
    page.click("[data-law=SMC] input")
    turned(page, knob0=0.2, knob2=50.0)
    assert page.value("[...livePage.views.keys()]") == [1]


def test_the_bench_leaves_half_of_a_phone_to_the_page(page):
    page.size(360, 740, touch=True)
    opened(page)
    top = page.value("document.getElementById('bench-panel').getBoundingClientRect().top")
    assert top >= 370
    assert page.value("document.documentElement.scrollWidth") <= 360


def test_copied_lines_name_what_was_turned_in_each_loop(page):
    opened(page)
    turned(page, knob0=0.2, knob1=7.5)
    lines = ["import workbench as wb", 'run("FS: SMC", {"phi": 0.2, "gain: K": 7.5}, None)', ""]
    assert page.value("livePage.bench.python()").split("\n") == lines


def test_copied_lines_of_several_loops_keep_all_their_scores(page):
    opened(page)
    turned(page, knob0=0.2, knob2=50.0)
    page.value("livePage.data.python = 'scores = run({case}, {values})'")
    lines = [
        "scores = {}",
        'scores["FS: SMC"] = run("FS: SMC", {"phi": 0.2})',
        'scores["FS: PID"] = run("FS: PID", {"Kd": 50})',
    ]
    assert page.value("livePage.bench.python()").split("\n") == lines


def test_a_copied_link_holds_the_last_turn(page, path):
    opened(page)
    page.value("livePage.bench.knobs[1].turn(7.5)")
    assert page.value("livePage.bench.link()") == path.resolve().as_uri() + "#knobs=gain%3A%20K:7.5"


def test_the_plant_moves_beside_its_printed_run(data, tmp_path, browser):
    drawn = [loop | {"drawing": {"shapes": [], "first": 1, "places": 2}} for loop in data["loops"]]
    with open_page(write_page(tmp_path, data | {"loops": drawn}), browser=browser) as page:
        opened(page)
        page.value("document.querySelector('.bench-motion').open = true")
        page.until("window.animation && animation.frames && animation.frames.every(Number.isFinite)")
        assert page.value("animation.before === null && animation.frames.length === 2 * animation.times.length")
        still = page.value("[...animation.frames]")
        turned(page, knob0=0.2)
        page.until("animation.before")
        assert page.value("[...animation.before]") == still
        assert page.value("[...animation.frames]") != still


def test_the_knobs_stay_where_they_are_while_one_is_turned(page):
    opened(page)
    tops = "[...document.querySelectorAll('.bench-knob')].map((knob) => knob.getBoundingClientRect().top)"
    before = page.value(tops)
    turned(page, knob0=0.2, knob2=1e6)
    assert page.value(tops) == before


def test_each_control_has_a_name_that_is_read_aloud(page):
    opened(page)
    turned(page, knob0=0.2)
    roles = {"slider", "spinbutton", "button", "checkbox", "combobox", "textbox", "region"}
    nodes = [node for node in page.call("Accessibility.getFullAXTree")["nodes"] if not node["ignored"]]
    controls = [(node["role"]["value"], node["name"]["value"]) for node in nodes if node["role"]["value"] in roles]
    assert [role for role, name in controls if not name] == []
    assert ("slider", "phi") in controls
    assert ("button", "phi: reset to the baseline 0.01") in controls
