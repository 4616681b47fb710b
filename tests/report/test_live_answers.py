"""Linear answers on a page: decibels, phases, gains of channels and planes by the rules of the printed pictures."""

import numpy as np
import pytest

import workbench as wb
from studies.paper.laws import rival
from tests.support.browsers import needs_node
from tests.support.linear_answers import answer_of
from tests.support.live_figures import NUMBERS, ROOM
from tests.support.node import answered
from workbench.design.frequency import CertifiedValue
from workbench.design.frequency.frequency_axis import phases
from workbench.report.loop_pictures import PoleZeroSet, nyquist_figure, pole_zero_map
from workbench.report.loop_pictures.margin_words import fall_in_decibels
from workbench.report.loop_pictures.pole_maps import _rings
from workbench.report.pictures.loop_gain_table import least_damping
from workbench.report.pictures.loop_gains import channel_gains
from workbench.study.document.frequency_curves import FrequencyCurve

pytestmark = needs_node
FILES = ("curves", "rulers", "planes", "knobs", "tables", "answers", "holds")
OMEGA = np.geomspace(0.1, 300.0, 200)


def said(body, given=None):
    """What a script returns that finds `given` under this name, and `answerOf`, which makes an answer of plain data."""
    program = "\n".join((ROOM / f"{name}.js").read_text("utf-8") for name in FILES)
    make = """const arrays = (one) => ({re: numbers(one.re), im: numbers(one.im)});
      const answerOf = ([plain, about]) => new LoopAnswer({...plain, omega: numbers(plain.omega), L: arrays(plain.L),
        poles: arrays(plain.poles), openPoles: arrays(plain.openPoles)}, about);"""
    return answered(f"{program}\n{NUMBERS}\n{make}\n{body}", given)


def motor_loop(**gains):
    motor = wb.DCMotor()
    law = wb.PID(motor.outputs, motor.inputs, **{"Kp": 100.0, "Ki": 200.0} | gains)
    return wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0, time=0.1))


def given_of(linear, omega=OMEGA):
    return [answer_of(linear, omega), {"channels": linear.channels, "period": linear.period}]


@pytest.fixture(scope="module")
def motor():
    return wb.linear_loop(motor_loop())


@pytest.fixture(scope="module")
def arm():
    return wb.linear_loop(rival("FS", "PID"), at_rest=False)


def test_the_phase_has_no_jumps_and_begins_where_the_printed_one_does():
    random = np.random.default_rng(3)
    cases = []
    for _ in range(60):
        poles = random.normal(size=int(random.integers(1, 6))) + 1j * random.normal()
        order = int(random.integers(0, 3))
        values = random.normal() / (1j * OMEGA) ** order / np.prod([1j * OMEGA - p for p in poles], axis=0)
        values[random.random(len(values)) < 0.05] = np.nan
        cases.append(values)
    plain = [[[None if x != x else x for x in part.tolist()] for part in (v.real, v.imag)] for v in cases]
    body = "const w = numbers(given[0]); return given[1].map(([re, im]) => [...phasesOf(w, numbers(re), numbers(im))]);"
    for values, told in zip(cases, said(body, [OMEGA.tolist(), plain]), strict=True):
        found = np.array([np.nan if x is None else x for x in told])
        np.testing.assert_allclose(found, phases(OMEGA, values), atol=1e-9)  # rounding of some turns of 360 degrees


@pytest.mark.parametrize("name", ["motor", "arm"])
def test_the_gain_of_a_channel_is_that_with_the_others_closed(name, request):
    linear = request.getfixturevalue(name)
    count = len(linear.channels)
    body = """const a = answerOf(given);
      return [...Array(a.count).keys()].map((i) => [[...a.gain(i).re], [...a.gain(i).im]]);"""
    told = np.array(said(body, given_of(linear)))
    found = told[:, 0] + 1j * told[:, 1]
    L, S = (linear.response(OMEGA, kind).values for kind in ("L", "S"))
    for i in range(count):
        np.testing.assert_allclose(found[i], channel_gains(L)[:, i], rtol=1e-12)
        # 1 / (1 + L_i) is the sensitivity there; the conditions of both roads leave some digits
        np.testing.assert_allclose(1 / (1 + found[i]), S[:, i, i], rtol=1e-9)


def test_crossovers_are_marked_on_the_curves_that_are_drawn(arm):
    body = """const a = answerOf(given); return [...Array(a.count).keys()].map((i) =>
      ["gain margins", "phase margins"].map((of) => a.crossovers(i, of)));"""
    told = said(body, given_of(arm))
    gains = channel_gains(arm.response(OMEGA, "L").values)
    marked = 0
    for i, (drops, turns) in enumerate(told):
        for omega, base, end in drops:
            assert base == 0
            heights = 20 * np.log10(np.abs(gains[:, i]))
            assert end == pytest.approx(np.interp(omega, OMEGA, heights), abs=0.2)  # between two frequencies
        for omega, base, end in turns:
            assert base % 360 == 180
            assert end == pytest.approx(np.interp(omega, OMEGA, phases(OMEGA, gains[:, i])), abs=0.5)
            marked += 1
    assert marked


def test_a_nyquist_plane_and_a_map_of_poles_have_the_printed_limits(motor):
    body = 'const a = answerOf(given); return ["imaginary part", "poles of"].map((one) => a.range([one], [0]));'
    told = said(body, given_of(motor))
    curve = FrequencyCurve("L", OMEGA, motor.response(OMEGA, "L").values[:, 0, 0])
    poles = np.array([pole.value for pole in motor.poles])
    sets = [PoleZeroSet("closed", poles), PoleZeroSet("cut", motor.L.poles())]
    for range_of, figure in zip(told, (nyquist_figure("n", "", [curve]), pole_zero_map("p", "", sets)), strict=True):
        (panel,) = figure.panels
        assert range_of["x"] == pytest.approx(panel.xlim)
        assert range_of["y"] == pytest.approx(panel.ylim)


@pytest.mark.parametrize("most", [0.03, 1.0, 4.0, 73.0, 5e3])
def test_a_map_of_poles_has_the_printed_rings(most):
    assert said("return ringsUpTo(given);", most) == pytest.approx(_rings(0.0, most))


def test_the_lines_of_a_computers_map_lie_at_the_same_natural_frequency_and_damping():
    period = 0.01
    lines = said("return poleGrid({low: -1.2, high: 1.2}, {low: -1.2, high: 1.2}, given);", period)
    assert len(lines) > 20
    for line in lines:
        x, y = np.array(line["points"]).T
        inner = np.hypot(x, y) > 1e-9
        s = np.log(x[inner] + 1j * y[inner]) / period
        s = s[np.abs(s.imag) < 0.999 * np.pi / period]  # beyond, a logarithm has another branch
        s = s[np.abs(s) > 1e-6]
        damping, size = -s.real / np.abs(s), np.abs(s)
        assert np.ptp(damping) < 1e-6 or np.ptp(size) < 1e-6 * size.max()


def test_a_table_says_the_numbers_or_why_there_are_none(motor):
    cells = [
        {"quantity": name, "channel": 0}
        for name in ("gain margin", "phase margin", "Ms", "disk margin", "largest real part of a pole",
                     "least damping of a pole")
    ]  # fmt: skip
    body = "const a = answerOf(given[0]); return given[1].map((cell) => a.value(cell));"
    told = said(body, [given_of(motor), cells])
    margins, poles = motor.margins()["v"].margins, np.array([pole.value for pole in motor.poles])
    numbers = margins.phase_margin.value, margins.Ms.gain.value, motor.disk_margin.alpha, poles.real.max()
    assert told[0] == "no limit"
    assert told[1:] == pytest.approx([*numbers, least_damping(poles, None)])
    unstable = wb.linear_loop(motor_loop(Kp=-100.0))
    assert said(body, [given_of(unstable), cells])[:4] == ["unstable"] * 4


def test_a_table_says_by_how_much_a_gain_may_fall_as_the_printed_one_does(motor):
    body = """const a = answerOf(given); return [0.25, 0].map((low) => {
      a.margins[0].gainMargin = {low, high: Infinity};
      return a.value({quantity: "gain may fall by", channel: 0}); });"""
    assert said(body, given_of(motor)) == [pytest.approx(20 * np.log10(4)), "no limit"]
    printed = fall_in_decibels(CertifiedValue(0.25, 0.24, 0.26))
    assert printed.value == pytest.approx(20 * np.log10(4))
    assert printed.low < printed.value < printed.high


def test_equal_axes_grow_together_and_hold_what_is_asked():
    body = """const printed = (low, high) => ({scale: "linear", low, high, fixed: false}), letters = {size: 8};
      const x = new LiveRuler(printed(-2, 2), 0, 200, letters), y = new LiveRuler(printed(-1, 1), 0, -100, letters);
      const moved = fitEqual(x, y, ...given); return [moved, [x.low, x.high], [y.low, y.high]];"""
    assert said(body, [[-1, 1], [-1, 1]]) == [[False, False], [-2, 2], [-1, 1]]
    moved, across, up = said(body, [[-7, 1], [-1, 1.5]])
    assert moved == [True, True]
    assert across[0] <= -7
    assert up[1] >= 1.5
    assert (across[1] - across[0]) / 200 == pytest.approx((up[1] - up[0]) / 100)
