"""A live sheet is drawn over the printed one: pinned curves, rulers that grow, and what was shown is cleared."""

import html
import json
import re
import subprocess

import numpy as np
import pytest

from tests.support.browsers import CHROMIUM, needs_chromium, needs_node
from tests.support.live_figures import NUMBERS, plain, said, scripts
from workbench.report.figures.figure_sheet import draw_all
from workbench.study.document.document import Band, Figure, Panel, Series

# In a browser.

T = np.linspace(0, 10, 101)
PANELS = (
    Panel("e [rad]", (Series("a", T, np.sin(T)), Series("b", T, np.cos(T), 1, "steps"), Series("r", T, 0 * T, 2))),
    Panel("y", (Series("a", T, np.exp(-T)),), xlim=(1.0, 6.0), yscale="log", hlines=(0.1,)),
    Panel("y", (Series("m", np.cos(T), np.sin(T), 3, "marks"),), xlabel="x", vlines=(0.5,), ylim=(-2, 2)),
    Panel("y", (Band("half", T, np.sin(T) - 1, np.sin(T) + 1), Series("a", T, np.sin(T)))),
)


@pytest.fixture(scope="module")
def sheet():
    return draw_all([Figure("four", "Four panels.", PANELS, columns=2)])["four"]


def shown(sheet, tmp_path, body):
    """What a script of a page returns that has the figure `svg` open as `figure`, and has the `printed` numbers."""
    printed = [
        {"panel": i, "series": j, "x": plain(mark.x), "y": plain(mark.y)}
        for i, panel in enumerate(PANELS)
        for j, mark in enumerate(panel.series)
        if isinstance(mark, Series)
    ]
    start = f"""{NUMBERS} const plate = {json.dumps(sheet.plate)};
    const printed = {json.dumps(printed)}.map(one => ({{...one, x: numbers(one.x), y: numbers(one.y)}}));
    const times = factor => printed.map(one => ({{...one, y: one.y.map(y => factor * y)}}));
    const svg = document.querySelector("svg"), before = svg.outerHTML, figure = openFigure(svg, plate);
    const all = selector => [...svg.querySelectorAll(selector)], hidden = '[visibility="hidden"]';"""
    run = f"try {{ return [(() => {{ {body} }})()]; }} catch (error) {{ return error.stack; }}"
    page = tmp_path / "page.html"
    page.write_text(
        f"<!DOCTYPE html><meta charset='utf-8'><body>{sheet.svg}<pre></pre><script>{scripts()}\n{start}\n"
        f"document.querySelector('pre').textContent = JSON.stringify((() => {{ {run} }})());</script>",
        encoding="utf-8",
    )
    line = [CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-dev-shm-usage"]
    line += [f"--user-data-dir={tmp_path / 'profile'}", "--dump-dom", page.resolve().as_uri()]
    done = subprocess.run(line, capture_output=True, text=True, timeout=90, check=True)
    answer = json.loads(html.unescape(re.search(r"<pre>(.*?)</pre>", done.stdout, re.DOTALL)[1]))
    assert isinstance(answer, list), answer
    return answer[0]


@needs_chromium
def test_what_was_shown_is_cleared_to_the_byte(sheet, tmp_path):
    body = """const seen = [];
    for (const factor of [1, 3, 0.5, -40, 1e200, 1e308, NaN]) {
        figure.show(times(factor));
        figure.cursor(2.5);
        seen.push(svg.outerHTML !== before);
        figure.clear();
        seen.push(svg.outerHTML === before);
    }
    figure.cursor(1);
    figure.cursor(null);
    return [...seen, svg.outerHTML === before];"""
    assert all(shown(sheet, tmp_path, body))


@needs_chromium
def test_printed_numbers_are_drawn_where_and_as_they_are_printed(sheet, tmp_path):
    body = """figure.show(printed);
    const look = element => element && [element.getAttribute("d"), ...["stroke", "stroke-width", "stroke-dasharray",
        "stroke-linecap", "stroke-linejoin", "fill"].map(name => getComputedStyle(element)[name])];
    const pairs = [[0, 0], [0, 1], [0, 2], [1, 0], [3, 1]].map(([i, j]) => [
        look(svg.querySelector(`g.series[data-panel="${i}"][data-series="${j}"] path`)),
        look(figure.panels[i].curves.get(j).element)]);
    const marks = svg.querySelectorAll('g.series[data-panel="2"] use').length;
    return [pairs, marks, figure.panels[2].curves.get(0).element.children.length, all(hidden).length];"""
    pairs, marks, live_marks, moved = shown(sheet, tmp_path, body)
    for printed, live in pairs:
        assert printed[1:] == live[1:]
        one, two = (corners(path) for path in (printed[0], live[0]))
        apart = np.abs(one[:, np.newaxis] - two).max(axis=2).min(axis=1)  # matplotlib leaves points out
        assert apart.max() <= 0.0151  # one is rounded, the other cut
    assert marks == live_marks == len(T)
    assert moved == 0


def corners(path):
    """The points (N, 2) of a path of moves, lines and strokes along an axis."""
    points, at = [], [0.0, 0.0]
    for command, numbers in re.findall(r"([MLHV])([^MLHV]*)", path):
        given = [float(number) for number in numbers.split()]
        at = {"H": lambda at, g: [g[0], at[1]], "V": lambda at, g: [at[0], g[0]]}.get(command, lambda at, g: g)(
            at, given
        )
        points.append(at)
    return np.array(points)


@needs_chromium
def test_a_grown_ruler_takes_the_printed_curves_along_and_a_fixed_one_clips(sheet, tmp_path):
    body = """figure.show(times(3));
    const range = figure.panels.map(panel => [panel.y.low, panel.y.high]);
    const texts = all(".live-ruler").map(group => [...group.querySelectorAll("text")].map(text => text.textContent));
    const covered = all(hidden).map(group => group.getAttribute("class") + group.dataset.panel);
    const level = svg.querySelector("g.hlines path").getAttribute("d");
    const first = svg.querySelector('g.series[data-panel="0"][data-series="0"] path');
    const live = figure.panels[0].curves.get(0);
    return [range, first.getAttribute("d"), live.element.getAttribute("d"), texts, covered, level];"""
    ranges, printed, live, texts, covered, level = shown(sheet, tmp_path, body)
    (low, high), log, fixed, band = ranges
    assert low <= -3 <= 3 <= high
    assert log[0] == sheet.plate["panels"][1]["y"]["low"]
    assert log[1] == 10
    assert fixed == [-2, 2]
    assert band[1] > 3
    box = sheet.plate["panels"][0]["box"]
    foot = sheet.plate["height"] - box[1]
    for path, factor in ((printed, 1), (live, 3)):
        x, y = corners(path).T
        t = (x - box[0]) / box[2] * 10
        number = low + (foot - y) / box[3] * (high - low)
        assert number == pytest.approx(factor * np.sin(t), abs=0.02)
    assert "0" in texts[0]
    assert all("10" in text for text in texts[1])
    assert sorted(covered) == ["ruler-y0", "ruler-y0", "ruler-y1", "ruler-y1", "ruler-y3", "ruler-y3"]
    box = sheet.plate["panels"][1]["box"]
    share = (sheet.plate["height"] - box[1] - corners(level)[0, 1]) / box[3]
    assert np.log10(log[0]) + share * (1 - np.log10(log[0])) == pytest.approx(-1, abs=0.01)


@needs_chromium
def test_live_curves_lie_above_the_printed_ones_in_the_same_order_and_those_stay_pinned(sheet, tmp_path):
    body = """figure.show(printed.filter(one => one.panel === 0 && one.series !== 1).reverse());
    const colors = all(".live-series").map(curve => getComputedStyle(curve).stroke);
    const pinned = all(".pinned").map(group => group.dataset.panel + group.dataset.series);
    figure.show(printed.filter(one => one.panel === 1));
    return [colors, pinned, all(".pinned").map(group => group.dataset.panel + group.dataset.series),
        svg.getAttribute("class"), svg.lastElementChild === svg.querySelector(".live-panel")];"""
    colors, pinned, later, name, last = shown(sheet, tmp_path, body)
    assert colors == ["rgb(0, 158, 115)", "rgb(0, 114, 178)"]  # the first law on top
    assert pinned == ["02", "00"]
    assert later == ["10"]
    assert name == "live"
    assert last


@needs_chromium
def test_the_cursor_has_a_dot_on_the_last_point_of_each_curve_at_or_before_its_time(sheet, tmp_path):
    body = """const ended = printed.map(one => ({...one, y: one.y.map((y, i) => i > 50 ? NaN : y)}));
    const place = dot => [dot.getAttribute("cx"), dot.getAttribute("cy")];
    const look = () => [all(".live-cursor").length, all("circle").map(place)];
    figure.show(ended.filter(one => one.panel !== 1));
    figure.cursor(2.55);
    const dots = look();
    figure.cursor(7);
    const over = look();
    figure.cursor(20);
    return [dots, over, look()];"""
    (lines, dots), over, beyond = shown(sheet, tmp_path, body)
    assert lines == 3  # not where the abscissa is no time
    assert len(dots) == 4
    box, y = sheet.plate["panels"][0]["box"], sheet.plate["panels"][0]["y"]
    up = box[1] + box[3] * (np.sin(2.5) - y["low"]) / (y["high"] - y["low"])
    wanted = (box[0] + box[2] * 0.25, sheet.plate["height"] - up)
    assert any(np.array(dot, dtype=float) == pytest.approx(wanted, abs=0.01) for dot in dots)
    assert over == [2, []]  # the second panel ends at 6 s
    assert beyond == [0, []]


@needs_node
def test_numbers_at_a_grown_ordinate_have_the_room_beside_it():
    random = np.random.default_rng(9)
    given = []
    for _ in range(300):
        size, middle = 10.0 ** random.uniform(-6, 8), random.choice([0.0, *random.normal(size=3)])
        low, high = size * (middle - random.uniform(0.1, 1)), size * (middle + random.uniform(0.1, 1))
        given.append((low, high, int(random.integers(2, 10)), float(random.uniform(1.1, 3.5))))
    body = """return given.map(([low, high, count, room]) => {
      const { marks, power } = rulerMarks("linear", low, high, count, room);
      return [SMALLEST_LETTERS * widestText(marks), marks.map(([place, text]) => [place, text]), power];
    });"""
    for (low, high, _, room), (wide, marks, power) in zip(given, said(body, given), strict=True):
        assert marks
        for place, text in marks:
            assert low - 1e-6 * (high - low) <= place <= high + 1e-6 * (high - low)
            written = float(text.replace("−", "-")) * 10.0**power
            assert written == pytest.approx(place, abs=1e-6 * (high - low))
        if room > 2:  # in less even a sign and a digit may not find place: then the letters are smaller still
            assert wide <= room or len(marks) < 3


@needs_chromium
def test_no_number_at_a_grown_ordinate_reaches_the_name_of_the_axis(tmp_path):
    t = np.linspace(0, 10, 200)
    narrow = Figure("narrow", "c", (Panel("a name that is read", (Series("", t, 0.5 + 0 * t),)),), width=0.6)
    sheet = draw_all([narrow])["narrow"]
    body = """const left = plate.panels[0].box[0], { tick, pad } = plate.letters, edge = left - tick - pad;
    const starts = given => {
      figure.show([{ panel: 0, series: 0, x: numbers([0, 5, 10]), y: numbers(given) }]);
      return Math.min(...all(".live-ruler text").filter(one => one.getAttribute("text-anchor") === "end")
        .map(one => one.getBBox().x));
    };
    const given = [[-1234.5, 3, 877], [-0.013, 0.5, 0.507], [99999, 100000.5, 0], [-3e-7, 0, 4e9], [-12, 12, 0]];
    return [given.map(starts), edge - plate.panels[0].y.room];"""
    starts, edge = shown(sheet, tmp_path, body)
    assert min(starts) >= edge - 0.5  # the width of letters is that of the browser's font, not of the sheet's
