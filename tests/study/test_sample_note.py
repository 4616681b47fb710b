"""What a sample says of itself below a figure."""

from dataclasses import replace

import numpy as np
import pytest

from tests.support.samples import made_sample, with_measurement
from workbench.study.document.document import Section
from workbench.study.study import Results, Study
from workbench.study.uncertainty import MonteCarlo, OneAtATime
from workbench.study.writeup import document

COLUMNS = ("RMSE", 0, "rad", "joint 1"), ("RMSE", 1, "rad", "joint 2"), ("TV", 0, "N*m/s")


def sample(errors, diverged=(), columns=COLUMNS):
    runs, k = 1200, len(columns)
    lost = np.full(runs, np.nan)
    lost[list(diverged)] = 0.5
    values = np.where(np.isnan(lost)[:, None, None], np.ones((runs, 1, k)), np.nan)
    held = np.reshape(errors, (-1, 1, k))
    again = np.arange(len(held))
    return made_sample(
        "s", (), columns, np.ones(1), 0.001, 3, "0", np.ones((runs, 0)), values, again, held, again + 1.0, lost
    )


def test_a_note_says_runs_failures_seed_step_and_the_error_of_the_step_with_its_unit():
    found = sample([[2.1e-5, 1e-3, 0.25], [1e-6, 2e-3, 0.5]], diverged=[7])
    assert found.note_of("RMSE") == (
        "1,200 runs, 1 of them diverged; seed 3; step 0.001 s, and half of it in 2 runs; "
        "error of RMSE of joint 1 at most 2.1×10⁻⁵ rad"
    )
    assert found.note_of("RMSE", 1).endswith("; error of RMSE of joint 2 at most 0.002 rad")
    assert found.note_of("TV").endswith("; error of TV at most 0.5 N·m/s")


def test_an_error_that_is_not_known_or_not_bounded_is_said_to_be_so():
    lost = sample([[np.nan] * 3], diverged=[0])
    assert lost.note_of("TV").endswith("; error of TV not known")
    alone = sample([[np.nan] * 3])
    assert alone.note_of("TV").endswith("; error of TV not bounded, as a run diverges at half of the step alone")
    assert "1,200 runs, 0 of them diverged, and 1 more at half of the step; " in alone.note


def test_a_number_without_a_unit_has_none_in_its_note():
    share = sample([[1.5e5]], columns=(("share", 0, "1"),))
    assert share.note_of("share").endswith("; error of share at most 1.5×10⁵")
    exact = sample([[0.0]], columns=(("share", 0, ""),))
    assert exact.note_of("share").endswith("; error of share at most 0")


def test_a_metric_that_was_not_taken_is_refused_by_name():
    with pytest.raises(
        LookupError, match="There is no metric 'RMS' among RMSE and TV|There is no metric 'RMS' among RMSE, TV"
    ):
        sample([[0.0] * 3]).note_of("RMS")


def test_the_seed_of_a_note_is_that_of_the_design_and_the_noise_has_its_own():
    drawn = replace(sample([[0.0] * 3]), design=MonteCarlo(1, 1200, seed=9))
    assert "; seed 9, of the noise 3; " in drawn.note
    assert "; seed 9; " in replace(drawn, seed=0).note
    assert "seed" not in replace(drawn, design=OneAtATime(1, tuple(np.linspace(0, 1, 1199)))).note


def test_a_short_step_is_said_in_microseconds():
    assert "; step 62.5 µs, and half" in with_measurement(sample([[0.0] * 3]), h=6.25e-5).note
    assert "; step 0.00125 s, and half" in with_measurement(sample([[0.0] * 3]), h=0.00125).note


def test_the_colophon_of_a_study_without_a_seed_says_those_of_its_samples():
    drawn = replace(sample([[0.0] * 3]), seed=0, design=MonteCarlo(1, 1200, seed=9))
    study = Study("s", "t", "q", "m", lambda results: (Section("s", ()),))
    seeds = [
        document(study, Results(samples=samples), "again").colophon.seed
        for samples in ((), (drawn,), (drawn, replace(drawn, name="other", seed=4)))
    ]
    assert seeds == [None, "9", "9 of s; 9, of the noise 4 of other"]


def test_samples_of_one_equation_with_other_numbers_have_other_digests_and_with_another_name_the_same():
    one = sample([[0.1, 0.1, 0.1]])
    others = [
        replace(one, factor_values=np.ones((1200, 1))),
        with_measurement(one, values=one.values + 1e-12),
        with_measurement(one, t=one.t + 1),
    ]
    assert len({one.digest, *(other.digest for other in others)}) == 4
    assert replace(one, name="other").digest == one.digest


def test_the_design_of_a_sample_is_of_the_kind_that_a_method_asks_for_or_refused_by_name():
    held = replace(sample([1e-6, 1e-6, 1e-6]), design=MonteCarlo(1, 2))
    assert held.design_of(MonteCarlo) is held.design
    with pytest.raises(ValueError, match="`MonteCarlo`; got `OneAtATime`"):
        held.design_of(OneAtATime)
    with pytest.raises(ValueError, match="NoneType"):
        sample([1e-6, 1e-6, 1e-6]).design_of(MonteCarlo)
    with pytest.raises(ValueError, match="a class of designs"):
        held.design_of("MonteCarlo")
