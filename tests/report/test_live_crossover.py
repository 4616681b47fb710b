"""The gain crossover of a live Bode plot is dragged: one knob takes the number at which |L| is one there."""

import json
import math

import pytest

import workbench as wb
from studies.performance.chromium import open_browser, open_page
from tests.support.browsers import needs_chromium
from tests.support.compilers import needs_llvmlite

pytestmark = [needs_chromium, needs_llvmlite]

HANDLE = ".live-handle:not(.live-pole)"
SHOWN = "Boolean(document.querySelector('.live-handle:not(.live-pole, [hidden])'))"
STILL = "livePage.handles.all.every(({pursuit}) => !pursuit.isSeeking && !pursuit.aim) && !livePage.late.size"
STILL += " && (!livePage.flight || !livePage.flight.fine.size) && !livePage.held && !livePage.away.size"
CROSSOVER = "Number(document.querySelector('.live-handle').ariaValueNow)"
TOLD = "[...document.querySelector('.live-drag').querySelectorAll('span')].map((one) => one.textContent).join('')"
NEAR = 1e-6  # of a frequency, as promised


def loop(**gains):
    motor = wb.DCMotor()
    law = wb.PID(motor.outputs, motor.inputs, **{"Kp": 100.0, "Ki": 200.0} | gains)
    return wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0, time=0.1))


def crossovers(closed, **options):
    (margins,) = wb.linear_loop(closed, **options).margins().values()
    return [one.frequency.value for one in margins.gain_crossovers]


def knob(page, name):
    return page.value(f"livePage.state.values[livePage.data.knobs.findIndex((one) => one.name === {json.dumps(name)})]")


def choose(page, index):
    page.value(f"(({{options}}) => (options[{index}].selected = true))(document.querySelector('.live-drag select'))")
    page.value("document.querySelector('.live-drag select').dispatchEvent(new Event('change'))")


def mouse(page, kind, x, y):
    page.call("Input.dispatchMouseEvent", type=f"mouse{kind}", x=x, y=y, button="left", buttons=1, clickCount=1)


@pytest.fixture(scope="module")
def browser():
    with open_browser() as browser:
        yield browser


@pytest.fixture(scope="module")
def opened(tmp_path_factory, browser):
    path = wb.live(loop(), until=0.5).write(tmp_path_factory.mktemp("crossover") / "motor.html")
    with open_page(path, browser=browser) as page:
        page.until(SHOWN)
        yield page
        assert page.requests == [path.resolve().as_uri()]


@pytest.fixture
def page(opened):
    opened.value("livePage.bench.reset()")
    choose(opened, 0)
    opened.until(f"{STILL} && !livePage.answers.size")
    yield opened
    assert opened.complaints == []


def test_the_handle_stands_at_the_crossover_and_offers_the_knobs_that_move_it(page):
    assert page.value(CROSSOVER) == pytest.approx(crossovers(loop())[0], rel=1e-9)
    offered = page.value("[...document.querySelector('.live-drag select').options].map((one) => one.textContent)")
    assert offered == ["controller.Kp", "controller.Ki", "controller.Kd"]  # not N, of a Kd that is zero, nor b and c
    box = page.value("[[...document.querySelectorAll('.live-handle')].map((one) => one.offsetWidth)]")[0]
    assert min(box) >= 24  # WCAG 2.5.8


def test_a_pointer_drags_the_crossover_to_the_frequency_below_it(page):
    x, y = page.middle(HANDLE)
    start = page.value(CROSSOVER)
    width = page.value("document.querySelector('[data-figure=linear_bode] svg').getBoundingClientRect().width")
    plate = page.value("(({width, panels}) => ({width, ...panels[0]}))(livePage.data.plates.linear_bode)")
    decades = math.log10(plate["x"]["high"] / plate["x"]["low"]) / plate["box"][2] * plate["width"] / width  # of a px
    mouse(page, "Pressed", x, y)
    for way in (3, 8, 13):
        mouse(page, "Moved", x + way, y + 20)
    mouse(page, "Released", x + 13, y)
    page.until(f"{STILL} && livePage.answers.size")
    wished = start * 10 ** (13 * decades)
    assert page.value(CROSSOVER) == pytest.approx(wished, rel=NEAR)
    Kp = knob(page, "controller.Kp")
    assert Kp > 100
    assert crossovers(loop(Kp=Kp))[0] == pytest.approx(page.value(CROSSOVER), rel=1e-9)
    assert f"controller.Kp = {Kp:.6g}" in page.value(TOLD).replace("\u2212", "-")


def test_arrow_keys_move_the_crossover_by_a_twentieth_of_a_decade_and_the_copied_lines_follow(page):
    wished = page.value(CROSSOVER) * 10 ** (-3 / 20)
    page.press(HANDLE, "ArrowLeft", times=4)
    page.press(HANDLE, "ArrowRight")
    page.until(f"{STILL} && livePage.answers.size")
    names = {"loop": loop()}
    exec(page.value("livePage.bench.python()"), names)
    (margins,) = names["linear"].margins().values()
    assert margins.gain_crossovers[0].frequency.value == pytest.approx(wished, rel=NEAR)
    assert page.value("document.querySelector('.live-handle').ariaValueText").startswith("Crossover at ")


@pytest.mark.parametrize(
    "moment", ["while the worker seeks", "before the answer is there", "while another one is on its way"]
)
def test_no_key_press_is_lost_whenever_it_comes(page, moment):
    start = page.value(CROSSOVER)
    presses = {
        "while the worker seeks": "press(); press();",
        "before the answer is there": "after(pursuit, 'arrive'); press();",
        "while another one is on its way": "press(); setTimeout(press, 30);",
    }[moment]
    page.value(f"""(() => {{
      const {{element, pursuit}} = livePage.handles.all[0];
      const press = () => element.dispatchEvent(new KeyboardEvent("keydown", {{key: "ArrowRight"}}));
      const after = (object, name) => (object[name] = (...told) => {{
        delete object[name];
        object[name](...told);
        press();
      }});
      {presses}
    }})()""")
    wished = start * 10 ** (2 / 20)
    page.until(f"{STILL} && Math.abs({CROSSOVER} / {wished} - 1) < {NEAR}")
    assert crossovers(loop(Kp=knob(page, "controller.Kp")))[0] == pytest.approx(page.value(CROSSOVER), rel=1e-9)


def test_a_knob_that_is_turned_meanwhile_ends_the_drag(page):
    page.press(HANDLE, "ArrowRight")
    page.value("livePage.bench.knobs[1].turn(300)")
    page.until(f"{STILL} && livePage.answers.size")
    assert knob(page, "controller.Ki") == 300
    page.until(f"Math.abs({CROSSOVER} / {crossovers(loop(Kp=knob(page, 'controller.Kp'), Ki=300.0))[0]} - 1) < 1e-9")


def test_the_knob_that_the_reader_chooses_is_the_one_that_moves(page):
    choose(page, 1)
    wished = page.value(CROSSOVER) * 10 ** (1 / 20)
    page.press(HANDLE, "ArrowRight")
    page.until(f"{STILL} && livePage.answers.size")
    assert knob(page, "controller.Kp") == 100
    Ki = knob(page, "controller.Ki")
    assert 200 < Ki < 1000
    assert crossovers(loop(Ki=Ki))[0] == pytest.approx(wished, rel=NEAR)


def test_beyond_the_range_of_the_knob_the_crossover_stops_and_the_page_says_so(page):
    page.value("livePage.handles.all[0].wish(300)")
    page.until(f"{STILL} && livePage.answers.size")
    assert knob(page, "controller.Kp") == 500
    told = page.value(TOLD).replace("\xa0", " ")
    assert told == (
        "No value of controller.Kp from 20 to 500 puts this crossover at 300 rad/s. It stops at 500 V s/rad."
    )
    assert page.value(CROSSOVER) == pytest.approx(crossovers(loop(Kp=500.0))[0], rel=1e-9)
    page.press(HANDLE, "ArrowLeft")
    page.until(f"{STILL} && livePage.state.values[0] < 500")
    assert page.value(TOLD).startswith("Crossover at ")


def test_back_at_the_baseline_the_handle_is_back_too(page):
    start = page.value(CROSSOVER)
    page.press(HANDLE, "ArrowRight")
    page.until(f"{STILL} && livePage.answers.size")
    assert page.value(CROSSOVER) != start
    page.value("livePage.bench.reset()")
    page.until(f"{STILL} && !livePage.answers.size")
    assert page.value(CROSSOVER) == start
    page.until("!location.hash")


def test_a_loop_without_a_crossover_has_no_handle(tmp_path, browser):
    weak = wb.live(loop(Kp=0.01, Ki=0.0), until=0.2).write(tmp_path / "weak.html")
    assert crossovers(loop(Kp=0.01, Ki=0.0)) == []
    with open_page(weak, browser=browser) as page:
        page.until("Boolean(livePage.handles && livePage.handles.baseline.size)")
        assert not page.value(SHOWN)
        assert page.value("document.querySelector('.live-drag').hidden")
        assert page.complaints == []


@pytest.mark.heavy
def test_in_a_computer_the_crossover_is_that_of_its_periods(tmp_path, browser):
    closed = wb.DigitalLoop(loop(), 0.01)
    with open_page(wb.live(closed, until=0.2, h=5e-3).write(tmp_path / "computer.html"), browser=browser) as page:
        page.until(SHOWN)
        wished = page.value(CROSSOVER) * 10 ** (2 / 20)
        page.press(HANDLE, "ArrowRight", times=2)
        page.until(f"{STILL} && livePage.answers.size")
        Kp = knob(page, "controller.Kp")
        found = crossovers(wb.DigitalLoop(loop(Kp=Kp), 0.01), substeps=2)
        assert min(found, key=lambda one: abs(one - wished)) == pytest.approx(wished, rel=NEAR)
        assert page.complaints == []
