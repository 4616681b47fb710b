"""The plate of a figure says where a script finds its curves and how to draw them again."""

import json
import re
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest

from tests.support.sensitivity_pictures import NOTE, made
from workbench.report.figures import drawings, sheets
from workbench.report.figures.figure_sheet import draw_all
from workbench.report.figures.style import LINES
from workbench.study.document.document import Band, Bars, Colophon, Document, Figure, Panel, Points, Section, Series
from workbench.study.document.figure import Tiles

T = np.linspace(0, 10, 101)  # so few points that no drawn line leaves any out


def curve(law, k=0, **look):
    return Series(law, T, np.exp(-T) * np.cos((k + 1) * T) + k, k, **look)


PANELS = (
    Panel("e [rad]", (curve("a"), curve("b", 1, look="steps"), Series("wanted", T, 0 * T, "reference"))),
    Panel("|e| [rad]", (Series("a", T, np.exp(-T)),), xlim=(1.0, 6.0), yscale="log", ylim=(1e-3, 1.0)),
    Panel("y", (Series("a", np.cos(T), np.sin(T)), curve("marks", 2, look="marks")), xlabel="x", hlines=(0.5,)),
    Panel("y", (Band("half of all", T, np.sin(T) - 1, np.sin(T) + 1), curve("a")), vlines=(1.0, 2.0)),
)
FIGURE = Figure("four", "Four panels.", PANELS, columns=2)
OTHERS = tuple(replace(make(), name=f"other_{k}") for k, make in enumerate(made(NOTE).values()))


@pytest.fixture(scope="module")
def sheet():
    return draw_all([FIGURE])["four"]


def group(svg, panel, series):
    """The markup of the group of a series."""
    head = f'<g class="series" data-panel="{panel}" data-series="{series}">'
    assert svg.count(head) == 1
    return svg.split(head)[1].split("</g>")[0]


def points(path):
    """The points (N, 2) of the path of a line, from the upper left corner of the sheet."""
    return np.array(re.findall(r"[ML] (\S+) ([-.\d]+)", path), dtype=float)


def shares(ruler, numbers):
    straight = np.log10 if ruler["scale"] == "log" else np.asarray
    low, high = straight(ruler["low"]), straight(ruler["high"])
    return (straight(numbers) - low) / (high - low)


def places(plate, panel, x, y):
    """The points (N, 2) of numbers by the plate, from the upper left corner of the sheet."""
    left, bottom, width, height = plate["panels"][panel]["box"]
    across = left + width * shares(plate["panels"][panel]["x"], x)
    up = bottom + height * shares(plate["panels"][panel]["y"], y)
    return np.column_stack([across, plate["height"] - up])


@pytest.mark.parametrize(("panel", "series"), [(0, 0), (0, 2), (1, 0), (2, 0), (3, 1)])
def test_each_drawn_point_of_a_line_is_where_the_plate_puts_its_number(sheet, panel, series):
    drawn = points(group(sheet.svg, panel, series))
    mark = PANELS[panel].series[series]
    all_of = places(sheet.plate, panel, mark.x, mark.y)
    apart = np.abs(drawn[:, np.newaxis] - all_of).max(axis=2).min(axis=1)
    assert len(drawn) > 1
    assert apart.max() <= 0.0101  # two decimals are kept, the others cut


def test_a_marked_point_is_where_the_plate_puts_its_number(sheet):
    drawn = np.array(re.findall(r'<use [^>]*x="(\S+)" y="(\S+)"', group(sheet.svg, 2, 1)), dtype=float)
    mark = PANELS[2].series[1]
    assert np.abs(drawn - places(sheet.plate, 2, mark.x, mark.y)).max() <= 0.0101


def test_all_curves_and_both_rulers_of_each_panel_are_groups_of_their_own(sheet):
    found = re.findall(r'<g class="series" data-panel="(\d)" data-series="(\d)">', sheet.svg)
    assert sorted(found) == [(str(i), str(j)) for i, panel in enumerate(PANELS) for j in range(len(panel.series))]
    for name in ("ruler-x", "ruler-y"):
        held = re.findall(rf'<g class="{name}" data-panel="(\d)">', sheet.svg)
        assert sorted(held) == [number for number in "0123" for _ in range(2)]  # the grid below, the numbers above
    assert re.findall(r'<g class="hlines" data-panel="(\d)">', sheet.svg) == ["2"]
    assert re.findall(r'<g class="vlines" data-panel="(\d)">', sheet.svg) == ["3"]


def test_the_markup_is_well_formed_and_names_no_other_groups(sheet):
    tree = ElementTree.fromstring(sheet.svg)
    named = [element for element in tree.iter() if "class" in element.attrib]
    assert {element.tag.split("}")[1] for element in named} == {"g"}
    assert {element.get("class") for element in named} == {"series", "ruler-x", "ruler-y", "hlines", "vlines"}


def test_a_plate_says_which_abscissa_is_the_time_and_which_rulers_a_study_fixed(sheet):
    panels = sheet.plate["panels"]
    assert [panel["x"]["time"] for panel in panels] == [True, True, False, True]
    assert [panel["x"]["fixed"] for panel in panels] == [False, True, False, False]
    assert [panel["y"]["fixed"] for panel in panels] == [False, True, False, False]
    assert (panels[1]["x"]["low"], panels[1]["x"]["high"]) == (1.0, 6.0)
    assert [panel["y"]["scale"] for panel in panels] == ["linear", "log", "linear", "linear"]


def test_a_plate_has_the_looks_that_are_drawn(sheet):
    for panel, series in ((0, 0), (0, 1), (0, 2), (1, 0)):
        look, drawn = sheet.plate["panels"][panel]["series"][series], group(sheet.svg, panel, series)
        assert f"stroke: {look['color'].lower()}" in drawn
        width = re.search(r"stroke-width: ([\d.]+)", drawn)
        assert float(width[1]) == look["width"]
        dash = re.search(r"stroke-dasharray: ([\d.,]+)", drawn)
        assert [float(length) for length in dash[1].split(",")] == look["dash"] if dash else not look["dash"]
    assert [mark["look"] for mark in sheet.plate["panels"][0]["series"]] == ["line", "steps", "line"]
    assert [mark["look"] for mark in sheet.plate["panels"][2]["series"]] == ["line", "marks"]
    assert [mark["look"] for mark in sheet.plate["panels"][3]["series"]] == ["band", "line"]
    assert sheet.plate["panels"][0]["series"][1]["label"] == "b"
    assert sheet.plate["panels"][0]["series"][1]["color"] == LINES[1]["color"]


def test_every_figure_of_a_document_has_a_plate_that_json_holds():
    figures = (FIGURE, *OTHERS)
    document = Document("t", "q", "m", (Section("s", figures),), Colophon("c", "0"))
    found = sheets(document)
    assert set(found) == {figure.name for figure in figures}
    assert drawings(document) == {name: sheet.svg for name, sheet in found.items()}
    for figure in figures:
        plate = json.loads(json.dumps(found[figure.name].plate, allow_nan=False))
        assert plate == found[figure.name].plate
        assert [len(panel["series"]) for panel in plate["panels"]] == [len(panel.series) for panel in figure.panels]


def test_a_panel_with_tiles_and_a_ruler_with_names_are_fixed():
    for figure in OTHERS:
        plate = draw_all([figure])[figure.name].plate
        for panel, drawn in zip(figure.panels, plate["panels"], strict=True):
            tiles = any(isinstance(mark, Tiles) for mark in panel.series)
            assert drawn["x"]["fixed"] == bool(tiles or panel.xlim or panel.xnames)
            assert drawn["y"]["fixed"] == bool(tiles or panel.ylim or panel.ynames)


def test_each_bar_and_each_point_is_a_group_of_its_own_with_its_numbers_in_the_plate():
    ends = np.array([0.5, np.nan, 2.0])
    bars = Bars("ours", np.arange(3) + 0.2, ends, np.zeros(3), 1, 0.5, thick=0.35, texts=("0.5", "", "2"))
    points = Points(
        "laws", np.array([1.0, np.nan]), np.array([0.5, 0.2]), ("PID", "SMC"), 2, xlow=ends[:2], xhigh=ends[:2]
    )
    panels = Panel("", (bars,), "RMSE", ynames=("a", "b", "c")), Panel("y", (points,), "x")
    sheet = draw_all([Figure("two", "Two panels.", panels)])["two"]
    one, two = re.split(r'<g class="marks" data-panel="\d" data-series="0">', sheet.svg)[1:]
    held = [re.findall(r'<g class="(\w+)" data-index="(\d)">', part) for part in (one, two)]
    assert [pair for pair in held[0] if pair[0] == "words"] == [("words", "0"), ("words", "2")]
    assert {number for _, number in held[0]} == {"0", "2"}  # a gap has no bar
    assert set(held[1]) == {("mark", "0"), ("words", "0")}
    told = [panel["series"][0] for panel in sheet.plate["panels"]]
    assert told[0]["places"] == bars.places.tolist()
    assert (told[0]["starts"], told[0]["ends"], told[0]["thick"]) == ([0.0, 0.0, 0.0], [0.5, None, 2.0], 0.35)
    assert told[0]["fill"] in one
    assert (told[1]["x"], told[1]["y"]) == ([1.0, None], [0.5, 0.2])
    # a bar lies where the plate puts its numbers
    corners = points_of_first_bar(one)
    left, right = places(sheet.plate, 0, np.array([0.0, 0.5]), np.array([0.2, 0.2]))
    middle = (corners.min(axis=0) + corners.max(axis=0)) / 2
    assert middle == pytest.approx((left + right) / 2, abs=0.0101)
    assert np.ptp(corners[:, 0]) == pytest.approx(right[0] - left[0], abs=0.0201)


def points_of_first_bar(markup):
    return points(markup.split("</g>")[0])
