"""No run is lost: one that diverges is marked with its time and its first bad state, the others are untouched."""

from functools import cache

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as some

from tests.support.compilers import ENGINES, NATIVE
from tests.support.equations import decay, explosion, with_next
from workbench.core import Entry, Layout, Ode, rk4
from workbench.engine import divergence, simulate
from workbench.engine.divergence import find_divergence
from workbench.engine.job import Job
from workbench.engine.kernel import casadi_machine

EACH = [NATIVE, "numpy", "casadi"]
STEP = rk4(explosion(), 1e-3)


@cache
def first_bad_step(x0):
    """The step at which the recursion, one step after the other, is no longer finite."""
    x, k = x0, 0
    with np.errstate(all="ignore"):
        while np.isfinite(x):
            x, k = float(STEP.F(k, x, [], [])), k + 1
    return k


@pytest.mark.parametrize("engine", EACH)
@pytest.mark.parametrize("every", [1e-3, 0.05, pytest.param(4.0, marks=pytest.mark.heavy)])
def test_the_time_is_that_of_the_first_step_that_is_not_finite(engine, every):
    starts = np.array([1.0, 0.1, 0.3, 3.0, 0.27])
    runs = simulate(STEP, x0=starts[:, np.newaxis], until=4.0, every=every, engine=engine)
    expected = [first_bad_step(x) * 1e-3 if x > 0.25 else np.nan for x in starts]
    np.testing.assert_allclose(runs.diverged_at, expected, rtol=1e-12)
    assert runs.diverged_in == tuple("x[0]" if x > 0.25 else None for x in starts)


@pytest.mark.parametrize("engine", EACH)
def test_rows_from_the_divergence_on_are_nan_and_those_before_it_are_kept(engine):
    runs = simulate(STEP, x0=np.array([[1.0], [0.5]]), until=1.5, every=0.1, engine=engine)
    bad = runs.t >= runs.diverged_at[0]
    assert np.isnan(runs.x[0, bad]).all()
    np.testing.assert_allclose(runs.x[0, ~bad, 0][:-1], 1 / (1 - runs.t[~bad][:-1]), rtol=1e-6)
    assert np.isfinite(runs.x[1]).all()


def chain():
    """Three states, of which the second explodes and takes the third with it."""
    states = Layout((Entry("calm", np.ones(1)), Entry("wild", np.ones(2)), Entry("led", np.zeros(()))))
    t, x = ca.SX.sym("t"), states.symbols()
    rates = {"calm": -x[0], "wild": ca.vertcat(-x[1], x[2] ** 2), "led": x[2]}
    return Ode.of("chain", states, Layout(), (t, x, ca.SX(0, 1)), rates, {"e": x[0]})


@pytest.mark.parametrize("engine", EACH)
def test_the_state_that_was_lost_first_is_named(engine):
    runs = simulate(rk4(chain(), 1e-3), until=2.0, every=0.5, engine=engine)
    assert runs.diverged_in == ("wild[1]",)


@pytest.mark.heavy
def test_many_diverging_runs_are_found_in_as_many_looks_as_digits(monkeypatch):
    monkeypatch.setattr(divergence, "ROWS", 10)
    looks = []

    def march(job, x, tell):
        looks.append(x.shape)
        casadi_machine.march(job, x, tell)

    starts = np.linspace(0.5, 0.52, 6)
    x = np.empty((6, 2, 1))
    x[:, 0, 0] = starts
    job = Job(STEP, np.zeros((6, 0)), 4000, 0, np.arange(6))
    casadi_machine.march(job, x, lambda share: None)
    found = find_divergence(job, x, march)
    np.testing.assert_allclose(found.at, [first_bad_step(x0) * 1e-3 for x0 in starts], rtol=1e-12)
    # 4,000 steps in tens: a look for all, then one for each place where some are
    assert sum(shape[0] * shape[1] for shape in looks) < 6 * 11 * 4
    assert all(shape[1] <= 11 for shape in looks)


def test_a_start_that_blows_up_at_once_is_a_divergence_at_the_first_step():
    runs = simulate(STEP, x0=np.array([[1e200], [0.1]]), until=0.1, every=0.1)
    np.testing.assert_array_equal(runs.diverged_at, [1e-3, np.nan])
    assert runs.x[1, -1, 0] == pytest.approx(0.1 / 0.99, rel=1e-9)


@pytest.mark.heavy
@pytest.mark.parametrize("engine", EACH)
@pytest.mark.parametrize("company", [[], [5.0]])
def test_a_state_that_is_finite_again_at_the_next_kept_time_is_finite_alone_and_in_company(engine, company):
    states, parameters = Layout((Entry("x", np.zeros(2)),)), Layout((Entry("pole", np.array(3.0)),))
    t, x, p = ca.SX.sym("t"), states.symbols(), parameters.symbols()
    ode = Ode.of("pole", states, parameters, (t, x, p), {"x": 0 * x + 0 * p}, {"e": x[0]})
    step = rk4(ode, 1.0)
    step = with_next(step, ca.vertcat(step.rule.x[0] + 1, 1 / (step.rule.k - step.rule.p[0] + 1)))
    runs = simulate(step, np.array([[2000.0], *([v] for v in company)]), until=5000.0, every=5000.0, engine=engine)
    assert not runs.has_diverged[0]
    np.testing.assert_array_equal(runs.x[0, 1], [5000.0, 1 / 3000.0])


def test_what_the_caller_does_to_his_rows_later_changes_no_result():
    p = np.array([[3.0], [4.0]])
    equation = decay()
    runs = simulate(rk4(equation, 0.1), p, until=1.0)
    before = runs["e"].copy()
    p[:] = 99.0
    np.testing.assert_array_equal(runs.p, [[3.0], [4.0]])
    np.testing.assert_array_equal(runs["e"], before)


def test_a_structural_zero_of_a_step_keeps_its_place():
    states = Layout((Entry("x", np.array([5.0, 7.0])),))
    x = states.symbols()
    ode = Ode.of("sparse", states, Layout(), (ca.SX.sym("t"), x, ca.SX(0, 1)), {"x": -x}, {"e": x[0]})
    after = ca.SX(2, 1)
    step = rk4(ode, 1.0)
    after[1] = 3 * step.rule.x[0]
    for engine in ENGINES:
        runs = simulate(with_next(step, after), until=1.0, engine=engine)
        np.testing.assert_array_equal(runs.x[0, 1], [0.0, 15.0])


@given(stride=some.integers(1, 10**6), most=some.integers(1, 20_000))
def test_a_march_to_one_far_time_is_cut_into_few_lengths(stride, most):
    pieces = casadi_machine._pieces(stride, most)
    assert sum(pieces) == stride
    assert set(pieces) <= {1 << i for i in range(10) if 1 << i <= most}
    assert len(pieces) <= stride // min(most // 2 + 1, casadi_machine.LONGEST) + 10
