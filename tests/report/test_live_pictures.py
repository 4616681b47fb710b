"""The linear pictures of a loop on its page: linked, moved by knobs as in Python, greyed out without an answer."""

import re

import numpy as np
import pytest

import workbench as wb
from studies.performance.chromium import open_browser, open_page
from tests.support.browsers import needs_chromium
from tests.support.compilers import needs_llvmlite
from tests.support.linear_answers import received
from tests.support.live_pictures import blocks_of, data_of, drawn, loop, turn
from workbench.design.frequency.frequency_axis import phases
from workbench.study.document.document import Figure
from workbench.study.document.frequency_curves import decibels

FIGURES = ("linear_bode", "linear_nyquist", "linear_sensitivity", "linear_poles")
PICTURES = """JSON.stringify([...document.querySelectorAll('[data-figure^=linear]')].map((one) => {
  const picture = one.cloneNode(true); // without the handles, which lie above it
  picture.querySelectorAll('.live-handles, .live-drag').forEach((part) => part.remove());
  return picture.outerHTML; }))"""


@pytest.fixture(scope="module")
def motor():
    return wb.live(loop(), until=0.5)


@pytest.fixture(scope="module")
def path(motor, tmp_path_factory):
    return motor.write(tmp_path_factory.mktemp("linear") / "motor.html")


@pytest.fixture(scope="module")
def browser():
    with open_browser() as browser:
        yield browser


@pytest.fixture
def page(path, browser):
    with open_page(path, browser=browser) as page:
        page.until("Boolean(livePage.data && livePage.motion)")
        yield page
        assert page.complaints == []


def test_a_page_links_the_pictures_and_the_table_of_its_loop(motor):
    data = data_of(motor)
    marks = {(one["figure"], one["quantity"]) for one in data["linear_marks"]}
    assert {name for name, _ in marks} == {*FIGURES}
    quantities = {"magnitude", "phase", "gain margins", "phase margins", "imaginary part", "arrowheads", "circle of Ms"}
    quantities |= {"circle of the disk margin", "magnitude of S", "magnitude of T", "poles of the closed loop"}
    assert quantities | {"poles of the cut loop"} == {quantity for _, quantity in marks}
    cells = {one["quantity"]: one for one in data["cells"] if "quantity" in one}
    margins = wb.linear_loop(loop()).margins()["v"].margins
    assert cells["phase margin"]["printed"] == margins.phase_margin.value
    assert cells["gain margin"]["words"] == "no limit"
    assert {one["figure"] for one in data["linear_marks"]} <= data["plates"].keys()


def test_no_caption_of_a_live_picture_has_a_margin_that_could_not_move():
    figures = [block for block in blocks_of(loop()) if isinstance(block, Figure) and block.name in FIGURES]
    assert [figure.name for figure in figures] == [*FIGURES]
    for figure in figures:
        words = "".join(part for part in np.atleast_1d(np.array(figure.caption, dtype=object)) if isinstance(part, str))
        words += "".join(str(mark.label) for panel in figure.panels for mark in panel.series)
        assert not re.search(r"\d", words.replace("t = 0 s", "").replace("1 / (1 + L)", "").replace("L / (1 + L)", ""))


@needs_chromium
@needs_llvmlite
def test_a_turned_knob_moves_all_pictures_as_python_draws_them(page, path):
    turn(page, 350)
    linear, omega = wb.linear_loop(loop(Kp=350.0)), np.array(page.value("livePage.data.loops[0].linear.omega"))
    L = linear.response(omega, "L").values[:, 0, 0]
    x, heights = drawn(page, "linear_bode", 0, 0)
    np.testing.assert_array_equal(x, omega)
    np.testing.assert_allclose(heights, decibels(L), atol=1e-7)
    np.testing.assert_allclose(drawn(page, "linear_bode", 1, 0)[1], phases(omega, L), atol=1e-7)
    np.testing.assert_allclose(drawn(page, "linear_sensitivity", 0, 0)[1], decibels(1 / (1 + L)), atol=1e-7)
    real, imaginary = drawn(page, "linear_nyquist", 0, 0)
    seen = np.isfinite(imaginary)
    assert seen.sum() > 20
    np.testing.assert_allclose(real[seen] + 1j * imaginary[seen], L[seen], rtol=1e-9)
    crosses = page.value("(() => { const {x, y} = livePage.figure('linear_poles').panels[0].sets.get('now 0');"
                         " return [...x].map((one, k) => [one, y[k]]); })()")  # fmt: skip
    poles = [[pole.value.real, pole.value.imag] for pole in linear.poles]
    np.testing.assert_allclose(sorted(crosses), sorted(poles), rtol=1e-9, atol=1e-9)
    assert page.requests == [path.resolve().as_uri()]


@needs_chromium
@needs_llvmlite
def test_the_table_and_the_bench_show_the_margins_of_now(page):
    turn(page, 350)
    margins = wb.linear_loop(loop(Kp=350.0)).margins()["v"].margins
    cells = page.value(
        "[...document.querySelectorAll('[data-cell]')].map((one) => ["
        "livePage.data.cells[one.dataset.cell].quantity, one.querySelector('.live-number')?.textContent])"
    )
    shown = dict(cell for cell in cells if cell[0])
    assert float(shown["phase margin"]) == pytest.approx(margins.phase_margin.value, rel=1e-4)  # five digits
    assert float(shown["Ms"]) == pytest.approx(margins.Ms.gain.value, rel=1e-4)
    assert shown["gain margin"] == "no limit"
    rows = page.value(
        "[...document.querySelectorAll('.bench-results tr')].map((row) => [...row.cells].map((one) => one.textContent))"
    )
    (row,) = [row for row in rows if row[0].startswith("phase margin")]
    assert float(row[1]) == pytest.approx(margins.phase_margin.value, rel=1e-3)
    assert float(row[2]) == pytest.approx(38.67, abs=0.01)  # the baseline, as in the docstring of linear_loop
    assert ["At rest at the reference at t = 0 s, before the reference moves."] in rows


@needs_chromium
@needs_llvmlite
def test_back_at_the_baseline_the_pictures_are_those_of_the_page_as_it_was_made(page):
    before = page.value(PICTURES)
    turn(page, 500)
    assert page.value(PICTURES) != before
    page.value("livePage.bench.reset()")
    page.until("!livePage.answers.size && !document.querySelector('.live-series')")
    page.value("(() => { livePage.holds.step(); livePage.redraw(0); })()")  # the next step, which leaves no trace
    page.until("!document.querySelector('svg.live') && !document.querySelector('.live-pale')")
    assert page.value(PICTURES) == before


@needs_chromium
@needs_llvmlite
def test_a_trace_and_held_settings_lie_below_the_curves_of_now(page):
    turn(page, 300)
    page.value("livePage.holds.hold(0)")
    page.value("livePage.movedAt = -Infinity")  # the next turn is a step of its own
    turn(page, 400)
    pale = "[...livePage.figure(%r).panels[0].pale.keys()].sort()"
    assert page.value(pale % "linear_bode") == ["before 0", "held-a 0"]
    assert page.value(pale % "linear_nyquist") == ["before 0", "held-a 0"]
    assert page.value("[...livePage.figure('linear_poles').panels[0].sets.keys()].sort()") == [
        "before 0", "held-a 0", "now 0", "now 1"
    ]  # fmt: skip
    names = "[...document.querySelectorAll('[data-figure=linear_poles] .live-pale text')].map((one) => one.textContent)"
    assert page.value(names) == ["A"]
    assert page.value("document.querySelector('.bench-results thead').textContent").endswith("nowAbaseline")


@needs_chromium
@needs_llvmlite
def test_a_loop_that_does_not_rest_greys_its_pictures_out_below_the_sentence(page):
    turn(page, 300)
    page.value(received({"rests": False, "reason": "The loop does not rest: 'plant.omega' moves."}))
    page.until("document.querySelectorAll('figure.live-refused').length === 4")
    told = page.value("[...document.querySelectorAll('.live-reason')].map((one) => one.textContent)")
    assert told == ["The loop does not rest: 'plant.omega' moves."] * 4
    assert page.value("document.querySelectorAll('[data-figure^=linear] .live-series').length") == 0
    assert "no answer" in page.value("document.querySelector('.bench-results').textContent")
    turn(page, 310)
    page.until("!document.querySelector('.live-refused')")
    page.until("document.querySelector('[data-figure=linear_bode] .live-series') !== null")


@needs_chromium
@needs_llvmlite
def test_axes_of_one_scale_stay_so_and_hold_every_pole(page):
    page.value("livePage.bench.knobs.find(({knob}) => knob.name === 'controller.N').turn(500)")
    page.until("livePage.answers.size && !livePage.late.size && !livePage.away.size")
    across, up, box, poles = page.value(
        "(() => { const {x, y, box, sets} = livePage.figure('linear_poles').panels[0];"
        " return [[x.low, x.high], [y.low, y.high], [box.width, box.height], [...sets.get('now 0').x]]; })()"
    )
    assert across[0] < min(poles) < -300  # the filter of the law is five times as fast
    assert (across[1] - across[0]) / box[0] == pytest.approx((up[1] - up[0]) / box[1])
    assert page.value("document.querySelectorAll('[data-figure=linear_poles] .live-guides').length") == 1


@needs_chromium
@needs_llvmlite
def test_copied_lines_make_the_loop_linear_as_it_is_on_the_page(page):
    turn(page, 350)
    names = {"loop": loop()}
    exec(page.value("livePage.bench.python()"), names)
    margins = names["linear"].margins()["v"].margins
    assert page.value("livePage.answers.get(0).answer.margins[0].phaseMargin") == pytest.approx(
        margins.phase_margin.value, rel=1e-9
    )
