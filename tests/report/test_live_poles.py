"""Poles of a live page are dragged: knobs take the numbers that put them there, where there is one way to do so."""

import json

import pytest

import workbench as wb
from studies.performance.chromium import open_browser, open_page
from tests.support.browsers import needs_chromium
from tests.support.compilers import needs_llvmlite
from tests.support.pole_handles import MAP, PLACED, POLES, SHOWN, STILL, TOLD, drag, gains, knobs, loop, nearest, poles

pytestmark = [needs_chromium, needs_llvmlite]
PAIR = ".live-pole.chosen"
LABELS = "[...document.querySelectorAll('.live-pole:not([hidden])')].map((one) => one.ariaLabel)"


def prefer(page, words):
    page.value(f"""(() => {{
      const {{choice}} = {MAP};
      [...choice.options].find((one) => one.textContent === {json.dumps(words)}).selected = true;
      choice.dispatchEvent(new Event("change"));
    }})()""")


@pytest.fixture(scope="module")
def browser():
    with open_browser() as browser:
        yield browser


@pytest.fixture(scope="module")
def opened(tmp_path_factory, browser):
    path = wb.live(loop(), until=0.5).write(tmp_path_factory.mktemp("poles") / "motor.html")
    with open_page(path, browser=browser) as page:
        page.until(SHOWN)
        yield page
        assert page.requests == [path.resolve().as_uri()]


@pytest.fixture
def page(opened):
    opened.value(f"livePage.bench.reset(); {MAP}.prefer('')")
    opened.until(f"{STILL} && !livePage.answers.size")
    opened.value(f"{MAP}.records.find(({{at}}) => at.im > 0).element.focus()")
    opened.until(f"{MAP}.known.key === ''")
    yield opened
    assert opened.complaints == []


def test_handles_stand_at_the_poles_that_knobs_move(page):
    found = {complex(*one) for one in page.value(POLES)}
    for expected in poles(loop()):
        assert nearest(found, expected) == pytest.approx(expected, rel=1e-9)
    assert sorted(page.value(LABELS)) == ["Pair of poles of the closed loop", *["Pole of the closed loop"] * 2]
    sizes = page.value("[...document.querySelectorAll('.live-pole:not([hidden])')].map((one) => one.offsetWidth)")
    assert min(sizes) >= 24  # WCAG 2.5.8
    offered = page.value(f"[...{MAP}.choice.options].map((one) => one.textContent)")
    assert offered[0] == "controller.Kp and controller.Ki"
    assert "controller.N alone" not in offered  # of a Kd that is zero


def test_a_pointer_drags_a_pair_by_two_knobs_and_the_copied_lines_follow(page):
    x, y = page.middle(PAIR)
    start = nearest(poles(loop()), 13j)
    scale = page.value(f"""(() => {{
      const {{x, y}} = {MAP}.rulers, sheet = document.querySelector("[data-figure=linear_poles] svg");
      const unit = livePage.data.plates.linear_poles.width / sheet.getBoundingClientRect().width;
      return [unit / x.slope, unit / y.slope]; }})()""")
    for kind, way in (("Pressed", 0), ("Moved", 2), ("Moved", 3), ("Released", 3)):
        page.call(
            "Input.dispatchMouseEvent",
            type=f"mouse{kind}",
            x=x - way / 3,  # which two gains reach within their ranges
            y=y + way,
            button="left",
            buttons=1,
            clickCount=1,
        )
    page.until(f"{STILL} && livePage.answers.size")
    target = start + complex(-scale[0], 3 * scale[1])
    assert abs(nearest([complex(*one) for one in page.value(POLES)], target) - target) < PLACED * abs(target)
    turned = gains(page)
    assert turned["Kp"] != 100
    assert turned["Ki"] != 200
    assert (turned["Kd"], turned["N"]) == (0, 100)
    names = {"loop": loop()}
    exec(page.value("livePage.bench.python()"), names)
    for expected in (one.value for one in names["linear"].poles if one.value.imag >= 0):
        assert nearest([complex(*one) for one in page.value(POLES)], expected) == pytest.approx(expected, rel=1e-9)
    told = page.value(TOLD)
    assert f"controller.Kp = {turned['Kp']:.6g}" in told
    assert f"controller.Ki = {turned['Ki']:.6g}" in told


@pytest.mark.heavy
def test_what_two_knobs_do_not_reach_is_left_at_the_nearest_place_and_said(page):
    target = -8 + 9j
    stop = drag(page, -5 + 13j, target)
    turned = gains(page)
    assert turned["Ki"] == 40  # the least number of its knob
    assert nearest(poles(loop(**turned)), stop) == pytest.approx(stop, rel=1e-9)
    reach = [loop(Kp=Kp, Ki=Ki) for Kp in (30.0, 45.0, 50.0, 55.0, 70.0, 100.0) for Ki in (40.0, 80.0)]
    assert abs(stop - target) <= min(abs(nearest(poles(one), target) - target) for one in reach)
    told = page.value(TOLD).replace("\xa0", " ").replace("\u2212", "-")
    assert told.startswith(
        "Within their ranges, controller.Kp and controller.Ki do not put these poles at -8 ± 9j rad/s."
    )
    assert f"The poles stop at {stop.real:.4g} ± {stop.imag:.4g}j rad/s" in told


def test_arrow_keys_move_a_pair_by_a_twentieth_of_its_distance_from_zero_and_none_is_lost(page):
    start = nearest(poles(loop()), 13j)
    first = start - 0.05 * abs(start)
    target = first - 0.05j * abs(first)
    page.press(PAIR, "ArrowLeft")
    page.press(PAIR, "ArrowDown")
    page.until(f"{STILL} && livePage.answers.size")
    assert abs(nearest([complex(*one) for one in page.value(POLES)], target) - target) < PLACED * abs(target)
    assert page.value("document.activeElement.ariaValueText").startswith(f"Poles at \u2212{-target.real:.4g} ± ")
    assert nearest(poles(loop(**gains(page))), target) == pytest.approx(target, rel=PLACED)


def test_a_finger_drags_a_pair_and_the_page_stays_where_it_is(page):
    page.size(390, 844, touch=True)
    try:
        start = nearest(poles(loop()), 13j)
        page.value("document.querySelector('[data-figure=linear_poles]').scrollIntoView()")  # above the knobs
        x, y = page.middle(PAIR)
        top = "document.querySelector('[data-figure=linear_poles]').getBoundingClientRect().top"
        place = page.value(top)
        page.call("Input.dispatchTouchEvent", type="touchStart", touchPoints=[{"x": x, "y": y}])
        for way in (2, 4, 6):
            page.call("Input.dispatchTouchEvent", type="touchMove", touchPoints=[{"x": x, "y": y + way}])
        page.call("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])
        page.until(f"{STILL} && livePage.answers.size")
        found = nearest([complex(*one) for one in page.value(POLES)], start)
        assert found.real == pytest.approx(start.real, rel=PLACED)
        assert 0 < found.imag < start.imag - 1
        assert page.value(top) == pytest.approx(place, abs=1)  # a px, of six that the finger moved
    finally:
        page.size(1100, 800)


def test_a_single_knob_moves_a_pair_along_its_root_locus_to_the_point_nearest_to_the_pointer(page):
    prefer(page, "controller.Kp alone")
    target = -7 + 20j
    stop = drag(page, -5 + 13j, target)
    turned = gains(page)
    assert turned["Kp"] > 100
    assert turned["Ki"] == 200
    assert nearest(poles(loop(**turned)), stop) == pytest.approx(stop, rel=1e-9)
    for factor in (0.999, 1.001):
        beside = nearest(poles(loop(Kp=factor * turned["Kp"])), stop)
        assert abs(beside - target) > abs(stop - target)


def test_the_locus_of_a_knob_ends_with_its_range_and_the_page_says_so(page):
    prefer(page, "controller.Kp alone")
    drag(page, -5 + 13j, -5 + 50j)
    assert knobs(page)["controller.Kp"] == 500
    told = page.value(TOLD).replace("\xa0", " ")
    assert told.startswith("The locus of controller.Kp ends at its largest number, 500 V s/rad. The poles stop at ")


def test_a_real_pole_is_put_in_its_place_by_one_knob(page):
    stop = drag(page, -2, -3)
    assert abs(stop + 3) < PLACED
    assert knobs(page)["controller.Kp"] == 100
    assert nearest(poles(loop(**gains(page))), -3) == pytest.approx(-3, rel=PLACED)


def test_a_dragged_pole_comes_back_with_the_baseline(page):
    before = page.value(POLES)
    page.press(PAIR, "ArrowLeft")
    page.until(f"{STILL} && livePage.answers.size")
    assert page.value(POLES) != before
    page.value("livePage.bench.reset()")
    page.until(f"{STILL} && !livePage.answers.size")
    assert sorted(page.value(POLES)) == sorted(before)
