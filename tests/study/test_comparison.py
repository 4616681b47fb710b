"""Laws side by side, and a paper's rankings held against ours."""

from dataclasses import replace

import numpy as np
import pytest

from tests.support.equations import decay, explosion
from workbench.engine.metrics import iae, ise
from workbench.study.case_runs import run
from workbench.study.document.document import BoldCell, DivergedCell, ValueWithError
from workbench.study.evidence.law_tables import PublishedColumn, against_published, order, ranking, side_by_side
from workbench.study.run_and_sweep import Run
from workbench.study.study import Case, Outcome, Results, Study


def results() -> Results:
    laws = {"slow": decay(1.0), "fast": decay(4.0), "lost": explosion()}
    cases = tuple(Case("S", law, Run(ode, (iae(), ise()), 2.0, 0.1, 0.005)) for law, ode in laws.items())
    return run(Study("s", "t", "q", "m", sections=lambda r: (), cases=cases))


RESULTS = results()
LAWS = {o.case.law: o for o in RESULTS.outcomes}


def test_a_value_is_below_another_only_by_more_than_both_errors():
    assert order((1.0, 0.1), (1.3, 0.1)) == "below"
    assert order((1.3, 0.1), (1.0, 0.1)) == "above"
    assert order((1.0, 0.1), (1.15, 0.1)) == "undecided"
    assert order((1.0, 0.0), (1.0, 0.0)) == "undecided"


def test_the_best_law_is_bold_and_a_diverged_one_says_when():
    table = side_by_side("t", "c", RESULTS.outcomes, ["IAE"], 0)
    rows = {row[0]: row[1] for row in table.rows}
    assert isinstance(rows["slow"], ValueWithError)
    assert isinstance(rows["fast"], BoldCell)
    assert isinstance(rows["lost"], DivergedCell)
    assert rows["fast"].cell.value == pytest.approx((1 - np.exp(-8)) / 4, rel=1e-6)


def test_no_law_is_bold_where_two_are_within_their_errors():
    table = side_by_side("t", "c", [LAWS["slow"], replace(LAWS["slow"])], ["IAE"], 0)
    assert not any(isinstance(row[1], BoldCell) for row in table.rows)


def test_a_published_column_stands_beside_ours_with_its_difference():
    published = PublishedColumn("here", "IAE", 0, {"slow": 0.8, "fast": 0.3, "lost": 0.1}, digits=2)
    rows = {row[0]: row[1:] for row in against_published("t", "c", published, LAWS).rows}
    assert rows["slow"][0] == "0.80"
    assert rows["slow"][2] == "+0.06"  # 1 - exp(-2) = 0.8647
    assert rows["slow"][3] == "+8.1"
    assert isinstance(rows["lost"][1], DivergedCell)


def test_a_ranking_counts_pairs_that_hold_and_pairs_that_are_turned_round():
    published = PublishedColumn("here", "IAE", 0, {"slow": 0.1, "fast": 0.3, "lost": 0.5}, digits=2)
    judged = ranking(published, LAWS)
    assert judged.reversed_pairs == (("slow", "fast"),)
    assert set(judged.kept_pairs) == {("slow", "lost"), ("fast", "lost")}
    assert "slow has a smaller printed value than fast, and a larger one here" in judged.sentence("slow")


def test_an_unknown_case_or_metric_is_answered_with_the_nearest():
    with pytest.raises(LookupError, match="no 'S: slo' among the 3 cases of this study. Did you mean 'S: slow'"):
        RESULTS["S", "slo"]
    with pytest.raises(LookupError, match="'S: slow': There is no metric 'IAEE' among IAE, ISE. Did you mean 'IAE'"):
        LAWS["slow"].score("IAEE", 0)


def test_results_become_a_tidy_data_frame():
    frame = RESULTS.to_frame()
    assert len(frame) == 3 * 2  # three laws, two metrics, one joint
    slow = frame[(frame.law == "slow") & (frame.metric == "IAE")].iloc[0]
    assert slow.value == pytest.approx(1 - np.exp(-2), rel=1e-6)
    assert slow.unit == "s"  # that of an error without a unit, times seconds
    assert np.isnan(frame[frame.law == "lost"].value).all()
    assert (frame[frame.law == "lost"].diverged_at > 0.9).all()


def test_a_metric_that_no_case_has_is_answered_with_the_nearest():
    with pytest.raises(LookupError, match=r"knows no metric 'IAEE'\. Did you mean 'IAE'\? It knows: IAE, ISE\."):
        side_by_side("t", "c", RESULTS.outcomes, ["IAEE"], 0)
    with pytest.raises(LookupError, match=r"knows no metric 'effort'\. It knows: IAE, ISE\."):
        side_by_side("t", "c", RESULTS.outcomes, ["effort"], 0)


def test_a_table_without_named_metrics_has_all_that_were_taken():
    every = RESULTS.outcomes[0].measurement.names
    assert side_by_side("t", "c", RESULTS.outcomes) == side_by_side("t", "c", RESULTS.outcomes, every)
    assert [column.header for column in side_by_side("t", "c", RESULTS.outcomes).columns] == ["law", *every]


def test_a_metric_that_one_case_lacks_leaves_its_cell_empty():
    fast = LAWS["fast"]
    kept = fast.measurement
    kept = replace(kept, columns=kept.columns[1:], values=kept.values[..., 1:], errors=kept.errors[..., 1:])
    without = replace(fast, measurement=kept)
    rows = side_by_side("t", "c", [without, LAWS["slow"]], ["IAE", "ISE"], 0).rows
    assert rows[0][1] is None
    assert rows[1][1] is not None


def test_no_outcome_at_all_is_refused():
    with pytest.raises(ValueError, match="at least one outcome"):
        side_by_side("t", "c", [], ["IAE"], 0)


@pytest.mark.parametrize("judge", [lambda p, o: against_published("t", "c", p, o), ranking])
def test_a_published_law_without_an_outcome_is_answered_with_the_nearest(judge):
    with pytest.raises(LookupError, match="no 'slwo' among the 3 outcomes beside here. Did you mean 'slow'"):
        judge(PublishedColumn("here", "IAE", 0, {"slwo": 0.8}, digits=2), LAWS)


def test_a_printed_zero_has_no_percent():
    published = PublishedColumn("here", "IAE", 0, {"slow": 0.0}, digits=2)
    assert against_published("t", "c", published, LAWS).rows[0][-1] is None


@pytest.mark.parametrize("number", [1, -1, np.int64(7)])
def test_a_signal_that_is_not_there_is_refused(number):
    with pytest.raises(LookupError, match=r"'S: slow': 'IAE' has no signal .*: it has 0 \('e'\), counted from 0"):
        LAWS["slow"].score("IAE", number)
    with pytest.raises(LookupError, match=r"counts from 0 and knows 0 to 0 in 'S: slow'"):
        LAWS["slow"].signal("e", number)


def judged(tolerance, h=0.05) -> Outcome:
    case = Case("S", "law", Run(decay(4.0), (iae(), ise()), 2.0, 0.1, h, tolerance))
    return run(Study("s", "t", "q", "m", sections=lambda r: (), cases=(case,))).outcomes[0]


def test_a_metric_that_misses_its_tolerance_is_named_below_the_table_with_its_figure():
    outcome = judged(1e-5)
    errors = {m: abs(np.divide(*outcome.score(m).pair[::-1])) for m in ("IAE", "ISE")}
    assert errors["IAE"] < 1e-5 < errors["ISE"]
    note = f"ISE beyond its tolerance 1e-05: its error is {errors['ISE']:.1e}"
    assert outcome.notes == (note,)
    table = side_by_side("t", "c", [outcome], ["IAE"], 0)
    assert table.notes[-1] == f"law: {note}."


def test_a_run_without_a_value_is_not_said_to_keep_its_tolerance():
    case = Case("S", "lost", Run(explosion(), (iae(),), 2.0, 0.1, 0.005, 1e-3))
    (outcome,) = run(Study("s", "t", "q", "m", sections=lambda r: (), cases=(case,))).outcomes
    assert "IAE not tested against its tolerance 0.001" in outcome.notes
    assert outcome.within("IAE") is False


def test_a_tolerance_that_is_kept_or_not_asked_for_is_not_mentioned():
    assert judged(1e-2).notes == judged(None).notes == ()
    assert judged(None).within("ISE") is None


def test_the_data_frame_tells_of_a_tolerance_where_one_was_asked_for():
    assert not {"tolerance", "within"} & set(RESULTS.to_frame().columns)
    frame = Results((judged(1e-5), LAWS["slow"])).to_frame().set_index(["law", "metric"])
    assert (frame.within["law", "IAE"], frame.within["law", "ISE"]) == (True, False)
    assert frame.within["slow", "IAE"] is None
    assert frame.tolerance["law", "ISE"] == 1e-5


def test_a_case_without_a_step_has_one_chosen_for_its_tolerance():
    outcome = judged(1e-3, h=None)
    # the integral of exp(-8 t) over 2 s
    assert outcome.score("ISE").pair[0] == pytest.approx(1 / 8, rel=1e-3)
    assert outcome.measurement.check.is_passed
    np.testing.assert_allclose(outcome.t, np.arange(21) * 0.1, atol=1e-12)
    assert judged(None, h=None).measurement.check.is_passed  # for the tolerance that a run without a step has


@pytest.mark.parametrize("bad", [0.0, -1.0, float("nan")])
def test_a_run_refuses_a_tolerance_that_is_none(bad):
    with pytest.raises(ValueError, match=r"`Run\(tolerance=...\)` must be a positive, finite number; got"):
        Run(decay(), (iae(),), 2.0, 0.1, 0.1, tolerance=bad)


def test_what_must_be_said_of_several_laws_alike_is_said_once():
    def seen(law):
        ode = replace(LAWS["fast"].ode, notes=("the observer uses the truth",))
        return replace(LAWS["fast"], case=replace(LAWS["fast"].case, law=law), ode=ode)

    table = side_by_side("t", "c", [seen("a"), LAWS["slow"], seen("b")], ["IAE"], 0)
    assert [note for note in table.notes if "truth" in note] == ["a †, b †: the observer uses the truth."]
