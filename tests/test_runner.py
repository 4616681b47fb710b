"""Running the cases of a study."""

import numpy as np
import pytest
from equations import decay
from test_comparison import Given

from workbench.metrics import iae
from workbench.study.runner import run
from workbench.study.study import Case, Study


def study(*rates: float, **changes: object) -> Study:
    cases = tuple(Case("S", f"{r:g}", Given(decay(r)), (iae(),), 0.01, 2.0, 0.1) for r in rates)
    declared = {"name": "s", "title": "t", "question": "q", "method": "m", "sections": lambda r: (), "cases": cases}
    return Study(**{**declared, **changes})


def test_outcomes_come_in_the_order_of_the_cases_whatever_ran_first():
    outcomes = run(study(3.0, 1.0, 2.0), workers=3).outcomes
    assert [o.case.law for o in outcomes] == ["3", "1", "2"]


def test_the_number_of_workers_changes_no_bit():
    one, three = run(study(1.0, 2.0), workers=1), run(study(1.0, 2.0), workers=3)
    for a, b in zip(one.outcomes, three.outcomes, strict=True):
        np.testing.assert_array_equal(a.measurement.trajectories.x, b.measurement.trajectories.x)
        assert a.score("IAE", 0) == b.score("IAE", 0)


def test_progress_adds_up_over_the_cases():
    seen: list[float] = []
    run(study(1.0, 2.0), seen.append, workers=2)
    assert seen == sorted(seen)
    assert seen[-1] == pytest.approx(1.0)


def test_a_case_that_fails_stops_the_study_with_its_own_sentence():
    class Bad:
        def ode(self, name="loop"):
            raise ValueError("this loop has no equations")

    cases = (Case("S", "bad", Bad(), (iae(),), 0.01, 2.0, 0.1),)
    with pytest.raises(ValueError, match="this loop has no equations"):
        run(study(cases=cases))


@pytest.mark.parametrize("name", ["../up", "a/b", "", "Study", "a b", "x" * 81, None])
def test_a_name_that_is_no_plain_folder_is_refused(name):
    with pytest.raises(ValueError, match="lower-case letters, digits and underscores"):
        study(1.0, name=name)


@pytest.mark.parametrize("change", [{"h": 0.0}, {"h": "fast"}, {"until": float("inf")}, {"every": float("nan")}])
def test_a_case_refuses_a_time_that_is_none(change):
    times = {"h": 0.01, "until": 2.0, "every": 0.1} | change
    with pytest.raises(ValueError, match="positive, finite number of seconds"):
        Case("S", "law", Given(decay()), (iae(),), **times)


def test_two_cases_of_one_name_are_refused():
    with pytest.raises(ValueError, match="distinct cases"):
        study(1.0, 1.0)
