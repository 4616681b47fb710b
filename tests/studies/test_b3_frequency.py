"""The loops of b3 over frequency: margins and poles by other roads, and the pages that show them."""

from dataclasses import replace

import numpy as np
import pytest

from studies.b3_any_plant import frequency, frequency_pages, pages
from studies.b3_any_plant.loops import COMPUTER, PID, cut, margins, run
from tests.support.settings_of_b3 import BY_NAME
from workbench.engine import simulate
from workbench.report.pictures.loop_gains import loop_gain
from workbench.study import Case, Results, Study
from workbench.study.case_runs import run as run_study


def test_equal_poles_are_named_once_with_the_slowest_first():
    assert pages.spots(np.array([-2.0, -1 + 3j, -1 - 3j, 0.5])) == "0.5, \N{MINUS SIGN}1 ± 3i, \N{MINUS SIGN}2"
    assert pages.spots(np.array([])) is None
    operating = {row[0]: row[1] for row in pages.plants_table().rows}
    assert operating["buck converter"] == "i = 5 A, v = 15 V, d = 0.5357"


@pytest.mark.parametrize(
    "name",
    ["DC motor", *(pytest.param(name, marks=pytest.mark.heavy) for name in ("buck converter", "cart-pole"))],
)
def test_the_loops_over_frequency_are_those_whose_margins_are_compared(name):
    item = (name, PID)
    found, old = frequency.frequency_answer(item), margins(item)
    assert found.reasons == ()
    # two roads to the same loop gain: the equations at rest, and the loop that was cut where its plant rests
    assert found.continuous.alpha == pytest.approx(old.disk, rel=1e-6)
    assert found.continuous.margins[0].margins.delay_margin.value == pytest.approx(old.delay, rel=1e-6)
    L = np.asarray([complex(cut(BY_NAME[item[0]], item[1])(1j * omega)) for omega in found.omega[::60]])
    np.testing.assert_allclose(found.gains[::60, 0], L, rtol=1e-6)


@pytest.mark.parametrize("name", ["cart-pole", "stirred tank"])
def test_the_plant_rests_at_its_operating_point_in_its_computer(name):
    setting = BY_NAME[name]
    linear = frequency.linear_at_rest(setting, PID, computer=True)
    rest = linear.states.unpack(linear.x0[np.newaxis])
    for state, wanted in setting.open.states.unpack(setting.point.x).items():
        assert np.squeeze(rest[f"plant.{state}"]) == pytest.approx(np.squeeze(wanted), rel=1e-9, abs=1e-9)


def test_the_slowest_pole_of_a_motor_in_its_computer_is_that_of_its_run():
    own = run(BY_NAME["DC motor"], PID, computer=True)
    step = replace(own.loop, instruments=None).ode().step(8)
    out = simulate(step, until=2.0, every=own.loop.period)
    off = out["omega"][0].ravel()[20:80] - 1.0  # when the voltage has left its limit, and three poles are left
    lags = np.stack([off[2 - k : -1 - k] for k in range(3)], axis=1)
    coefficients, *_ = np.linalg.lstsq(lags, off[3:], rcond=None)
    answer = frequency.answer_of(frequency.linear_at_rest(BY_NAME["DC motor"], PID, computer=True))
    # the run is linear from there on; the fourth pole has decayed to 1e-9
    assert np.abs(np.roots([1.0, *-coefficients])).max() == pytest.approx(abs(answer.largest), rel=1e-6)


def test_a_loop_without_a_linear_answer_says_why():
    lost = frequency.FrequencyAnswer(None, None, np.zeros(0), np.zeros((0, 0), complex), ("It does not rest.",) * 2)
    held = Results(works={"frequency": (lost,) * len(frequency.ITEMS)})
    first, *_ = frequency_pages.frequency_blocks(BY_NAME["DC motor"], held)
    assert first.text == "DC motor, LQG: no linear answer. It does not rest."
    assert {row[3].words for row in frequency_pages.frequency_table(held).rows} == {"no linear answer"}


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.release] * (name == "cart-pole")) for name in frequency_pages.LIVE_LOOPS],
)
def test_the_pictures_that_a_reader_turns_have_the_margins_of_the_table(name):
    law = frequency_pages.LIVE_LOOPS[name]
    own_run = run(BY_NAME[name], law.removesuffix(f" {COMPUTER}"), computer=COMPUTER in law)
    case = Case(name, law, own_run)
    own = run_study(Study("s", "T", "Q?", "M.", sections=lambda results: [], cases=(case,)))
    shown = loop_gain(own[name, law])
    at = frequency.linear_at_rest(BY_NAME[name], law.removesuffix(f" {COMPUTER}"), computer=COMPUTER in law)
    ((_, held),) = at.margins().items()
    # both seek the same rest by Newton's method, from the start of the run and from the operating point
    assert shown.margins[0].margins.phase_margin.value == pytest.approx(held.margins.phase_margin.value, rel=1e-6)
    assert shown.margins[0].margins.Ms.gain.value == pytest.approx(held.margins.Ms.gain.value, rel=1e-6)
    assert len(frequency_pages.live_blocks(BY_NAME[name], own)) == 7  # two paragraphs, four figures and a table
