"""Loops behind a hold: python-control, closed forms, 400 bits of flint and runs by RK4 decide; odd input is refused."""

import control
import numpy as np
import pytest
from flint import acb, acb_mat, arb, ctx

from workbench.design.frequency import hold_loop
from workbench.design.matrices import DesignError

H = 0.1
PLANT = control.ss([[-1.0, 4.0, 0], [-4.0, -1.0, 1], [0, 0, -3.0]], [[0], [0], [2.0]], [[1.0, 0.5, 0]], 0)
PI = control.ss([[1.0]], [[1.0]], [[0.08]], [[0.4]], H)
GAIN = control.ss([], [], [], [[0.5]], H)
CHAIN = control.ss(np.eye(5, k=1), np.eye(5)[:, 4:], np.eye(5)[:1], 0)
BAND = np.array([0.01, 0.1, 0.35, 0.6, 0.9, 1.0]) * np.pi / H


def close(plant, law, delay, frequencies=BAND):
    return hold_loop(plant, law, delay).response(frequencies)


@pytest.mark.parametrize("law", [PI, GAIN])
@pytest.mark.parametrize("periods", [0, 1, 3])
def test_a_loop_with_whole_periods_of_delay_is_that_of_python_control(law, periods):
    L = control.sample_system(PLANT, H) * law * control.tf([1], [1] + periods * [0], H)
    np.testing.assert_allclose(close(PLANT, law, periods * H).loop[:, 0, 0], L(np.exp(1j * BAND * H)), rtol=1e-11)
    ours, peer = hold_loop(PLANT, law, periods * H).poles.values, control.feedback(control.ss(L), 1).poles()
    for pole in peer:
        assert np.abs(ours - pole).min() < 1e-9


@pytest.mark.parametrize("delay", [0.0, 0.3 * H, H, 2.37 * H])
def test_the_output_between_the_samples_is_that_of_the_plant_driven_by_the_hold(delay):
    answers, s, z = close(PLANT, PI, delay), 1j * BAND, np.exp(1j * BAND * H)
    hold = (1 - 1 / z) / (s * H) * np.exp(-s * delay)
    between = PLANT(s) * hold * PI(z) / (1 + answers.loop[:, 0, 0])
    np.testing.assert_allclose(answers.between[:, 0, 0], between, rtol=1e-12)
    assert (answers.between_error[:, 0, 0] < 1e-11 * np.abs(between)).all()


def test_several_channels_have_matrices_of_answers():
    plant = control.ss([[-1, 0.3], [0, -2.0]], [[1, 0], [0.5, 1]], [[1, 0], [0.2, 1]], 0)
    law = control.ss(np.eye(2), np.eye(2), 0.1 * np.eye(2), [[0.4, 0.1], [0, 0.6]], H)
    answers = close(plant, law, 0.25 * H)
    for i, w in enumerate(BAND):
        s, z = 1j * w, np.exp(1j * w * H)
        aliases = np.arange(-40000, 40001)
        far = s + 2j * np.pi / H * aliases
        P = np.linalg.solve(far[:, None, None] * np.eye(2) - plant.A, np.broadcast_to(plant.B, (len(far), 2, 2)))
        sampled = np.einsum("k,kij->ij", (1 - 1 / z) / far / H * np.exp(-far * 0.25 * H), plant.C @ P)
        K = law(z)
        np.testing.assert_allclose(answers.loop[i], sampled @ K, atol=1e-9)  # the sum falls as 1 / far^2
        driven = plant(s) * (1 - 1 / z) / (s * H) * np.exp(-s * 0.25 * H)
        np.testing.assert_allclose(answers.between[i], driven @ K @ np.linalg.inv(np.eye(2) + answers.loop[i]))


@pytest.mark.parametrize("delay", [0.0, 0.25, 1.0, 1.75])
def test_a_run_by_rk4_has_the_part_at_the_frequency(delay):
    """At 3 turns in 20 periods the steady run repeats: its mean with e^-jwt over them is half of the answer to cos."""
    turns, periods, parts = 3, 20, 400
    w = 2 * np.pi * turns / (periods * H)
    F = np.zeros((5, 5), complex)  # of x, u and p = e^jwt times the integral of y e^-jwt
    F[:3, :3], F[:3, 3:4], F[4:, :3], F[4, 4] = PLANT.A, PLANT.B, PLANT.C, 1j * w
    step = np.eye(5) + sum(np.linalg.matrix_power(F * H / parts, k) / [1, 1, 2, 6, 24][k] for k in (1, 2, 3, 4))
    late = round(delay % 1 * parts)
    first, then = (np.linalg.matrix_power(step, count) for count in (late, parts - late))
    x, z, waiting = np.zeros(5, complex), 0.0, [0.0] * int(delay)
    for k in range(200 * periods):
        if k == 199 * periods:
            x[4] = 0  # the mean is that of the last repetition, the start having decayed
        e = np.cos(w * k * H) - (PLANT.C @ x[:3])[0].real
        waiting.append(0.08 * z + 0.4 * e)
        z += e
        x = first @ x
        x[3] = waiting.pop(0)
        x = then @ x
    answer = close(PLANT, PI, delay * H, [w]).between[0, 0, 0]
    assert abs(2 * x[4] / (periods * H) - answer) < 1e-9 * abs(answer)  # RK4: (5 h / 400)^4


def exact(plant, law, delay, w):
    """L(e^jwh) in 400 bits, for a delay of less than a period."""
    ctx.prec = 400
    A, B, C = (matrix(M) for M in (plant.A, plant.B, plant.C))
    h, late, n = arb(law.dt), arb(delay), len(plant.A)

    def integral(span):
        block = acb_mat(2 * n, 2 * n)
        for i in range(n):
            block[i, n + i] = span
            for j in range(n):
                block[i, j] = A[i, j] * span
        E = block.exp()
        return acb_mat(n, n, [E[i, n + j] for i in range(n) for j in range(n)])

    eye = matrix(np.eye(n))
    new = integral(h - late) * B
    old = (eye + A * integral(h - late)) * (integral(late) * B)
    z = (acb(0, 1) * arb(w) * h).exp()
    P = (C * (eye * z - eye - A * integral(h)).solve(new + old * (1 / z)))[0, 0]
    L = P * (acb(float(law.D[0, 0])) + acb(float((law.C @ law.B)[0, 0])) / (z - acb(float(law.A[0, 0]))))
    return complex(float(L.real.mid()), float(L.imag.mid()))


def matrix(M):
    return acb_mat(*M.shape, [acb(float(v)) for v in M.ravel()])


@pytest.mark.parametrize(
    ("plant", "h"),
    [
        (CHAIN, 1e-5),  # entries of the period's map from 1e-5 to 1e-22
        (control.ss([[0, 1], [-1e4, -1e-2]], [[0], [1e4]], [[1, 0]], 0), 0.01),  # Q = 1e4
        (control.ss([[0, 1], [-((40 * np.pi) ** 2), -1e-5]], [[0], [1e4]], [[1, 0]], 0), 0.05),  # folded onto z = 1
        (control.ss([[0, 1], [-1e12, -1e5]], [[0], [1e12]], [[1, 0]], 0), 1e-3),  # a thousand radians in a period
        (control.ss([[-1e6, 1], [0, -1e-2]], [[1], [1]], [[1, 1]], 0), 0.1),  # stiff
    ],
)
def test_the_error_of_a_loop_bounds_what_rounding_did(plant, h):
    law, frequencies = control.ss([[1.0]], [[1.0]], [[0.1]], [[1.0]], h), np.array([1e-3, 0.3, 0.99]) * np.pi / h
    answers = close(plant, law, 0.37 * h, frequencies)
    for w, L, error in zip(frequencies, answers.loop[:, 0, 0], answers.loop_error[:, 0, 0], strict=True):
        assert abs(L - exact(plant, law, 0.37 * h, w)) <= error < 1e-10 * abs(L)


@pytest.mark.parametrize("delay", [0.0, 0.4, 1.0, 2.5])
def test_one_plus_the_loop_is_zero_at_each_pole(delay):
    """For one channel, by the transfer functions of plant and law at the pole."""
    loop = hold_loop(PLANT, PI, delay * H)
    whole, rest = divmod(delay, 1)
    late, early = control.sample_system(PLANT, (1 - rest) * H), control.sample_system(PLANT, max(rest, 1e-300) * H)
    Phi = control.sample_system(PLANT, H).A
    for z, error in zip(loop.poles.values, loop.poles.errors, strict=True):
        if abs(z) < 1e-3:
            continue  # where z^-3 magnifies the rounding of the pole
        G = z ** -int(whole) * (late.B + (late.A @ early.B / z if rest else 0))
        L = (PLANT.C @ np.linalg.solve(z * np.eye(3) - Phi, G))[0, 0] * PI(z)
        assert abs(1 + L) < 1e-9
        assert error < 1e-12
    assert len(loop.poles.values) == 4 + int(np.ceil(delay))
    assert loop.poles.stable


def test_a_chain_of_delays_without_feedback_has_its_poles_at_zero():
    average = control.ss(np.eye(5, k=-1), np.eye(5)[:, :1], np.full((1, 5), 0.1), [[0.1]], H)
    open_loop = control.ss([[-1.0]], [[0.0]], [[1.0]], 0)
    poles = hold_loop(open_loop, average, 3.5 * H).poles.values
    np.testing.assert_allclose(poles, [np.exp(-H)] + 9 * [0], atol=1e-15)


def test_a_delay_of_three_tenths_is_three_periods_of_a_tenth():
    loop = hold_loop(PLANT, PI, 0.3)  # 0.3 % 0.1 is 0.09999999999999998
    assert (loop.whole, loop.rest) == (3, 0.0)
    near = hold_loop(PLANT, PI, 0.3 - 1e-9)
    assert near.whole == 2
    np.testing.assert_allclose(near.response(BAND).loop, loop.response(BAND).loop, rtol=1e-6)


def test_an_undamped_plant_has_an_answer_between_the_samples_at_its_own_frequency():
    w = 7.0
    oscillator = control.ss([[0, 1], [-w * w, 0]], [[0], [w * w]], [[1, 0]], 0)
    near = close(oscillator, PI, 0.0, [w * (1 - 1e-7)]).between[0, 0, 0]
    np.testing.assert_allclose(near, 1.0, atol=1e-5)  # L is large, T is one, and the other harmonics are small


@pytest.mark.parametrize(
    ("frequencies", "words"),
    [
        ([], "at least one"),
        ([1.0, np.nan], "finite"),
        ([3.0, 1.0], "must rise"),
        ([-1.0, 1.0], "must rise"),
        ([1.0, 31.5], "Nyquist"),
        ([[1.0]], "vector"),
    ],
)
def test_frequencies_that_are_none_are_refused(frequencies, words):
    with pytest.raises(ValueError, match=words):
        hold_loop(PLANT, PI).response(frequencies)


@pytest.mark.parametrize(
    ("plant", "law", "delay", "words"),
    [
        (PLANT, PI, -0.01, "delay"),
        (PLANT, PI, np.nan, "delay"),
        (PLANT, PI, np.inf, "delay"),
        (PLANT, control.ss([[1.0]], [[1.0]], [[1.0]], 0), 0.0, "positive period"),
        (PLANT, control.ss([[1.0]], [[1.0]], [[1.0]], 0, True), 0.0, "positive period"),
        (control.ss([[-1.0]], [[1.0]], [[1.0]], [[1.0]]), PI, 0.0, "no feedthrough"),
        (control.ss([[-1.0]], [[1.0]], [[1.0]], 0, H), PI, 0.0, "continuous time"),
        (control.ss([[np.nan]], [[1.0]], [[1.0]], 0), PI, 0.0, "finite matrices"),
        (PLANT, control.ss(0.5 * np.eye(2), np.eye(2), np.eye(2), 0, H), 0.0, "inputs and 2 outputs"),
        (3.0, PI, 0.0, "StateSpace"),
    ],
)
def test_loops_that_are_none_are_refused(plant, law, delay, words):
    with pytest.raises(ValueError, match=words):
        hold_loop(plant, law, delay)


def test_a_pole_of_the_loop_has_no_answer_there():
    with pytest.raises(DesignError, match="a pole at 0 rad/s"):
        hold_loop(PLANT, PI).response([0.0, 1.0])


def test_the_poles_of_too_long_a_delay_are_refused_and_its_answers_are_not():
    loop = hold_loop(PLANT, PI, 1000.5 * H)
    with pytest.raises(DesignError, match="1001 periods"):
        _ = loop.poles
    np.testing.assert_allclose(np.abs(loop.response(BAND).loop), np.abs(close(PLANT, PI, 0.5 * H).loop), rtol=1e-9)


def test_a_plant_that_leaves_the_numbers_within_a_period_is_refused():
    with pytest.raises(DesignError, match="shorter period"):
        hold_loop(control.ss([[1e4]], [[1.0]], [[1.0]], 0), PI).response([1.0])
