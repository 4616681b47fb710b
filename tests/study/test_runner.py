"""Running the cases of a study."""

import time
from dataclasses import replace

import numpy as np
import pytest

from tests.support.comparisons import Given
from tests.support.equations import decay
from workbench.engine.metrics import iae
from workbench.study.case_runs import CaseError, run
from workbench.study.document.document import Section
from workbench.study.run_and_sweep import Run
from workbench.study.study import Case, Results, Study
from workbench.study.writeup import document, headlines


def study(*rates: float, **changes: object) -> Study:
    cases = tuple(Case("S", f"{r:g}", Run(Given(decay(r)), (iae(),), 2.0, 0.1, 0.005)) for r in rates)
    declared = {"name": "s", "title": "t", "question": "q", "method": "m", "sections": lambda r: (), "cases": cases}
    return Study(**{**declared, **changes})


def test_outcomes_come_in_the_order_of_the_cases_whatever_ran_first():
    outcomes = run(study(3.0, 1.0, 2.0), workers=3).outcomes
    assert [o.case.law for o in outcomes] == ["3", "1", "2"]


def test_the_number_of_workers_changes_no_bit():
    one, three = run(study(1.0, 2.0), workers=1), run(study(1.0, 2.0), workers=3)
    for a, b in zip(one.outcomes, three.outcomes, strict=True):
        np.testing.assert_array_equal(a.measurement.trajectories.x, b.measurement.trajectories.x)
        assert a.score("IAE").pair == b.score("IAE").pair


def test_progress_adds_up_over_the_cases():
    seen: list[float] = []
    run(study(1.0, 2.0), seen.append, workers=2)
    assert seen == sorted(seen)
    assert seen[-1] == pytest.approx(1.0)


def test_a_case_that_fails_stops_the_study_with_its_own_sentence():
    class Bad:
        def ode(self, name="loop"):
            raise ValueError("this loop has no equations")

    cases = (Case("S", "bad", Run(Bad(), (iae(),), 2.0, 0.1, 0.005)),)
    with pytest.raises(ValueError, match="this loop has no equations"):
        run(study(cases=cases))


@pytest.mark.parametrize("name", ["../up", "a/b", "", "Study", "a b", "x" * 81])
def test_a_name_that_is_no_plain_folder_is_refused(name):
    with pytest.raises(ValueError, match="made of a-z, 0-9 and _, 1 to 80"):
        study(1.0, name=name)


@pytest.mark.parametrize("change", [{"h": 0.0}, {"h": -1.0}, {"until": float("inf")}, {"every": float("nan")}])
def test_a_case_refuses_a_time_that_is_none(change):
    times = {"h": 0.01, "until": 2.0, "every": 0.1} | change
    with pytest.raises(ValueError, match="positive, finite number of seconds"):
        Case("S", "law", Run(Given(decay()), (iae(),), **times))


def test_two_cases_of_one_name_are_refused():
    with pytest.raises(ValueError, match="distinct cases"):
        study(1.0, 1.0)


def test_a_case_that_fails_is_named_and_ends_the_others_early():
    class Bad:
        def ode(self, name="loop"):
            raise LookupError("no such gain")

    slow = Case("FS", "slow", Run(Given(decay()), (iae(),), 1e4, 1.0, 5e-6))
    cases = (slow, Case("FS", "SMC", Run(Bad(), (iae(),), 2.0, 0.1, 0.005)))
    start = time.monotonic()
    with pytest.raises(CaseError, match="^FS: SMC: no such gain$"):
        run(study(cases=cases), workers=2)
    assert time.monotonic() - start < 20  # the slow case alone takes a minute and more


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"every": 0.0125}, r"`Run\(every=...\)` must be a multiple of `h`, 0.005 s; got 0.0125 s"),
        ({"until": 2.05}, r"`Run\(until=...\)` must be a multiple of `every`, 0.1 s"),
        ({"until": 0.002}, r"`Run\(until=...\)` must be a multiple of `h`"),
    ],
)
def test_times_that_are_no_multiples_of_the_step_are_refused_with_the_case(change, words):
    times = {"h": 0.005, "until": 2.0, "every": 0.1} | change
    with pytest.raises(ValueError, match=words):
        Case("S", "law", Run(Given(decay()), (iae(),), **times))


def test_multiples_that_rounding_hides_are_multiples():
    case = Case("S", "law", Run(Given(decay()), (iae(),), h=1e-3 / 24, until=25.08, every=0.01))
    assert case.run.h * 24 == pytest.approx(1e-3)


def test_a_metric_alone_is_refused_with_its_comma():
    with pytest.raises(
        ValueError, match=r"`Run\(metrics=...\)` must be a tuple of `AbstractMetric`.*written `\(...,\)`"
    ):
        Run(Given(decay()), iae(), 2.0, 0.1, 0.01)


@pytest.mark.parametrize("name", ["title", "question", "method"])
def test_a_study_without_its_words_is_refused(name):
    with pytest.raises(ValueError, match=rf"`Study\({name}=...\)` must be text; got None"):
        study(1.0, **{name: None})


@pytest.mark.parametrize("name", ["sections", "headlines"])
def test_a_study_whose_answer_is_no_function_is_refused(name):
    with pytest.raises(ValueError, match=rf"`Study\({name}=...\)` must be a function; got"):
        study(1.0, **{name: ()})


@pytest.mark.parametrize("answer", [None, Section("T", ()), "T"])
def test_sections_that_are_no_list_of_sections_are_refused(answer):
    with pytest.raises(ValueError, match=r"`Study\(sections=...\)\(results\)` must be a tuple of `Section`; got"):
        document(study(sections=lambda results: answer), Results(), "command")


@pytest.mark.parametrize("answer", [None, "It runs.", [3]])
def test_headlines_that_are_no_list_of_texts_are_refused(answer):
    with pytest.raises(ValueError, match=r"`Study\(headlines=...\)\(results\)` must be"):
        headlines(study(headlines=lambda results: answer), Results())


def test_the_seed_of_a_study_is_in_its_colophon():
    seeds = [document(study(**given), Results(), "again").colophon.seed for given in ({"seed": 7}, {})]
    assert seeds == [7, None]


def printed(*cases: Case, seed: int | None = None) -> dict[str, str]:
    """What the page prints beside each case."""
    one = study(cases=cases, seed=seed)
    return dict(document(one, run(one), "command").colophon.digests)


def test_cases_that_differ_in_one_number_have_two_digests():
    case = Case("S", "law", Run(Given(decay(1.0)), (iae(),), 2.0, 0.1, 0.005))
    others = {
        "rate": {"loop": Given(decay(1.0 + 2**-52))},
        "start": {"loop": Given(decay(1.0, start=1.0 + 2**-52))},
        "step": {"h": 0.0025},
        "horizon": {"until": 2.1},
        "grid": {"every": 0.05},
    }
    cases = [case, *(replace(case, law=name, run=replace(case.run, **change)) for name, change in others.items())]
    digests = printed(*cases)
    assert len(digests) == len(set(digests.values())) == 6
    assert len({outcome.ode.fingerprint for outcome in run(study(cases=tuple(cases))).outcomes}) == 1


def test_another_name_of_a_case_leaves_its_digest_as_it_is():
    case = Case("S", "law", Run(Given(decay(1.0)), (iae(),), 2.0, 0.1, 0.005))
    told = (
        case,
        replace(case, scenario="T", law="other", style=3, remark="new"),
        replace(case, law="whole", run=replace(case.run, until=2)),
    )
    assert len(set(printed(*told).values())) == 1
