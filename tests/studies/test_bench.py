"""The bench: pictures from the top with the knobs beside them, traces, settings held by name, coarse pictures first."""

import json

import pytest

import workbench as wb
from studies.performance.chromium import open_page
from tests.support.browsers import needs_chromium
from tests.support.compilers import needs_llvmlite
from workbench.report.figures.style import SMALL_LETTERS

pytestmark = [needs_chromium, needs_llvmlite]

PICTURES = ["omega", "v_applied", "Bode", "Nyquist", "S and T", "poles"]
LEAST = 24  # px of a target, WCAG 2.5.8
IDLE = "!livePage.flight?.fine.size && !livePage.held"
BOX = """(() => { const box = document.querySelector(%r).getBoundingClientRect();
  return [box.left, box.top, box.right, box.bottom]; })()"""
TARGETS = """[".bench button", ".bench input", ".bench select", ".bench summary", ".pictures input"]
  .flatMap((one) => [...document.querySelectorAll(one)])
  .filter((one) => one.checkVisibility())
  .map((one) => [one.outerHTML.slice(0, 60), one.getBoundingClientRect()])
  .filter(([, box]) => box.width < %d || box.height < %d)
  .map(([text, box]) => `${text}: ${box.width} x ${box.height}`)"""
MOVING = "[...document.querySelectorAll('.pictures-grid figure')].map((one) => one.getBoundingClientRect().toJSON())"


def loop():
    motor = wb.DCMotor()
    law = wb.PID(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0, low=-24.0, high=24.0)
    return wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0, time=0.1))


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return wb.live(loop(), until=1.0).write(tmp_path_factory.mktemp("bench") / "motor.html")


@pytest.fixture
def page(path, browser):
    with open_page(path, width=1300, height=900, browser=browser) as page:
        page.until("livePage.data && livePage.bench.knobs")
        yield page


def turn(page, value, knob=0):
    page.value(f"livePage.bench.knobs[{knob}].turn({value})")
    page.until(IDLE)
    page.until("!livePage.frame && !livePage.late.size && !livePage.away.size")


def test_pictures_stand_at_the_top_beside_open_knobs_and_words_below(page):
    _, top, right, bottom = page.value(BOX % ".pictures-grid")
    panel = page.value(BOX % ".bench-panel")
    assert 0 <= top < 100  # the title is above
    assert right <= panel[0] < panel[2] <= 1300
    assert page.value(BOX % ".bench-knob")[3] < 900
    boxes = page.value(MOVING)
    assert len(boxes) == len(PICTURES)
    assert boxes[0]["top"] == boxes[1]["top"]
    assert boxes[0]["right"] <= boxes[1]["left"]
    assert page.value(BOX % "dl.abstract")[1] >= bottom
    assert page.value("document.querySelectorAll('h1').length") == 1


@pytest.mark.parametrize(("width", "height"), [(1300, 1000), (1900, 1200)])
def test_all_pictures_are_on_the_first_screen_in_letters_that_can_be_read(path, browser, width, height):
    with open_page(path, width=width, height=height, browser=browser) as page:
        page.until("livePage.data && livePage.bench.knobs")
        pictures = "[...document.querySelectorAll('.pictures-grid svg')].filter((one) => one.viewBox.baseVal)"
        bottoms = page.value(f"{pictures}.map((one) => one.getBoundingClientRect().bottom)")
        scales = page.value(f"{pictures}.map((one) => one.getBoundingClientRect().width / one.viewBox.baseVal.width)")
    assert len(bottoms) == len(PICTURES)
    assert max(bottoms) <= height
    assert min(scales) * SMALL_LETTERS >= 9.0  # px


def test_each_picture_can_be_hidden_and_comes_back(page):
    names = page.value("[...document.querySelectorAll('.pictures-boxes label')].map((one) => one.textContent)")
    assert names == PICTURES
    page.click(".pictures-boxes input")
    seen = "[...document.querySelectorAll('.pictures-grid figure')].map((one) => one.checkVisibility())"
    assert page.value(seen) == [False, *[True] * 5]
    turn(page, 300)
    page.click(".pictures-boxes input")
    assert page.value(seen) == [True] * 6
    page.until("document.querySelectorAll('.pictures-grid .live-series').length >= 2")


def test_knobs_are_the_first_stops_of_the_tabulator(page):
    stops = []
    for _ in range(4):
        page.press("body", "Tab") if not stops else press_tab(page)
        stops.append(page.value("document.activeElement.id || document.activeElement.className"))
    assert "knob-0" in stops[:3]
    assert page.value("!!document.activeElement.closest('.bench')")


def press_tab(page):
    for kind in ("keyDown", "keyUp"):
        page.call("Input.dispatchKeyEvent", type=kind, key="Tab", code="Tab", windowsVirtualKeyCode=9)


@pytest.mark.parametrize(("width", "touch"), [(1300, False), (390, True)])
def test_no_target_is_smaller_than_a_finger_needs(page, width, touch):
    page.size(width, 844, touch=touch)
    page.value("livePage.holds.hold(0)")
    turn(page, 300)
    assert page.value(TARGETS % (LEAST, LEAST)) == []


def test_a_phone_shows_a_picture_and_the_table_while_a_knob_is_turned(page):
    page.size(390, 844, touch=True)
    page.value("scrollTo(0, document.body.scrollHeight)")  # where no picture is
    turn(page, 300)
    panel = page.value(BOX % ".bench-panel")
    page.until(f"{MOVING}.some((box) => Math.min(box.bottom, {panel[1]}) - Math.max(box.top, 0) >= 140)")
    _, top, _, bottom = page.value(BOX % ".bench-results")  # what it does not show is reached by scrolling in it
    assert panel[1] <= top < page.value(BOX % ".bench-results tr:nth-child(2)")[3] <= bottom <= 844
    assert page.value(f"document.elementFromPoint(200, {(top + bottom) / 2}).closest('.bench-results') !== null")
    assert page.value(BOX % "#knob-0")[3] < 844
    assert page.value("document.documentElement.scrollWidth") <= 390


def test_a_step_of_a_knob_leaves_the_curve_before_as_a_pale_trace(page):
    trace = "document.querySelector('[data-figure=signal_1] .live-pale.before path')?.getAttribute('d')"
    line = "[...document.querySelectorAll('[data-figure=signal_1] .live-series')].at(-1).getAttribute('d')"  # the law's
    turn(page, 300)
    assert page.value(trace) is None  # before it was the baseline, which is pale itself
    before = page.value(line)
    page.value("new Promise((done) => setTimeout(done, 700))")
    page.value("livePage.bench.knobs[0].turn(290)")
    turn(page, 270)  # of one movement of the hand
    assert page.value(trace) == before
    assert page.value(line) != before


def test_two_settings_are_held_and_compared_by_the_names_that_are_typed(page):
    odd = "<img src=x onerror=alert(1)>"
    turn(page, 300)
    page.value("document.querySelectorAll('.slot-take')[0].click()")
    turn(page, 50)
    page.value("document.querySelectorAll('.slot-take')[1].click()")
    page.value(
        f"(() => {{ const field = document.querySelector('.slot-name'); field.value = {json.dumps(odd)};"
        " field.dispatchEvent(new Event('input', { bubbles: true })); })()"
    )
    turn(page, 100.0)  # the baseline
    heads = page.value("[...document.querySelectorAll('.bench-results thead th')].map((one) => one.textContent)")
    assert heads[1:] == ["now", odd, "B", "baseline"]
    page.until("document.querySelectorAll('[data-figure=signal_1] .live-pale.held-a text').length === 1")
    assert page.value("document.querySelector('.held-a text').textContent") == odd
    assert page.value("document.querySelectorAll('img').length") == 0
    cells = page.value("[...document.querySelectorAll('.bench-results tbody td')].map((one) => one.textContent)")
    now, first, second, baseline = cells[:4]  # of the first metric
    assert now == ""
    assert len({first, second, baseline}) == 3
    turn(page, 300)
    assert page.value("document.querySelector('.bench-results tbody td').textContent") == first
    page.value("livePage.holds.slots[1].back.click()")
    assert page.value("livePage.state.values[0]") == 50
    page.value("livePage.holds.slots[0].out.click()")
    page.until("!document.querySelector('.held-a text') && !!document.querySelector('.held-b text')")
    assert page.complaints == []


def test_figures_are_no_white_plates_in_the_dark(page):
    page.size(1300, 900, dark=True)
    turn(page, 300)
    ground = page.value("getComputedStyle(document.body).backgroundColor")
    assert ground == "rgb(22, 24, 27)"
    fills = page.value(
        "[...document.querySelectorAll('.pictures-grid svg path:first-of-type')]"
        ".filter((path) => path === path.ownerSVGElement.querySelector('path'))"
        ".map((path) => getComputedStyle(path).fill)"
    )
    assert fills == [ground] * len(PICTURES)
    inks = page.value(
        "['.live-ruler text', '.pictures-grid svg'].map((one) => document.querySelector(one))"
        ".filter(Boolean).map((one) => getComputedStyle(one).fill)"
    )
    assert set(inks) == {"rgb(243, 243, 243)"}


def test_a_reader_who_closes_the_bench_has_the_whole_width(page):
    page.click(".bench-close")
    assert page.value(BOX % ".pictures-grid")[2] > 1200
    assert page.value("document.activeElement.className") == "bench-handle"


@pytest.fixture(scope="module")
def slow(tmp_path_factory):
    """The page of a run of five million steps."""
    return wb.live(loop(), until=50.0, h=1e-5).write(tmp_path_factory.mktemp("slow") / "slow.html")


@pytest.mark.heavy
def test_a_run_of_many_steps_has_a_coarse_picture_first_and_then_the_exact_one(slow, browser):
    with open_page(slow, width=1300, height=900, browser=browser) as page:
        page.until("livePage.data && livePage.pool")
        page.value(
            "(() => { window.heard = []; const hear = livePage.hear.bind(livePage);"
            " livePage.hear = (view) => { hear(view); if (view.phase !== 'linear')"
            " heard.push([view.phase, view.done, view.h,"
            " livePage.bench.status.textContent, livePage.views.get(0).scores === null,"
            " Array.from(view.y ?? [])]); }; })()"
        )
        page.value("livePage.bench.knobs[0].turn(300)")
        page.until(IDLE, patience=120)
        (first, *others) = page.value("heard")
        phase, done, h, status, silent, rough = first
        assert (phase, done, silent) == ("coarse", True, True)
        assert h > 1e-5
        assert status.startswith("Coarse picture, of steps up to ")
        whole = [one for one in others if one[0] == "whole"]
        assert [one[1] for one in whole] == [True]  # it does not grow over the coarse picture
        exact = whole[0][5]
        assert len(rough) == len(exact)
        assert rough != exact
        assert max(abs(a - b) for a, b in zip(rough, exact, strict=True)) < 0.1 * max(map(abs, exact))
        assert page.value("livePage.views.get(0).phase") == "half"
        assert page.value("livePage.bench.status.textContent").startswith("One loop computed here in")
        assert page.complaints == []


@pytest.mark.heavy
def test_a_loop_in_a_computer_and_one_of_few_steps_have_no_coarse_steps(path):
    def coarse(text):
        return json.loads(text.split('id="live">')[1].split("</script>")[0])["loops"][0]["coarse"]

    assert coarse(path.read_text(encoding="utf-8")) == []  # of one second
    assert coarse(wb.live(loop().digital(0.01), until=300.0, h=1e-3).text) == []
    lengths = coarse(wb.live(loop().ode(), until=50.0, h=5e-4).text)
    strides = [length["stride"] for length in lengths]
    assert strides == sorted(strides, reverse=True)
    assert all(100 % stride == 0 for stride in strides)
    assert lengths[0]["h"] < lengths[-1]["h"]
