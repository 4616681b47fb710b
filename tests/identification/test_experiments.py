"""Designs of experiments: what they promise is what fits of simulated logs reach, within all limits."""

from itertools import pairwise

import casadi as ca
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.stats import chi2

import workbench as wb
from workbench.core import Entry, Layout
from workbench.identification.experiments.design_problem import InputSchedule, problem_of

MOTOR = wb.open_loop(wb.DCMotor())
NOISE = {"omega": 0.01, "i": 0.05}
LIMITS = {"v": (-12.0, 12.0), "omega": (-0.5, 0.5), "rate of omega": (-20.0, 20.0), "rate of v": (-200.0, 200.0)}


def motor_design(free=("J", "b", "R", "L"), outputs=("omega", "i"), **changes):
    """A small design for the motor."""
    values = {"noise": {name: NOISE[name] for name in outputs}, "limits": {"v": (-12.0, 12.0)}, "until": 2.0}
    values |= {"every": 0.02, "harmonics": 3, "starts": 1, **changes}
    return wb.design_experiment(MOTOR, list(free), ["v"], list(outputs), **values)


def lag(a, b):
    """x' = -a x + b u as an equation."""
    entries = (Entry("a", np.array(a), "1/s"), Entry("b", np.array(b), "m/(s V)"), Entry("u", np.array(0.0), "V"))
    t, x, p = ca.SX.sym("t"), ca.SX.sym("x"), ca.SX.sym("p", 3)
    states = Layout((Entry("x", np.array(0.0), "m"),))
    return wb.Ode.of("lag", states, Layout(entries), (t, x, p), {"x": -p[0] * x + p[1] * p[2]}, {"y": x}, {"y": "m"})


def motion(ode, name, t, u):
    """The states under a held input, by SciPy, sample by sample."""
    p, rows = ode.parameters.default.copy(), [ode.states.default]
    for (begin, end), value in zip(pairwise(t), u[:-1], strict=True):
        p[ode.parameters.labels.index(name)] = value
        run = solve_ivp(lambda s, x: ode.rate_at(s, x, p), (begin, end), rows[-1], "DOP853", rtol=1e-10, atol=1e-12)
        rows.append(run.y[:, -1])
    return np.array(rows)


@pytest.fixture(scope="module")
def design():
    """A design whose motion several limits hold back."""
    return motor_design(limits=LIMITS, criterion="A")


@pytest.mark.parametrize("hold", ["hold", "linear"])
@pytest.mark.parametrize("criterion", ["D", "A"])
def test_slopes_of_criterion_and_margins_are_differences(hold, criterion):
    schedule = InputSchedule.of(2.0, 0.05, 1.0, 2, None)
    free = ["J", "R", "omega(0)", "scale of i", "offset of omega"]
    problem = problem_of(MOTOR, free, ["v"], ["omega", "i"], NOISE, LIMITS, schedule, criterion, hold, {})
    c, rng = np.array([[0.5, 3.0, -1.0, 2.0, 0.7]]), np.random.default_rng(3)
    step = 1e-5 * rng.standard_normal(c.shape)  # of a central difference, whose error goes with its square
    response, goal = problem.response, problem.criterion.goal
    slope = np.sum(response.pull_back(c, goal)[1] * step)
    change = (response.pull_back(c + step, goal)[0] - response.pull_back(c - step, goal)[0]) / 2
    assert slope == pytest.approx(change, rel=1e-5)
    before, after = response.margins(c - step), response.margins(c + step)
    places = np.argwhere(np.isfinite(before))[::7]
    changes = (after[tuple(places.T)] - before[tuple(places.T)]) / 2
    assert response.margin_slopes(c, places) @ step.ravel() == pytest.approx(changes, rel=1e-5, abs=1e-12)


def test_limits_hold_along_a_motion_of_another_program(design):
    t, v = design.table("v")
    x = motion(MOTOR, "v", t, v)
    p = np.tile(MOTOR.parameters.default, (t.size, 1))
    p[:, -1] = v
    rates = np.array([MOTOR.rate_at(0.0, *pair)[0] for pair in zip(x, p, strict=True)])
    for values, name in ((v, "v"), (x[:, 0], "omega"), (rates, "rate of omega"), (np.diff(v) / 0.02, "rate of v")):
        low, high = LIMITS[name]
        assert low <= np.min(values), name
        assert np.max(values) <= high, name
    assert "omega" in design.active_limits
    assert design.certificate.is_passed
    assert min(design.certificate.margins.values()) >= 0


def test_expected_errors_are_those_of_the_information_along_the_designed_inputs(design):
    """The derivatives by central differences of another program's motions give the same standard errors."""
    t, v = design.table("v")
    columns = []
    for name in design.names:
        size = 1e-4 * MOTOR.parameters.default[MOTOR.parameters.labels.index(name)]
        ends = []
        for sign in (-1, 1):
            p = MOTOR.parameters.default.copy()
            p[MOTOR.parameters.labels.index(name)] += sign * size
            other = wb.open_loop(wb.DCMotor(**dict(zip(["J", "b", "K", "R", "L"], p, strict=False))))
            ends.append(motion(other, "v", t, v) / list(NOISE.values()))
        columns.append(((ends[1] - ends[0]) / 2 / size).ravel())
    J = np.column_stack(columns)
    errors = np.sqrt(np.diag(np.linalg.inv(J.T @ J)))
    # the differences have an error of 1e-8, and the steps one of 1e-5 by the certificate
    assert list(design.standard_errors.values()) == pytest.approx(errors, rel=1e-4)
    assert design.value == pytest.approx(np.sum((errors / design.values) ** 2), rel=1e-4)
    low, high = design.intervals()["J"]
    assert high - low == pytest.approx(2 * 1.959964 * design.standard_errors["J"], rel=1e-6)


def test_a_design_tells_more_than_plain_excitations(design):
    assert set(design.mean_ratios) == {"random steps", "chirp"}
    assert min(design.mean_ratios.values()) > 1.0
    assert design.warnings == ()
    for kind, plain in design.plain.items():
        assert np.abs(plain.inputs).max() <= 12.0, kind
        own = np.array(list(design.standard_errors.values()))
        assert list(design.ratios[kind].values()) == pytest.approx(plain.errors / own)


def test_the_gain_of_a_lag_alone_is_told_best_by_the_largest_constant_input():
    a, b, most = 0.7, 2.0, 3.0
    found = wb.design_experiment(
        lag(a, b),
        ["b"],
        ["u"],
        ["y"],
        noise={"y": 0.1},
        limits={"u": (-most, most)},
        until=4.0,
        every=0.1,
        steps=4,
        starts=2,
    )
    t, u = found.table("u")
    sensitivity = most / a * (1 - np.exp(-a * t))
    # the search leaves 2e-4 of the range of the input, 4e-4 of its largest value
    assert found.standard_errors["b"] == pytest.approx(0.1 / np.linalg.norm(sensitivity), rel=1e-3)
    assert np.abs(u) == pytest.approx(most, rel=1e-3)
    assert found.active_limits == ("u",)


def test_sines_and_table_are_the_designed_input(design):
    t, v = design.table("v")
    constant, amplitude, frequency, phase = design.sines("v")
    signal = constant + np.sum(amplitude * np.sin(np.outer(t, frequency) + phase), axis=1)
    assert signal == pytest.approx(v, abs=1e-9)
    table = wb.Table("v", "V", times=t, values=v, interpolation="hold")
    assert float(table.at(t[7]).v) == v[7]
    with pytest.raises(ValueError, match="needs an input of harmonics"):
        motor_design(free=("J",), steps=2).sines("v")


def test_a_limit_with_one_end_and_inputs_that_must_not_rest_at_zero_are_kept():
    found = motor_design(free=("J", "R"), limits={"v": (2.0, 12.0), "omega": (-np.inf, 0.3)}, steps=4)
    t, v = found.table("v")
    assert v.min() >= 2.0
    assert motion(MOTOR, "v", t, v)[:, 0].max() <= 0.3
    assert "omega" in found.active_limits


def test_a_design_is_the_same_for_the_same_seed():
    one, two, other = (motor_design(free=("J", "R"), steps=2, seed=seed) for seed in (5, 5, 6))
    assert np.array_equal(one.dataset["v"], two.dataset["v"])
    assert not np.array_equal(other.plain["random steps"].inputs, one.plain["random steps"].inputs)


REFUSALS = {
    "cross": ({"limits": {"v": (1.0, -1.0)}}, "limits that cross"),
    "nothing limited": ({"limits": {}}, "must limit an input, state or output"),
    "rates alone": ({"limits": {"rate of v": (-20.0, 20.0)}}, "must limit an input, state or output"),
    "nothing free": ({"free": ()}, "at least one number"),
    "start beyond": ({"limits": {"omega": (1.0, 2.0)}}, "'omega' is 0, and its limits are 1 and 2"),
    "ambiguous": ({"free": ("J", "b", "K", "R", "L"), "outputs": ("omega",)}, "no input of this shape tells J, b, K"),
    "period": ({"period": 0.3}, "multiple of the period 0.3 s"),
    "samples": ({"period": 0.5, "every": 0.3}, "multiple of the time between samples"),
    "fast harmonics": ({"harmonics": 50}, "below half of the 100 samples"),
    "no harmonic": ({"harmonics": [0]}, "at least one harmonic"),
    "step between samples": ({"steps": 3}, "multiple of the time between samples"),
    "delay of steps": ({"free": ("J", "delay of v")}, "with hold='linear' alone"),
    "noise": ({"noise": {"omega": 0.1}}, "there is none for 'i'"),
    "sign of noise": ({"noise": {"omega": 0.1, "i": 0.0}}, "positive standard deviations"),
    "known input": ({"free": ("v",)}, "cannot estimate 'v'"),
    "criterion": ({"criterion": "E"}, "criterion"),
    "no output": ({"outputs": ()}, "at least one output"),
}


@pytest.mark.parametrize("case", REFUSALS)
def test_what_cannot_be_designed_is_refused_by_name(case):
    changes, sentence = REFUSALS[case]
    with pytest.raises(ValueError, match=sentence):
        motor_design(**changes)


def test_an_unstable_system_that_leaves_its_limits_at_rest_is_refused_by_name_and_time():
    falling = wb.open_loop(wb.CartPole(phi=0.1))
    with pytest.raises(ValueError, match=r"'phi' leaves its limits at t = 0\.\d+ s: an unstable system"):
        wb.design_experiment(
            falling,
            ["M"],
            ["F"],
            ["x"],
            noise={"x": 0.01},
            limits={"F": (-5, 5), "phi": (-0.4, 0.4)},
            until=2,
            every=0.02,
        )
    with pytest.raises(LookupError, match="omeg"):
        motor_design(limits={"omeg": (-1.0, 1.0)})


@pytest.mark.release
def test_the_best_single_sine_of_a_lag_has_the_frequency_a_over_root_three():
    """det M in steady state is (U^2 / 2)^2 b^2 w^2 / (a^2 + w^2)^4 (Goodwin and Payne 1977), largest at a / sqrt(3)."""
    a, best = 0.7, 0.7 / np.sqrt(3)
    period = 2 * np.pi / best
    orders, values = (80, 93, 107, 120), []
    for order in orders:
        found = wb.design_experiment(
            lag(a, 2.0),
            ["a", "b"],
            ["u"],
            ["y"],
            noise={"y": 0.1},
            limits={"u": (-1.0, 1.0)},
            until=100 * period,
            every=period / 61,
            period=100 * period,
            harmonics=[order],
            hold="linear",
            starts=1,
        )
        assert found.active_limits == ("u",)
        values.append(found.value)
    cubic = np.polyfit(np.log(np.array(orders) / 100), values, 3)
    extremes = np.roots(np.polyder(cubic))
    assert np.exp(extremes[np.argmin(np.abs(extremes))]) == pytest.approx(1.0, abs=0.01)


PLANTS = {
    "motor": (MOTOR, ["J", "b", "R", "L"], "v", "V", NOISE, {"omega": "rad/s", "i": "A"}, LIMITS),
    "cart and pole": (
        wb.open_loop(wb.CartPole(phi=np.pi)),
        ["M", "m", "b", "l"],
        "F",
        "N",
        {"x": 0.002, "phi": 0.005},
        {"x": "m", "phi": "rad"},
        {"F": (-5, 5), "x": (-0.4, 0.4), "xd": (-1.5, 1.5), "phi": (np.pi - 1, np.pi + 1)},
    ),
}


@pytest.mark.release
@pytest.mark.parametrize("plant", PLANTS)
def test_estimates_from_simulated_logs_scatter_as_promised(plant):
    ode, free, name, unit, noise, units, limits = PLANTS[plant]
    found = wb.design_experiment(
        ode, free, [name], list(noise), noise=noise, limits=limits, until=4, every=0.02, starts=2
    )
    t, count = found.table(name)[0], 120
    inputs = {"design": found.table(name)[1], **{kind: one.inputs[:, 0] for kind, one in found.plain.items()}}
    expected = {"design": np.array(list(found.standard_errors.values()))}
    expected |= {kind: one.errors for kind, one in found.plain.items()}
    low, high = np.sqrt(chi2.ppf([0.0005, 0.9995], count - 1) / (count - 1))
    for kind, u in inputs.items():
        x, rng = motion(ode, name, t, u), np.random.default_rng(7)
        estimates = []
        for _ in range(count):
            log = {name: u} | {
                y: x[:, ode.states.labels.index(y)] + s * rng.standard_normal(t.size) for y, s in noise.items()
            }
            fitted = wb.fit(ode, wb.Dataset.of(t, log, {name: unit, **units}), free, noise=noise, hold_out=0.0)
            estimates.append(fitted.theta)
        scatter = np.std(estimates, axis=0, ddof=1) / expected[kind]
        assert (low < scatter).all(), kind
        assert (scatter < high).all(), kind
    assert min(found.mean_ratios.values()) > 1.0
