"""What the batch engine cannot run is refused at its door; what is a number of another kind is run as it is."""

import re

import casadi as ca
import numpy as np
import pytest
from equations import decay
from workbench.simulate.stepping.schedule import Segment

from workbench.core import Layout, Ode, layout, rk4, stepper
from workbench.reference import reference, reference_of_function
from workbench.simulate import (
    Schedule,
    Trajectories,
    arithmetic,
    check_by_halving,
    choose,
    pilot_rows,
    run,
    simulate,
    simulate_alike,
    simulate_both,
    step_limit,
)
from workbench.simulate.batch import LARGEST_COPY, table_of

ODE = decay()
STEP = rk4(ODE, 0.1)
P = X0 = np.ones((2, 1))
SCHEDULE = Schedule(0.1, (Segment("rk4", 1, 10),))


def make(method, h):
    return stepper(method)(ODE, h)


def ends(runs):
    return {"end": runs.x[:, -1]}


def halved(score=ends, **given):
    return check_by_halving(
        **({"schedule": SCHEDULE, "make": make, "p": P, "x0": X0, "tolerance": 0.1} | given), score=score
    )


MAKE = "`run(make=...)` must be a function of (method, h) that gives a `Step` of length h; it "
SCORE = "`check_by_halving(score=...)` must be a function of trajectories that gives arrays (2, k) by the names of "
REFUSED = [
    (lambda: run(SCHEDULE, lambda *a: "x", P, X0), MAKE + "gave 'x'."),
    (lambda: run(SCHEDULE, len, P, X0), MAKE + "raised TypeError: "),
    (
        lambda: run(SCHEDULE, lambda method, h: STEP, P, X0, 3),
        "must be a number of cells that divides the schedule's 10",
    ),
    (lambda: choose(lambda method, h: STEP, P, X0, 1.0, 0.1), "it gave one of 0.1 s for 5e-05 s."),
    (
        lambda: choose(make, P[0], X0, 1.0, 0.1),
        "`choose(p, x0)` takes rows (R, np) and (R, nx) of pilots; got shapes (1,), (2, 1).",
    ),
    (
        lambda: pilot_rows(P, X0[:1]),
        "`pilot_rows(p, x0)` takes rows (B, np) and (B, nx); got shapes (2, 1) and (1, 1).",
    ),
    (lambda: halved(lambda runs: None), SCORE),
    (lambda: halved(lambda runs: {"end": runs.x[0, -1]}), "it gave 'end' in shape (1,)."),
    (lambda: halved(lambda runs: runs.nothing), "it raised AttributeError: "),
    (lambda: halved(tolerance=-1), "`check_by_halving(tolerance=...)` must be a positive, finite number; got -1"),
    (lambda: Schedule(0.1, ()), "`Schedule(segments=...)` must be a tuple of at least 1 `Segment`; got none."),
    (lambda: Schedule(1.7e308, (Segment("rk4", 1, 10),)), "must be a finite number of seconds in all; got inf."),
    (
        lambda: simulate(STEP, until=1.0, progress=len),
        "`simulate(progress=...)` must be a function of the share that is",
    ),
    (lambda: simulate(STEP, until=1.0, engine="gpu"), "`simulate(engine=...)` is one of 'native', 'numpy', 'casadi'"),
    (
        lambda: simulate_both(STEP, ODE, until=1.0, every=0.1),
        "`simulate_both(half=...)` must be a `Step`; got an `Ode`: wrap it",
    ),
    (lambda: simulate_alike([(STEP, STEP)], until=[1.0, 2.0], every=0.1), "a horizon for each of the 1 pairs; got 2."),
    (
        lambda: step_limit(simulate(STEP, until=1.0), 1),
        "`step_limit(run=...)` must be a whole number from 0 to 0; got 1.",
    ),
    (
        lambda: reference(ODE, times=[1.7e308, -1.7e308]),
        "finite numbers of seconds that increase, from 0 on; got [1.7e+308",
    ),
    (lambda: arithmetic.has_graph("x"), "`has_graph(step=...)` must be a `Step`; got 'x'."),
    (lambda: arithmetic.signature(3), "`simulate(arithmetic=...)` is one of 'fused', 'portable', 'casadi'; got 3."),
    (lambda: reference(STEP, times=[1.0]), "`reference(ode=...)` must be an `Ode`; got a `Step`."),
    (
        lambda: reference_of_function(lambda t, x: 1j * x, [1.0], times=[1.0]),
        "a rate for each of the 1 states; got an array",
    ),
    (lambda: Trajectories(1, 2, 3, 4), "`Trajectories(job=...)` must be a `Job`; got 1."),
]


@pytest.mark.parametrize(("call", "says"), REFUSED, ids=[says[:50] for _, says in REFUSED])
def test_what_cannot_be_run_is_refused_at_the_door(call, says):
    with pytest.raises(ValueError, match=re.escape(says)):
        call()


def test_what_a_maker_of_steps_refuses_is_said_in_its_words():
    with pytest.raises(LookupError, match="^There is no method 'euler'"):
        run(Schedule(0.1, (Segment("euler", 1, 1),)), make, P, X0)


def test_what_has_no_state_is_refused_by_every_engine():
    t, none = ca.SX.sym("t"), ca.SX(0, 1)
    clock = Ode("clock", Layout(), Layout(), layout(y="s"), t, none, none, none, t)
    for engine in ("native", "numpy", "casadi"):
        with pytest.raises(ValueError, match="at least one state, as nothing else moves; 'clock' has none"):
            simulate(rk4(clock, 0.1), until=1.0, engine=engine)


@pytest.mark.parametrize("whole", [np.int8, np.uint64, np.array])
@pytest.mark.parametrize("real", [np.float32, np.longdouble, np.array])
def test_numbers_of_any_kind_run_as_pythons(whole, real):
    plain = simulate(STEP, [[2.0]], [[0.5]], until=1.0, every=0.5, seed=3, runs=[4])
    other = simulate(STEP, [[real(2)]], [[real(0.5)]], until=real(1), every=real(0.5), seed=whole(3), runs=[whole(4)])
    np.testing.assert_array_equal(plain.x, other.x)
    assert type(other.job.seed) is int
    assert Segment("rk4", whole(2), whole(3)) == Segment("rk4", 2, 3)
    assert len(run(SCHEDULE, make, P, X0, whole(5)).t) == 3
    one = reference(ODE, times=[real(0.5)], rtol=real(2**-20), atol=real(2**-20), most_steps=whole(100))
    assert one.x == pytest.approx(np.exp(-1.5), rel=1e-5)  # ten times the tolerance


def test_large_rows_are_taken_as_they_are_and_others_copied():
    large = np.ones((LARGEST_COPY // 8 + 1, 1))
    assert table_of("f(x=...)", ODE.states, large) is large
    assert not np.shares_memory(table_of("f(x=...)", ODE.states, large[:3]), large)


def test_what_is_told_begins_with_nothing_done():
    shares = []
    simulate(STEP, until=1.0, progress=shares.append)
    assert shares[0] == 0.0


def test_casadis_machine_counts_as_slow():
    assert not arithmetic.is_compiled(STEP, "casadi")
