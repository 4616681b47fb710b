"""A thousand rows have the answers of each of them, through the compiled kernel; a bad row is flagged alone."""

import control
import numpy as np
import pytest

import workbench as wb
from studies.paper.card import PROPOSED_LAW
from studies.paper.linearization import HELD_STATES, LEVEL, POSES, still
from tests.support.cases import heavy_but
from workbench.design.linear.switching_functions import SwitchingFunctions
from workbench.design.linear_loop import linear_loop
from workbench.design.linear_loop.cut_margins import channel_margins, common_margin
from workbench.design.linear_loop.frequency_answers import CutModels, feedback
from workbench.design.linear_loop.loop_model import LoopModel
from workbench.design.linear_loop.row_margins import largest_gains, phase_margins, row_margins

N, OMEGA = 1000, np.geomspace(0.1, 1e3, 200)
RNG = np.random.default_rng(11)
MOTOR = wb.DCMotor()
LAW = wb.PID(MOTOR.outputs, MOTOR.inputs, Kp=100.0, Ki=200.0)
LOOP = wb.ClosedLoop(MOTOR, controller=LAW, reference=wb.Step("omega", "rad/s", 1.0))
INERTIAS = np.linspace(0.005, 0.02, 9)


@pytest.fixture(scope="module")
def proposed():
    """The repaired AOSMC-RGS loop of the paper at rest, cut at the torques, its adapting gains frozen as in a5."""
    return linear_loop(still(PROPOSED_LAW, POSES[LEVEL]), freeze=HELD_STATES[PROPOSED_LAW])


def drawn(linear, name):
    """Draws of a parameter about its own value, each number within a fifth of it."""
    entry = linear.parameters[name]
    own = linear.parameters.unpack(linear.p0[np.newaxis])[name][0]
    return own * RNG.uniform(0.8, 1.2, (N, *entry.shape))


def test_a_thousand_draws_of_the_gains_have_the_answers_of_python_control(proposed):
    names = ("controller.K", "observer.state.L1", "observer.state.L2")
    rows = proposed.rows({name: drawn(proposed, name) for name in names})
    response = rows.response(OMEGA)
    assert response.values.shape == (N, 200, 2, 2)
    assert not rows.flagged_rows.any()
    assert not response.flagged_rows.any()
    assert (response.errors <= 1e-10 * np.abs(response.values)).all()
    model, rounding = rows.models.kind("", "L"), np.finfo(float).eps
    for i in range(0, N, 100):
        theirs = control.frequency_response(model.row(i).system(), OMEGA, squeeze=False).frdata
        # theirs is off by some roundings of the entries, which count near the undamped poles of the arm
        apart = np.abs(response.values[i] - np.moveaxis(theirs, -1, 0))
        assert (apart <= response.errors[i] + 100 * rounding * response.sensitivities[i]).all()


def test_the_margins_of_rows_are_the_certified_ones_of_each(proposed):
    names = ("controller.K", "observer.state.L1")
    values = {name: drawn(proposed, name)[:60] for name in names}
    rows = proposed.rows(values)
    margins = rows.margins
    assert margins.channels == ("tau[0]", "tau[1]")
    for i in (0, margins.worst):
        alone = proposed.rows({name: value[i : i + 1] for name, value in values.items()})
        for k, one in enumerate(channel_margins("", alone.models, margins.channels).values()):
            true = one.margins
            assert margins.Ms[i, k] <= true.Ms.gain.high * (1 + 1e-12)
            assert margins.Ms[i, k] * (1 + margins.error) >= true.Ms.gain.low * (1 - 1e-9)
            np.testing.assert_allclose(margins.disk_margin[i, k], true.disk_margin.value, rtol=1e-6)
            np.testing.assert_allclose(margins.phase_margin[i, k], true.phase_margin.value, rtol=1e-9)
            np.testing.assert_allclose(margins.delay_margin[i, k], true.delay_margin.value, rtol=1e-9)
        assert 0 < margins.disk_margin_of_all[i] <= common_margin("", alone.models).alpha_above
    assert margins.Ms.max() == margins.Ms[margins.worst].max()


def test_a_narrow_peak_is_seen_and_an_unstable_row_has_no_margins():
    # L = k / (s^2 + 2 d s + 1): the peak of S is narrower than any grid for small d
    dampings, K = np.array([1e-4, 1e-2, -0.1]), 0.5
    A = np.array([[[0.0, 1.0], [-1.0, -2 * d]] for d in dampings])
    b, c, d = (np.tile(M, (3, 1, 1)) for M in (np.array([[0.0], [1.0]]), np.array([[K, 0.0]]), np.zeros((1, 1))))
    L = LoopModel(A, b, c, d, ("x", "v"), ("u",), ("u",))
    gain, place = largest_gains(feedback(L, "S"))
    for i in range(2):
        true = wb.stability_margins(L.row(i).system()).margins
        np.testing.assert_allclose(gain[i], true.Ms.gain.value, rtol=2e-7)
        np.testing.assert_allclose(place[i], true.Ms.frequency, rtol=1e-4)  # a peak is flat at its top
        np.testing.assert_allclose(phase_margins(L.row(i))[0], true.phase_margin.value, rtol=1e-9)
    opened = LoopModel(A, b, -c, d, ("x", "v"), ("u",), ("u",))
    found = row_margins("", CutModels(L, opened, (0,), np.zeros(1)), ("u",), np.array([True, True, False]))
    assert np.isnan(found.Ms[2, 0])
    assert np.isfinite(found.Ms[:2]).all()
    assert found.worst == 0


@pytest.mark.heavy
def test_rows_in_a_computer_have_margins_and_rows_with_a_delay_refuse_them():
    digital = linear_loop(wb.DigitalLoop(LOOP, 0.01, delay=True))
    rows = digital.rows({"plant.J": INERTIAS})
    margins = rows.margins
    for i in (0, 8):
        alone = linear_loop(wb.DigitalLoop(LOOP, 0.01, delay=True), values={"plant.J": INERTIAS[i]})
        true = alone.margins()["v"].margins
        np.testing.assert_allclose(margins.Ms[i, 0], true.Ms.gain.value, rtol=1e-6)
        np.testing.assert_allclose(margins.phase_margin[i, 0], true.phase_margin.value, rtol=1e-8)
        np.testing.assert_allclose(margins.delay_margin[i, 0], true.delay_margin.value, rtol=1e-8)
    late = linear_loop(LOOP, delays={"v": 0.01}).rows({"plant.J": INERTIAS})
    with pytest.raises(ValueError, match="without delays"):
        _ = late.margins


def test_feedback_passes_the_errors_of_answers_on():
    late = linear_loop(LOOP, delays={"v": 0.01})
    for of in ("L", "S", "T", "closed"):
        response = late.response(OMEGA, of)
        assert response.errors.shape == response.values.shape
        assert (response.errors > 0).any()
        assert (response.errors <= 1e-9 * np.abs(response.values) + 1e-12).all()  # terms cancel at high frequencies
    # a sensitivity passes through feedback as the error does: compare with a changed entry
    plain, moved = linear_loop(LOOP), linear_loop(LOOP, values={"plant.J": 0.01 * (1 + 1e-8)})
    before, after = plain.response(OMEGA, "S"), moved.response(OMEGA, "S")
    assert (np.abs(after.values - before.values) <= 1.01e-8 * 3 * before.sensitivities).all()


@pytest.mark.heavy
def test_rows_of_a_nonlinear_loop_rest_each_at_its_own_state(proposed):
    name = "plant.arm.links[0].mass"  # not the one in which the law believes
    masses = drawn(proposed, name)
    rows = proposed.rows({name: masses})
    assert np.ptp(rows.x[:, 0]) > 1e-3
    sensitivities = rows.response(OMEGA, "S").values
    for i in (0, 999):
        alone = linear_loop(
            still(PROPOSED_LAW, POSES[LEVEL]), values={name: masses[i]}, freeze=HELD_STATES[PROPOSED_LAW]
        )
        np.testing.assert_allclose(rows.x[i], alone.x0, rtol=1e-9, atol=1e-11)
        np.testing.assert_allclose(sensitivities[i], alone.response(OMEGA, "S").values, rtol=1e-8, atol=1e-10)
        ours, theirs = np.sort_complex(rows.poles[i]), np.sort_complex([pole.value for pole in alone.poles])
        np.testing.assert_allclose(ours, theirs, rtol=1e-6, atol=1e-9)  # two poles at -18.5 1/s


@pytest.mark.parametrize("computer", heavy_but([False, True], False))
def test_each_row_is_the_loop_of_its_values(computer):
    loop = wb.DigitalLoop(LOOP, 0.01, delay=True) if computer else LOOP
    low = OMEGA[OMEGA < 300]
    rows = linear_loop(loop).rows({"plant.J": INERTIAS})
    alone = {i: linear_loop(loop, values={"plant.J": INERTIAS[i]}) for i in (0, 8)}
    for of in ("L", "T", "closed", "open"):
        values = rows.response(low, of).values
        for i, one in alone.items():
            np.testing.assert_allclose(values[i], one.response(low, of).values, rtol=1e-9, atol=1e-13)
    assert rows.stable.all()


def test_a_row_that_is_no_number_is_flagged_and_the_others_keep_their_bits():
    linear, broken = linear_loop(LOOP), INERTIAS.copy()
    broken[3], broken[5] = np.nan, -1.0
    whole, rows = linear.rows({"plant.J": INERTIAS}), linear.rows({"plant.J": broken})
    assert list(np.flatnonzero(rows.flagged_rows)) == [3, 5]
    assert "plant.J" in rows.reasons[3]
    assert "nan" in rows.reasons[3]
    assert "-1" in rows.reasons[5]
    ours, theirs = rows.response(OMEGA), whole.response(OMEGA)
    assert list(np.flatnonzero(ours.flagged_rows)) == [3, 5]
    np.testing.assert_array_equal(ours.values[~rows.flagged_rows], theirs.values[~rows.flagged_rows])
    np.testing.assert_array_equal(rows.poles[~rows.flagged_rows], whole.poles[~rows.flagged_rows])
    assert np.isnan(ours.bode().phase[3]).all()
    assert not rows.stable[3]


@wb.block
class Pendulum(wb.Plant):
    """q'' = a - w^2 sin q - d q' + u, which has no rest for a > w^2."""

    a: float = wb.parameter(default=0.5, unit="rad/s^2")
    w: float = wb.parameter(default=3.0, unit="rad/s")
    d: float = wb.parameter(default=1.0, unit="1/s")
    q: float = wb.initial(default=0.0, unit="rad")
    qd: float = wb.initial(default=0.0, unit="rad/s")
    inputs, outputs = wb.layout(u="rad/s^2"), wb.layout(q="rad", qd="rad/s")

    def rate(self, t, x, u):
        return {"q": x.qd, "qd": self.a + u.u - self.w**2 * np.sin(x.q) - self.d * x.qd}


@wb.block
class Damping(wb.Controller):
    """u = - k qd."""

    k: float = wb.parameter(default=0.5, unit="1/s")
    reads, drives = wb.layout(qd="rad/s"), wb.layout(u="rad/s^2")

    def command(self, t, z, est, ref):
        return {"u": -self.k * est.qd}


def test_a_row_that_does_not_rest_is_flagged_with_the_state_that_moves():
    linear = linear_loop(wb.ClosedLoop(Pendulum(), controller=Damping()))
    pushes = np.array([0.0, 4.5, 20.0])
    rows = linear.rows({"plant.a": pushes})
    assert list(rows.flagged_rows) == [False, False, True]
    assert "plant.q" in rows.reasons[2]
    np.testing.assert_allclose(np.sin(rows.x[:2, 0]), pushes[:2] / 9.0, rtol=1e-9, atol=1e-12)
    s = 1j * OMEGA
    theirs = 0.5 * s / (s**2 + s + 9.0 * np.cos(rows.x[:2, :1]))
    np.testing.assert_allclose(rows.response(OMEGA).values[:2, :, 0, 0], theirs, rtol=1e-10)


def test_rows_beyond_a_bad_common_value_are_refused_in_one_sentence():
    with pytest.raises(ValueError, match="plant.J"):
        linear_loop(LOOP).rows({"plant.J": np.full(4, np.nan)})
    with pytest.raises(LookupError, match="plant.Jay"):
        linear_loop(LOOP).rows({"plant.Jay": INERTIAS})


@pytest.mark.heavy
def test_rows_on_a_corner_whose_pieces_agree_take_their_equations_from_the_first_one():
    law = wb.PID(MOTOR.outputs, MOTOR.inputs, Kp=100.0, Ki=200.0, Kd=10.0, low=-24.0, high=24.0)
    loop = wb.ClosedLoop(MOTOR, controller=law, reference=wb.Step("omega", "rad/s", 1.0, time=0.1))
    linear = linear_loop(loop)
    before = SwitchingFunctions.of.cache_info().misses
    rows = linear.rows({"plant.J": INERTIAS})
    assert SwitchingFunctions.of.cache_info().misses - before <= 2  # the loop, closed and cut
    answers = rows.response(OMEGA).values
    for i in (0, 8):
        single = linear_loop(loop, values={"plant.J": INERTIAS[i]}).response(OMEGA).values
        np.testing.assert_allclose(answers[i], single, rtol=1e-10)  # of two evaluations of the same Jacobians


def test_a_fast_pole_does_not_hide_the_margins_of_a_slow_loop():
    """The filter of a derivative is up to 1e9 times as fast as the peak; held against margins in exact arithmetic."""
    motor = wb.DCMotor()
    law = wb.PID(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0, Kd=1.0)
    loop = wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0))
    numbers = np.array([[15.0, 168.0, 1.96, 6.4e6], [1.14, 5.97, 0.013, 9.3e8], [6.5, 71.7, 2.07, 2.8e7]])
    names = [f"controller.{name}" for name in ("Kp", "Ki", "Kd", "N")]
    rows = wb.linear_loop(loop).rows({name: numbers[:, [i]] for i, name in enumerate(names)}).margins
    for k, values in enumerate(numbers):
        one = wb.linear_loop(loop, values={name: values[[i]] for i, name in enumerate(names)}).margins()["v"]
        # the gap between a peak and the level above it
        assert rows.Ms[k, 0] == pytest.approx(one.Ms.gain.value, rel=1e-6)
        assert rows.phase_margin[k, 0] == pytest.approx(one.phase_margin.value, abs=1e-4)
