"""Few runs at a step and at its half go side by side, and nobody can tell."""

import sys
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from workbench.core import Entry, Layout, Ode, rk4
from workbench.metrics import measured, rmse, total_variation
from workbench.metrics.accumulators import maker
from workbench.plants import ArmInstruments
from workbench.simulate import arithmetic, job, simulate, simulate_both
from workbench.simulate.job import Job
from workbench.simulate.marches import march_of_pairs

pytest.importorskip("llvmlite")  # there is no wheel of it for some platforms, where two marches serve

sys.path.insert(0, str(Path(__file__).parent.parent / "studies"))
import paper_laws

LOOP = paper_laws.rival("FS", "ASMC")
ODE = LOOP.ode()
MAKE = maker(ODE, (rmse(), total_variation(1e-3)))
WHOLE, HALF = MAKE("rk4", 1e-3), MAKE("rk4", 5e-4)
CUBIC = Layout((Entry("x", np.zeros(1)),))
SPAN = {"until": 0.3, "every": 0.05}
CLOCKS = {"reference.frequency": [[2.0, 3.0], [2.5, 2.0]], "plant.arm.links[0].mass": [1.0, 1.2]}
P = ODE.parameters.pack({name: np.array(values) for name, values in CLOCKS.items()})
STARTS = np.tile(HALF.states.default, (2, 1)) + 0.01 * np.arange(2)[:, np.newaxis] * (np.arange(HALF.states.size) < 2)


def apart(p, x0, whole=WHOLE, half=HALF, **span):
    return simulate(whole, p, x0, **span), simulate(half, p, x0, **span)


def same(pair, other):
    for a, b in zip(pair, other, strict=True):
        np.testing.assert_array_equal(a.x, b.x)
        np.testing.assert_array_equal(a.t, b.t)
        np.testing.assert_array_equal(a.diverged_at, b.diverged_at)
        assert a.diverged_in == b.diverged_in
        assert a.step.h == b.step.h


@pytest.mark.parametrize("runs", [1, 2])
def test_a_step_beside_its_half_changes_no_bit(runs):
    assert march_of_pairs(Job(HALF, P[:runs], 2, 0, np.arange(runs))) is not None
    same(simulate_both(WHOLE, HALF, P[:runs], STARTS[:runs], **SPAN), apart(P[:runs], STARTS[:runs], **SPAN))


def test_a_pair_has_the_bits_of_runs_in_company():
    together = apart(np.repeat(P, 4, axis=0), np.repeat(STARTS, 4, axis=0), **SPAN)
    for one, all_ in zip(simulate_both(WHOLE, HALF, P, STARTS, **SPAN), together, strict=True):
        np.testing.assert_array_equal(one.x, all_.x[::4])


def test_a_table_that_ends_amid_a_long_step_changes_no_bit(monkeypatch):
    usual = simulate_both(WHOLE, HALF, P, STARTS, **SPAN)
    monkeypatch.setattr(job, "STEPS_AT_ONCE", 7)
    same(simulate_both(WHOLE, HALF, P, STARTS, **SPAN), usual)
    monkeypatch.setattr(job, "STEPS_OF_A_STAGE", 1)
    same(simulate_both(WHOLE, HALF, P, STARTS, **SPAN), usual)


@pytest.mark.parametrize("start", [3.5, 5.5, 9.0], ids=["neither", "the longer", "both"])
def test_each_of_a_pair_is_lost_for_itself(start):
    x = ca.SX.sym("x")
    cubic = Ode.of("cubic", CUBIC, Layout(), (ca.SX.sym("t"), x, ca.SX(0, 1)), {"x": -(x**3)}, {})
    whole, half = (rk4(cubic, h) for h in (0.1, 0.05))
    span = {"x0": np.array([[start]]), "until": 2.0, "every": 0.2}
    pair = simulate_both(whole, half, **span)
    same(pair, (simulate(whole, **span), simulate(half, **span)))
    assert [bool(runs.diverged[0]) for runs in pair] == [start > 5, start > 7]


def test_more_runs_go_one_step_after_the_other():
    p = np.repeat(P, 2, axis=0)
    assert march_of_pairs(Job(HALF, p, 2, 0, np.arange(4))) is None
    same(simulate_both(WHOLE, HALF, p, until=0.1, every=0.05), apart(p, None, until=0.1, every=0.05))


def test_where_nothing_can_be_compiled_there_are_two_marches(monkeypatch):
    def missing(name):
        raise ImportError("there is no compiler")

    monkeypatch.setattr(arithmetic, "native", missing)
    same(simulate_both(WHOLE, HALF, until=0.02, every=0.01), apart(None, None, until=0.02, every=0.01))


def test_the_noise_of_a_run_alone_is_that_in_company():
    sampled = LOOP.digital(5e-3, ArmInstruments(2, noise_q=1e-4))
    step = measured(sampled, (rmse(),), 5e-3)
    together = simulate(step, np.tile(step.parameters.default, (5, 1)), until=0.5, every=0.1, seed=3)
    alone = simulate(step, until=0.5, every=0.1, seed=3, runs=np.array([4]))
    np.testing.assert_array_equal(alone.x[0], together.x[4])
    assert not np.array_equal(together.x[3], together.x[4])
