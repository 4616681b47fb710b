"""A run's bits are its own: they do not depend on company, place, threads, vectors or on what else varies."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.engine import job, simulate
from workbench.engine.job import Job
from workbench.engine.metrics import rmse, step_with_metrics, total_variation

pytest.importorskip("llvmlite")  # there is no wheel of it for some platforms, where another engine serves

from studies.paper import laws as paper_laws
from workbench.engine.kernel import native
from workbench.engine.kernel.plan import KernelPlan

ODE = paper_laws.proposed_repaired("FS").ode()
STEP = step_with_metrics(ODE, (rmse(), total_variation(1e-3)), 1e-4)
RUNS = 21  # two blocks of eight and a part, or five of four and a part
SPAN = {"until": 0.2, "every": 0.05}
PHYSICS = ["plant.arm.links[0].mass", "plant.arm.links[1].length", "controller.phi"]
CLOCKS = ["reference.frequency", "plant.disturbance.frequency"]


def rows(*names):
    rng = np.random.default_rng(7)
    return ODE.parameters.pack(
        {
            name: ODE.parameters.unpack(ODE.parameters.default)[name]
            * rng.uniform(0.9, 1.1, (RUNS, *ODE.parameters[name].shape))
            for name in names
        }
    )


P = rows(*PHYSICS, *CLOCKS)
STARTS = np.tile(STEP.states.default, (RUNS, 1))
STARTS[:, :2] += np.random.default_rng(8).uniform(-0.1, 0.1, (RUNS, 2))
PLAN = KernelPlan.of_step(STEP, Job(STEP, P, 1, 0, np.arange(RUNS)).varied_parameters)


@pytest.fixture(scope="module")
def whole():
    """The states of all runs together."""
    return simulate(STEP, P, STARTS, **SPAN).x


def test_the_order_of_the_runs_changes_no_bit(whole):
    order = np.random.default_rng(9).permutation(RUNS)
    np.testing.assert_array_equal(simulate(STEP, P[order], STARTS[order], **SPAN).x, whole[order])


@pytest.mark.parametrize("size", [1, 3, 8, 20])
def test_cutting_the_batch_changes_no_bit(size, whole):
    parts = [simulate(STEP, P[i : i + size], STARTS[i : i + size], **SPAN).x for i in range(0, RUNS, size)]
    np.testing.assert_array_equal(np.concatenate(parts), whole)


@pytest.mark.parametrize("threads", [1, 2, 5])
def test_the_number_of_threads_changes_no_bit(threads, monkeypatch, whole):
    monkeypatch.setattr(job, "threads", lambda: threads)
    np.testing.assert_array_equal(simulate(STEP, P, STARTS, **SPAN).x, whole)


@pytest.mark.parametrize("width", [1, 2, 4, 8])
def test_the_width_of_the_vectors_changes_no_bit(width, whole):
    x = np.empty_like(whole)
    x[:, 0] = STARTS
    native.march(Job(STEP, P, 500, 0, np.arange(RUNS)), x, lambda share: None, width)
    np.testing.assert_array_equal(x, whole)


@pytest.mark.parametrize("haste", [True, False])
def test_code_made_in_haste_gives_the_bits_of_better_code(haste, monkeypatch, whole):
    monkeypatch.setattr(native, "_kernel", lambda of, kept, width: native.kernel(PLAN, width, haste))
    x = np.empty_like(whole)
    x[:, 0] = STARTS
    native.march(Job(STEP, P, 500, 0, np.arange(RUNS)), x, lambda share: None)
    np.testing.assert_array_equal(x, whole)


@pytest.mark.parametrize("names", [PHYSICS, CLOCKS], ids=["physics", "clocks"])
def test_a_number_that_varies_in_company_and_not_alone_changes_no_bit(names):
    # alone, every number is equal in all runs: what was made per run, or in the loop, is made once, or tabled
    p = rows(*names)
    together = simulate(STEP, p, **SPAN).x
    for i in (0, 7, 20):
        np.testing.assert_array_equal(simulate(STEP, p[i], **SPAN).x[0], together[i])


def test_keeping_more_times_changes_no_bit(monkeypatch, whole):
    often = simulate(STEP, P, STARTS, until=0.2, every=1e-4).x
    np.testing.assert_array_equal(often[:, ::500], whole)
    monkeypatch.setattr(job, "STEPS_AT_ONCE", 170)  # a table that ends amid a stride and amid a vector
    np.testing.assert_array_equal(simulate(STEP, P, STARTS, **SPAN).x, whole)
    monkeypatch.setattr(job, "STEPS_OF_A_STAGE", 1)  # a look at progress after every table
    np.testing.assert_array_equal(simulate(STEP, P, STARTS, **SPAN).x, whole)
    monkeypatch.setattr(job, "NUMBERS_OF_A_STAGE", 1)
    monkeypatch.setattr(job, "BLOCKS_OF_A_LOT", 1)
    np.testing.assert_array_equal(simulate(STEP, P, STARTS, **SPAN).x, whole)


def test_neighbours_that_diverge_change_no_bit(whole):
    bad = STARTS.copy()
    bad[[2, 9, 10], 0] = [1e200, -1e300, 1e13]
    beside = simulate(STEP, P, bad, **SPAN)
    good = np.setdiff1d(np.arange(RUNS), [2, 9, 10])
    np.testing.assert_array_equal(beside.x[good], whole[good])
    assert beside.has_diverged[[2, 9]].all()
    assert not beside.has_diverged[good].any()


def test_the_half_step_from_one_kernel_is_that_of_a_kernel_of_its_own():
    whole, half = (step_with_metrics(ODE, (rmse(),), h) for h in (1e-4, 5e-5))
    first = simulate(half, P, until=0.1, every=0.1).x
    simulate(whole, P, until=0.1, every=0.1)
    np.testing.assert_array_equal(simulate(replace(half), P, until=0.1, every=0.1).x, first)
