"""Dead zone, quantiser and backlash against their describing functions, their hysteresis, and a limit cycle."""

import casadi as ca
import numpy as np
import pytest
from hypothesis import given as example
from hypothesis import settings
from hypothesis import strategies as st

import workbench as wb
from tests.support.equipped_plants import behind

VOLTS = st.floats(-100, 100)
PERIOD = 1.0  # s, of the waves
OMEGA = 2 * np.pi / PERIOD


def static(element, v):
    return behind((element,), lambda t: v + 0 * t, 1e-3)[1][0]


def wave(element, amplitude, h=1e-4, periods=3):
    """Times of the last period of a sine, the sine, and what leaves the element."""
    t, y = behind((element,), lambda t: amplitude * ca.sin(OMEGA * t), periods * PERIOD, h)
    last = (t >= (periods - 1) * PERIOD) & (t < periods * PERIOD - h / 2)
    return t[last], amplitude * np.sin(OMEGA * t[last]), y[last]


def first_harmonic(element, amplitude, h=1e-4):
    """The complex gain from a sine to the first harmonic of the output."""
    t, _, y = wave(element, amplitude, h)
    return 2 * np.mean(y * 1j * np.exp(-1j * OMEGA * t)) / amplitude


@settings(max_examples=6)
@example(VOLTS)
def test_a_saturation_and_its_dead_zone_add_up_to_the_signal(v):
    inside, beyond = static(wb.Saturation("v", -2.0, 1.0), v), static(wb.DeadZone("v", -2.0, 1.0), v)
    assert inside == min(max(v, -2.0), 1.0)
    assert beyond == v - inside


@settings(max_examples=9)
@example(
    VOLTS, st.sampled_from([("nearest", lambda x: np.floor(x + 0.5)), ("down", np.floor), ("toward zero", np.trunc)])
)
def test_a_quantiser_gives_the_multiple_that_its_rule_says(v, rule):
    name, count = rule
    assert static(wb.Quantiser("v", 0.25, name), v) == count(v / 0.25) * 0.25


def test_a_quantum_of_zero_is_no_quantiser_and_a_batch_varies_it():
    loop = wb.ClosedLoop(
        wb.EquippedPlant(wb.DCMotor(), sensors=(wb.Quantiser("omega", 0.0),)),
        controller=wb.PID(wb.DCMotor().outputs, wb.DCMotor().inputs, Kp=100.0),
        reference=wb.Step("omega", "rad/s", 1.0),
    )
    step = wb.rk4(loop.ode(), 1e-3)
    assert step.parameters["plant.sensors[0].quantum"].unit == "rad/s"
    runs = wb.simulate(step, step.parameters.pack({"plant.sensors[0].quantum": [0.0, 0.125]}), until=1.0)
    y, truth = runs["omega"], runs["omega_true"]
    np.testing.assert_array_equal(y[0], truth[0])
    np.testing.assert_array_equal(y[1], np.floor(truth[1] / 0.125 + 0.5) * 0.125)


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_the_first_harmonic_behind_a_dead_zone_is_its_describing_function(share):
    # Gelb and Vander Velde, appendix B: of a dead zone of half-width d = share A, slope 1
    want = 1 - 2 / np.pi * (np.arcsin(share) + share * np.sqrt(1 - share**2))
    # the mean of a wave with corners over 1e4 samples errs by about 1 / 1e8 of it
    assert first_harmonic(wb.DeadZone("v", -2 * share, 2 * share), 2.0) == pytest.approx(want, abs=1e-6)


@pytest.mark.parametrize("ratio", [0.4, 0.6, 1.3, 4.7])
def test_the_first_harmonic_behind_a_quantiser_is_its_describing_function(ratio):
    # the same, for A = ratio q: each step of height q at (i - 1/2) q is a relay with a dead zone
    edges = np.arange(0.5, ratio, 1.0)
    want = 4 / (np.pi * ratio) * np.sum(np.sqrt(1 - (edges / ratio) ** 2))
    # a sample near each of 4 edges a period and step may be on the wrong side: h omega / pi of q / A each
    bound = 4 * len(edges) * 1e-4 * OMEGA / np.pi / ratio
    assert abs(first_harmonic(wb.Quantiser("v", 1.0), ratio) - want) <= bound


def backlash_function(share):
    """The describing function of backlash with half-gap b = share A, from Gelb and Vander Velde, appendix B."""
    c = 1 - 2 * share
    return (np.pi / 2 + np.arcsin(c) + c * np.sqrt(1 - c**2)) / np.pi - 1j * (1 - c**2) / np.pi


@pytest.mark.parametrize("share", [0.1, 0.5, 0.8])
def test_the_first_harmonic_behind_backlash_is_its_describing_function(share):
    T = 2e-3
    N = first_harmonic(wb.Backlash("v", 2 * 1.5 * share, T), 1.5)
    want = backlash_function(share)
    # at rest y is A (omega T)^2 / 2 short, which is 4 / pi of that at most in the first harmonic
    assert abs(N - want) < 2 / np.pi * (OMEGA * T) ** 2 + 1e-6
    assert abs(N - want) > 1e-6  # and that is no rounding


def test_the_loop_of_hysteresis_has_the_area_of_its_parallelogram():
    A, gap = 1.5, 0.8
    _, v, y = wave(wb.Backlash("v", gap, 1e-3), A)
    area = -np.sum((y + np.roll(y, -1)) / 2 * (np.roll(v, -1) - v))
    # sides gap along v and 2 A - gap along y; the wave is traversed so that y is late
    assert abs(area) == pytest.approx(gap * (2 * A - gap), rel=(OMEGA * 1e-3) ** 2 + 1e-5)


def test_backlash_in_contact_is_exact_and_comes_to_rest_short_by_the_square_of_its_time_constant():
    A, gap, shortfalls = 1.0, 0.5, []
    for T in (8e-3, 4e-3):
        _, v, y = wave(wb.Backlash("v", gap, T), A)
        assert np.all(np.abs(y - v) <= gap / 2 + 1e-14)  # of a sine of 6 pi rounded here and there
        shortfalls.append(A - gap / 2 - np.median(y[y > 0.99 * (A - gap / 2)]))
    # the curvature of the wave is A omega^2, and the next term is omega T = 5 % of the first
    np.testing.assert_allclose(shortfalls, [A * OMEGA**2 * T**2 / 2 for T in (8e-3, 4e-3)], rtol=0.05)


def test_a_wave_within_half_a_gap_moves_nothing():
    _, y = behind((wb.Backlash("v", 2.0, 1e-3, start=0.1),), lambda t: 0.1 + ca.sin(9 * t), 2.0)
    np.testing.assert_array_equal(y, 0.1)


@wb.block
class Sum(wb.Plant):
    """x+ = x + v: a plant in discrete time."""

    period = 0.1
    x: float = wb.initial(default=0.0, unit="V")
    inputs = wb.layout(v="V")
    outputs = wb.layout(x="V")

    def update(self, t, x, u):
        return {"x": x.x + u.v}


@wb.block
class Wave(wb.Controller):
    """v = a cos(t)."""

    a: float = wb.parameter(default=0.3, unit="V")
    reads = wb.layout()
    drives = wb.layout(v="V")

    def command(self, t, z, est, ref):
        return {"v": self.a * ca.cos(t)}


def test_a_plant_in_discrete_time_has_its_elements_sample_by_sample():
    gap, zone, quantum = 0.25, 0.05, 0.125
    plant = wb.EquippedPlant(
        Sum(),
        (wb.Backlash("v", gap), wb.DeadZone("v", -zone, zone)),
        (wb.Backlash("x", 2 * gap, start=0.2), wb.Quantiser("x", quantum)),
    )
    run = wb.simulate(wb.ClosedLoop(plant, controller=Wave()).digital(0.1), until=10.0)
    z, x, seen, given = 0.0, 0.0, 0.2, []
    for k in range(101):
        seen = min(max(seen, x - gap), x + gap)
        given.append((x, np.floor(seen / quantum + 0.5) * quantum))
        v = 0.3 * np.cos(0.1 * k)
        z = min(max(z, v - gap / 2), v + gap / 2)
        x += z - min(max(z, -zone), zone)
    np.testing.assert_allclose(run["x_true"].ravel(), [x for x, _ in given], rtol=0, atol=1e-13)  # 100 roundings
    np.testing.assert_allclose(run["x"].ravel(), [y for _, y in given], rtol=0, atol=1e-13)


def play(z, v, gap):
    return min(max(z, v - gap / 2), v + gap / 2)


def test_backlash_without_a_time_constant_moves_at_the_instants_of_a_computer():
    gap, wide, period = 0.5, 0.02, 0.05
    plant = wb.EquippedPlant(
        wb.DisturbedPlant(wb.DCMotor(), by=wb.Sines("v", "V", 0.4, 3.0)),
        (wb.DeadZone("v", -0.05, 0.05), wb.Backlash("v", gap, start=0.1)),
        (wb.Backlash("omega", wide),),
    )
    loop = wb.ClosedLoop(plant, controller=Wave(1.0))
    digital = loop.digital(period, delay=True)
    run = wb.simulate(digital.step(2), until=12.0, every=period)
    command, z, seen = run["v"][0, :, 0], 0.1, 0.0
    for k, (v, omega) in enumerate(zip(command, run["omega_true"][0, :, 0], strict=True)):
        z, seen = play(z, v - np.clip(v, -0.05, 0.05), gap), play(seen, omega, wide)
        assert run["v_applied"][0, k, 0] - 0.4 * np.sin(3 * k * period) == pytest.approx(z, abs=1e-13)
        assert run["omega"][0, k, 0] == pytest.approx(seen, abs=1e-13)
    with pytest.raises(
        ValueError, match=r"'v.driven_side', 'omega.driven_side', which moves at the instants of a computer"
    ):
        loop.ode()
    with pytest.raises(ValueError, match="moves at the instants themselves"):
        digital.with_timing_faults()


def test_backlash_sample_by_sample_is_the_limit_of_the_one_with_a_time_constant():
    def applied(T):
        plant = wb.EquippedPlant(wb.DCMotor(), (wb.Backlash("v", 0.5, T),))
        return wb.simulate(wb.ClosedLoop(plant, controller=Wave(1.0)).digital(0.1).step(40), until=12.0)["v_applied"]

    # the share exp(-period / T) of a jump of the held command, at most 0.75 V, is not remembered at the next one
    np.testing.assert_allclose(applied(None), applied(0.01), rtol=0, atol=0.75 * np.exp(-10) * 1.01)


def test_a_quantised_loop_keeps_the_limit_cycle_that_its_describing_function_predicts():
    # K / (s (s + 1) (s + 2)) has the phase -180 degrees at sqrt(2) rad/s and the gain K / 6 there: with K = 5.5 the
    # loop is stable without the quantiser, whose describing function is at most 4 / pi
    K, q = 5.5, 1.0

    def rate(t, x, u):
        return [x[1], x[2], -2 * x[1] - 3 * x[2] + u[0]]

    plant = wb.OdePlant.of(
        rate, states=("x", "xd", "xdd"), inputs=("u",), outputs=("y",), h=lambda t, x: [x[0]], x0=[1, 0, 0]
    )
    plant = wb.EquippedPlant(plant, sensors=(wb.Quantiser("y", q),))

    @wb.block
    class P(wb.Controller):
        reads = wb.layout(y="?")
        drives = wb.layout(u="?")

        def command(self, t, z, est, ref):
            return {"u": -K * est.y}

    run = wb.simulate(wb.rk4(wb.ClosedLoop(plant, controller=P()).ode(), 1e-3), until=120.0)
    y, late = run["y_true"].ravel(), run.t > 60
    A = (y[late].max() - y[late].min()) / 2
    ups = run.t[1:][late[1:] & (y[:-1] < 0) & (y[1:] >= 0)]
    # 4 q / (pi A) sqrt(1 - (q / 2 A)^2) = 6 / K with q / 2 < A < 3 q / 2: the larger of both is the stable one
    c = (6 / K * np.pi * 1.0 / 4) ** 2
    predicted = q * np.sqrt((1 + np.sqrt(1 - c)) / (2 * c))
    assert predicted < 1.5 * q
    # the method leaves the third harmonic out, which the plant passes with 1 / 20 of the first
    assert pytest.approx(predicted, rel=0.05) == A
    assert pytest.approx(2 * np.pi / np.sqrt(2), rel=0.05) == np.diff(ups).mean()


MOTOR = wb.DCMotor()


def equipped(*elements):
    return wb.open_loop(wb.EquippedPlant(MOTOR, actuators=elements))


def test_a_corner_or_a_jump_is_not_linearised_unless_a_side_is_named():
    zone = equipped(wb.DeadZone("v", -1.0, 1.0))
    with pytest.raises(ValueError, match=r"corner.*`side="):
        wb.linearize(zone, 0.0, [0.0, 0.0], u=[1.0])
    inside = wb.linearize(zone, 0.0, [0.0, 0.0], u=[1.0], side={"v": -1})
    outside = wb.linearize(zone, 0.0, [0.0, 0.0], u=[1.0], side={"v": 1})
    np.testing.assert_array_equal(inside.B, 0.0)
    np.testing.assert_array_equal(outside.B, wb.linearize(wb.open_loop(MOTOR), 0.0, [0.0, 0.0]).B)
    with pytest.raises(ValueError, match="jumps by"):
        wb.linearize(equipped(wb.Quantiser("v", 1.0)), 0.0, [0.0, 0.0], u=[0.5])
    with pytest.raises(ValueError, match="corner"):
        wb.linearize(equipped(wb.Backlash("v", 1.0, 0.1)), 0.0, [0.0, 0.0, 0.0], u=[0.5])


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: wb.DeadZone("v", [0.0, 2.0], 1.0), r"`DeadZone\(low=..., high=...\)` of 'v' must have low <= high"),
        (lambda: wb.Backlash("v", -0.1, 0.1), r"`Backlash\(gap=...\)` must be finite, with 0 <= value"),
        (lambda: wb.Backlash("v", 0.1, 0.0), r"`Backlash\(time_constant=...\)` must be finite, with 0 < value \[s\]"),
        (lambda: wb.Quantiser("v", -0.1), r"`Quantiser\(quantum=...\)` must be finite, with 0 <= value"),
        (lambda: wb.Quantiser("v", 1e-200), r"`Quantiser\(quantum=...\)` of 'v' must be 0, for none, or at least"),
        (lambda: wb.Quantiser("v", 0.1, "up"), r"`Quantiser\(rounding=...\)` is one of 'nearest', 'down'"),
    ],
)
def test_a_number_that_no_element_has_is_refused(make, says):
    with pytest.raises(ValueError, match=says):
        make()
