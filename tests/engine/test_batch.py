"""simulate: many runs of one step."""

from itertools import pairwise

import numpy as np
import pytest

from tests.support.compilers import COMPILES, NATIVE, needs_llvmlite
from tests.support.equations import decay, explosion, oscillator
from workbench.core import rk4
from workbench.engine import arithmetic, batch, job, simulate
from workbench.engine.kernel import casadi_machine, numpy_kernel


def test_the_oscillator_follows_its_closed_form_in_every_run():
    ode = oscillator()
    omega = np.array([0.5, 1.0, 2.0, 3.0])
    runs = simulate(rk4(ode, 1e-3), ode.parameters.pack({"omega": omega}), until=2.0, every=0.1)
    exact = np.cos(omega[:, np.newaxis] * runs.t)
    # RK4 at 1 ms: the error of a mode of 3 rad/s after 2 s is below (3e-3)^4 * 6 / 120
    np.testing.assert_allclose(runs["q"][:, :, 0], exact, atol=1e-11)


def test_kept_times_are_multiples_of_every_and_begin_at_the_initial_state():
    runs = simulate(rk4(decay(), 0.01), until=1.0, every=0.25)
    np.testing.assert_allclose(runs.t, [0, 0.25, 0.5, 0.75, 1.0], atol=1e-15)
    assert runs.x.shape == (1, 5, 1)
    assert runs["x"][0, 0, 0] == 1.0


def test_keeping_fewer_times_changes_no_bit_of_what_is_kept():
    step = rk4(oscillator(), 0.01)
    all_steps, few = simulate(step, until=3.0), simulate(step, until=3.0, every=0.3)
    np.testing.assert_array_equal(all_steps.x[:, ::30], few.x)


def test_a_run_does_not_depend_on_its_neighbours():
    ode = oscillator()
    omega = np.array([0.7, 1.9, 2.3])
    step = rk4(ode, 0.01)
    together = simulate(step, ode.parameters.pack({"omega": omega}), until=2.0)
    for i, value in enumerate(omega):
        alone = simulate(step, ode.parameters.pack({"omega": value}), until=2.0)
        np.testing.assert_array_equal(alone.x[0], together.x[i])


def test_a_horizon_longer_than_one_chunk_is_one_trajectory():
    step = rk4(decay(0.1), 1e-4)
    runs = simulate(step, until=6.0, every=0.5)  # 60,000 steps: three chunks
    np.testing.assert_allclose(runs["x"][0, :, 0], np.exp(-0.1 * runs.t), rtol=1e-12)


def test_a_diverged_run_is_marked_with_its_time_and_leaves_the_others_alone():
    ode = explosion()
    step = rk4(ode, 1e-3)
    starts = ode.states.pack({"x": np.array([[1.0], [0.1], [2.0]])})
    runs = simulate(step, x0=starts, until=2.0, every=0.1)
    np.testing.assert_array_equal(runs.has_diverged, [True, False, True])
    # escape at 1 / x(0); RK4 runs a few steps past it before its numbers overflow
    np.testing.assert_allclose(runs.diverged_at[[0, 2]], [1.0, 0.5], atol=0.02)
    assert np.isnan(runs.diverged_at[1])
    np.testing.assert_allclose(runs["x"][1, -1, 0], 0.1 / (1 - 0.2), rtol=1e-9)
    assert np.isnan(runs.x[0, -1]).all()


def test_the_time_of_divergence_does_not_depend_on_the_kept_times():
    step = rk4(explosion(), 1e-3)
    coarse, fine = simulate(step, until=2.0, every=0.5), simulate(step, until=2.0)
    assert coarse.diverged_at[0] == fine.diverged_at[0]


def test_progress_rises_to_one():
    seen: list[float] = []
    simulate(rk4(decay(), 1e-4), until=6.0, every=0.1, progress=seen.append)
    assert seen == sorted(seen)
    assert seen[-1] == 1.0


def test_outputs_are_those_of_the_kept_states():
    runs = simulate(rk4(oscillator(), 0.01), until=1.0, every=0.5)
    np.testing.assert_array_equal(runs["tau_applied"], runs["plant.qd"])


def test_a_misspelt_output_is_answered_with_what_there_is():
    runs = simulate(rk4(decay(), 0.01), until=1.0)
    with pytest.raises(LookupError, match=r"no 'y'.*x, e"):
        runs["y"]


def test_one_run_becomes_a_data_frame_indexed_by_time():
    frame = simulate(rk4(oscillator(), 0.01), until=1.0, every=0.5).to_frame()
    assert list(frame.columns) == ["plant.q [rad]", "plant.qd [rad/s]", "q", "e", "q_ref", "tau_applied"]
    assert frame.index.name == "t [s]"
    assert len(frame) == 3


@pytest.mark.parametrize(
    ("times", "sentence"),
    [
        ({"until": 0.0}, "must be a positive, finite number of seconds; got 0"),
        ({"until": -1.0}, "got -1"),
        ({"until": float("nan")}, "got nan"),
        ({"until": float("inf")}, "got inf"),
        ({"until": "ten"}, r"`simulate\(until=...\)` must be a number; got 'ten'"),
        ({"until": "1"}, "must be a number; got '1'"),
        ({"until": [1.0, 2.0]}, r"must be a number; got \[1.0, 2.0\]"),
        ({"until": None}, "must be a number; got None"),
        ({"until": 1.005}, "must be a multiple of the step 0.01 s; got 1.005 s"),
        ({"until": 1.0, "every": 0.015}, "multiple of the step"),
        ({"until": 1.0, "every": 0.03}, "must be a multiple of `every`"),
        ({"until": 1e9}, "would need 745 GB"),
        ({"until": 1.7e308}, r"`simulate\(until=...\)` must be at most 2\^53 times the step 0.01 s"),
        ({"until": 1.0, "every": 1.7e308}, r"`simulate\(every=...\)` must be at most 2\^53 times the step 0.01 s"),
        ({"until": 1e14, "every": 1e14}, r"must be at most 2\^53 times"),
    ],
)
def test_a_bad_time_is_refused_in_one_sentence(times, sentence):
    with pytest.raises(ValueError, match=sentence):
        simulate(rk4(decay(), 0.01), **times)


def test_rows_of_wrong_shape_or_out_of_bounds_are_refused():
    ode = oscillator()
    step = rk4(ode, 0.01)
    with pytest.raises(ValueError, match=r"one row per run: \(B, 1\). Got \(3, 4\)"):
        simulate(step, np.ones((3, 4)), until=1.0)
    with pytest.raises(ValueError, match="'omega' must be finite, with 0 < value"):
        simulate(step, np.array([[-1.0]]), until=1.0)
    with pytest.raises(ValueError, match=r"'plant.q\[0\]' must be finite"):
        simulate(step, x0=np.array([[np.nan, 0.0]]), until=1.0)
    with pytest.raises(ValueError, match="got 3 rows of p and 2 rows of x0"):
        simulate(step, np.ones((3, 1)), np.ones((2, 2)), until=1.0)


def test_what_is_no_step_is_refused_with_the_way_to_make_one():
    with pytest.raises(ValueError, match=r"must be a `StepMap`; got an `Ode`: wrap it in `rk4\(ode, h\)`\."):
        arithmetic.default_for(decay())
    with pytest.raises(
        ValueError, match=r"`simulate\(step=...\)` must be a `StepMap`, an `Ode`, .* a `ClosedLoop` does"
    ):
        simulate(3, until=1.0)


def test_no_runs_at_all_are_refused_and_so_is_text():
    step = rk4(oscillator(), 0.01)
    with pytest.raises(ValueError, match=r"`simulate\(x0=...\)` needs at least one run; got no rows"):
        simulate(step, x0=np.zeros((0, 2)), until=1.0)
    with pytest.raises(ValueError, match=r"`simulate\(p=...\)` must be numbers, .* got \[\['2'\]\]"):
        simulate(step, [["2"]], until=1.0)


@pytest.mark.parametrize("runs", [1, 7, 30_000])
def test_a_call_of_casadis_machine_is_as_small_as_its_runs_are_many(runs):
    step = rk4(decay(), 0.01)
    together = simulate(step, x0=np.linspace(1, 2, runs)[:, np.newaxis], until=0.05, engine="casadi")
    alone = simulate(step, until=0.05, engine="casadi")
    np.testing.assert_array_equal(together.x[0], alone.x[0])


def test_casadis_machine_hands_back_no_parameter_at_a_kept_time():
    marcher = casadi_machine._marcher(rk4(decay(), 0.1), 2, 5, 3)
    assert marcher.size_out(0) == (1 + 1, 5 * 3)


def test_a_billion_runs_are_refused_with_their_time_and_memory_before_the_start():
    step = rk4(oscillator(), 1e-3)
    starts = np.broadcast_to(step.states.default, (10**9, 2))
    with pytest.raises(ValueError, match=r"would need 29\.8 GB of memory for its states; the limit is 4 GB"):
        batch.afford(step, len(starts), 10_000, 1)
    few = np.broadcast_to(step.states.default, (10**5, 2))
    with pytest.raises(ValueError, match=r"would take about \d+ hours of one processor for 100000 runs of 10000000000"):
        batch.afford(step, len(few), 10**10, 1)


def test_the_memory_of_a_run_that_keeps_its_end_alone_does_not_grow_with_the_horizon():
    import tracemalloc

    step, peaks = rk4(oscillator(), 1e-3), []
    starts = np.tile(step.states.default, (500, 1))
    for until in (20.0, 200.0) if COMPILES else (2.5, 7.5):  # all longer than one table of time
        tracemalloc.start()
        simulate(step, x0=starts, until=until, every=until)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < 1.2 * peaks[0]


def test_a_notebook_shows_one_line_of_a_step_and_of_its_runs():
    step = rk4(explosion(), 1e-3)
    assert repr(step) == "<Step of 'explosion': h = 0.001 s, 1 states>"
    runs = simulate(step, x0=np.array([[1.0], [0.1]]), until=2.0, every=1.0)
    assert repr(runs) == "<2 runs of 'explosion' at 3 times to 2 s, 1 diverged>"


def test_one_row_of_parameters_is_not_copied_for_every_run():
    step = rk4(oscillator(), 1e-3)
    runs = simulate(step, x0=np.tile(step.states.default, (50, 1)), until=1e-3)
    assert runs.p.shape == (50, 1)
    assert runs.p.strides[0] == 0


@pytest.mark.parametrize("engine", [NATIVE, "numpy", "casadi"])
def test_an_oscillator_is_an_oscillator_on_every_engine(engine):
    runs = simulate(rk4(oscillator(), 1e-3), until=3.0, every=0.5, engine=engine)
    np.testing.assert_allclose(runs["q"][0, :, 0], np.cos(2 * runs.t), atol=1e-11)


@pytest.mark.parametrize(("stride", "kept"), [(1, 5000), (7, 900), (4500, 3)])
def test_the_stages_of_a_march_follow_on_and_keep_no_more_rows_than_there_is_room_for(stride, kept):
    step = rk4(oscillator(), 1e-3)
    made = job.Job(step, np.tile(step.parameters.default, (512, 1)), stride, 0, np.arange(512))
    found = list(job.stages(made, kept, 512))
    for stage in found:
        assert len(stage) == 1 or sum(piece.rows for piece in stage) * 512 * 2 <= job.NUMBERS_OF_A_STAGE
        assert max(piece.rows for piece in stage) * 512 * 2 <= job.NUMBERS_OF_A_STAGE
    every = [piece for stage in found for piece in stage]
    assert sum(piece.length for piece in every) == stride * kept
    assert all(a.begin + a.length == b.begin for a, b in pairwise(every))
    assert [piece.whole for piece in every].count(True) == len({piece.row for piece in every})


@needs_llvmlite
def test_a_step_of_very_many_operations_is_compiled_only_when_asked(monkeypatch):
    step = rk4(oscillator(), 0.01)
    p = np.tile(step.parameters.default, (2, 1))
    asked = job.Job(step, p, 1, 0, np.arange(2), arithmetic="fused")
    compiled = arithmetic.march_of(asked, "native")
    assert arithmetic.march_of(asked) is compiled
    assert simulate(step, p, until=0.1).arithmetic == arithmetic.default_for(step) == "fused"
    monkeypatch.setattr(arithmetic, "MOST_COMPILED", step.operations // 2 - 1)
    assert simulate(step, p, until=0.1).arithmetic == "casadi"
    assert arithmetic.default_for(step) == "casadi"
    assert arithmetic.march_of(asked) is numpy_kernel.march
    assert arithmetic.march_of(asked, "native") is compiled
