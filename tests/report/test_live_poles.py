"""Poles of a live page are dragged: knobs take the numbers that put them there, where there is one way to do so."""

import json
import math

import control
import numpy as np
import pytest

import workbench as wb
from studies.performance.chromium import open_browser, open_page
from tests.support.browsers import needs_chromium
from tests.support.compilers import needs_llvmlite

pytestmark = [needs_chromium, needs_llvmlite]

PAIR = ".live-pole.chosen"
SHOWN = "Boolean(document.querySelector('.live-pole:not([hidden])'))"
STILL = "livePage.handles.all.every(({pursuit}) => !pursuit.isSeeking && !pursuit.aim) && !livePage.late.size"
STILL += " && (!livePage.flight || !livePage.flight.fine.size) && !livePage.held && !livePage.away.size"
MAP = "livePage.handles.all.find((one) => one.records)"
POLES = f"{MAP}.records.filter(({{element}}) => !element.hidden).map(({{at}}) => [at.re, at.im])"
TOLD = f"[...{MAP}.row.querySelectorAll('span')].map((one) => one.textContent).join('')"
PLACED = 1e-6  # of a pole, as promised
LABELS = "[...document.querySelectorAll('.live-pole:not([hidden])')].map((one) => one.ariaLabel)"


def loop(**gains):
    motor = wb.DCMotor()
    law = wb.PID2(motor.outputs, motor.inputs, **{"Kp": 100.0, "Ki": 200.0} | gains)
    return wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0, time=0.1))


def poles(closed, **options):
    return [one.value for one in wb.linear_loop(closed, **options).poles if one.value.imag >= 0]


def nearest(all_poles, target):
    return min(all_poles, key=lambda one: abs(one - target))


def knobs(page):
    return page.value("Object.fromEntries(livePage.data.knobs.map(({name}, i) => [name, livePage.state.values[i]]))")


def gains(page):
    values = knobs(page)
    return {name: values[f"controller.{name}"] for name in ("Kp", "Ki", "Kd", "N")}


def drag(page, start, target):
    """Drag the pole nearest to a place to another place, and give the pole that came nearest to it."""
    page.value(f"""(() => {{
      const map = {MAP}, away = ({{at}}) => Math.hypot(at.re - {start.real}, at.im - {start.imag});
      const record = [...map.records].sort((a, b) => away(a) - away(b))[0];
      record.element.focus();
      return map.wish(record, {{re: {target.real}, im: {target.imag}}});
    }})()""")
    page.until(STILL)
    return nearest([complex(*one) for one in page.value(POLES)], target)


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


MASSES = control.ss(
    [[0, 0, 1, 0, 0], [0, 0, 0, 1, 0], [-1, 1, 0, 0, 0], [1, -1, 0, 0, 0], [0, 0, 0, 0, -0.5]],
    [[0], [0], [1], [0], [0]], np.eye(5), 0,
    inputs="f", outputs=["x1", "x2", "v1", "v2", "slow"], states=["x1", "x2", "v1", "v2", "slow"],
)  # fmt: skip
CONTROLLED = control.ss(MASSES.A[:4, :4], MASSES.B[:4], np.eye(4), 0)


def feedback(K):
    plant = wb.LinearPlant(MASSES)
    return wb.ClosedLoop(plant, controller=wb.Regulator.of(plant, [[*K, 0.0]]))


def test_the_gains_of_a_state_feedback_place_a_pair_and_hold_the_other_poles(tmp_path, browser):
    K, placed = (wb.place(CONTROLLED, [pole, pole.conjugate(), -2, -3]).K[0] for pole in (-1 + 1j, -1.5 + 1.5j))
    room = 1.2 * max(abs(placed - K))
    turned = [wb.Knob(f"k{i + 1}", f"controller.K[0,{i}]", k - room, k + room) for i, k in enumerate(K)]
    written = wb.live(feedback(K), until=0.1, knobs=turned).write(tmp_path / "masses.html")
    with open_page(written, browser=browser) as page:
        page.until(SHOWN)
        assert all(abs(complex(*one) + 0.5) > 0.1 for one in page.value(POLES))  # no gain moves it
        stop = drag(page, -1 + 1j, -1.5 + 1.5j)
        assert abs(stop - (-1.5 + 1.5j)) < PLACED
        found = knobs(page)
        np.testing.assert_allclose([found[f"k{i + 1}"] for i in range(4)], placed, rtol=PLACED)
        assert page.value(f"{MAP}.choice.selectedOptions[0].textContent") == "k1, k2, k3 and k4, and no other pole"
        stop = drag(page, -1.5 + 1.5j, -2.5 + 1.7j)  # on the straight way until a gain ends
        found = knobs(page)
        assert max(abs(found[f"k{i + 1}"] - k) for i, k in enumerate(K)) == pytest.approx(room, rel=PLACED)
        direction = (stop - (-1.5 + 1.5j)) / (-1 + 0.2j)
        assert abs(direction.imag) < PLACED
        assert 0 < direction.real < 1
        held = poles(feedback([found[f"k{i + 1}"] for i in range(4)]))
        for expected in (-2, -3):
            assert nearest(held, expected) == pytest.approx(expected, rel=PLACED)
        assert "as far on the way there as the other poles stay" in page.value(TOLD)
        assert page.complaints == []


@wb.block
class TwoGains(wb.Controller):
    """v = a b e with e = omega_ref - omega: two gains that move poles the same way, and a third that moves none."""

    a: float = wb.parameter(unit="V s/rad")
    b: float = wb.parameter(unit="1")
    c: float = wb.parameter(unit="V")

    reads = follows = wb.layout(omega="rad/s")
    drives = wb.layout(v="V")

    def command(self, t, z, est, ref):
        return {"v": self.a * self.b * (ref.omega - est.omega) + self.c}


@pytest.mark.heavy
def test_two_knobs_that_move_a_pair_the_same_way_place_nothing_and_one_is_followed(tmp_path, browser):
    def alike(a):
        law = TwoGains(a, 2.0, 1.0)
        return wb.ClosedLoop(wb.DCMotor(), controller=law, reference=wb.Step("omega", "rad/s", 1.0))

    start = nearest(poles(alike(50.0)), 10j)
    with open_page(wb.live(alike(50.0), until=0.1).write(tmp_path / "alike.html"), browser=browser) as page:
        page.until(SHOWN)
        offered = page.value(f"[...{MAP}.choice.options].map((one) => one.textContent)")
        assert sorted(offered) == ["controller.a alone", "controller.b alone"]
        both = f"{MAP}.records.find(({{at}}) => at.im > 0).choices = [{{knobs: [0, 1], holds: false, key: 'both'}}]"
        page.value(both)  # as if a reader had chosen them where they differ
        drag(page, start, start - 3)
        assert math.isclose(nearest([complex(*one) for one in page.value(POLES)], start).imag, start.imag)
        found = knobs(page)
        assert found["controller.a"] * found["controller.b"] == pytest.approx(100, rel=1e-6)
        page.value("livePage.bench.reset()")
        page.until(f"{STILL} && !livePage.answers.size")
        page.value(both)
        stop = drag(page, start, start + 2j)
        found = knobs(page)
        assert (found["controller.a"] != 50) != (found["controller.b"] != 2)
        assert abs(stop - (start + 2j)) < PLACED * abs(stop)
        followed = "a" if found["controller.a"] != 50 else "b"
        assert page.value(TOLD) == (
            "Here controller.a and controller.b do not place this pole in one way: "
            f"it follows controller.{followed} alone."
        )
        assert page.complaints == []


@pytest.mark.heavy
def test_in_a_computer_a_pair_is_placed_in_the_plane_of_its_periods(tmp_path, browser):
    closed = wb.DigitalLoop(loop(), 0.01)
    start = nearest(poles(closed, substeps=2), 0.95 + 0.1j)
    with open_page(wb.live(closed, until=0.2, h=5e-3).write(tmp_path / "computer.html"), browser=browser) as page:
        page.until(SHOWN)
        target = start + 0.005 - 0.01j
        stop = drag(page, start, target)
        assert abs(stop - target) < PLACED
        found = nearest(poles(wb.DigitalLoop(loop(**gains(page)), 0.01), substeps=2), target)
        assert found == pytest.approx(stop, rel=1e-9)
        assert page.complaints == []
