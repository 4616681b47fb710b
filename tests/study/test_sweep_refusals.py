"""Sweeps that cannot be, take too long or too much, are refused before they begin."""

from dataclasses import replace

import pytest

from tests.support.sweep_samples import Digital, sample
from tests.support.sweeps import RATE, START, sweep
from workbench.engine.distributions import Uniform
from workbench.engine.factors import Factor
from workbench.study import study_cost
from workbench.study.compiled_sweep import compile_sweep
from workbench.study.sweep_runs import tasks_of
from workbench.study.uncertainty import MonteCarlo


@pytest.mark.parametrize(
    ("change", "kind", "said"),
    [
        ({"factors": (Factor("r", ("rat",), Uniform(0, 1)), START)}, LookupError, "Did you mean 'rate'"),
        ({"factors": (RATE, replace(RATE, name="again"))}, ValueError, "both move 'rate'"),
        ({"factors": (replace(RATE, distribution=Uniform(0, 11)), START)}, ValueError, "goes from 0 to 11, too far"),
        ({"design": MonteCarlo(3, 50)}, ValueError, "as many dimensions as there are factors, 2; got 3"),
        ({"design": 50}, ValueError, "design=.* 50"),
        ({"factors": ()}, ValueError, "factors, 0"),
        ({"factors": (replace(RATE, name="run"), START)}, ValueError, "another name for ..run.."),
        ({"metrics": ()}, ValueError, "at least one"),
        ({"name": "A b"}, ValueError, "a-z"),
        ({"every": 0.015}, ValueError, "multiple"),
        ({"h": float("nan")}, ValueError, "finite number of seconds"),
        ({"half_step_every": 0}, ValueError, "positive whole number"),
        ({"runs_of_chunk": 1.5}, ValueError, "a whole number or None; got 1.5"),
    ],
)
def test_what_cannot_be_swept_is_refused_before_it_begins(change, kind, said):
    with pytest.raises(kind, match=said):
        tasks_of([compile_sweep(sweep(**change))])


def test_a_sweep_without_a_size_of_chunks_is_cut_for_a_second_or_two_of_a_processor_each():
    made = compile_sweep(sweep(runs_of_chunk=None, design=MonteCarlo(2, 10**9), h=1e-3, until=100.0))
    sizes = {last - first for first, last in made.chunks[:-1]}
    assert len(sizes) == 1
    assert 0.2 < max(sizes) * made.cost.seconds <= 2.0
    assert made.chunks[-1][1] == 10**9


def test_what_takes_too_long_or_too_much_is_refused_with_the_figure(tmp_path):
    made = compile_sweep(sweep(design=MonteCarlo(2, 10**9), until=100.0))
    with pytest.raises(ValueError, match=r"^1,000,000,000 runs: at most about .*`--yes`"):
        study_cost.check(study_cost.cost_of([made]), tmp_path)
    study_cost.check(study_cost.cost_of([compile_sweep(sweep())]), tmp_path)


def test_a_time_that_is_no_multiple_of_the_period_is_refused_before_it_begins():
    width = Factor("boundary layer", ("controller.phi",), Uniform(0.05, 0.2))
    given = sweep(loop=Digital(), factors=(width,), design=MonteCarlo(1, 12), h=1e-3, until=0.2, every=5e-3)
    with pytest.raises(ValueError, match="multiple of the step"):
        compile_sweep(given)


def test_a_metric_that_was_not_taken_is_named_with_those_that_were(tmp_path):
    found = sample(tmp_path, sweep())
    with pytest.raises(LookupError, match=r"There is no metric 'IEA' among IAE, ISE. Did you mean"):
        found.score("IEA")
    with pytest.raises(LookupError, match=r"'IAE' has no signal 1: it has 0 \('e'\), counted from 0"):
        found.score("IAE", 1)


def test_the_time_to_write_many_short_runs_is_foreseen():
    # a million runs of 50 steps: half a second to march, and some ten to write seven million numbers as text
    made = compile_sweep(sweep(design=MonteCarlo(2, 10**6), until=0.5, runs_of_chunk=None))
    assert 10 < study_cost.cost_of([made]).seconds < 40


@pytest.mark.parametrize(("needs", "word"), [({"memory": 5e9}, "4.0 GB"), ({"disk": 1e18}, "half of what is free")])
def test_too_much_memory_or_disk_is_refused_with_the_limit(tmp_path, needs, word):
    small = study_cost.cost_of([compile_sweep(sweep())])
    with pytest.raises(ValueError, match=rf"{word}.*`--yes`"):
        study_cost.check(replace(small, **needs), tmp_path)
