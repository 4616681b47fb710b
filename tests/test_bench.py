"""bench: the workload, its right-hand sides, and the table; no time is asserted."""

import json
import re
import subprocess
import sys
import tomllib
from dataclasses import replace

import casadi as ca
import house_rules as rules
import numpy as np
import pytest

from studies.performance import accuracy, engine, table
from studies.performance.effort import Effort, ours, rows_of
from studies.performance.kernels import flops
from studies.performance.links import chain, inverse_dynamics, mass_matrix
from studies.performance.peak import CHAINS, UNROLLED, summed
from studies.performance.peers import PEERS, Peer, casadi_cvodes
from studies.performance.row import Row
from studies.performance.workload import PARAMETERS, STATES, VARIED, H, arm, draw, loop, rmse, workload
from studies.performance.written import in_matrices, in_scalars
from workbench.core import Dynamics, Entry, Layout, Ode, rk4
from workbench.robots import PlanarArm, paper_arm
from workbench.robots.planar_arm import PointMass
from workbench.simulate import simulate
from workbench.study.document.document import Strong

TINY = Effort(
    horizon=0.01,
    repetitions=1,
    processes=1,
    seconds=1e-9,
    runs=8,
    batch=8,
    samples=4,
    sizes=(8,),
    fallback=8,
    many=8,
    links=(2, 3),
)


def test_w_has_21_states_and_40_parameters_of_which_10_vary():
    p = draw(np.random.default_rng(1), 50)
    assert (loop().states.size, loop().parameters.size) == (21, 40)
    assert (p != p[0]).any(axis=0).sum() == 10
    for name, (low, high) in VARIED.items():
        times = p[:, PARAMETERS.slice(name)] / PARAMETERS[name].default
        assert low <= times.min() < times.max() <= high


def test_more_runs_begin_with_the_same_ones():
    np.testing.assert_array_equal(rows_of(20)[:7], rows_of(7))


def test_w_is_stable_and_its_error_is_that_of_its_prototype():
    step = workload()
    runs = simulate(step, np.vstack([PARAMETERS.default, rows_of(63)]), until=10.0, every=10.0)
    assert not runs.diverged.any()
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


MASSES_AND_LENGTHS = ((1.0, 0.7), (0.6, 1.1), (1.3, 0.4))


@pytest.mark.parametrize("n", [2, 3])
def test_the_arm_of_n_links_has_the_matrices_derived_from_energies(n):
    q, qd = np.linspace(0.3, -1.2, n), np.linspace(1.0, -0.5, n)
    M, C, G = Dynamics.of(PlanarArm(tuple(PointMass(m, l) for m, l in MASSES_AND_LENGTHS[:n]))).matrices(q, qd)
    mass, length = (ca.SX(ca.DM(column)) for column in zip(*MASSES_AND_LENGTHS[:n], strict=True))
    bias = inverse_dynamics(ca.SX(q), ca.SX(qd), ca.SX.zeros(n), mass, length, ca.SX(9.81))
    # sums of some ten terms of size 1 to 20
    np.testing.assert_allclose(np.array(ca.evalf(mass_matrix(ca.SX(q), mass, length))), M, rtol=0, atol=1e-13)
    np.testing.assert_allclose(np.array(ca.evalf(bias)).ravel(), C @ qd + G, rtol=0, atol=1e-12)


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
    if not peer.installed:
        pytest.skip("not installed")
    p, horizon = rows_of(3), 0.2
    # RK4 at the same step differs by rounding, a solver of variable step by its tolerance
    tolerance = {"control": 1e-2, "scipy": 1e-4}.get(peer.package, 1e-12)
    np.testing.assert_allclose(peer.runner(horizon)(p), ours(p, horizon), rtol=tolerance)


def test_cvodes_comes_nearer_to_the_fine_reference_as_its_tolerance_shrinks():
    p, horizon = rows_of(3), 0.2
    wanted = ours(p, horizon, 1e-5)
    errors = [accuracy.error(casadi_cvodes.runner(horizon, tolerance)(p), wanted) for tolerance in (1e-3, 1e-5, 1e-8)]
    assert errors[0] > 10 * errors[1] > 100 * errors[2]


def test_the_peak_kernel_adds_one_in_every_chain():
    rounds = 1000
    np.testing.assert_array_equal(summed(rounds), rounds * UNROLLED * CHAINS)


def decays(n):
    """So many numbers that decay, each at its own rate."""
    states, parameters = (Layout((Entry(name, np.ones(n)),)) for name in ("x", "rate"))
    t, x, p = ca.SX.sym("t"), states.symbols(), parameters.symbols()
    return rk4(Ode.of("decays", states, parameters, (t, x, p), {"x": -p * ca.sin(x)}, {"e": x}), 0.1)


def test_twice_the_equations_are_twice_the_operations():
    assert 4 * 10 < flops(decays(1), (0,)) < 4 * 60  # four sines by polynomials, and what is around them
    assert flops(decays(6), range(6)) == 6 * flops(decays(1), (0,))


def test_the_coarsest_setting_within_the_error_is_found_from_above():
    found = accuracy.coarsest(lambda h: h**2, 1e-4, 1e-5, 1.0)
    assert found <= 1e-2 * (1 + 1e-9) < found * 10 ** (1 / accuracy.STEPS_A_DECADE) * (1 + 2e-9)
    with pytest.raises(ValueError, match="has a larger error at every setting down to 0.1"):
        accuracy.coarsest(lambda h: h, 1e-3, 0.1, 1.0)


def test_a_run_that_is_lost_counts_as_infinitely_wrong():
    assert accuracy.error(np.array([[np.nan, 1.0]]), np.ones((1, 2))) == np.inf


def test_the_table_has_a_row_for_each_bar_and_json_says_it_all():
    there = Peer("one that is there", "numpy", 1e9, 2, lambda horizon: lambda p: ours(p, horizon))
    absent = Peer("one that is not", "no-such-package", 7.0, 2, lambda horizon: pytest.fail("it is not there"))
    said = []
    rows = list(table.measured(TINY, say=said.append, peers=(there, absent)))
    read = json.loads(table.as_json(rows))
    assert len(said) == len(rows) == 2 + len(table.EQUAL) + len(engine.TARGETS)
    for row in read["rows"]:
        assert {"name", "runs_per_s", "ratio", "bar", "reached"} <= row.keys()
        assert row["reached"] in (True, False, None)
        assert row["ratio"] is None or "unit" not in row
    first, second, *rest = read["rows"]
    assert (first["reached"], first["runs_per_s"] > 0, first["error"] < 1) == (False, True, True)
    assert (second["reached"], second["ratio"], second["note"]) == (
        None,
        None,
        "not installed: pip install control-workbench[peers]",
    )
    unmeasured = {row["name"] for row in rest if row["reached"] is None}
    assert unmeasured <= {"two threads over one"}  # which needs two
    assert {"cpu", "python", "numpy"} <= read["machine"].keys()


def test_a_peer_that_cannot_be_imported_is_said_and_stops_nothing():
    def broken(horizon):
        raise ImportError("numpy is too new for it")

    (row,) = table.measured(TINY, "broken", peers=(Peer("broken", "numpy", 2.0, 2, broken),))
    assert (row.reached, row.note) == (None, "not measured, it cannot be imported: numpy is too new for it")


def test_without_a_compiler_what_is_about_compiled_code_is_not_measured(monkeypatch):
    monkeypatch.setattr(engine, "find_spec", lambda name: None)
    (row,) = table.measured(TINY, "cached kernel")
    assert (row.reached, row.value) == (None, None)
    assert "llvmlite has no wheel" in row.note


def test_a_bar_that_is_missed_is_said_with_its_figure_and_one_that_was_not_measured_is_not_missed():
    rows = [
        Row("slow", 10.0, 3.0, 4.5, error=1.2e-3),
        Row("light", 1.0, value=0.25, unit="GB", at_most=True),
        Row("gone", 14.0, note="not installed: pip install control-workbench[peers]"),
    ]
    text = table.as_text(rows)
    assert [row.reached for row in rows] == [False, True, None]
    slow, light, gone = (next(line for line in text.splitlines() if line.startswith(row.name)) for row in rows)
    assert slow.split() == ["slow", "3", "4.5", "x", "≥", "10", "x", "1.2e-03", "MISSED"]
    assert light.split() == ["light", "0.25", "GB", "≤", "1", "GB", "reached"]
    assert gone.endswith("not measured")
    assert "gone: not installed: pip install control-workbench[peers]" in text
    assert "1 reached, 1 MISSED, 1 not measured" in text


def test_a_row_that_is_not_there_is_named():
    with pytest.raises(LookupError, match="There is no 'nombar' in the names of the rows"):
        list(table.measured(TINY, "nombar"))


def test_the_peers_are_needed_anyhow_or_named_by_the_extra_that_installs_them():
    project = tomllib.loads((rules.ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    named_there = project["dependencies"] + project["optional-dependencies"]["peers"]
    assert {peer.package for peer in PEERS} <= {re.match(r"[\w-]+", line)[0] for line in named_there}


def test_compile_time_is_fitted_over_the_size(monkeypatch):
    monkeypatch.setattr(engine, "compilation", lambda effort: tuple((n, 100.0 * n, 0.01 * n**2) for n in (2, 4, 8)))
    assert engine.growth(TINY).value == pytest.approx(2.0)


def test_the_loop_of_n_links_follows_its_reference():
    runs = simulate(rk4(chain(3), H), until=2.0, every=2.0)
    # errors of proportional action: gravity of some 60 N m over a gain of 400
    assert np.abs(runs["e"][0, -1]).max() < 0.3


def test_the_report_tells_of_every_row():
    from studies.performance import study

    rows = [
        Row("slow peer", 10.0, 3.0, 4.5, error=1e-3),
        Row("absent peer", 14.0, note="not installed"),
        Row("memory", 1.0, value=0.25, unit="GB", at_most=True, note="in 3 s"),
    ]
    shown = study.bars(rows)
    assert [row[0] for row in shown.rows] == [row.name for row in rows]
    assert [row[-1] for row in shown.rows] == [Strong("MISSED"), "not measured", "reached"]
    assert study.notes(rows).items == ("absent peer: not installed.", "memory: in 3 s.")
    (panel,) = study.speed_figure(rows).panels
    assert "slow peer" in [series.label for series in panel.series]
    assert "absent peer" not in [series.label for series in panel.series]


def test_a_peer_is_imported_by_its_own_file_alone():
    assert rules.open_side_doors({"studies/performance/peers/python_control.py": "import control"}) == []
    for library in ("control", "jax", "numba"):
        assert rules.open_side_doors({"studies/performance/table.py": f"import {library}"})


def test_the_table_is_there_before_any_peer_is_imported():
    code = "import sys, studies.performance.table; sys.exit(bool({'control', 'jax', 'numba'} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_what_a_pilot_chooses_for_an_error_has_that_error_in_the_runs_of_a_call(monkeypatch):
    effort = replace(TINY, horizon=0.1, batch=12, samples=6)
    runner, how = accuracy.ours_at_equal_accuracy(1e-4, effort)
    wanted = accuracy.reference(effort.horizon, effort.fine, effort.samples)
    found = runner(rows_of(effort.batch))
    assert found.shape == (12, 2)
    assert accuracy.error(found, wanted) <= 1e-4
    assert "in calls of 12, each with pilot runs" in how
    monkeypatch.setattr(accuracy, "OURS", (1e-2, 1e-1))  # a search that finds nothing tries all there is
    with pytest.raises(ValueError, match=r"`ours_at_equal_accuracy\(target=1e-15\)` is reached by no tolerance"):
        accuracy.ours_at_equal_accuracy(1e-15, effort)
