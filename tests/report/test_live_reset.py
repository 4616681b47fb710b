"""The buttons of a live page: none comes below the pointer when one is pressed, and what a reset took comes back."""

import pytest

import workbench as wb
from studies.performance.chromium import open_page
from tests.support.browsers import needs_chromium
from tests.support.compilers import needs_llvmlite
from tests.support.live_pages import data_of, write_page

pytestmark = [needs_chromium, needs_llvmlite]

KNOBS = (("Kp", "V s/rad", "controller.Kp", 10.0, 1000.0, True), ("Ki", "V/rad", "controller.Ki", 1.0, 1000.0, True))
IDLE = "livePage.flight && !livePage.flight.fine.size && !livePage.held"
PLACES = """JSON.stringify([...document.querySelectorAll('.bench-buttons button')].map((button) => {
  const box = button.getBoundingClientRect(); return [box.x, box.y, box.width, box.height].map(Math.round); }))"""
BUTTON = "[...document.querySelectorAll('.bench-buttons button')].find((button) => button.textContent === '%s')"
CLIPBOARD = """Object.defineProperty(navigator, 'clipboard', {configurable: true,
  value: {writeText: async (text) => { %s }}})"""
WIDTHS = (360, 1400)  # pixels: the bench at the bottom, and at the side


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    motor = wb.DCMotor()
    law = wb.PID(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0)
    loop = wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0))
    data = data_of({("speed", "PID"): loop.ode()}, 1e-3, 1.0, 0.01, KNOBS) | {"python": "scores = turned({values})"}
    return write_page(tmp_path_factory.mktemp("live"), data)


@pytest.fixture(params=WIDTHS)
def page(request, path, browser):
    with open_page(path, browser=browser) as page:
        page.call(
            "Emulation.setDeviceMetricsOverride", width=request.param, height=800, deviceScaleFactor=1, mobile=False
        )
        page.click(".bench-handle")
        page.until("livePage.data")
        page.value("document.fonts.ready.then(() => true)")
        yield page


def press(page, name):
    page.value(f"{BUTTON % name}.click()")


def turn(page, *values):
    for place, value in enumerate(values):
        page.value(f"livePage.bench.knobs[{place}].turn({value})")
    page.until(IDLE)


def numbers(page):
    return page.value("livePage.bench.state.values.slice()")


def fields(page):
    return page.value("livePage.bench.knobs.map((knob) => Number(knob.field.value))")


def test_no_button_moves_when_a_text_is_copied(page):
    page.value(CLIPBOARD % "window.clipped = text;")
    turn(page, 321.5)
    before = page.value(PLACES)
    for name in ("Copy as Python", "Copy link"):
        press(page, name)
        page.until(f"{BUTTON % 'Copied'} !== undefined")
        assert page.value(PLACES) == before
        page.value("new Promise((done) => setTimeout(done, 1600))")  # it says so for 1.5 s
        assert page.value(PLACES) == before
        assert page.value(f"{BUTTON % name} !== undefined")


def test_a_text_that_is_copied_twice_at_once_leaves_the_button_its_name(page):
    page.value(CLIPBOARD % "window.clipped = text;")
    press(page, "Copy as Python")
    page.until(f"{BUTTON % 'Copied'} !== undefined")
    press(page, "Copied")
    page.value("new Promise((done) => setTimeout(done, 1700))")
    assert page.value(f"{BUTTON % 'Copy as Python'} !== undefined")


def test_no_button_moves_where_a_text_is_shown_to_be_copied_by_hand(page):
    page.value(CLIPBOARD % "throw new Error('not here');")
    turn(page, 321.5)
    before = page.value(PLACES)
    press(page, "Copy as Python")
    page.until("!livePage.bench.copied.hidden")
    assert page.value(PLACES) == before


def test_a_reset_of_all_knobs_is_undone_by_keyboard(page):
    assert page.value(f"{BUTTON % 'Undo'}.disabled")  # there is nothing to undo
    printed = numbers(page)
    turn(page, 321.5, 70.0)
    page.value(f"{BUTTON % 'All to baseline'}.focus()")  # which brings it into sight, where the bench is low
    before = page.value(PLACES)
    strike(page)
    assert numbers(page) == fields(page) == printed
    assert page.value(PLACES) == before
    assert page.value(f"document.activeElement === {BUTTON % 'Undo'}")  # the reader is left at the way back
    strike(page)
    assert numbers(page) == fields(page) == [321.5, 70.0]
    page.until(IDLE)
    page.until("location.hash.includes('Kp:321.5')")
    assert page.complaints == []


def test_a_second_click_upon_a_reset_resets_nothing_more(page):
    turn(page, 321.5, 70.0)
    press(page, "All to baseline")
    press(page, "All to baseline")
    turn(page, 55.0)
    press(page, "Undo")
    assert numbers(page) == [321.5, 70.0]
    press(page, "Undo")  # and what was turned since comes back by the same button
    assert numbers(page) == [55.0, 200.0]


def strike(page):
    """The Enter key, as a reader strikes it."""
    for kind in ("keyDown", "keyUp"):
        page.call("Input.dispatchKeyEvent", type=kind, key="Enter", code="Enter", windowsVirtualKeyCode=13, text="\r")
