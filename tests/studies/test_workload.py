"""The workload of the study of speed: its right-hand sides, and the peers that run it."""

import re
import tomllib

import casadi as ca
import numpy as np
import pytest

from studies.paper.workload import PARAMETERS, STATES, VARIATION_RANGES, H, arm, loop, rmse, rows_of, run, workload
from studies.performance.peers import PEERS
from studies.performance.processes import chain
from studies.performance.right_hand_sides import in_matrices, in_scalars
from tests.house import sources
from workbench.arms.dynamics import Dynamics
from workbench.arms.mechanics import paper_arm
from workbench.engine import simulate


def test_w_has_21_states_and_40_parameters_of_which_10_vary():
    p = rows_of(50)
    assert (loop().states.size, loop().parameters.size) == (21, 40)
    assert (p != p[0]).any(axis=0).sum() == 10
    for name, (low, high) in VARIATION_RANGES.items():
        times = p[:, PARAMETERS.slice(name)] / PARAMETERS[name].default
        assert low <= times.min() < times.max() <= high


def test_more_runs_begin_with_the_same_ones():
    np.testing.assert_array_equal(rows_of(20)[:7], rows_of(7))


def test_w_is_stable_and_its_error_is_that_of_its_prototype():
    step = workload()
    runs = simulate(step, np.vstack([PARAMETERS.default, rows_of(63)]), until=10.0, every=10.0)
    assert not runs.has_diverged.any()
    # the prototype left out the friction, which damps the first swing of joint 1 by a few percent
    np.testing.assert_allclose(rmse(runs.x[0, -1], 10.0), (0.83, 0.94), rtol=0.08)


def test_the_arm_of_w_is_that_of_the_paper():
    q, qd, mass, length, gravity = (ca.SX.sym(name, size) for name, size in zip("qvmlg", (2, 2, 2, 2, 1), strict=True))
    ours = ca.Function("arm", [q, qd, mass, length, gravity], list(arm(q, qd, mass, length, gravity)))
    state = [0.4, -1.1], [0.7, 1.9]
    derived = Dynamics.of(paper_arm()).matrices(*state)
    for mine, theirs in zip(ours(*state, [1, 1], [1, 1], 9.81), derived, strict=True):
        # sums of some ten terms of size 1 to 20
        np.testing.assert_allclose(np.array(mine).reshape(theirs.shape), theirs, rtol=0, atol=1e-13)


def by_hand(rate, steps):
    """State and total variation after so many steps of RK4."""
    x, before, variation = STATES.default, None, 0.0
    for k in range(steps):
        t = k * H
        k1, tau = rate(t, x)
        k2, _ = rate(t + H / 2, x + H / 2 * k1)
        k3, _ = rate(t + H / 2, x + H / 2 * k2)
        k4, _ = rate(t + H, x + H * k3)
        x = x + H / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        variation += 0.0 if before is None else np.abs(tau - before).sum()
        before = tau
    return x, variation


def scalars(p):
    rate = in_scalars(np)

    def both(t, x):
        parts = np.array(rate(t, x, p))
        return parts[: STATES.size], parts[STATES.size :]

    return both


@pytest.mark.parametrize("written", [in_matrices, scalars])
def test_the_right_hand_side_written_by_hand_is_that_of_casadi(written):
    p, steps = rows_of(3)[2], 300
    step = workload()
    x = step.states.default
    for k in range(steps):
        x = np.array(step.F(k, x, p, [])).ravel()
    state, variation = by_hand(written(p), steps)
    # rounding of 300 steps, which a loop that forgets its past does not amplify
    np.testing.assert_allclose(state, x[: STATES.size], rtol=1e-11, atol=1e-12)
    np.testing.assert_allclose(variation, x[-1], rtol=1e-10)


@pytest.mark.parametrize("peer", PEERS, ids=lambda peer: peer.package)
def test_a_peer_runs_the_same_loop(peer):
    if not peer.is_installed:
        pytest.skip("not installed")
    if peer.package == "numba":
        pytest.importorskip("llvmlite", reason="numba compiles with llvmlite")
    p, horizon = rows_of(3), 0.2
    # RK4 at the same step differs by rounding, a solver of variable step by its tolerance
    tolerance = {"control": 1e-2, "scipy": 1e-4}.get(peer.package, 1e-12)
    np.testing.assert_allclose(peer.runner(horizon)(p), run(p, horizon), rtol=tolerance)


def test_the_peers_are_needed_anyhow_or_named_by_the_extra_that_installs_them():
    project = tomllib.loads((sources.ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    named_there = project["dependencies"] + project["optional-dependencies"]["peers"]
    assert {peer.package for peer in PEERS} <= {re.match(r"[\w-]+", line)[0] for line in named_there}


def test_the_loop_of_n_links_comes_to_rest_where_it_hangs():
    step = chain(3)
    runs = simulate(step, x0=step.states.pack({"plant.q": [0.3, -0.2, 0.1]}), until=4.0, every=4.0)
    assert np.abs(runs["q"][0, -1]).max() < 0.01
