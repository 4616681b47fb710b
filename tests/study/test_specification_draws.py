"""Specifications over draws of factors: shares with binomial intervals, figures on a grid and proved near a limit."""

import numpy as np
import pytest
from scipy.stats import beta, norm

import workbench as wb

DRAWS = 60


@pytest.fixture(scope="module")
def motor_loop():
    """A motor without inductance to speak of, under PI: its poles are known by a formula."""
    motor = wb.DCMotor()
    law = wb.PID(motor.outputs, motor.inputs, Kp=10.0, Ki=20.0)
    return wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0))


def poles_of(draw):
    """The poles of the motor under PI, from the equations of a DC motor as a book prints them."""
    m = wb.DCMotor()
    J, b, K, R, L = (draw.get(f"plant.{name}", getattr(m, name)) for name in ("J", "b", "K", "R", "L"))
    Kp, Ki = 10.0, draw.get("controller.Ki", 20.0)
    # (J s + b)(L s + R) + K^2 = P(s); the loop is K (Kp s + Ki) / (s P)
    return np.roots([J * L, J * R + b * L, b * R + K * K + K * Kp, K * Ki])


def factors(spread):
    way = [(0.002, 0.0), (0.001, spread)]
    return tuple(
        wb.Factor(
            f"direction {i}",
            ("plant.J", "plant.R"),
            wb.uncertainty.Normal(0.0, 1.0, -4.0, 4.0),
            direction=wb.uncertainty.FactorDirection((0.02, 1.0), change),
        )
        for i, change in enumerate(way)
    )


def test_shares_are_those_of_a_formula_draw_by_draw(motor_loop):
    linear = wb.linear_loop(motor_loop)
    damping, decay = 0.8, 1.97
    found = wb.Specification(damping=damping, decay=decay).check_draws(linear, factors(0.1), draws=DRAWS, seed=4)
    draws = [found.draw(k) for k in range(DRAWS)]
    poles = [poles_of(draw) for draw in draws]
    decays = np.array([np.min(-one.real) for one in poles])
    dampings = np.array([np.min(-one.real / np.abs(one)) for one in poles])
    assert found["decay"].values == pytest.approx(decays, rel=1e-9)  # eigenvalues beside roots of a polynomial
    assert found["damping"].values == pytest.approx(dampings, rel=1e-9)
    assert 0 < (dampings >= damping).sum() < DRAWS  # the limit cuts through the draws
    assert np.array_equal(found["damping"].flags, dampings >= damping)
    both = int(((dampings >= damping) & (decays >= decay)).sum())
    assert found.share.value == both / DRAWS
    assert found.share.low == pytest.approx(beta.ppf(0.025, both, DRAWS - both + 1))  # Clopper and Pearson
    assert found.worst("damping") == int(np.argmin(dampings))
    assert np.std([draw["plant.R"] for draw in draws]) == pytest.approx(0.1, abs=4 * 0.1 / np.sqrt(2 * DRAWS))


def test_draws_near_a_limit_are_proved_and_agree_with_single_checks(motor_loop):
    linear = wb.linear_loop(motor_loop)
    middle = wb.Specification(phase_margin=1.0).check(linear)["phase_margin"].figure.value.value
    limits = wb.Specification(phase_margin=middle)
    found = limits.check_draws(linear, factors(0.1), draws=24)
    one = found["phase_margin"]
    for k in range(len(found)):
        verdict = limits.check(wb.linear_loop(motor_loop, values=found.draw(k)))["phase_margin"]
        assert (verdict.kind == "holds") == bool(one.flags[k])
        assert abs(verdict.figure.value.value - one.values[k]) <= 2 * one.grid_error
    assert one.is_proved.sum() >= 8
    far = np.abs(one.values - middle) > 5 * one.grid_error
    assert one.is_proved[~far].all()


def test_an_unstable_draw_keeps_no_limit(motor_loop):
    gain = wb.Factor("Ki", ("controller.Ki",), wb.Uniform(20.0, 500.0))
    found = wb.Specification(Ms=50.0).check_draws(wb.linear_loop(motor_loop), (gain,), draws=40)
    draws = [found.draw(k)["controller.Ki[0]"] for k in range(40)]
    stable = np.array([poles_of({"controller.Ki": Ki}).real.max() < 0 for Ki in draws])
    assert 0 < (~stable).sum() < 40
    assert found.unstable == (~stable).sum()
    assert (found["Ms"].flags[~stable] == 0).all()
    assert f"not stable at {found.unstable} draws" in str(found)


def test_the_share_of_a_normal_number_is_covered_by_its_interval(motor_loop):
    """The decay of a slow integral mode falls with R: its median draw divides the draws in halves."""
    linear = wb.linear_loop(motor_loop)
    limit = float(np.min(-poles_of({"plant.J": 0.02, "plant.R": 1.0 + 0.1 * norm.ppf(0.7)}).real))
    ways = (factors(0.1)[1],)
    moved = wb.uncertainty.FactorDirection((0.02, 1.0), (0.0, 0.1))
    only = (wb.Factor("R", ways[0].paths, ways[0].distribution, direction=moved),)
    found = wb.Specification(decay=limit).check_draws(linear, only, draws=200, seed=1)
    rising = np.min(-poles_of({"plant.J": 0.02, "plant.R": 1.5}).real) > limit
    share = found.share.value if not rising else 1 - found.share.value
    assert share == pytest.approx(0.7, abs=4 * np.sqrt(0.21 / 200))  # four standard errors of a binomial share


def test_what_cannot_be_drawn_is_refused_by_name(motor_loop):
    linear, limits = wb.linear_loop(motor_loop), wb.Specification(Ms=2.0)
    with pytest.raises(ValueError, match=r"check_draws\(factors"):
        limits.check_draws(linear, ())
    with pytest.raises(ValueError, match=r"check_draws\(draws"):
        limits.check_draws(linear, factors(0.1), draws=0)
    with pytest.raises(LookupError, match=r"There is no 'plant\.Q'"):
        limits.check_draws(linear, (wb.Factor("Q", ("plant.Q",), wb.Uniform(1.0, 2.0)),))
