"""The animation of a plant on a live page: its script in Node and in Chromium, where these are."""

import json
import subprocess
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from tests.support.browsers import CHROMIUM, NODE, needs_chromium, needs_node
from tests.support.cases import heavy_but
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.blocks.loop import open_loop
from workbench.core import rk4
from workbench.engine import simulate

LIVE = Path(__file__).resolve().parents[2] / "workbench" / "report" / "templates" / "live"
SCRIPT, STYLE = LIVE / "animation.js", LIVE / "animation.css"
FLAGS = ("--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--virtual-time-budget=20000", "--dump-dom")
POLICY = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'"

# A pendulum of two places, x and y of its tip, on a hinge that stands still; seven rows 0.1 s apart.
PENDULUM = {
    "view": None,
    "follow": False,
    "shapes": [
        {"kind": "line", "tone": "ground", "width": 0.0, "closed": False, "fixed": [-99.0, 0.0, 99.0, 0.0]},
        {"kind": "line", "tone": "link", "width": 0.05, "closed": False, "points": [2, 2, 0, 1]},
        {"kind": "circle", "tone": "path", "points": [0, 1, 3]},
    ],
}
ANGLES = np.linspace(-0.6, 0.6, 7)
FRAMES = np.stack([np.sin(ANGLES), -np.cos(ANGLES), 0 * ANGLES, 0 * ANGLES + 0.05], axis=1)


def in_node(expression, setting=""):
    """The value of an expression behind the script."""
    text = f"{SCRIPT.read_text()}\n{setting}\nprocess.stdout.write(JSON.stringify({expression}));"
    done = subprocess.run([NODE, "-e", text], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def in_chromium(folder, steps, *flags):
    """What the steps of a script write to `told` of a page with an animation of the pendulum, and the errors."""
    setting = f"""
    const told = {{}}, errors = [];
    addEventListener("error", (event) => errors.push(event.message));
    addEventListener("securitypolicyviolation", (event) => errors.push(event.violatedDirective));
    const drawing = {json.dumps(PENDULUM)};
    const frames = Float64Array.from({json.dumps(FRAMES.ravel().tolist())});
    const times = Float64Array.from({json.dumps((0.1 * np.arange(7)).tolist())});
    const host = document.getElementById("host"), done = () => {{
      document.getElementById("told").textContent = JSON.stringify({{told, errors}});
    }};
    const animation = openAnimation(host, drawing);
    const find = (name) => host.querySelector(name);
    """
    page = folder / "page.html"
    page.write_text(
        f'<!doctype html><meta charset="utf-8"><meta http-equiv="Content-Security-Policy" content="{POLICY}">'
        f"<style>{STYLE.read_text()}</style><div id='host'></div><pre id='told'></pre>"
        f"<script>{SCRIPT.read_text()}\n{setting}\n{steps}</script>"
    )
    call = [CHROMIUM, *FLAGS, *flags, f"--user-data-dir={folder / 'profile'}", page.as_uri()]
    done = subprocess.run(call, capture_output=True, text=True, timeout=120)
    text = done.stdout.partition('<pre id="told">')[2].partition("</pre>")[0]
    assert text, done.stderr
    held = json.loads(text.replace("&gt;", ">").replace("&lt;", "<").replace("&amp;", "&"))
    assert held["errors"] == []
    return held["told"]


def run_of(frames):
    """The setting of a run in Node."""
    flat = json.dumps(np.asarray(frames, dtype=float).ravel().tolist()).replace("Infinity", "1e999")
    return f"const d = {json.dumps(PENDULUM)}; const r = runOf(Float64Array.from({flat}), 4);"


@needs_node
def test_the_row_of_a_time_is_the_last_one_that_is_not_later():
    times = np.cumsum(np.random.default_rng(1).uniform(0.1, 1.0, 50))
    asked = [*np.random.default_rng(2).uniform(times[0], times[-1] + 1, 200), *times]
    rows = in_node(f"{json.dumps(list(asked))}.map((t) => rowAt({json.dumps(times.tolist())}, t))")
    np.testing.assert_array_equal(rows, np.searchsorted(times, asked, side="right") - 1)
    assert in_node("rowAt([0, 1, 2], -5)") == 0


@needs_node
def test_a_run_ends_at_its_first_row_that_is_not_finite():
    frames = FRAMES.copy()
    frames[4, 1] = np.nan
    assert in_node("[r.rows, r.finite]", run_of(frames)) == [7, 4]
    assert in_node("[r.rows, r.finite]", run_of(FRAMES)) == [7, 7]


@needs_node
def test_the_window_holds_all_that_moves_and_counts_no_ground():
    extent = in_node("extentOf(d, r, 0, Infinity)", run_of(FRAMES))
    low, high = FRAMES[:, :2].min(axis=0) - 0.05, FRAMES[:, :2].max(axis=0) + 0.05
    np.testing.assert_allclose(extent, [low[0], low[1], high[0], 0.025])
    view = in_node("windowOf(d, r, null)", run_of(FRAMES))
    assert not view["follow"]
    width, height = np.array([extent[2] - extent[0], extent[3] - extent[1]]) * view["scale"]
    assert width <= 640 - 52 + 1e-9
    assert height <= view["tall"] - 52 + 1e-9
    assert max(width / (640 - 52), height / (view["tall"] - 52)) == pytest.approx(1.0)


@needs_node
@pytest.mark.parametrize("far", [50.0, 1e12, 1e300])
def test_a_plant_that_leaves_is_followed_in_its_own_size(far):
    frames = FRAMES.copy()
    frames[:, [0, 2]] += np.linspace(0, far, 7)[:, np.newaxis]
    view = in_node("windowOf(d, r, null)", run_of(frames))
    assert view["follow"]
    assert 50 < view["scale"] < 400  # points to the metre of a pendulum of 1 m


@needs_chromium
def test_a_page_shows_the_live_run_over_the_printed_one_at_the_time_asked_for(tmp_path):
    steps = """
    animation.load(frames, frames.map((v) => v), times);
    animation.at(0.45);
    told.live = find(".live .line.link").getAttribute("d");
    told.ghost = find(".ghost .line.link").getAttribute("d");
    told.still = host.querySelectorAll(".ghost .ground").length;
    told.track = find(".track").getAttribute("d").split("L").length;
    told.clock = find("output").textContent;
    told.text = find("input").getAttribute("aria-valuetext");
    told.note = find(".note").textContent;
    animation.onTime = (t) => { told.time = t; };
    find("input").value = "2";
    find("input").dispatchEvent(new Event("input"));
    told.turned = find(".live .line.link").getAttribute("d");
    done();
    """
    told = in_chromium(tmp_path, steps)
    assert told["live"] == told["ghost"] != told["turned"]
    numbers = np.array(told["live"].replace("M", "").replace("L", " ").split(), dtype=float).reshape(2, 2)
    step = (numbers[1] - numbers[0]) * [1, -1]
    np.testing.assert_allclose(np.arctan2(step[0], -step[1]), ANGLES[4], atol=1e-4)  # to a hundredth of a point
    assert (told["clock"], told["text"], told["note"]) == ("0.40 s", "0.40 s", "")
    assert told["still"] == 0
    assert told["track"] == 4  # the last third of the run
    assert told["time"] == pytest.approx(0.2)


@pytest.mark.heavy
@needs_chromium
def test_the_slider_of_a_long_run_has_stops_that_keys_can_walk_and_reaches_the_end(tmp_path):
    steps = """
    const rows = 5016, many = new Float64Array(4 * rows), t = Float64Array.from({length: rows}, (_, i) => i / 100);
    for (let row = 0; row < rows; row++) many.set([Math.sin(t[row]), -Math.cos(t[row]), 0, 0.05], 4 * row);
    const began = performance.now();
    animation.load(many, many, t);
    const loaded = performance.now();
    for (let i = 0; i < 100; i++) animation.at(0.5 * i);
    told.milliseconds = [loaded - began, (performance.now() - loaded) / 100];
    told.stops = Number(find("input").max) / Number(find("input").step);
    animation.onTime = (time) => { told.end = time; };
    find("input").value = "999999";
    find("input").dispatchEvent(new Event("input"));
    told.text = find("input").getAttribute("aria-valuetext");
    done();
    """
    told = in_chromium(tmp_path, steps)
    assert 100 < told["stops"] <= 500
    assert (told["end"], told["text"]) == (50.15, "50.15 s")


@needs_chromium
def test_a_run_that_diverged_keeps_its_last_finite_frame_and_says_when(tmp_path):
    steps = """
    const broken = frames.map((v, i) => (i >= 16 ? NaN : v));
    const state = () => [find(".live .line.link").getAttribute("d"), find(".note").textContent];
    animation.load(broken, frames, times);
    animation.at(0.3);
    told.before = state();
    animation.at(0.6);
    told.behind = state();
    animation.load(broken, frames, times, 0.3721);
    told.exact = state();
    animation.load(broken, frames, times, null);
    told.growing = state();
    animation.load(frames.map(() => NaN), null, times);
    told.nothing = [getComputedStyle(find(".live")).display, find(".note").textContent];
    done();
    """
    told = in_chromium(tmp_path, steps)
    assert told["before"][1] == ""
    assert told["behind"] == [told["before"][0], "diverged at 0.40 s"]
    assert told["exact"][1] == "diverged at 0.37 s"
    assert told["growing"] == [told["before"][0], ""]
    assert told["nothing"] == ["none", "diverged at 0.00 s"]


@needs_chromium
@pytest.mark.parametrize("reduced", heavy_but([False, True], False))
def test_play_goes_to_the_end_by_itself_and_opening_plays_nothing(tmp_path, reduced):
    steps = """
    window.requestAnimationFrame = (next) => setTimeout(() => next(performance.now()), 16);  // in virtual time
    const heard = [];
    animation.onTime = (t) => heard.push(t);
    animation.load(frames, null, times);
    told.first = [find("button").textContent, heard.length];
    find("button").click();
    told.playing = find("button").textContent;
    setTimeout(() => {
      told.last = [heard[heard.length - 1], find("button").textContent, find("output").textContent];
      told.sorted = heard.every((t, i) => i === 0 || t >= heard[i - 1]);
      told.count = heard.length;
      animation.play();
      animation.pause();
      told.paused = [find("button").textContent, find("output").textContent];
      done();
    }, 3000);
    """
    told = in_chromium(tmp_path, steps, *(["--force-prefers-reduced-motion"] if reduced else []))
    assert told["first"] == ["Play", 0]
    assert told["playing"] == "Pause"
    assert told["last"] == [pytest.approx(0.6), "Play", "0.60 s"]
    assert told["sorted"]
    assert told["count"] <= 25 if reduced else told["count"] > 5
    assert told["paused"] == ["Play", "0.00 s"]


@needs_node
def test_the_numbers_of_a_drawing_in_python_are_those_of_the_script():
    ode = open_loop(Manipulator(paper_arm(), q=[1.0, 0.5]))
    run = simulate(rk4(ode, 1e-2), until=0.5)
    places = ca.Function("places", [ode.t, ode.x, ode.p], [ode.drawing.coordinates])
    frames = np.array(
        [np.array(places(t, x, ode.parameters.default)).ravel() for t, x in zip(run.t, run.x[0], strict=True)]
    )
    flat, places = json.dumps(frames.ravel().tolist()), frames.shape[1]
    setting = f"const d = {json.dumps(ode.drawing.data)}; const r = runOf({flat}, {places});"
    wanted = [
        frames[-1, shape["points"]].tolist() if "points" in shape else shape["fixed"] for shape in ode.drawing.shapes
    ]
    assert in_node("d.shapes.map((shape) => coordinatesOf(shape, r, r.rows - 1))", setting) == wanted
    assert in_node("[r.rows, r.finite]", setting) == [51, 51]
