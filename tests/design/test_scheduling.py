"""Gain scheduling of a reactor through its unstable range: operating points, and the check at and between them."""

import numpy as np
import pytest

import workbench as wb

TEMPERATURE, COOLANT = wb.layout(T="K"), wb.layout(T_c="K")
POINTS = np.array([320.0, 335.0, 350.0, 365.0])


@pytest.fixture(scope="module")
def family():
    return wb.scheduling.operating_family(wb.open_loop(wb.StirredTank()), {"T": POINTS})


def scheduled(family, gains=(3.0, 4.0, 6.0, 5.0)):
    laws = tuple(
        wb.PID(TEMPERATURE, COOLANT, Kp=k, Ki=k / 30, N=1.0, u0=u) for k, u in zip(gains, family.u.ravel(), strict=True)
    )
    return wb.ScheduledLaw(laws, TEMPERATURE, POINTS)


def loop_with(law):
    return lambda T: wb.ClosedLoop(wb.StirredTank(T=T), controller=law, reference=wb.Constant("T", "K", T))


def test_the_equation_rests_at_each_point_of_a_family(family):
    ode = wb.open_loop(wb.StirredTank())
    for x, u, model in zip(family.x, family.u, family.models, strict=True):
        row = ode.parameters.pack({"T_c": u})[0] if "T_c" in ode.parameters else None
        assert row is None or np.abs(ode.rate_at(0.0, x, row)).max() < 1e-12
        np.testing.assert_array_equal(model.point.x0, x)


def test_the_middle_of_the_reactor_is_unstable_and_the_scheduled_loop_is_stable_between_all_points(family):
    assert [model.poles().real.max() > 0 for model in family.models] == [False, False, True, True]
    law = scheduled(family)
    check = wb.scheduling.check_schedule(law, loop_with(law), between=1)
    assert check.stable
    assert (len(check.values), check.reasons) == (7, {})
    # the slopes jump at both ends, where the loop is linearised a millionth of 15 K inside
    np.testing.assert_allclose(check.values[::2], POINTS, rtol=0, atol=2e-5)


def test_the_slope_of_the_schedule_is_a_part_of_the_linear_loop_and_not_of_the_held_one(family):
    law, T = scheduled(family), 342.0
    # by hand: u = u0(T) + Kp (r - T) + I at rest r = T, so du/dT = u0'(T) - Kp, beside the growth of the integral
    h = 1e-4
    slope = (law.at(T + h).u0 - law.at(T - h).u0) / (2 * h)
    scale = wb.linear_loop(loop_with(law)(T)).response(np.array([1e3])).values[0, 0, 0]
    held = wb.linear_loop(loop_with(law.at(T))(T)).response(np.array([1e3])).values[0, 0, 0]
    Kp = law.at(T).Kp
    # at 1000 rad/s the integral is Ki / 1000 of the gain; the difference quotient has 8 digits
    np.testing.assert_allclose(scale / held, (Kp - slope) / Kp, rtol=1e-4)


def test_a_loop_that_is_unstable_between_its_points_is_found(family):
    law = scheduled(family, gains=(3.0, 4.0, 0.05, 5.0))
    check = wb.scheduling.check_schedule(law, loop_with(law), between=1)
    assert not check.stable
    assert np.isinf(check.Ms).any()
    assert "stable at" in str(check)


def test_the_nonlinear_loop_follows_a_ramp_through_the_unstable_range_within_its_lag(family):
    loop = wb.ClosedLoop(
        wb.StirredTank(c_A=family.x[0, 0], T=320.0),
        controller=scheduled(family),
        reference=wb.Trapezoid("T", "K", 365.0, speed=0.05, acceleration=1e-3, start=320.0),
    )
    run = wb.simulate(wb.rk4(loop.ode(), 0.5), until=1200.0, every=5.0)
    assert abs(run["T"].ravel()[-1] - 365.0) < 1e-3


@pytest.mark.parametrize(
    ("targets", "sentence"),
    [
        ({"T": 350.0}, "the same number of values .*; got none with several values"),
        ({"T": [320.0, 330.0], "T_c": [1.0, 2.0, 3.0]}, "got T: 2, T_c: 3"),
        ({"T": [320.0, np.nan]}, "'T' must be finite numbers"),
        ({"T": [320.0, 330.0], "T_c": 300.0, "c_A": 0.1}, "no input or no state is free|must have an input"),
    ],
)
def test_targets_that_are_no_family_are_refused(targets, sentence):
    with pytest.raises((ValueError, wb.linear.DesignError), match=sentence):
        wb.scheduling.operating_family(wb.open_loop(wb.StirredTank()), targets)


def test_a_loop_whose_law_is_not_scheduled_is_refused():
    law = wb.PID(TEMPERATURE, COOLANT, Kp=5.0)
    with pytest.raises(ValueError, match="law=.* must be a `ScheduledLaw`"):
        wb.scheduling.check_schedule(law, loop_with(law))


def test_a_loop_with_another_law_is_refused(family):
    with pytest.raises(ValueError, match="a function that returns a `ClosedLoop` or `DigitalLoop` with this law"):
        wb.scheduling.check_schedule(scheduled(family), loop_with(wb.PID(TEMPERATURE, COOLANT, Kp=5.0)))


def test_with_the_linear_rule_the_loop_is_linearised_on_both_sides_of_each_point(family):
    law = wb.ScheduledLaw(scheduled(family).laws, TEMPERATURE, POINTS, interpolation="linear")
    check = wb.scheduling.check_schedule(law, loop_with(law), between=0)
    assert check.stable
    assert len(check.values) == 6
    # the slope of u0 jumps at 335 K, and the gain of the loop with it; the held law has one gain there
    assert abs(check.decay_rates[1] - check.decay_rates[2]) > 1e-4
    assert abs(check.frozen_decay_rates[1] - check.frozen_decay_rates[2]) < 1e-6


@pytest.mark.heavy
def test_a_scheduled_law_in_a_computer_is_checked_by_the_map_of_its_period(family):
    law = scheduled(family)
    loop_at = loop_with(law)
    check = wb.scheduling.check_schedule(law, lambda T: wb.DigitalLoop(loop_at(T), period=1.0), between=0)
    fast = wb.scheduling.check_schedule(law, loop_at, between=0)
    assert check.stable
    # the slowest pole is 0.02 1/s, and a period of 1 s moves it by about half of its square
    np.testing.assert_allclose(check.decay_rates, fast.decay_rates, rtol=0.05)
