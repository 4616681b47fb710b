"""The study of any plant: its gains, margins, runs and sentences by other roads."""

from functools import cache

import control
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from studies.b3_any_plant import choices, findings, orders
from studies.b3_any_plant.loops import (
    COMPUTER,
    ITEMS,
    LAWS,
    LQG,
    LQR,
    PID,
    SEED,
    cases,
    cut,
    design,
    factors,
    loop,
    margins,
    recovery,
    run,
)
from studies.b3_any_plant.settings import HARD, SETTINGS
from studies.b3_any_plant.settings import REGULATOR as REGULATOR_OF_LQG
from tests.support.settings_of_b3 import BY_NAME, compensator, rows
from workbench.core import rk4
from workbench.design.linear import sensitivity
from workbench.engine import simulate
from workbench.engine.factors import Space
from workbench.engine.metrics import measure
from workbench.study import Results

EACH = pytest.mark.parametrize("setting", SETTINGS, ids=lambda setting: setting.name)
BOTH = pytest.mark.parametrize("law", LAWS)


@cache
def linear():
    """The margins of all loops, as the study has them."""
    return Results(works={"margins": tuple(map(margins, ITEMS))})


@EACH
def test_the_gains_are_those_of_python_control(setting):
    Q, R, W, V = rows(setting)
    model = setting.model
    K, _, _ = control.lqr(model.A, model.B, Q, R, method="scipy")
    L, _, _ = control.lqe(model.A, model.B, model.C, W, V, method="scipy")
    for ours, theirs in ((setting.design.regulator.K, K), (setting.design.estimator.K, L)):
        # SciPy's first answers lose some digits of their condition, up to 1e3 here
        np.testing.assert_allclose(ours, theirs, rtol=1e-6, atol=1e-9 * np.abs(theirs).max())


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
    off = max(abs(setting.start[name] - value) for name, value in setting.operating_outputs.items())
    for name, value in setting.operating_outputs.items():
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


@pytest.mark.release
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


@pytest.mark.heavy
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
    assert first.detail.startswith("if one of these is left out: ")
    assert first.detail.count(",") == 4  # each of the five that LQG leads
    assert third.words == "b"
    assert len(rest) == 2
    assert (second.answer, second.detail) == (LQG, "LQG lower in 4 settings, PID in 2")


def test_a_margin_is_counted_by_the_law_with_the_larger_one():
    margin = {"DC motor": -1.6, "cart-pole": -0.6, "buck converter": -0.8}  # of LQG; that of PID is one
    disk = {name: orders.order_of(value, -1.0) for name, value in margin.items()}
    assert orders.leader(disk) == PID
    assert orders.count_words("disk margin", disk) == "LQG larger in 1 setting, PID in 2"
    assert orders.count_words("RMSE", disk) == "LQG lower in 1 setting, PID in 2"
    assert orders.count_words("scatter", disk, larger=True) == "LQG larger in 2 settings, PID in 1"


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
    off = np.abs(out[setting.main][0].ravel() - setting.operating_outputs[setting.main])
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
