"""The study of any plant: its gains, margins, runs and sentences by other roads."""

from dataclasses import replace
from functools import cache

import control
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import place_poles

from studies.b3_any_plant import choices, findings, frequency, frequency_pages, orders, pages, tanks
from studies.b3_any_plant.loops import (
    COMPUTER,
    ITEMS,
    LAWS,
    LQG,
    LQR,
    OBSERVER,
    PID,
    PLACED,
    REGULATOR,
    SEED,
    cases,
    cut,
    design,
    factors,
    loop,
    margins,
    placed,
    recovery,
    run,
)
from studies.b3_any_plant.settings import EASY, HARD, SENSOR, SETTINGS
from studies.b3_any_plant.settings import REGULATOR as REGULATOR_OF_LQG
from workbench.core import rk4
from workbench.design.linear import sensitivity
from workbench.engine import simulate
from workbench.engine.factors import Space
from workbench.engine.metrics import measure
from workbench.report.pictures.loop_gains import loop_gain
from workbench.study import Results, Study
from workbench.study.case_runs import run as run_study

BY_NAME = {setting.name: setting for setting in SETTINGS}
EACH = pytest.mark.parametrize("setting", SETTINGS, ids=lambda setting: setting.name)
BOTH = pytest.mark.parametrize("law", LAWS)


@cache
def linear():
    """The margins of all loops, as the study has them."""
    return Results(works={"margins": tuple(map(margins, ITEMS))})


def rows(setting):
    """Weights and intensities as the docstring of a setting words them."""
    Q, R = (np.diag(np.array(sizes) ** -2.0) for sizes in (setting.states, setting.inputs))
    W = setting.push**2 * setting.period * np.eye(len(setting.inputs))
    V = np.diag([setting.noise[name] ** 2 * setting.period for name in setting.plant.outputs.names])
    return Q, R, W, V


@EACH
def test_the_gains_are_those_of_python_control(setting):
    Q, R, W, V = rows(setting)
    model = setting.model
    K, _, _ = control.lqr(model.A, model.B, Q, R, method="scipy")
    L, _, _ = control.lqe(model.A, model.B, model.C, W, V, method="scipy")
    for ours, theirs in ((setting.design.regulator.K, K), (setting.design.estimator.K, L)):
        # SciPy's first answers lose some digits of their condition, up to 1e3 here
        np.testing.assert_allclose(ours, theirs, rtol=1e-6, atol=1e-9 * np.abs(theirs).max())


def pid_of(Kp, Ki, Kd=0.0, N=100.0):
    """Kp + Ki / s + Kd s / (1 + s / N)."""
    s = control.tf("s")
    return control.ss(Kp + Ki / s + (Kd * s / (1 + s / N) if Kd else 0))


def pd_of(setting, N=100.0):
    """The gains of the regulator, velocities by a filtered derivative."""
    names, ny = setting.plant.states.names, setting.model.noutputs
    K = dict(zip(names, setting.design.regulator.K.T, strict=True))
    Kp, Kd = (np.column_stack([K[name + rate] for name in setting.plant.outputs.names]) for rate in ("", "d"))
    return control.ss(-N * np.eye(ny), N * np.eye(ny), -N * Kd, Kp + N * Kd)


def tank_of(gains, times):
    return control.append(*(pid_of(SENSOR * k, SENSOR * k / T) for k, T in zip(gains, times, strict=True)))


def compensator(setting, law):
    """u = -C y of a law, written down anew."""
    A, B, C = setting.model.A, setting.model.B, setting.model.C
    K, L = setting.design.regulator.K, setting.design.estimator.K
    if law == LQG:
        return control.ss(A - B @ K - L @ C, L, K, 0)
    return {
        "DC motor": lambda: pid_of(15.0, 40.0),
        EASY: lambda: tank_of((3.0, 2.7), (30.0, 40.0)),
        HARD: lambda: tank_of((1.5, -0.12), (110.0, 220.0)),
        "two masses": lambda: control.ss(control.tf([0.7, 0.2], [1, 1.4, 1.5])),
        "buck converter": lambda: pid_of(0.05, 200.0, 2e-5, 1e5),
        "stirred tank": lambda: pid_of(5.0, 0.03),
    }.get(setting.name, lambda: pd_of(setting))()


@EACH
@BOTH
def test_the_loop_at_rest_is_the_one_that_python_control_closes(setting, law):
    ours = sensitivity(cut(setting, law)).poles()
    theirs = control.feedback(setting.model * compensator(setting, law), np.eye(setting.model.noutputs)).poles()
    far = [np.abs(ours - pole).min() / np.abs(pole) for pole in theirs]
    # of poles that lie together, rounding moves each by its root; a filter without a gain is a pole of ours alone
    assert max(far) < 1e-5
    assert len(ours) - len(theirs) == (setting.name in ("DC motor", "stirred tank") and law == PID)


@pytest.mark.parametrize("name", ["DC motor", "buck converter", "stirred tank", "two masses"])
@pytest.mark.parametrize("law", [LQR, *LAWS])
def test_the_delay_that_one_input_stands_is_that_of_python_control(name, law):
    setting = BY_NAME[name]
    L = cut(setting, law)
    _, _, _, _, crossings, _ = control.stability_margins(L, returnall=True)
    turned = [np.angle(-L(1j * omega)) % (2 * np.pi) / omega for omega in np.atleast_1d(crossings)]
    assert margins((setting.name, law)).delay == pytest.approx(min(turned, default=np.inf), rel=1e-5)


@pytest.mark.parametrize("setting", [s for s in SETTINGS if len(s.inputs) == 1], ids=lambda setting: setting.name)
def test_a_regulator_of_all_states_keeps_its_guaranteed_distance(setting):
    L = cut(setting, LQR)
    # Kalman's inequality: |1 + L| >= 1, to the rounding of 1 / (1 + L)
    assert abs(1 / (1 + L(1j * np.geomspace(1e-4, 1e6, 400)))).max() <= 1 + 1e-9


@EACH
@BOTH
def test_every_loop_rests_where_it_is_wanted(setting, law):
    closed = loop(setting, law)
    end = simulate(rk4(closed.ode(), setting.period / 8), until=setting.until, every=setting.until)
    off = max(abs(setting.start[name] - value) for name, value in setting.wanted.items())
    for name, value in setting.wanted.items():
        # the slowest pole, of the hard tanks, has decayed to 3 %
        assert abs(end[name][0, -1].item() - value) < 0.03 * off


def test_the_cart_pole_under_lqg_runs_as_scipy_integrates_it():
    setting = BY_NAME["cart-pole"]
    K, L, model, p = setting.design.regulator.K[0], setting.design.estimator.K, setting.model, setting.plant

    def rate(t, z):
        (_, v, phi, omega), hat = z[:4], z[4:]
        F = -K @ hat
        # Newton's law with the accelerations as unknowns
        mass = [[p.M + p.m, -p.m * p.l * np.cos(phi)], [-p.m * p.l * np.cos(phi), p.I + p.m * p.l**2]]
        push = [F - p.b * v - p.m * p.l * omega**2 * np.sin(phi), p.m * p.g * p.l * np.sin(phi)]
        v_t, omega_t = np.linalg.solve(mass, push)
        seen = model.A @ hat + model.B[:, 0] * F + L @ (z[[0, 2]] - hat[[0, 2]])
        return [v, v_t, omega, omega_t, *seen]

    start = [0.2, 0.0, 0.1, 0.0, 0.2, 0.0, 0.1, 0.0]
    other = solve_ivp(rate, (0.0, 5.0), start, rtol=1e-10, atol=1e-12, dense_output=True)
    t = np.linspace(0.0, 5.0, 20_001)
    own = run(setting, LQG, computer=False)
    score = measure(own.loop.ode(), own.metrics, until=5.0, h=own.h, every=5.0).score("RMSE of x")
    # the mean of squares on a grid of 0.25 ms is off by some (h / 0.02 s)^2 / 12
    assert score.value.item() == pytest.approx(np.sqrt(np.trapezoid(other.sol(t)[0] ** 2, t) / 5.0), rel=1e-4)


def test_no_pid_with_a_plain_filter_makes_the_two_masses_stable():
    rng = np.random.default_rng(3)
    for _ in range(100):
        m_1, m_2, k, N = rng.uniform(0.2, 5.0, 4)
        Kp, Ki, Kd = rng.normal(0.0, 10.0 ** rng.uniform(-3, 1), 3)
        plant = [m_1 * m_2, 0, k * (m_1 + m_2), 0, 0]  # k over this, from the force to the second mass
        closed = np.polyadd(np.polymul(plant, [1, N, 0]), k * np.array([Kp + Kd * N, Kp * N + Ki, Ki * N]))
        # poles on the axis, as all gains are small: rounding moves a double one by its root
        assert np.roots(closed).real.max() > -1e-7
    assert findings.mass_claim(linear()).kind == "holds"


def test_friction_or_a_reading_of_the_first_mass_lets_a_plain_filter_do():
    law = control.tf([0.2 + 0.7 * 5, 0.2 * 5], [1, 5])  # a PD with N = 5
    small = control.tf([0.002 + 0.02 * 5, 0.002 * 5], [1, 5])
    first = control.tf([1.0, 0, 1.0], [1.0, 0, 2.0, 0, 0])  # x_1 from u, all numbers one
    friction = control.tf([1.0], np.polysub(np.polymul([1, 0.1, 1], [1, 0.1, 1]), [1.0]))
    for plant, pd in ((first, law), (friction, small)):
        assert control.feedback(plant * pd).poles().real.max() < -1e-4  # far beyond rounding of simple poles


def test_under_two_pi_the_slowest_mode_is_thirteen_times_as_slow_at_p_plus_and_the_level_four_to_five_times():
    slow = {name: -sensitivity(cut(BY_NAME[name], PID)).poles().real.max() for name in (EASY, HARD)}
    assert slow[EASY] / slow[HARD] == pytest.approx(13.4, abs=0.1)
    runs = {name: tanks.levels((name, PID, 1.0)) for name in (EASY, HARD)}
    (easy, _), (hard, both) = runs[EASY].settling, runs[HARD].settling
    assert hard / easy == pytest.approx(4.6, abs=0.1)  # times on a grid of 0.25 s
    assert both / max(runs[EASY].settling) > 15


def placed_by_scipy():
    """The tanks at P+ under the placed design, with equations, gains and solver of other hands: t, levels, voltages."""
    setting = BY_NAME[HARD]
    A, B, C = (np.asarray(part) for part in (setting.model.A, setting.model.B, setting.model.C))
    K = place_poles(A, B, REGULATOR).gain_matrix
    L = place_poles(A.T, C.T, OBSERVER).gain_matrix.T
    x0, u0, start = setting.point.x, setting.point.u, np.array([10.4, 13.0, 4.8, 4.9])

    def rate(t, z):
        x, hat = z[:4], z[4:]
        v, out = u0 - K @ hat, np.sqrt(2 * 981.0 * x)
        levels = [
            (-0.071 * out[0] + 0.071 * out[2] + 0.43 * 3.14 * v[0]) / 28.0,
            (-0.057 * out[1] + 0.057 * out[3] + 0.34 * 3.29 * v[1]) / 32.0,
            (-0.071 * out[2] + 0.66 * 3.29 * v[1]) / 28.0,
            (-0.057 * out[3] + 0.57 * 3.14 * v[0]) / 32.0,
        ]
        return np.concatenate([levels, A @ hat + B @ (v - u0) + L @ ((x - x0)[:2] - hat[:2])])

    z0 = np.concatenate([start, (start - x0)[:2], [0.0, 0.0]])
    t = np.arange(0.0, 400.0, 0.25)
    out = solve_ivp(rate, (0.0, 400.0), z0, "LSODA", t, rtol=1e-9, atol=1e-11)
    return t, out.y[:2].T - [setting.wanted["h_1"], setting.wanted["h_2"]], u0 - out.y[4:].T @ K.T


def test_a_placed_design_settles_both_tanks_beyond_the_decay_of_the_mirrored_zero():
    t, off, volts = placed_by_scipy()
    band = 0.05 * np.abs(off[0]).max()
    late = t[np.flatnonzero((np.abs(off) > band).any(axis=1)).max() + 1]
    assert late < 73.0
    assert 1.5 < volts.min() < volts.max() < 6.0
    ours = tanks.levels((HARD, PLACED, 1.0))
    # both on the grid of 0.25 s; the two solvers differ by less than a step of it
    assert max(ours.settling) == pytest.approx(late, abs=0.26)
    assert ours.voltages == pytest.approx((volts.min(), volts.max()), rel=1e-3)
    # what the zero does force, to the 5 % that are left then
    _, psi = tanks.zero_of(BY_NAME[HARD])
    assert np.abs(off @ psi).max() > 0.95 * tanks.least_swing(BY_NAME[HARD], late)
    # eight poles, the nearest where it was placed: no mode as slow as the mirror image of the zero
    assert ours.decay == pytest.approx(0.05, rel=1e-6)
    assert ours.decay > 3 * tanks.zero_of(BY_NAME[HARD])[0]


def test_the_zero_fixes_a_weighted_integral_of_the_levels_under_every_law():
    setting = BY_NAME[HARD]
    (z, psi), n = tanks.zero_of(setting), 4
    A, B, C = (np.asarray(part) for part in (setting.model.A, setting.model.B, setting.model.C))
    off = setting.open.states.default - setting.point.x
    K, L = placed(setting)
    laws = [compensator(setting, PID), compensator(setting, LQG), control.ss(A - B @ K - L @ C, L, K, 0)]
    for law in laws:
        whole = np.block([[A - B @ law.D @ C, -B @ law.C], [law.B @ C, law.A]])
        start = np.concatenate([off, np.zeros(len(law.A))])
        # the Laplace transform of the levels at z, which is the integral where the loop decays
        transform = np.linalg.solve(z * np.eye(len(whole)) - whole, start)[:n]
        assert psi @ C @ transform == pytest.approx(tanks.predicted_integral(setting), rel=1e-9)
    # the nonlinear run is 2 cm from rest of 12 cm
    assert tanks.levels((HARD, LQG, 1.0)).fixed == pytest.approx(tanks.predicted_integral(setting), rel=0.03)


def test_cheap_control_puts_a_mode_of_the_regulator_on_the_mirror_image_of_the_zero():
    setting = BY_NAME[HARD]
    z, _ = tanks.zero_of(setting)
    far = []
    for price in (1.0, 1e-2, 1e-4):
        _, _, poles = control.lqr(setting.model.A, setting.model.B, rows(setting)[0], price * np.eye(2), method="scipy")
        far.append(np.abs(poles + z).min() / z)
    assert far[0] < 2e-3
    assert far[0] > far[1] > far[2]


def test_more_push_returns_the_margin_where_no_zero_lies_to_the_right():
    for name, returns in (("buck converter", True), (HARD, False)):
        plain = linear().work("margins")[ITEMS.index((name, LQG))].disk
        assert (recovery((name, 100.0)) > plain) is returns


def test_pid_is_the_regulators_own_gain_where_the_page_says_so():
    own = [setting.name for setting in SETTINGS if setting.pid.origin == REGULATOR_OF_LQG]
    assert own == ["cart-pole", "Furuta pendulum", "planar quadrotor"]
    for name in own:
        setting = BY_NAME[name]
        names, ny = setting.plant.states.names, setting.model.noutputs
        columns = [names.index(output) for output in setting.plant.outputs.names]
        model, at = setting.model, 1e-3j
        # the loop gain without poles of its own at low frequency: that of the positions' gains, to a filter of 1/N
        gain = setting.design.regulator.K[:, columns] @ model(at).reshape(ny, -1)
        np.testing.assert_allclose(np.asarray(cut(setting, PID)(at)).reshape(gain.shape), gain, rtol=5e-3)


def test_the_laws_are_counted_by_every_statistic_and_without_each_setting():
    one = dict.fromkeys([s.name for s in SETTINGS], "below") | dict.fromkeys([s.name for s in SETTINGS[:4]], "above")
    assert (orders.standing(one), orders.leader(one), orders.leader(one, larger=True)) == ((5, 4), LQG, PID)
    first, second, third, *rest = orders.variations_of({"a": one, "b": one})
    assert (first.words, first.answer) == ("a, leaving out one setting", "neither")
    assert first.detail.count(",") == 4  # each of the five that LQG leads
    assert third.words == "b"
    assert len(rest) == 2
    assert (second.answer, second.detail) == (LQG, "LQG below in 4, PID in 2")


def test_tables_of_choices_hold_what_the_runs_use():
    starts, weights, gains, second, numbers = choices.choice_tables()
    for table in (starts, weights, gains, second, numbers):
        assert [row[0] for row in table.rows] == [setting.name for setting in SETTINGS]
    assert starts.rows[3][1:4] == (
        "h_1 = 10.3 cm, h_2 = 12.8 cm, h_3 = 1.6 cm, h_4 = 1.4 cm",
        "h_1 = 12.26, h_2 = 12.78",
        "800 s",
    )
    assert second.rows[0][3] == "Kp = 15, Ki = 40"
    assert "R = 1 Ohm" in numbers.rows[0][1] or "R = 1" in numbers.rows[0][1]
    assert gains.rows[1][1].startswith("[−70.71, −37.83, 105.5")


@pytest.mark.parametrize(
    "setting",
    [
        pytest.param(one, marks=[pytest.mark.heavy] * (one.name not in ("DC motor", "cart-pole")), id=one.name)
        for one in SETTINGS
    ],
)
@BOTH
def test_every_loop_comes_to_rest_in_its_computer(setting, law):
    own = run(setting, law, computer=True)
    step = own.loop.ode().step(8)
    out = simulate(step, until=setting.until, every=setting.period, seed=SEED)
    off = np.abs(out[setting.main][0].ravel() - setting.wanted[setting.main])
    assert off[3 * len(off) // 4 :].max() < 0.05 * off[0]  # the band of the settling time
    for name in setting.plant.inputs.names:
        commands = out[f"{name}_applied"][0][1:]
        assert setting.limit[0] <= commands.min() <= commands.max() <= setting.limit[1]


@pytest.mark.heavy
def test_a_case_is_a_plant_a_law_and_a_machine_and_its_factors_are_numbers_of_the_plant():
    assert len(cases()) == 4 * len(SETTINGS) + 2  # the placed design beside them
    assert sum(COMPUTER in case.law for case in cases()) == 2 * len(SETTINGS) + 1
    for setting in SETTINGS:
        ode = loop(setting, PID).ode()
        drawn, _ = Space(factors(setting), ode.parameters, ode.states).rows(design(setting).points(0, 4))
        moved = [name for name, column in zip(ode.parameters.labels, drawn.T, strict=True) if np.ptp(column) > 0]
        assert set(moved) <= {f"plant.{name}" for name in setting.spread}


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
    "name", [pytest.param(name, marks=[pytest.mark.heavy] * (name == "cart-pole")) for name in frequency_pages.TURNED]
)
def test_the_pictures_that_a_reader_turns_have_the_margins_of_the_table(name):
    law = frequency_pages.TURNED[name]
    (case,) = (one for one in cases() if (one.scenario, one.law) == (name, law))
    own = run_study(Study("s", "T", "Q?", "M.", sections=lambda results: [], cases=(case,)))
    shown = loop_gain(own[name, law])
    at = frequency.linear_at_rest(BY_NAME[name], law.removesuffix(f" {COMPUTER}"), computer=COMPUTER in law)
    ((_, held),) = at.margins().items()
    # both seek the same rest by Newton's method, from the start of the run and from the operating point
    assert shown.margins[0].margins.phase_margin.value == pytest.approx(held.margins.phase_margin.value, rel=1e-6)
    assert shown.margins[0].margins.Ms.gain.value == pytest.approx(held.margins.Ms.gain.value, rel=1e-6)
    assert len(frequency_pages.turned(BY_NAME[name], own)) == 7  # two paragraphs, four figures and a table
