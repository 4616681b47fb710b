"""The colours of figures on a dark page: each as readable there as by day, and the PDF without them."""

import re

import numpy as np
import pytest

import workbench as wb
from workbench.core.templates import template_text
from workbench.report import pdf
from workbench.report.figures import sheets
from workbench.report.figures.axes import GRID
from workbench.report.figures.boxes import ink_on, ink_over, tint, tone
from workbench.report.figures.dark_colors import GROUND, INK, LEAST, contrast, dark, dark_scheme, with_variables
from workbench.report.figures.style import LINES
from workbench.report.html_page import html
from workbench.report.live.loop_study import loop_study
from workbench.study import case_runs, writeup
from workbench.study.document.figure import STYLES

BY_EYE = 0.05  # of a contrast: a colour has 8 bits, and nobody sees less


def documents():
    motor = wb.DCMotor()
    law = wb.PID(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0)
    loop = wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0, time=0.1))
    study = loop_study(loop, until=0.2, h=1e-2)
    return writeup.document(study, case_runs.run(study), "command")


def test_white_paper_becomes_the_page_and_black_ink_almost_white():
    assert dark("#ffffff") == GROUND
    assert contrast(dark("#000000"), GROUND) == pytest.approx(INK, rel=BY_EYE)
    assert f"--page: {GROUND};" in template_text("workbench.report", "dark.css")


def test_the_contrast_of_two_colours_is_that_of_the_guidelines():
    assert contrast("#ffffff", "#000000") == pytest.approx(21)  # WCAG 2.2, the greatest
    assert contrast("#777777", "#ffffff") == pytest.approx(4.48, abs=0.005)  # the grey just below 4.5 that WebAIM names
    assert contrast("#ffffff", "#777777") == contrast("#777777", "#ffffff")


@pytest.mark.parametrize("style", LINES, ids=str)
def test_a_line_is_read_by_night_as_by_day(style):
    color = LINES[style]["color"]
    by_day, by_night = contrast(color, "#ffffff"), contrast(dark(color), GROUND)
    assert by_night >= min(by_day, 9.0) * (1 - BY_EYE)
    if style != "reference":  # which stands back behind all laws
        assert by_night >= LEAST * (1 - BY_EYE)


def test_a_grid_stands_back_by_night_as_by_day():
    assert contrast(dark(GRID["color"]), GROUND) == pytest.approx(contrast(GRID["color"], "#ffffff"), rel=BY_EYE)


def test_no_two_laws_have_one_colour_by_night():
    assert len({dark(LINES[style]["color"]) for style in range(STYLES)}) == STYLES


@pytest.mark.parametrize("style", LINES, ids=str)
@pytest.mark.parametrize("shade", np.linspace(0, 1, 11))
def test_words_on_bars_are_read_by_night(style, shade):
    fill, ink = tint(style, shade), ink_on(style, shade)
    assert contrast(dark(fill), dark(ink)) >= 3.5  # as by day at the colour where black gives way to white


def test_tiles_keep_their_order_and_their_words_by_night():
    shades = np.linspace(0, 1, 41)
    by_night = [contrast(dark(tone(shade)), GROUND) for shade in shades]
    assert np.all(np.diff(by_night) > -BY_EYE)
    assert by_night[-1] > 5
    assert min(contrast(dark(tone(shade)), dark(ink_over(shade))) for shade in shades) >= 3.5


def test_every_paint_of_a_page_is_a_variable_with_a_colour_for_the_night():
    document = documents()
    page = html(document)
    drawn = "".join(re.findall(r"<svg.*?</svg>", page, re.S))
    asked = set(re.findall(r"var\(--c([0-9a-f]{6}), #\1\)", drawn))
    assert len(asked) > 4
    assert not re.search(r"(fill|stroke): #", drawn)
    declared = dict(re.findall(r"--c([0-9a-f]{6}): (#[0-9a-f]{6});", page))
    assert asked <= declared.keys()
    assert declared["ffffff"] == GROUND


def test_the_pdf_has_the_colours_of_the_day_alone():
    document = documents()
    drawings = {name: sheet.svg for name, sheet in sheets(document).items()}
    assert "var(" not in "".join(drawings.values())
    assert "var(" not in str(pdf.data(document, drawings))


def test_a_drawing_keeps_all_but_its_paints():
    svg = '<path style="fill: none; stroke: #0072b2; opacity: 0.5" d="M 1 2"/><g style="fill: #ffffff">#0072b2</g>'
    painted = with_variables(svg)
    assert painted == svg.replace("stroke: #0072b2", "stroke: var(--c0072b2, #0072b2)").replace(
        "fill: #ffffff", "fill: var(--cffffff, #ffffff)"
    )
    assert dark_scheme(["#FFFFFF", "#ffffff"]) == f"--cffffff: {GROUND};"
