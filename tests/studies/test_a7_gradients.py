"""What a7 says of factors left alone, of pairs, of leaders, and of gradients beside indices."""

from dataclasses import replace

import numpy as np
import pytest

from studies.a7_sensitivity.gradients import gap, gradient_finding
from studies.a7_sensitivity.results import leaders
from studies.a7_sensitivity.study import acting_pairs
from studies.a7_sensitivity.sweeps import PROPOSED_LAW, metrics
from studies.a7_sensitivity.varied_numbers import left_table
from tests.support.drawn_indices import SOME, local, made, usual, widened
from workbench.study.uncertainty import Estimate


def test_factors_left_at_their_values_are_held_against_the_rule():
    def told(one):
        return left_table({PROPOSED_LAW: one}).rows[0][-1]

    one = made({metric.name: {"m1": 9.0, "phi": 0.9} for metric in metrics(PROPOSED_LAW)})
    assert told(one) == "yes"
    size = one.effects.mu_star
    vars(one)["effects"] = replace(one.effects, mu_star=Estimate(size.value, 0 * size.value + 0.2 * size.value.max()))
    assert told(one) == "open"  # 10 % of the largest, but up to 30 %
    assert told(made({metric.name: {"phi": 9.0} for metric in metrics(PROPOSED_LAW)})) == "no"


def test_factors_of_a_sum_act_in_no_pair():
    words = acting_pairs(usual().shares)
    assert "does not lie wholly above 0.02 for any pair. It reaches beyond 0.02 for 0 of 1,092 pairs;" in words
    size = usual().shares.S2
    wide = replace(usual().shares, S2=Estimate(size.value, 0 * size.half + 0.03))
    assert "for any pair. It reaches beyond 0.02 for 1,092 of 1,092 pairs;" in acting_pairs(wide)
    sure = replace(usual().shares, S2=Estimate(0 * size.value + 0.06, 0 * size.half + 0.03))
    assert "lies wholly above 0.02 for Lambda and Q (RMSE of joint 1)," in acting_pairs(sure)


def test_leaders_are_all_that_the_intervals_do_not_tell_apart():
    total = Estimate(np.array([0.5, 0.45, 0.1]), np.array([0.02, 0.1, 0.01]))
    assert leaders(("a", "b", "c"), total) == ("a", "b")


def said_of_gradients(near, one=None):
    verdict = gradient_finding({PROPOSED_LAW: one or usual()}, {PROPOSED_LAW: near})
    return verdict, verdict.statement.replace(", the exact gradient at the numbers of the card predicts every", ":")


def test_gradients_foretell_indices_only_of_metrics_that_are_linear():
    whole = local({"Q": 5.0, "m1": 3.0})
    verdict, said = said_of_gradients(whole)
    assert said == "For 2 of 2 pairs of law and joint: first-order index of the RMSE within 0.1."
    assert (verdict.answer, verdict.is_decided) == ("predicted", True)
    assert f"{2 * len(SOME) - 4} of the {2 * len(SOME)} indices are below 0.1 themselves." in verdict.evidence
    assert "the slope of neighbouring runs in all derivatives." in verdict.evidence
    for near in (local({"Q": 3.0, "m1": 5.0}), local({"Q": np.nan})):
        said = said_of_gradients(near)[1]
        assert said.startswith("For 0 of 2 pairs")
        assert said.endswith("For AOSMC-RGS at both joints it is farther off.")
    half = {"RMSE": whole.sensitivities.gradient["RMSE"] * np.array([[1.0], [np.nan]])}  # no gradient of joint 2
    second = replace(whole, sensitivities=replace(whole.sensitivities, gradient=half))
    assert said_of_gradients(second)[1].endswith("For AOSMC-RGS at joint 2 it is farther off.")
    assert said_of_gradients(whole, widened(usual()))[0].kind == "open"


def test_a_gradient_that_is_no_slope_of_the_runs_is_near_by_luck_alone():
    whole = local({"Q": 5.0, "m1": 3.0})
    steep = {"RMSE": 2 * whole.sensitivities.slope["RMSE"]}
    verdict, said = said_of_gradients(replace(whole, sensitivities=replace(whole.sensitivities, slope=steep)))
    assert said.startswith("For 0 of 2 pairs")
    assert "For AOSMC-RGS at both joints it is as near, but by luck" in said
    assert verdict.answer == "near by luck"
    assert [one.answer for one in verdict.variations if "slopes of runs" in one.words] == ["predicted", "predicted"]
    assert f"in only 0 of {2 * len(SOME)} derivatives of AOSMC-RGS." in verdict.evidence


def test_a_gap_counts_with_its_interval_and_that_of_any_factor():
    one = widened(usual(), 0.03)
    first = one.shares["RMSE of joint 1"].S1
    near = local({"Q": 5.0, "m1": 3.0})
    far = gap(one, near, "RMSE", 0)
    assert far.high == pytest.approx(np.abs(near.shares("RMSE", 0) - first.value).max() + 0.03, rel=1e-12)
    # a factor that lies nearer, but has a wider interval, decides
    wide = np.where(np.array(SOME) == "g", 0.08, 0.01)
    shares = replace(one.shares, S1=Estimate(one.shares.S1.value, 0 * one.shares.S1.value + wide))
    vars(one)["shares"] = shares
    assert gap(one, near, "RMSE", 0).high == pytest.approx(0.08, abs=0.005)
    assert said_of_gradients(local({"Q": 5.0, "m1": 3.0}), one)[0].kind == "open"  # an interval of 0.16
