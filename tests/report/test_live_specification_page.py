"""A specification on a live page: a limit is turned, and the knobs of the PID, the pictures and a sentence follow."""

import json
import re

import pytest

import workbench as wb
from studies.performance.chromium import open_browser, open_page
from tests.support.browsers import needs_chromium
from tests.support.compilers import needs_llvmlite

MOTOR = wb.DCMotor()
GAINS = (wb.Knob("Kp", "controller.Kp", 0.1, 500.0, log=True), wb.Knob("Ki", "controller.Ki", 0.1, 5000.0, log=True))
KD, INERTIA = wb.Knob("Kd", "controller.Kd", 0.0, 5.0), wb.Knob("inertia", "plant.J", 0.005, 0.05)
TOLD = "document.querySelector('.bench-told').textContent.replaceAll('\\u00a0', ' ')"
STILL = "!livePage.specifications[0].pursuit.isSeeking && livePage.flight && !livePage.flight.fine.size"
STILL += " && !livePage.held && !livePage.late.size"
BEGINNING = "A turn of a limit moves Kp and Ki."


def loop():
    law = wb.PID(MOTOR.outputs, MOTOR.inputs, Kp=2.0, Ki=5.0, Kd=0.02)
    return wb.ClosedLoop(MOTOR, controller=law, reference=wb.Step("omega", "rad/s", 1.0, time=0.1))


def written(*turned):
    return wb.live(loop(), until=0.5, knobs=turned)


def data_of(page):
    return json.loads(re.search(r'id="live">(.*?)</script>', page.text, re.DOTALL)[1])["specifications"]


@pytest.fixture(scope="module")
def opened(tmp_path_factory):
    path = written(*GAINS, KD, INERTIA, wb.PidSpecification("robustness")).write(
        tmp_path_factory.mktemp("s") / "m.html"
    )
    with open_browser() as browser, open_page(path, browser=browser) as page:
        page.until("Boolean(livePage.specifications)")
        yield page


@pytest.fixture
def page(opened):
    opened.value("livePage.bench.reset()")
    opened.value("Object.assign(livePage.specifications[0].target, {Ms: 1.4, Mt: 2.5, count: 2})")
    opened.until(f"!livePage.answers.size && {TOLD} !== ''")
    yield opened
    assert opened.complaints == []


def turn(page, limit, value):
    page.value(f"livePage.specifications[0].limits[{limit}].turn({value})")


def knobs(page):
    return page.value("Object.fromEntries(livePage.data.knobs.map(({name}, i) => [name, livePage.state.values[i]]))")


def shown(page):
    """The margins that the page shows for the loop of now."""
    page.until(f"{STILL} && livePage.answers.size")
    return page.value("(({Ms, Mt}) => [Ms, Mt])([...livePage.answers.values()][0].answer.margins[0])")


@needs_chromium
@needs_llvmlite
def test_a_turned_limit_moves_the_knobs_of_the_pi_and_the_margins_show_it(page):
    turn(page, 0, 1.6)
    page.until(f"{TOLD}.startsWith('Kp = ')")
    assert shown(page)[0] == pytest.approx(1.6, rel=5e-4)
    found = knobs(page)
    assert (found["Kd"], found["inertia"]) == (0.02, MOTOR.J)
    law = wb.PID(MOTOR.outputs, MOTOR.inputs, Kp=found["Kp"], Ki=found["Ki"], Kd=0.02)
    again = wb.ClosedLoop(MOTOR, controller=law, reference=wb.Step("omega", "rad/s", 1.0, time=0.1))
    assert wb.linear_loop(again).margins()["v"].margins.Ms.gain.value == pytest.approx(1.6, rel=5e-4)
    assert "The loop has Ms = 1.600 and Mt = " in page.value(TOLD)


@needs_chromium
@needs_llvmlite
def test_after_another_knob_the_page_offers_to_meet_the_limits_again(page):
    turn(page, 0, 1.5)
    page.until(f"{TOLD}.startsWith('Kp = ')")
    before = knobs(page)["Ki"]
    page.value("livePage.bench.knobs[3].turn(0.02)")
    page.until(f"{TOLD}.startsWith('A knob has been turned since')")
    page.value("livePage.specifications[0].again.click()")
    page.until(f"{TOLD}.startsWith('Kp = ')")
    assert shown(page)[0] == pytest.approx(1.5, rel=5e-4)
    assert knobs(page)["Ki"] != before
    assert knobs(page)["inertia"] == 0.02
    page.value("livePage.bench.reset()")
    page.until(f"{TOLD} === '{BEGINNING}'")


@pytest.mark.heavy
@needs_chromium
@needs_llvmlite
def test_the_derivative_moves_if_the_reader_asks_for_it_and_the_limit_of_T_holds(page):
    page.value("livePage.specifications[0].wish({count: 3, Mt: 1.2})")
    page.until(f"{TOLD}.startsWith('Kp = ')")
    Ms, Mt = shown(page)
    assert max(Ms / 1.4, Mt / 1.2) == pytest.approx(1, abs=5e-4)
    assert knobs(page)["Kd"] > 0.02


@pytest.mark.heavy
@needs_chromium
@needs_llvmlite
def test_limits_out_of_reach_leave_the_knobs_and_say_so(tmp_path):
    gains = (wb.Knob("Kp", "controller.Kp", 1.0, 200.0), wb.Knob("Ki", "controller.Ki", 2.0, 5000.0))
    delayed = wb.DigitalLoop(loop(), 0.25, delay=True)
    made = wb.live(
        delayed, until=1.0, h=0.05, knobs=(*gains, wb.PidSpecification("robustness", Ms=(1.01, 1.5), Mt=None))
    )
    with open_page(made.write(tmp_path / "weak.html")) as page:
        page.until("Boolean(livePage.specifications)")
        turn(page, 0, 1.01)
        page.until(f"{TOLD}.startsWith('No Kp')")
        assert page.value(TOLD) == (
            "No Kp from 1 to 200 and Ki from 2 to 5000 give a stable loop with Ms ≤ 1.01. "
            "The knobs stay where they are."
        )
        assert knobs(page) == {"Kp": 2.0, "Ki": 5.0}
        assert page.complaints == []


@needs_llvmlite
def test_the_page_of_a_pid_of_one_signal_has_a_specification_and_others_have_none():
    (one,) = data_of(wb.live(loop(), until=0.1))
    assert (one["loop"], one["channel"], len(one["knobs"])) == (0, 0, 3)
    assert data_of(written(*GAINS)) == []
    assert data_of(wb.live(loop().ode(), until=0.1)) == []


@needs_llvmlite
@pytest.mark.parametrize(
    ("turned", "sentence"),
    [
        ((GAINS[0],), "turns 'controller.Ki', which is no knob of this page"),
        ((wb.Knob("Kp", "controller.Kp", 0.5, 2.0, share=True), GAINS[1]), "turns a share, or several numbers"),
        ((*GAINS, wb.PidSpecification("b", channel="w")), "no 'w' among the 1 channels of this loop"),
    ],
)
def test_a_specification_that_fits_no_loop_is_refused_in_one_sentence(turned, sentence):
    with pytest.raises((ValueError, LookupError), match=sentence):
        written(*turned, wb.PidSpecification("a"))


@needs_llvmlite
def test_a_loop_without_linear_pictures_is_refused():
    with pytest.raises(ValueError, match="needs a loop on this page with linear pictures"):
        wb.live(loop().ode(), until=0.1, knobs=(*GAINS, wb.PidSpecification("a")))


@pytest.mark.parametrize("wrong", [{"name": " "}, {"law": ""}, {"Ms": (1.0, 2.0)}, {"Mt": (2.0, 1.5)}])
def test_ranges_begin_above_one_and_rise(wrong):
    with pytest.raises(ValueError, match=r"`PidSpecification\("):
        wb.PidSpecification(**{"name": "a"} | wrong)


def test_the_gains_of_a_component_have_its_place():
    assert wb.PidSpecification("a", law="controller[1]").paths[0] == "controller.Kp[1]"
