"""A sweep: its runs, their errors, and the chunks that are the same wherever they are computed."""

import csv
import io
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from tests.support.samples import with_measurement
from tests.support.sweep_samples import Digital, sample
from tests.support.sweeps import RATE, START, Explosion, sweep
from workbench.engine.distributions import Uniform
from workbench.engine.factors import Factor
from workbench.engine.metrics import iae, measure, rmse
from workbench.study import run_tables, study_cost
from workbench.study.compiled_sweep import compile_sweep
from workbench.study.executors import on_threads
from workbench.study.ledger.store import RunCounter, chunks, complete, open_ledger
from workbench.study.sweep_runs import tasks_of
from workbench.study.uncertainty import ListedPoints, MonteCarlo


def held(out):
    """The names of the records of a ledger."""
    return [chunk.name for chunk in chunks(out)]


def test_a_sample_is_what_the_closed_form_says(tmp_path):
    found = sample(tmp_path, sweep())
    rate, start = found.factor_values.T
    # RK4 at 10 ms: the error is (rate h)^4 / 120 of the value, below 1e-8
    np.testing.assert_allclose(found.score("IAE").value, start * (1 - np.exp(-2 * rate)) / rate, rtol=1e-7)
    np.testing.assert_allclose(found.score("ISE").value, start**2 * (1 - np.exp(-4 * rate)) / (2 * rate), rtol=1e-7)
    assert (found.diverged_count, len(found), found.note.split(";")[0]) == (0, 50, "50 runs, 0 of them diverged")


def test_values_and_errors_are_those_of_measure(tmp_path):
    given = sweep(half_step_every=1)
    found, made = sample(tmp_path, given), compile_sweep(given)
    p, x0 = made.rows(0, 50)
    x0 = x0[:, : made.equation.states.size]
    theirs = measure(made.equation, given.run.metrics, p, x0, until=2.0, h=0.01, every=2.0)
    np.testing.assert_array_equal(found.score("IAE").error, theirs.score("IAE").error)
    np.testing.assert_array_equal(found.score("IAE").value, theirs.score("IAE").value)


def test_the_error_of_the_step_is_known_of_every_so_manyth_run(tmp_path):
    found = sample(tmp_path, sweep(half_step_every=7))
    assert found.measurement.looked_at.tolist() == list(range(0, 50, 7))
    assert found.measurement.errors.shape == (8, 1, 2)
    assert found.score("IAE").largest_error == found.measurement.errors[:, -1, 0].max()


def test_a_step_beyond_its_stability_limit_is_said_with_the_sample(tmp_path):
    # x' = -rate x decays under RK4 while h rate < 2.7853, the root of 1 - z + z^2/2 - z^3/6 + z^4/24 = 1
    fast = Factor("rate", ("rate",), Uniform(2.0, 9.0))
    found = sample(tmp_path / "a", sweep(factors=(fast, START), h=0.5, half_step_every=2))
    rates = found.factor_values[found.measurement.looked_at, 0]
    # the region is known to 1e-3: a crossing on a grid of 2001 radii
    np.testing.assert_allclose(found.measurement.limits, 2.78529356 / rates, rtol=1e-3)
    beyond = rates > 2.78529356 / 0.5
    assert 0 < beyond.sum() < len(rates)
    said = f"; BEYOND the stability limit in {beyond.sum()} of these, down to {found.measurement.limits.min():.3g} s"
    assert said in found.note
    assert "BEYOND" not in sample(tmp_path / "b", sweep(factors=(fast, START))).note
    assert (
        len(sample(tmp_path / "c", sweep(factors=(fast, START), h=0.5, half_step_every=None)).measurement.limits) == 0
    )


def test_a_limit_that_is_not_known_is_said(tmp_path):
    found = with_measurement(sample(tmp_path, sweep(half_step_every=25)), limits=np.array([np.nan, 1.0]))
    assert found.note.endswith("and half of it in 2 runs; stability limit not known of 1")


def test_metrics_over_time_are_those_of_shorter_horizons(tmp_path):
    long = sample(tmp_path / "long", sweep(every=0.5))
    assert long.t.tolist() == [0.5, 1.0, 1.5, 2.0]
    short = sample(tmp_path / "short", sweep(until=1.0))
    np.testing.assert_array_equal(long.over_time("IAE")[:, 1], short.score("IAE").value)


def test_a_run_that_diverges_is_counted_and_has_no_value_from_then_on(tmp_path):
    start = Factor("start", ("x",), Uniform(0.5, 2.0))
    given = sweep(loop=Explosion(), factors=(start,), design=MonteCarlo(1, 50), metrics=(iae(),), until=1.0, every=0.25)
    found = sample(tmp_path, given)
    lost = np.isfinite(found.diverged_at)
    # x(t) = 1 / (1 / x0 - t), and RK4 of a pole is late by some steps
    np.testing.assert_array_equal(found.factor_values[~lost, 0] < 1.1, True)
    np.testing.assert_array_equal(found.factor_values[lost, 0] > 0.9, True)
    assert found.diverged_count == lost.sum() > 10
    assert np.isnan(found.score("IAE").value[lost]).all()
    early = found.t < found.diverged_at[lost][:, np.newaxis]
    assert np.isfinite(found.over_time("IAE")[lost][early]).all()


def test_neither_chunks_nor_workers_change_a_bit(tmp_path):
    one = sample(tmp_path / "a", sweep())
    for i, (size, workers) in enumerate([(1, 1), (50, 2), (7, 3), (None, None)]):
        other = sample(tmp_path / f"b{i}", sweep(runs_of_chunk=size), workers=workers)
        assert other.values.tobytes() == one.values.tobytes()
        assert other.measurement.errors.tobytes() == one.measurement.errors.tobytes()
        assert other.measurement.limits.tobytes() == one.measurement.limits.tobytes()


def test_only_what_is_missing_is_computed_and_acknowledged_after_it_is_kept(tmp_path):
    one = compile_sweep(sweep())
    tasks = tasks_of([one])
    asked, acknowledged, states = [], [], []
    counter = RunCounter(50, lambda: lambda *state: states.append(state))

    def some(missing):
        asked.append([task.name for task in missing])
        return on_threads([one], missing[:3])

    with open_ledger(tmp_path) as ledger:
        with pytest.raises(ValueError, match="4 chunks were asked for and never came"):
            complete(tasks, ledger, some, counter, lambda c: acknowledged.append((c.name, c.name in ledger)))
        complete(tasks, ledger, lambda some: asked.append([t.name for t in some]) or on_threads([one], some))
    names = [task.name for task in tasks]
    assert asked == [names, names[3:]]
    assert acknowledged == [(name, True) for name in names[:3]]
    assert [done for done, _, _ in states] == [0, 8, 16, 24]


def test_runs_that_failed_before_a_study_was_stopped_are_counted_when_it_goes_on(tmp_path):
    lost = sweep(loop=Explosion(), factors=(START,), design=MonteCarlo(1, 50, seed=3))
    one, states = compile_sweep(lost), []
    tasks, counter = tasks_of([one]), RunCounter(50, lambda: lambda *state: states.append(state))
    with open_ledger(tmp_path) as ledger:
        with pytest.raises(ValueError, match="never came"):
            complete(tasks, ledger, lambda missing: on_threads([one], missing[:3]))
        complete(tasks, ledger, lambda missing: on_threads([one], missing), counter)
        found = one.sample(ledger.read(task.name) for task in tasks)
    assert states[0][1] > 0
    assert states[-1] == (50, found.diverged_count, 50)


def test_a_chunk_that_comes_twice_is_kept_once(tmp_path):
    one = compile_sweep(sweep())
    tasks = tasks_of([one])
    with open_ledger(tmp_path) as ledger:
        complete(tasks, ledger, lambda missing: on_threads([one], [*missing[:2], *missing]))
        assert len(ledger.names) == len(tasks)


@pytest.mark.parametrize(
    "change",
    [
        {"seed": 1},
        {"h": 0.005},
        {"until": 1.0},
        {"half_step_every": 2},
        {"every": 0.5},
        {"metrics": (iae(),)},
        {"design": MonteCarlo(2, 50, seed=4)},
        {"factors": (RATE, replace(START, distribution=Uniform(0.5, 1.9)))},
    ],
)
def test_whatever_changes_a_result_changes_the_name_of_its_chunk(change):
    one, other = compile_sweep(sweep()), compile_sweep(sweep(**change))
    assert one.name(0, 8) != other.name(0, 8)


def test_a_chunk_is_named_by_numbers_and_not_by_words():
    renamed = replace(iae(), name="another name", unit="furlong", about="other words")
    factors = (replace(RATE, name="another", distribution=Uniform(0.5, 3.0)), START)
    one, other = compile_sweep(sweep(metrics=(iae(),))), compile_sweep(sweep(metrics=(renamed,), factors=factors))
    assert one.name(0, 8) == other.name(0, 8)


def test_arithmetic_is_part_of_the_name():
    assert len({compile_sweep(sweep(), name).name(0, 8) for name in ("fused", "portable")}) == 2


def test_the_value_of_a_metric_is_computed_when_it_is_read(tmp_path):
    integral = rmse()
    doubled = replace(integral, finish=lambda value, horizon: 2 * integral.finish(value, horizon))
    once, twice = sample(tmp_path, sweep(metrics=(integral,))), sample(tmp_path, sweep(metrics=(doubled,)))
    np.testing.assert_array_equal(twice.values, 2 * once.values)
    assert len([name for name in held(tmp_path) if name.startswith("decay/")]) == 7


def test_more_samples_keep_the_chunks_that_are_there():
    few, many = (tasks_of([compile_sweep(sweep(design=MonteCarlo(2, size)))]) for size in (50, 96))
    assert {task.name for task in few[:-1]} < {task.name for task in many}


def test_several_paths_move_together(tmp_path):
    both = Factor("both", ("gains[0]", "gains[1]", "rate"), Uniform(0.5, 3.0))
    made = compile_sweep(sweep(factors=(both,), design=MonteCarlo(1, 5)))
    p, _ = made.rows(0, 5)
    values = made.space.values(made.sweep.design.points())
    np.testing.assert_array_equal(p[:, [0, 2, 3]], np.repeat(values, 3, axis=1))


def test_whole_numbers_of_any_kind_are_the_same_sweep_in_a_ledger(tmp_path):
    numbers = {"design": MonteCarlo(np.int8(2), np.int64(50), np.uint8(3)), "seed": np.int32(0)}
    other = sweep(**numbers, runs_of_chunk=np.int8(8), half_step_every=np.int64(16))
    plain = sample(tmp_path, sweep())
    before = held(tmp_path)
    np.testing.assert_array_equal(sample(tmp_path, other).values, plain.values)
    assert held(tmp_path) == before


def test_the_noise_of_a_run_is_its_own_whatever_chunk_it_is_in(tmp_path):
    width = Factor("boundary layer", ("controller.phi",), Uniform(0.05, 0.2))
    given = sweep(loop=Digital(), factors=(width,), design=MonteCarlo(1, 12), h=1e-3, until=0.2, half_step_every=5)
    one, other = (sample(tmp_path / f"{n}", replace(given, runs_of_chunk=n)) for n in (12, 5))
    assert one.values.tobytes() == other.values.tobytes()
    assert one.measurement.errors.tobytes() == other.measurement.errors.tobytes()
    assert len(np.unique(one.score("IAE", 1).value)) == 12
    seeded = sample(tmp_path / "seed", replace(given, run=replace(given.run, seed=1)))
    assert not np.isin(seeded.score("IAE").value, one.score("IAE").value).any()


def test_a_sample_knows_the_design_it_was_drawn_from(tmp_path):
    given = sweep()
    assert sample(tmp_path, given).design is given.design


def test_an_error_of_the_step_that_is_not_known_is_not_left_out(tmp_path):
    found = sample(tmp_path, sweep())
    values, errors = found.values.copy(), found.measurement.errors.copy()
    values[found.measurement.looked_at] = np.nan
    errors[1] = np.nan
    assert np.isnan(with_measurement(found, values=values, errors=errors * np.nan).score("IAE").largest_error)
    assert with_measurement(found, errors=errors).score("IAE").largest_error == np.inf


def test_a_table_is_the_same_in_whatever_blocks_it_is_written(tmp_path, monkeypatch):
    found = sample(tmp_path, sweep(every=0.5))
    whole = run_tables.to_csv(found)
    monkeypatch.setattr(run_tables, "BLOCK", 7)
    assert run_tables.to_csv(found) == whole
    table = pd.read_csv(io.BytesIO(whole))
    np.testing.assert_array_equal(table["IAE[e] [rad s]"], found.over_time("IAE").ravel())
    assert len(table) == 50 * 4


def test_no_name_of_a_column_is_run_by_a_spreadsheet_and_its_numbers_are_as_they_were(tmp_path):
    found = sample(tmp_path, sweep())
    names = tuple(f"=HYPERLINK({i},x)" for i in range(len(found.factors)))
    columns = tuple(one._replace(metric="-x") for one in found.measurement.columns)
    told = run_tables.to_csv(with_measurement(replace(found, factors=names), columns=columns))
    head, numbers = run_tables.to_csv(found).split(b"\r\n", 1)
    assert told.split(b"\r\n", 1)[1] == numbers
    (read,) = csv.reader([told.decode().split("\r\n")[0]], strict=True)
    assert len(read) == len(head.split(b","))
    assert [name[:2] for name in read if "HYPERLINK" in name] == ["'="] * len(names)
    assert [name[:4] for name in read if "-x" in name] == ["'-x["] * 2 * len(found.measurement.columns)


def test_runs_that_share_their_noise_differ_by_their_numbers_alone(tmp_path):
    width = Factor("boundary layer", ("controller.phi",), Uniform(0.05, 0.2))
    points = ListedPoints([[0.1], [0.1], [0.9]])
    given = sweep(loop=Digital(), factors=(width,), design=points, h=1e-3, until=0.2, common=True)
    first, again, other = sample(tmp_path / "common", given).score("IAE").value
    assert first == again != other
    first, again, other = sample(tmp_path / "own", replace(given, common=False)).score("IAE").value
    assert first != again


def test_a_sweep_can_leave_out_half_steps(tmp_path):
    with_some, without = sweep(), sweep(half_step_every=None)
    found = sample(tmp_path, without)
    assert (len(found.measurement.looked_at), found.measurement.errors.shape) == (0, (0, 1, 2))
    assert np.isnan(found.score("IAE").largest_error)
    assert found.note == f"50 runs, 0 of them diverged; seed {without.design.seed}; step 0.01 s"
    assert compile_sweep(without).cost.seconds < compile_sweep(with_some).cost.seconds
    assert study_cost.cost_of([compile_sweep(without)]).disk < study_cost.cost_of([compile_sweep(with_some)]).disk


def test_a_sweep_at_half_its_step_has_the_errors_of_the_first(tmp_path):
    given = sweep(half_step_every=1)
    one = sample(tmp_path, given).measurement
    finer = sample(tmp_path / "finer", sweep(half_step_every=1, h=given.run.h / 2)).measurement
    np.testing.assert_array_equal(2 * np.abs(finer.values - one.values), one.errors)


def test_some_runs_of_a_sample_keep_their_numbers_and_errors(tmp_path):
    found = sample(tmp_path, sweep(half_step_every=7))
    few = found.only(np.array([3, 7, 8, 21]))
    np.testing.assert_array_equal(few.score("IAE").value, found.score("IAE").value[[3, 7, 8, 21]])
    np.testing.assert_array_equal(few.factor_values, found.factor_values[[3, 7, 8, 21]])
    assert few.measurement.looked_at.tolist() == [1, 3]
    np.testing.assert_array_equal(few.measurement.errors, found.measurement.errors[[1, 3]])
    assert len(found.only(np.arange(50)).measurement.looked_at) == len(found.measurement.looked_at)
