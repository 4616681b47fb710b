"""The bounds of what single precision costs a law: against its floats, at switches, and in words."""

import casadi as ca
import numpy as np
import pytest

from studies.paper.laws import rival
from tests.support.cases import heavy_but
from tests.support.recorded_laws import LOOPS, by_hand, recorded
from workbench.handover.single.rounding_bounds import rounding_bound
from workbench.handover.single.rounding_rules import CLOSE
from workbench.handover.single.rounding_statement import (
    box_of,
    ceiling,
    command_places,
    percent,
    stated_bound,
)
from workbench.handover.single.single_precision import single_precision

UNIT = 2.0**-24


def sides(law, k, z, y, r=None):
    """What floats differ from doubles in, and the bounds of that: memory and commands side by side."""
    floats, held = single_precision(law, k, z, y, r), rounding_bound(law, k, z, y, r)
    doubles = np.concatenate([held.z_next, held.u], axis=1)
    with np.errstate(invalid="ignore"):
        off = np.abs(np.concatenate(floats, axis=1).astype(float) - doubles)
    return off, np.concatenate([held.z_bound, held.u_bound], axis=1)


def of_reading(command, y, **names):
    """Difference and bound of u = command(y), row by row."""
    y = np.atleast_2d(np.asarray(y, float))
    law = by_hand(lambda y, k, p: command(y), readings=y.shape[1], **names)
    off, bound = sides(law, 0, np.zeros((len(y), 0)), y)
    return off[:, 0], bound[:, 0]


@pytest.mark.parametrize("name", heavy_but(LOOPS, "motor PID", "SMC", "LQG"))
def test_the_floats_of_every_law_are_within_their_bounds(name):
    law, k, z, y, r = recorded(name)
    off, bound = sides(law, k, z, y, r)
    assert (off <= bound).all()
    assert np.isfinite(bound).all()
    box, draws = box_of(z, y, r), np.random.default_rng(0)
    points = np.split(draws.uniform(*box, (2000, len(box.low))), np.cumsum([z.shape[1], y.shape[1]]), axis=1)
    off, bound = sides(law, draws.integers(0, 1000, 2000), *points)
    assert (off <= bound).all()
    assert np.isfinite(bound).mean() > 0.99
    assert np.median((bound / np.maximum(off, 1e-300))[np.isfinite(bound) & (off > 0)]) < 100  # and not idle


def rough(y):
    """The second reading with the rounding of a thousand, which CasADi sees no way around."""
    return ca.fabs(y[1] + 1000) - 1000


OPERATIONS = {
    "sum": lambda y: y[0] + y[1],
    "difference of products": lambda y: y[0] * y[1] - y[1] * y[2] - y[0] * y[2],
    "quotient": lambda y: y[0] / y[1],
    "reciprocal of a difference": lambda y: 1 / (y[0] - y[1]),
    "root": lambda y: ca.sqrt(ca.fabs(y[0] - y[1])),
    "root of squares": lambda y: ca.sqrt((y[0] - y[1]) ** 2 + y[2] * y[2]),
    "sine": lambda y: ca.sin(100 * (y[0] - y[1])),
    "cosine": lambda y: ca.cos(100 * y[0] * y[1]),
    "exponential": lambda y: ca.exp(5 * y[0] * y[1]),
    "exponential far below": lambda y: ca.exp(-90 + y[0] + y[1]),
    "logarithm": lambda y: ca.log(ca.fabs(y[0] * y[1] - y[2])),
    "hyperbolic tangent": lambda y: ca.tanh(y[0] * y[1] - y[2]),
    "angle": lambda y: ca.atan2(y[0] * y[1], y[1] - y[2]),
    "remainder": lambda y: ca.fmod(10 * y[0] * y[1], y[2]),
    "floor": lambda y: ca.floor(10 * y[0] * y[1]) * y[2],
    "saturation": lambda y: ca.fmin(ca.fmax(y[0] * y[1], -0.5), 0.5 * y[2]),
    "sign": lambda y: ca.sign(y[0] - y[1]) * y[2],
    "switch": lambda y: ca.if_else(ca.logic_and(y[0] < y[1], ca.logic_not(y[1] < y[2])), y[0] * y[1], y[2] * 3.3),
    "either": lambda y: ca.if_else(ca.logic_or(y[0] <= y[1] * y[2], y[1] == y[2]), y[0], -y[2]),
    "smaller of an exact and a rough one": lambda y: ca.fmin(y[0], rough(y)),
    "larger of an exact and a rough one": lambda y: ca.fmax(y[0], rough(y)),
    "switch where branches meet": lambda y: ca.if_else(y[0] < rough(y), y[0], rough(y)),
    "rounding up": lambda y: ca.ceil(10 * y[0] * y[1]) * y[2],
    "arc tangent": lambda y: ca.atan(5 * y[0] * y[1]),
    "arc sine": lambda y: ca.asin(0.9 * ca.tanh(y[0] * y[1])),
    "arc cosine": lambda y: ca.acos(0.9 * ca.tanh(y[0] * y[1])),
    "length": lambda y: ca.hypot(y[0] * y[1], y[1] - y[2]),
    "exponential less one": lambda y: ca.expm1(y[0] * y[1] - y[2]),
    "logarithm of one more": lambda y: ca.log1p(ca.fabs(y[0] * y[1] - y[2])),
    "hyperbolic sine": lambda y: ca.sinh(y[0] * y[1] - y[2]),
    "hyperbolic cosine": lambda y: ca.cosh(y[0] * y[1] - y[2]),
    "inverse hyperbolic sine": lambda y: ca.asinh(5 * y[0] * y[1] - y[2]),
    "inverse hyperbolic cosine": lambda y: ca.acosh(1.01 + ca.fabs(y[0] * y[1] - y[2])),
    "inverse hyperbolic tangent": lambda y: ca.atanh(0.9 * ca.tanh(y[0] * y[1])),
    "sign of another": lambda y: ca.copysign(y[0] * y[1], y[1] - y[2]),
    "power": lambda y: ca.fabs(y[0]) ** 1.7,
}


@pytest.mark.parametrize("name", OPERATIONS)
@pytest.mark.parametrize("near", [1.0, 1e-3, 1e-7])
def test_the_floats_of_every_operation_are_within_their_bounds(name, near):
    draws = np.random.default_rng(1)
    y = draws.normal(size=(20_000, 1)) + near * draws.normal(size=(20_000, 3))  # near: readings that cancel
    off, bound = of_reading(OPERATIONS[name], y)
    held = np.isfinite(bound)
    assert (off[held] <= bound[held]).all()
    if near == 1.0:
        assert held.mean() > 0.99
        assert (off > 0).any()


def test_what_is_copied_differs_by_its_own_rounding():
    y = np.random.default_rng(0).normal(size=(1000, 1))
    off, bound = of_reading(lambda y: -y, y)
    np.testing.assert_allclose(off, bound, rtol=1e-12)
    assert (off <= bound).all()
    assert (of_reading(lambda y: 2 * y, np.float32(y))[1] <= 2 * UNIT * np.abs(2 * y[:, 0])).all()


def test_a_sum_of_two_floats_is_off_by_half_a_unit_in_the_last_place():
    y = np.random.default_rng(0).uniform(1.0, 2.0, (1000, 2)).astype(np.float32)
    off, bound = of_reading(lambda y: y[0] + y[1], y)
    np.testing.assert_allclose(bound, UNIT * y.astype(float).sum(axis=1), rtol=1e-6)
    assert (off <= bound).all()


def relay(y):
    """A switch of the sum of two readings that no float has."""
    return 5.0 * ca.sign(y[0] + y[1])


def test_a_relay_has_no_bound_where_its_sign_is_within_rounding_and_says_so():
    law = by_hand(lambda y, k, p: relay(y), readings=2, s=lambda y: y[0] + y[1])
    y = np.array([[0.1, -0.1 + 1e-9], [0.1, -0.1 + 1e-6]])
    held = rounding_bound(law, 0, np.zeros((2, 0)), y)
    assert held.u_bound[0, 0] == np.inf
    assert held.u_bound[1, 0] < 6 * UNIT  # of the product alone
    assert held.has_bound.tolist() == [False, True]
    assert [held.reasons.get(cause) for cause in held.u_cause[:, 0]] == ["sign of s", None]


def test_a_switch_between_branches_that_meet_has_a_bound_and_one_that_jumps_has_none():
    y = [[1.0 / 3.0, 1.0 / 3.0 - 1e-10]]
    _, meets = of_reading(lambda y: ca.if_else(y[0] < y[1], 2 * y[0], 2 * y[1]), y)
    assert 0 < meets[0] < 4 * CLOSE * UNIT
    assert of_reading(lambda y: ca.if_else(y[0] < y[1], 1.0, 2.0), y)[1] == np.inf
    assert of_reading(lambda y: ca.if_else(y[0] < y[1] - 1e-3, 1.0, 2.0), y)[1] == 0


def test_a_limit_that_acts_leaves_no_error_of_what_it_cuts():
    _, bound = of_reading(lambda y: ca.fmax(ca.fmin(1000 * y[0] * y[1], 5.0), -5.0), [[0.3, 0.3], [0.001, 0.3]])
    assert bound[0] == 0
    assert 0 < bound[1] < 1e-6


@pytest.mark.parametrize(
    ("command", "y", "reason"),
    [
        (lambda y: 1 / (y[0] - y[1]), [0.1, 0.1], "reciprocal of a part of u"),
        (lambda y: ca.sqrt(y[0] - y[1]), [0.1, 0.1 + 1e-12], "root of a part of u"),
        (lambda y: ca.floor(y[0] + y[1]), [0.1, 0.9], "floor of a part of u"),
        (lambda y: ca.exp(y[0]) * y[1], [100.0, 1.0], "exponential of y.y[0]"),
        (lambda y: ca.sin(y[0]) * y[1], [10_000.0, 1.0], "sine of y.y[0]"),
        (lambda y: ca.atan2(y[0] - y[1], -1), [0.1, 0.1], "angle of -1 and a part of u"),
        (lambda y: (y[0] * y[0]) * y[1], [1e30, 1.0], "size of a part of u"),
        (lambda y: ca.if_else(y[0] < y[1], 3.0, 5.0), [0.1, 0.1 + 1e-12], "y.y[0] < y.y[1]"),
    ],
)
def test_an_operation_without_a_bound_is_named(command, y, reason):
    law = by_hand(lambda y, k, p: command(y), readings=2, u=command)
    held = rounding_bound(law, 0, np.zeros((1, 0)), [y])
    assert np.isinf(held.u_bound).all()
    assert [held.reasons[held.u_cause[0, 0]]] == [reason]


def test_a_stated_bound_is_repeated_by_its_seed():
    law, _, z, y, r = recorded("motor PID")
    again = [stated_bound(law, *box_of(z, y, r), samples=12_000, seed=3).u_bound for _ in range(2)]
    np.testing.assert_array_equal(*again)


def test_a_statement_says_how_often_no_bound_holds_and_why():
    law = by_hand(lambda y, k, p: relay(y), readings=2, s=lambda y: y[0] + y[1])
    stated = stated_bound(law, [1.0, -1.001], [1.001, -1.0], samples=200_000)
    # the sum spreads over 2e-3 as a triangle, and its sign is lost within the rounding of two readings at its middle
    assert 0.3 * UNIT / 1e-3 < stated.unbounded_share < 3 * UNIT / 1e-3
    assert stated.reasons == {"sign of s": stated.unbounded_share}
    assert f"at {percent(stated.unbounded_share)} of them a decision is within its rounding" in stated.sentence
    assert stated.sentence.endswith(f"no bound holds: sign of s ({percent(stated.unbounded_share)}).")


def test_the_command_of_a_law_with_a_delay_is_the_one_that_it_makes():
    loop = rival("FS", "PID")
    late, soon = (loop.digital(1e-3, delay=delay).law() for delay in (3, False))
    assert [(late.memory.labels + late.commands.labels)[i] for i in command_places(late)] == [
        "hold.next.3[0]",
        "hold.next.3[1]",
    ]
    _, _, z, y, r = recorded("PID")
    z = z[:, : soon.memory.size]
    waiting = np.concatenate([z, np.zeros((len(z), late.memory.size - z.shape[1]))], axis=1)
    bounds = []
    for law, x in ((late, waiting), (soon, z)):
        held = rounding_bound(law, 0, x, y, r)
        bounds.append(np.concatenate([held.z_bound, held.u_bound], axis=1).max(axis=0)[command_places(law)])
    np.testing.assert_array_equal(*bounds)


def test_a_box_is_a_tenth_wider_than_the_run():
    box = box_of([[0.0], [10.0]], [[1.0, -2.0], [1.0, 2.0]])
    np.testing.assert_allclose(box.low, [-0.5, 1.0, -2.2])
    np.testing.assert_allclose(box.high, [10.5, 1.0, 2.2])


def test_stated_numbers_are_rounded_up():
    assert [ceiling(x) for x in (0.0, 0.00496, 3.01e-4, 7.0, 12.3, 8.01e-5)] == [
        "0",
        "0.005",
        "0.00031",
        "7",
        "13",
        "8.1e-05",
    ]
    assert percent(0.000201) == "0.021 %"


def test_a_box_of_another_size_is_refused_by_name():
    law = recorded("motor PID").law
    with pytest.raises(ValueError, match=r"stated_bound\(low=...\)"):
        stated_bound(law, [0.0], [1.0])
    size = law.memory.size + law.readings.size + law.references.size
    with pytest.raises(ValueError, match=r"stated_bound\(high=...\).*`low`"):
        stated_bound(law, np.ones(size), np.zeros(size))
