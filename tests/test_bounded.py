"""Verdicts on the numbers that proofs lean on."""

from dataclasses import replace

import casadi
import casadi as ca
import numpy
import numpy as np
import pytest

from workbench.core import Dynamics
from workbench.proofs.bounded import (
    bounded,
    disturbance,
    lipschitz,
    lipschitz_coriolis,
    lipschitz_gravity,
    lipschitz_inverse_mass,
)
from workbench.proofs.bounds import guarantee
from workbench.robots import named, paper_arm

t, x = ca.SX.sym("t"), ca.SX.sym("x", 2)
DERIVED = Dynamics.of(paper_arm())
SINES = ca.vertcat(3 * ca.sin(2 * t), 4 * ca.sin(2 * t))


def replayed(verdict, **given):
    """What the line that a verdict prints gives."""
    return eval(verdict.replay, {"numpy": numpy, "casadi": casadi} | given)


def test_the_bounds_of_a_sine_disturbance_are_proved_in_closed_form():
    size, slope = disturbance(SINES, t, 20.0, D_max=5.0000001, L_D=10.0000002)  # 5 sin 2t along (3, 4) / 5
    assert size.kind == slope.kind == "proved"
    assert (size.bound, slope.bound) == pytest.approx((5.0, 10.0), rel=2e-8)
    assert 5.0 <= size.bound <= 5.0000001
    assert 10.0 <= slope.bound <= 10.0000002
    assert guarantee() in size.evidence
    assert size.statement == "|D(t)| <= 5 for t in [0, 20] s"


def test_a_limit_that_is_met_exactly_stays_open_unless_an_interval_meets_it_too():
    size, _ = disturbance(SINES, t, 20.0, D_max=5.0)
    assert size.kind == "not refuted"
    assert "what is seen reaches the limit, and what is proved exceeds the limit by" in size.evidence
    assert bounded(ca.sin(t), t, 0.0, 20.0, 1.0).kind == "proved"


@pytest.mark.parametrize("excess", [5e-9, 1e-12])
def test_a_limit_that_is_exceeded_by_less_than_any_tolerance_is_refuted(excess):
    refuted = bounded((1 + excess) * ca.cos(t), t, -1.0, 1.0, 1.0)
    assert refuted.kind == "refuted"
    assert f"exceed the limit by {excess:.2g} of itself" in refuted.evidence
    rotated = ca.vertcat(ca.cos(t), ca.sin(t) * ca.cos(x[0]))  # of norm 1 at x = 0
    assert bounded((1 + excess) * rotated, ca.vertcat(t, x[0]), -1.0, 1.0, 1.0).kind == "refuted"
    assert bounded(ca.diag((1 + excess) * rotated), ca.vertcat(t, x[0]), -1.0, 1.0, 1.0).kind == "refuted"


@pytest.mark.parametrize("room", [5e-9, 1e-7])
def test_a_limit_that_is_kept_by_less_than_the_tolerance_is_proved(room):
    verdict = bounded((1 - room) * ca.cos(t) ** 3 * ca.sqrt(1 + 0 * t), t, -1.0, 1.0, 1.0)
    assert verdict.kind == "proved"
    assert verdict.bound <= 1.0


def test_a_disturbance_beyond_its_stated_bounds_is_refuted_by_a_line_that_shows_it():
    size, slope = disturbance(SINES, t, 20.0, D_max=4.9, L_D=9.0)
    for verdict, exact in ((size, 5.0), (slope, 10.0)):
        assert verdict.kind == "refuted"
        assert verdict.seen == pytest.approx(exact, rel=1e-12)
        assert replayed(verdict, D=SINES, t=t) == pytest.approx(verdict.seen, rel=1e-12)


def test_without_a_limit_the_least_bound_is_named():
    size, _ = disturbance(ca.sin(t) + ca.sin(ca.sqrt(2) * t) / 2, t, 50.0)
    dense = np.linspace(0, 50, 1_000_001)
    seen = np.abs(np.sin(dense) + np.sin(np.sqrt(2) * dense) / 2).max()
    assert size.kind == "proved"
    assert seen <= size.bound
    assert size.bound == pytest.approx(seen, rel=1e-7)


def test_a_disturbance_that_jumps_has_a_size_and_no_slope():
    size, slope = disturbance(ca.sign(ca.sin(t)), t, 20.0, D_max=1.0, L_D=1.0)
    assert size.kind == "proved"
    assert slope.kind == "not checkable"
    assert "SIGN" in slope.evidence
    assert slope.seen is None


def test_a_disturbance_with_a_pole_is_not_checkable_and_the_pole_is_named():
    for verdict in disturbance(1 / (t - 3.3), t, 20.0):
        assert verdict.kind == "not checkable"
        assert "3.3" in verdict.evidence


def test_a_saturated_disturbance_is_proved_by_its_own_interval():
    # its slope is up to 1000, and its tops are flat to 4e-9: no tangent would do
    size, slope = disturbance(ca.tanh(10 * ca.sin(100 * t)), t, 100.0, D_max=1.0)
    assert size.kind == "proved"
    assert slope.bound == pytest.approx(1000.0, rel=2e-8)


def test_between_seen_and_proved_the_verdict_is_open():
    wavy = ca.sin(9 * x[0]) * ca.sin(9 * x[1] + x[0] * x[1]) + ca.tanh(x[0] - x[1])
    verdict = bounded(wavy, x, -3.0, 3.0, 1.99998, boxes=5)
    assert verdict.kind == "not refuted"
    assert "samples" in verdict.evidence
    assert "the budget of 5 boxes was used up" in verdict.evidence


def test_a_limit_that_is_far_from_what_is_seen_is_proved_without_the_last_digit():
    wavy = ca.sin(9 * x[0]) * ca.sin(9 * x[1] + x[0] * x[1]) + ca.tanh(x[0] - x[1])
    assert bounded(wavy, x, -3.0, 3.0, 3.0, boxes=1000).kind == "proved"


def test_the_lipschitz_constant_of_a_linear_map_is_its_norm():
    A = np.array([[1.0, 2.0], [3.0, 4.0]])
    verdict = lipschitz(ca.DM(A) @ x, x, -1.0, 1.0)
    assert verdict.bound == pytest.approx(np.linalg.norm(A, 2), rel=2e-8)
    assert lipschitz(ca.DM(A) @ x, x, -1.0, 1.0, 5.0).kind == "refuted"


def pairs(rng, low, high, count=20_000):
    a = rng.uniform(low, high, (count, len(low)))
    return a, np.clip(a + rng.normal(size=a.shape) * 10.0 ** rng.uniform(-4, 0, (count, 1)), low, high)


@pytest.mark.parametrize(
    ("make", "states"),
    [
        (lambda d: lipschitz_gravity(d), 2),
        (lambda d: lipschitz_inverse_mass(d), 2),
        (lambda d: lipschitz_coriolis(d, 2.0), 4),
    ],
)
def test_no_two_sampled_states_differ_by_more_than_the_lipschitz_constant_says(make, states):
    d, p = DERIVED, DERIVED.p.default
    verdict = make(d)
    assert verdict.kind == "proved"
    assert replayed(verdict, dynamics=d) == pytest.approx(verdict.seen, rel=1e-12)
    what = {"|dG": d.G, "|dM": ca.vec(ca.inv(d.M)), "|d(": d.C @ d.qd}[verdict.statement[:3]]
    f = ca.Function("f", [ca.vertcat(d.q, d.qd), d.symbols], [what])
    high = np.array([np.pi, np.pi, 2.0, 2.0])
    a, b = pairs(np.random.default_rng(3), -high, high)
    a[:, states:] = b[:, states:] = 0.0
    rise = np.linalg.norm(np.array(f(a.T, p)) - np.array(f(b.T, p)), axis=0)
    far = np.linalg.norm(a - b, axis=1)
    # differences of numbers of size 10 carry 1e-14, over distances from 1e-5 on
    assert (rise[far > 1e-5] <= verdict.bound * far[far > 1e-5] * (1 + 1e-8)).all()
    assert (rise[far > 1e-5] / far[far > 1e-5]).max() > 0.7 * verdict.bound


def test_the_lipschitz_constant_of_the_pendulum_is_its_weight():
    # G = m g c sin q with m = 1, c = 1/2
    verdict = lipschitz_gravity(Dynamics.of(named("planar-1r")), limit=9.81 / 2 * (1 + 1e-7))
    assert verdict.kind == "proved"
    assert verdict.bound == pytest.approx(9.81 / 2, rel=2e-8)


def test_a_wrong_gravity_breaks_the_constant_of_the_right_one():
    limit = lipschitz_gravity(DERIVED).bound
    broken = replace(DERIVED, G=DERIVED.G + ca.vertcat(3 * ca.sin(5 * DERIVED.q[0]), 0))
    verdict = lipschitz_gravity(broken, limit=limit)
    assert verdict.kind == "refuted"
    assert replayed(verdict, dynamics=broken) == pytest.approx(verdict.seen, rel=1e-12)


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda: bounded(x[0], x, 0, 1, -1.0), "must be a positive number"),
        (lambda: bounded(x[0], x, 0, 1, np.nan), "must be a positive number"),
        (
            lambda: disturbance(SINES, t, 0.0),
            r"`disturbance\(until=...\)` must be a positive, finite number of seconds",
        ),
        (lambda: disturbance(SINES * x[0], t, 1.0), "'x_0' is missing"),
        (lambda: lipschitz_gravity(DERIVED, 1.0, -1.0), "`lipschitz_gravity"),
    ],
)
def test_what_cannot_be_asked_is_refused(call, says):
    with pytest.raises(ValueError, match=says):
        call()
