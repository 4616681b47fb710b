"""What the batch engine cannot run is refused at its door; what is a number of another kind is run as it is."""

import re

import casadi as ca
import numpy as np
import pytest

from tests.support.equations import decay
from workbench.core import Layout, Ode, layout, rk4
from workbench.engine import Trajectories, arithmetic, simulate, step_limit
from workbench.engine.batch import LARGEST_COPY, table_of
from workbench.engine.reference import reference_of_function, reference_run

ODE = decay()
STEP = rk4(ODE, 0.1)

REFUSED = [
    (
        lambda: simulate(STEP, until=1.0, progress=len),
        "`simulate(progress=...)` must be a function of the share that is",
    ),
    (lambda: simulate(STEP, until=1.0, engine="gpu"), "`simulate(engine=...)` is one of 'native', 'numpy', 'casadi'"),
    (
        lambda: step_limit(simulate(STEP, until=1.0), 1),
        "`step_limit(run=...)` must be a whole number from 0 to 0; got 1.",
    ),
    (
        lambda: reference_run(ODE, times=[1.7e308, -1.7e308]),
        "finite numbers of seconds that increase, from 0 on; got [1.7e+308",
    ),
    (lambda: arithmetic.default_for("x"), "`default_for(step=...)` must be a `StepMap`; got 'x'."),
    (lambda: arithmetic.signature(3), "`simulate(arithmetic=...)` is one of 'fused', 'portable', 'casadi'; got 3."),
    (lambda: reference_run(STEP, times=[1.0]), "`reference_run(ode=...)` must be an `Ode`; got a `StepMap`."),
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


def test_what_has_no_state_is_refused_by_every_engine():
    t, none = ca.SX.sym("t"), ca.SX(0, 1)
    clock = Ode("clock", Layout(), Layout(), layout(y="s"), t, none, none, none, t)
    for engine in ("native", "numpy", "casadi"):
        with pytest.raises(ValueError, match="at least one state, as nothing else moves; 'clock' has none"):
            simulate(rk4(clock, 0.1), until=1.0, engine=engine)


@pytest.mark.parametrize("whole", [np.int8, np.uint64, np.array])
@pytest.mark.parametrize("real", [np.float32, np.longdouble, np.array])
def test_numbers_of_any_kind_run_as_pythons(whole, real):
    plain = simulate(STEP, [[2.0]], [[0.5]], until=1.0, every=0.5, seed=3, noise_keys=[4])
    other = simulate(
        STEP, [[real(2)]], [[real(0.5)]], until=real(1), every=real(0.5), seed=whole(3), noise_keys=[whole(4)]
    )
    np.testing.assert_array_equal(plain.x, other.x)
    assert type(other.job.seed) is int
    one = reference_run(ODE, times=[real(0.5)], rtol=real(2**-20), atol=real(2**-20), max_steps=whole(100))
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
