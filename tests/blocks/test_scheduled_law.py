"""Gain scheduling: the numbers of a law between points, as SciPy interpolates them, and the loop that results."""

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

import workbench as wb
from tests.support.plain_plants import SPEED, VOLTAGE, Turntable
from workbench.blocks.laws import PID, Cascade, ScheduledLaw

POINTS, GAINS = np.array([-1.0, 0.5, 1.0, 4.0]), np.array([2.0, 3.0, 1.5, 4.0])


def laws(gains=GAINS, **numbers):
    return tuple(PID(SPEED, VOLTAGE, Kp=k, Ki=2 * k, **numbers) for k in gains)


def test_between_the_points_the_numbers_are_on_a_cubic_whose_slopes_are_those_of_parabolas():
    law = ScheduledLaw(laws(), SPEED, POINTS)
    slopes = np.gradient(GAINS, POINTS)  # second order inside, of first order at the ends
    spline = CubicHermiteSpline(POINTS, GAINS, slopes)
    for value in np.linspace(-1, 4, 41):
        np.testing.assert_allclose(law.at(value).Kp, spline(value), rtol=1e-14)  # a few roundings
    assert [law.at(value).Kp.item() for value in POINTS] == GAINS.tolist()


def test_beyond_the_ends_the_numbers_are_those_of_the_ends():
    for rule in ("cubic", "linear"):
        law = ScheduledLaw(laws(), SPEED, POINTS, interpolation=rule)
        assert (law.at(-7.0).Kp.item(), law.at(9.0).Kp.item()) == (2.0, 4.0)


def test_the_linear_rule_is_that_of_numpy():
    law = ScheduledLaw(laws(), SPEED, POINTS, interpolation="linear")
    for value in np.linspace(-2, 5, 36):
        np.testing.assert_allclose(law.at(value).Ki, 2 * np.interp(value, POINTS, GAINS), rtol=1e-14)


def run(law, period=None):
    reference = wb.Ramp("omega", "rad/s", 1.0)
    loop = wb.ClosedLoop(Turntable(), controller=law, reference=reference)
    if period:
        return wb.simulate(wb.DigitalLoop(loop, period), until=2.0)
    return wb.simulate(wb.rk4(loop.ode(), 1e-3), until=2.0, every=0.1)


@pytest.mark.parametrize("period", [None, 0.05])
def test_laws_that_are_all_alike_give_the_run_of_one_of_them(period):
    alone = PID(SPEED, VOLTAGE, Kp=3.0, Ki=2.0, Kd=0.1)
    scheduled = run(ScheduledLaw((alone,) * 3, SPEED, points=[0.0, 1.0, 2.0]), period)
    # the weights sum to one but for their last digit, and the plant is stable
    np.testing.assert_allclose(scheduled["omega"], run(alone, period)["omega"], rtol=1e-12, atol=1e-14)


def test_nested_laws_are_interpolated_in_all_their_parts():
    def cascade(k):
        return Cascade(PID(wb.layout(theta="rad"), SPEED, Kp=k), PID(SPEED, VOLTAGE, Kp=2 * k))

    law = ScheduledLaw((cascade(1.0), cascade(3.0)), SPEED, points=[0.0, 1.0]).at(0.5)
    assert (law.outer.Kp.item(), law.inner.Kp.item()) == (2.0, 4.0)
    assert law.reads.names == ("theta", "omega")


def test_the_matrices_of_a_linear_law_are_interpolated_too():
    import control

    first, last = (
        wb.LinearLaw(control.ss([[-a]], [[1.0]], [[a]], [[0.0]], inputs="omega", outputs="v"), error=True)
        for a in (1.0, 3.0)
    )
    law = ScheduledLaw((first, last), SPEED, points=[0.0, 2.0]).at(1.0)
    assert (law.system.A.item(), law.system.C.item()) == (-2.0, 2.0)


def test_a_signal_that_no_law_takes_becomes_one_that_the_scheduled_law_reads_or_follows():
    angle = wb.layout(theta="rad")
    assert ScheduledLaw(laws(), angle, POINTS).reads.names == ("omega", "theta")
    assert ScheduledLaw(laws(), angle, POINTS, source="reference").follows.names == ("omega", "theta")
    assert ScheduledLaw(laws(), SPEED, POINTS, source="reference").reads.names == ("omega",)


def test_each_number_of_each_law_is_a_parameter_of_the_loop():
    loop = wb.ClosedLoop(
        Turntable(), controller=ScheduledLaw(laws(), SPEED, POINTS), reference=wb.Step("omega", "rad/s", 1.0)
    )
    assert "controller.laws[3].Kp" in loop.ode().parameters.names


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"laws": laws()[:1], "points": [1.0]}, "a law for each of two or more points; got 1"),
        ({"points": [0.0, 1.0]}, "one number for each of the laws"),
        ({"points": [0.0, 1.0, 1.0, 2.0]}, "must increase"),
        ({"signal": wb.layout(theta="rad", omega="rad/s")}, "a layout of one number, as `layout.*; it has 2"),
        ({"signal": wb.layout(omega="m/s")}, r"takes 'omega' in \[m/s\], where its laws take it in \[rad/s\]"),
        ({"laws": (*laws()[:3], PID(SPEED, VOLTAGE, Kp=1.0, anti_windup="none"))}, "laws.3. differ in `anti_windup`"),
        ({"laws": (*laws()[:3], PID(SPEED, VOLTAGE, Kp=1.0, low=-1.0, high=1.0))}, "laws.3. differ in `low`"),
        ({"laws": (*laws()[:3], laws()[3].run_every(0.1))}, "laws.3. has one of 0.1 s"),
        ({"source": "wish"}, "'estimate'.*'reference'"),
    ],
)
def test_what_is_no_schedule_is_refused_by_name(change, sentence):
    with pytest.raises((ValueError, LookupError), match=sentence):
        ScheduledLaw(**({"laws": laws(), "signal": SPEED, "points": POINTS} | change))
