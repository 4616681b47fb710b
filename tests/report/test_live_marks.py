"""Bars and points that a page draws again: slimmer over the printed ones, on rulers that grow."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from studies.paper.laws import rival
from studies.performance.chromium import open_page
from tests.support.browsers import needs_chromium
from tests.support.compilers import needs_llvmlite
from tests.support.live_pages import data_of, write_page
from workbench.report.figures.figure_sheet import draw_all
from workbench.study.document.document import Bars, Figure, Panel, Points, Series

pytestmark = needs_chromium

ROOM = Path(__file__).parents[2] / "workbench" / "report" / "templates" / "live"
SCRIPTS = "\n".join((ROOM / f"{name}.js").read_text("utf-8") for name in ("curves", "rulers", "marks", "figures"))
STYLE = (ROOM / "figures.css").read_text("utf-8")

ROWS, ZERO, T = np.arange(3), np.zeros(3), np.linspace(0, 10, 101)
ENDS = np.array([0.5, 0.25, 1.0])
TEXTS = ("0.50", "a law", "1.00")
BARS = Panel(
    "",
    (
        Bars("printed", ROWS - 0.2, np.array([0.4, 0.6, 0.9]), ZERO, 0, thick=0.35),
        Bars("ours", ROWS + 0.2, ENDS, ZERO, 1, thick=0.35, texts=TEXTS, low=0.9 * ENDS, high=1.1 * ENDS),
    ),
    "RMSE [rad]",
    ynames=("PID", "SMC", "STA"),
)
POINTS = Panel(
    "effort",
    (Points("", np.array([1.0, 2.0]), np.array([0.1, 0.3]), ("PID", "SMC"), 2),),
    "RMSE",
    yscale="log",
)
LIMITED = Panel("", (Bars("ours", ROWS, ENDS, ZERO, 1),), xlim=(0.0, 2.0), ynames=("a", "b", "c"))
CURVE = Panel("y", (Series("a", T, np.sin(T)),))


@pytest.fixture(scope="module")
def sheet():
    return draw_all([Figure("four", "Four panels.", (BARS, POINTS, LIMITED, CURVE), columns=2)])["four"]


@pytest.fixture(scope="module")
def browser(sheet, tmp_path_factory):
    path = tmp_path_factory.mktemp("marks") / "page.html"
    start = f"""const plate = {json.dumps(sheet.plate)}, svg = document.querySelector("svg"), before = svg.outerHTML;
    const figure = openFigure(svg, plate), all = (selector) => [...svg.querySelectorAll(selector)];
    const bar = (index, value, series = 1, panel = 0) => ({{ panel, series, index, axis: "x", value }});
    const point = (index, axis, value) => ({{ panel: 1, series: 0, index, axis, value }});
    const paths = () => all(".live-mark path").map((path) => path.getAttribute("d"));
    const words = () => all(".live-mark text").map((text) => text.textContent);
    const pinned = () => all(".pinned").map((one) =>
      [one.parentNode.dataset.panel, one.parentNode.dataset.series, one.dataset.index].join(""));"""
    path.write_text(
        f"<!DOCTYPE html><meta charset='utf-8'><style>{STYLE}</style><body>{sheet.svg}"
        f"<script>{SCRIPTS}\n{start}</script>",
        encoding="utf-8",
    )
    with open_page(path) as page:
        yield page


@pytest.fixture
def page(browser):
    """The page, whose figure is as printed before and after."""
    assert browser.value("svg.outerHTML === before")
    yield browser
    browser.value("figure.clear()")
    assert browser.value("svg.outerHTML === before")
    assert browser.complaints == []


def ends(path):
    """The least and the greatest abscissa and ordinate of a path of moves and strokes."""
    across = [float(x) for x in re.findall(r"[ML](\S+?) |H([-.\d]+)", path) for x in x if x]
    up = [float(y) for pair in re.findall(r"[ML]\S+? ([-.\d]+)|V([-.\d]+)", path) for y in pair if y]
    return min(across), max(across), min(up), max(up)


def number_at(plate, panel, x):
    """The number at an abscissa of the sheet, by the printed ruler."""
    ruler, (left, _, width, _) = plate["panels"][panel]["x"], plate["panels"][panel]["box"]
    return ruler["low"] + (x - left) / width * (ruler["high"] - ruler["low"])


def test_a_live_bar_ends_at_its_number_within_the_printed_one_which_stays_pinned(page, sheet):
    page.value("figure.show([], [bar(0, 0.75), bar(2, 0.3)])")
    printed = page.value(
        """svg.querySelector('.marks[data-series="1"] .mark[data-index="0"] path').getAttribute("d")"""
    )
    low, high, head, foot = ends(printed.replace("M ", "M").replace("L ", "L"))
    for path, number in zip(page.value("paths()"), (0.75, 0.3), strict=True):
        assert number_at(sheet.plate, 0, ends(path)[0]) == pytest.approx(0.0, abs=1e-4)
        assert number_at(sheet.plate, 0, ends(path)[1]) == pytest.approx(number, abs=1e-4)
    start, end, top, bottom = ends(page.value("paths()[0]"))
    assert start == pytest.approx(low, abs=0.011)
    assert end > high
    assert head < top < bottom < foot
    assert bottom + top == pytest.approx(head + foot, abs=0.04)
    assert set(page.value("pinned()")) == {"010", "012"}
    assert page.value("getComputedStyle(svg.querySelector('.live-mark path')).fill") == "rgb(213, 94, 0)"
    assert float(page.value("getComputedStyle(svg.querySelector('.pinned')).opacity")) < 0.5


def test_a_text_follows_its_bar_if_it_is_the_number(page):
    page.value("figure.show([], [bar(0, 0.754321), bar(1, 0.9)])")
    assert page.value("words()") == ["0.75"]
    page.value("figure.show([], [bar(0, 0.01)])")
    assert page.value("words()") == []  # no room


@pytest.mark.parametrize(("value", "word"), [("NaN", "diverged"), ("-Infinity", "diverged"), ("Infinity", "never")])
def test_a_run_without_a_number_has_a_word_in_the_place_of_its_bar(page, value, word):
    page.value(f"figure.show([], [bar(0, {value}), point(1, 'y', {value})])")
    assert page.value("paths()") == []
    assert page.value("words()") == [word, word]
    assert set(page.value("pinned()")) == {"010", "101"}


def test_a_number_without_a_logarithm_is_written_in_the_place_of_its_point(page):
    page.value("figure.show([], [point(0, 'y', -0.5), point(1, 'y', 0)])")
    assert page.value("words()") == ["−0.5", "0"]


def test_a_grown_ruler_takes_printed_bars_their_texts_and_their_intervals_along(page, sheet):
    page.value("figure.show([], [bar(0, 3)])")
    low, high = page.value("[figure.panels[0].x.low, figure.panels[0].x.high]")
    assert low == sheet.plate["panels"][0]["x"]["low"]
    assert high > 3
    left, _, width, _ = sheet.plate["panels"][0]["box"]
    at = [left + width * (number - low) / (high - low) for number in (3.0, *ENDS)]
    assert ends(page.value("paths()[0]"))[1] == pytest.approx(at[0], abs=0.011)
    moved = page.value(
        """[0, 1, 2].map((i) => svg.querySelector(`.marks[data-series="1"] [data-index="${i}"] path`))"""
        """.map((path) => path.getAttribute("d"))"""
    )
    assert [ends(path)[1] for path in moved] == pytest.approx(at[1:], abs=0.05)
    shifts = page.value("""all('.words[data-index="2"]').map((one) => one.getAttribute("transform"))""")
    assert re.fullmatch(r"translate\(-[\d.]+ 0\)", shifts[0])
    whiskers = page.value("""all('.marks .mark[data-index="1"]').map((one) => one.children.length)""")
    assert 3 in whiskers
    assert page.value("""all('[visibility="hidden"]').map((one) => one.getAttribute("class"))""") == ["ruler-x"] * 2
    inside = page.value(
        "all('.live-ruler text').map((text) => text.getBBox()).every((box) => box.x + box.width <= plate.width + 0.5)"
    )
    assert inside


def test_a_bar_beyond_a_ruler_that_the_study_fixed_ends_with_it(page, sheet):
    page.value("figure.show([], [bar(1, 5, 0, 2), bar(2, -5, 0, 2)])")
    left, _, width, _ = sheet.plate["panels"][2]["box"]
    first, second = page.value("paths()")
    assert ends(first)[:2] == pytest.approx((left, left + width), abs=0.011)
    assert ends(second)[:2] == pytest.approx((left, left), abs=0.011)


def test_a_live_point_hangs_on_a_line_to_the_printed_one(page, sheet):
    page.value("figure.show([], [point(0, 'x', 1.5), point(1, 'y', 0.2), point(1, 'x', 1.2)])")
    printed = page.value(
        """all('.marks[data-panel="1"] use').filter((use) => use.closest(".mark"))"""
        """.map((use) => [Number(use.getAttribute("x")), Number(use.getAttribute("y"))])"""
    )
    lines = [np.array(re.findall(r"[ML](\S+?) ([-.\d]+)", path), dtype=float) for path in page.value("paths()")]
    assert np.array([line[0] for line in lines]) == pytest.approx(np.array(printed), abs=0.011)
    assert lines[0][1][1] == lines[0][0][1]  # its effort is as printed
    assert number_at(sheet.plate, 1, lines[0][1][0]) == pytest.approx(1.5, abs=2e-3)
    assert number_at(sheet.plate, 1, lines[1][1][0]) == pytest.approx(1.2, abs=2e-3)
    ruler, (_, bottom, _, height) = sheet.plate["panels"][1]["y"], sheet.plate["panels"][1]["box"]
    share = np.log10(0.2 / ruler["low"]) / np.log10(ruler["high"] / ruler["low"])
    assert sheet.plate["height"] - lines[1][1][1] == pytest.approx(bottom + share * height, abs=0.011)
    shapes = page.value("""all('.live-mark use, .mark use').map((use) => use.getAttribute("xlink:href"))""")
    assert len(shapes) == 4
    assert len(set(shapes)) == 1


def test_marks_that_are_asked_for_no_more_go_back_to_print_beside_curves_that_stay(page):
    page.value(
        "figure.show([{ panel: 3, series: 0, x: Float64Array.of(0, 5), y: Float64Array.of(0, 9) }],"
        " [bar(0, 3), bar(1, 0.1)])"
    )
    page.value("figure.cursor(2)")
    page.value(
        "figure.show([{ panel: 3, series: 0, x: Float64Array.of(0, 5), y: Float64Array.of(0, 9) }], [bar(1, 0.1)])"
    )
    assert set(page.value("pinned()")) == {"011", ""}  # and the curve
    assert page.value("figure.panels[0].x.grown") is False
    page.value("figure.cursor(null)")
    assert len(page.value("paths()")) == 1
    assert page.value("all('.live-series').length") == 1


LOOPS = {("FS", law): rival("FS", law).ode() for law in ("SMC", "PID")}
KNOBS = (("phi", "rad/s", "controller.phi", 0.001, 0.5, True), ("Kd", "N m s/rad", "controller.Kd", 1.0, 1e6, True))
IDLE = "livePage.flight && !livePage.flight.fine.size && !livePage.held"


@needs_llvmlite
def test_a_page_shows_the_scores_of_loops_that_are_turned_and_on_as_bars(tmp_path):
    data = data_of(LOOPS, 1e-3, 2.0, 0.01, KNOBS)
    place = {"panel": 0, "series": 7, "axis": "x", "metric": 0}
    data["curves"] = []
    data["marks"] = [place | {"figure": "figure_0", "index": k, "loop": k, "number": 1, "scale": 1.0} for k in range(2)]
    with open_page(write_page(tmp_path, data), "#knobs=phi:0.2,Kd:50") as page:
        told = "(window.told ?? []).map((mark) => [mark.panel, mark.series, mark.index, mark.axis, String(mark.value)])"
        page.value(
            "window.openFigure = () => ({ show(curves, marks) { window.told = marks; }, clear() { window.told = []; },"
            " cursor() {} })"
        )
        page.until(IDLE)
        page.until(f"{told}.length === 2")
        scores = page.value("[0, 1].map((loop) => String(livePage.views.get(loop).scores[0][1][0]))")
        page.until(f"{told}[0][4] === {scores[0]!r} && {told}[1][4] === {scores[1]!r}")
        assert page.value(told) == [[0, 7, k, "x", scores[k]] for k in range(2)]
        page.value("livePage.turn({ ...livePage.state, off: new Set(['SMC']) })")
        page.until(f"{told}.length === 1")
        assert page.value(told)[0][2] == 1
        page.value("livePage.turn({ ...livePage.state, values: [0.2, 1e6] })")
        page.until(IDLE)
        page.until(f"{told}[0][4] === 'NaN'")
        page.value("livePage.turn(livePage.printed)")
        page.until(f"{told}.length === 0")
        assert page.complaints == []


def test_no_number_breaks_the_print(page):
    for value in ("0", "-0.0", "1e-320", "1e300", "1.7e308", "-1e308"):
        page.value(f"figure.show([], [bar(0, {value}), point(0, 'x', {value}), point(0, 'y', {value})])")
        page.value("figure.clear()")
        assert page.value("svg.outerHTML === before")
