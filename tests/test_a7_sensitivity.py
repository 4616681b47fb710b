"""The study of sensitivities: its factors, and verdicts that turn with the figures."""

from dataclasses import replace

import numpy as np
import pytest

from studies.a7_sensitivity import answers as answers
from studies.a7_sensitivity import factors as sensitivity_factors
from studies.a7_sensitivity import gradients as gradients
from studies.a7_sensitivity.factors import SPAN, TOLERANCE, factors
from studies.a7_sensitivity.laws import acting_pairs, course, left_out
from studies.a7_sensitivity.local import Local, numbers_of
from studies.a7_sensitivity.results import Found, heaviest
from studies.a7_sensitivity.sweeps import HELD, LAWS, PROPOSED, free, loop, metrics
from studies.a7_sensitivity.words import group_of, leaders
from workbench.study.sample import Sample
from workbench.study.uncertainty import Estimate, MonteCarlo, MorrisDesign, OneAtATime, SobolDesign
from workbench.study.uncertainty.factors import Space
from workbench.study.uncertainty.local import LocalSensitivities

T = 4


def sampled(names, design, weights, joint_weights=None):
    """Runs whose metrics are 1 + 0.01 w . (u - 1/2), by metric and factor; those of joint 2 alike if not said."""
    u = design.points() - 0.5
    columns, values = [], []
    for metric in [*(metric.name for metric in metrics(PROPOSED)), "ISE"]:
        for joint in (0, 1):
            chosen = joint_weights if joint and joint_weights else weights
            w = np.array([chosen.get(metric, {}).get(name, 0.1) for name in names])
            columns.append((metric, joint, "rad"))
            values.append(0.1 * (1 + 0.01 * u @ w))
    grown = np.stack(values, axis=1)[:, np.newaxis] * np.linspace(1 / T, 1, T)[:, np.newaxis]
    again = np.arange(0, len(u), 16)
    lost = np.full(len(u), np.nan)
    t, zeros, limits = 0.25 * np.arange(1, T + 1), np.zeros((len(again), T, len(columns))), np.full(len(again), np.inf)
    return Sample("made", tuple(names), tuple(columns), t, 1e-3, 0, "", u, grown, again, zeros, limits, lost, design)


def made(weights, joint_weights=None):
    """A law whose metrics are linear in its factors."""
    every, some = [f.name for f in factors(PROPOSED)], [f.name for f in free(PROPOSED)]
    d = len(every)
    designs = (every, MorrisDesign(d, 60)), (some, SobolDesign(len(some), 256, True)), (every, MonteCarlo(d, 128))
    return Found(PROPOSED, *(sampled(*each, weights, joint_weights) for each in (*designs, (every, OneAtATime(d)))))


@pytest.mark.parametrize("law", LAWS)
def test_every_factor_moves_numbers_of_its_loop_within_the_stated_shares(law):
    ode = loop(law).ode()
    p, _ = Space(factors(law), ode.parameters, ode.states).rows(np.array([np.zeros(len(factors(law)))]))
    ratio = p[0][ode.parameters.default != 0] / ode.parameters.default[ode.parameters.default != 0]
    assert f"within a factor of {SPAN:g} of" in sensitivity_factors.__doc__
    least = {"stated": 1 - TOLERANCE, "derived": 1 - TOLERANCE, "assumed": 1 / SPAN}
    for factor in factors(law):
        assert factor.distribution.reach()[0] >= least[factor.origin] - 1e-12
        assert numbers_of(ode, factor)
    assert ratio.min() >= 1 / SPAN - 1e-12  # rounding of a logarithm
    assert set(HELD[law]) <= {factor.name for factor in factors(law)}


def test_arm_and_model_are_factors_of_their_own():
    ode = loop(PROPOSED).ode()
    by_name = {factor.name: factor for factor in factors(PROPOSED)}
    assert numbers_of(ode, by_name["m2"]) == ["plant.arm.links[1].mass"]
    assert set(numbers_of(ode, by_name["model m2"])) == {
        "controller.model.links[1].mass",
        "observer.state.model.links[1].mass",
    }
    assert [group_of(name) for name in ("Q", "m2", "model m2", "g", "D", "l", "l2")] == [
        *("gains", "arm", "model", "arm", "arm", "gains", "arm")
    ]


def test_the_deciding_gain_is_named_by_the_figures_and_not_by_the_page():
    q, lam = {"RMSE": {"Q": 5.0, "m1": 9.0}}, {"RMSE": {"Lambda": 5.0, "m1": 9.0}}
    both = {"RMSE": {"Q": 5.0, "Lambda": 5.0}}
    for weights, kind, said in (
        ((q,), "found", ("Q decides", "Q decides")),
        ((lam,), "found", ("Lambda decides", "Lambda decides")),
        ((q, lam), "found", ("Q decides", "Lambda decides")),
        ((q, both), "open", ("Q decides", "do not tell")),
        ((both,), "open", ("do not tell", "do not tell")),
    ):
        verdict = answers.deciding_gain(made(*weights))
        assert verdict.kind == kind
        for part, words in zip(verdict.statement.split("; "), said, strict=True):
            assert words in part


def test_gains_are_as_idle_as_the_upper_end_of_their_interval_says():
    # linear runs: the effect of l is a third of that of m1, that of the other gains a ninetieth
    assert "by at most 1 % of what" in answers.idle_gains(made({"RMSE": {"m1": 9.0}})).statement
    third = made({"RMSE": {"m1": 9.0, "l": 3.0}})
    assert "by at most 33 % of what" in answers.idle_gains(third).statement
    size = third.effects.mu_star
    vars(third)["effects"] = replace(third.effects, mu_star=Estimate(size.value, 0.5 * size.value))
    assert "by at most 50 % of what" in answers.idle_gains(third).statement


def test_the_late_error_belongs_to_the_model_only_as_long_as_gains_do_nothing():
    def part(weights):
        verdict = answers.late_error_of(made({"late error": weights}))
        assert verdict.kind == "found"
        return float(verdict.statement.split("at most ")[1].split(" %")[0])

    assert part({"m1": 9.0, "model m1": 9.0}) <= 1
    assert part({"m1": 9.0, "Q": 9.0}) == pytest.approx(50, abs=2)  # half of the squares


def test_a_run_with_much_of_the_variance_of_the_late_error_is_told():
    one = made({})
    sample, place = one.indices, one.indices.columns.index(("late error", 1, "rad"))
    values = sample.values.copy()  # all about 0.1
    values[7, -1, place], values[8, -1, place] = 3.1, 1.1  # squares of 9 and 1 beside those of all others
    assert "has 90 % of the variance at joint 2 (3.10 rad; the next is 1.10)" in heaviest(
        replace(sample, values=values)
    )
    assert heaviest(sample) in answers.late_error_of(one).evidence


def widened(shares, half):
    """The same indices with wider intervals."""
    parts = {name: getattr(shares, name) for name in ("S1", "ST", "sums1", "sumsT")}
    return replace(shares, **{name: Estimate(e.value, 0 * e.value + half) for name, e in parts.items()})


def test_a_sentence_that_rests_on_a_wide_interval_stays_open():
    for judge, weights in (
        (answers.deciding_gain, {"RMSE": {"Q": 5.0, "m1": 9.0}}),
        (answers.chattering, {"TV": {"model l2": 9.0, "Q": 2.0}}),
        (answers.late_error_of, {"late error": {"m1": 9.0, "model m1": 9.0}}),
    ):
        one = made(weights)
        assert judge(one).kind == "found"
        vars(one)["shares"] = widened(one.shares, 0.051)
        assert judge(one).kind == "open"


def test_a_leader_with_a_wide_interval_is_open():
    one = made({"RMSE": {"Q": 5.0}})
    assert not str(answers._leading(one, "RMSE", 0)[0]).startswith("open")
    vars(one)["shares"] = widened(one.shares, 0.051)
    assert answers._leading(one, "RMSE", 0)[0] == "open: "


def test_chattering_is_that_of_the_model_or_of_the_gains_as_the_figures_say():
    model, gains = made({"TV": {"model l2": 9.0, "Q": 2.0}}), made({"TV": {"model l2": 2.0, "Q": 9.0}})
    for one, figures in ((model, ("95 % and 95 %", "5 % and 5 %")), (gains, ("5 % and 5 %", "95 % and 95 %"))):
        verdict = answers.chattering(one)
        assert verdict.kind == "found"
        assert f"The model has {figures[0]} of" in verdict.statement  # 81 / 85 and 4 / 85
        assert f"all gains together {figures[1]}." in verdict.statement


def test_late_errors_are_judged_by_the_quantiles_of_each_law():
    def scaled(one, factor):
        random = replace(one.random, values=one.random.values * factor)
        return replace(one, random=random)

    usual = made({})
    laws = {law: scaled(usual, 1e-4 if law.endswith("ASMC") else 1.0) for law in LAWS}
    assert answers.late_errors(laws).kind == "found"
    assert "e-" not in answers.late_errors(laws).evidence  # small errors read as numbers, in mrad
    assert "largest |e| from 3 to 5 s" in answers.late_errors(laws).estimand
    assert answers.late_errors(laws | {"ASMC": usual}).kind == "open"
    assert answers.late_errors(laws | {PROPOSED: scaled(usual, 1e-4)}).kind == "open"


def test_late_errors_of_all_laws_are_those_of_the_worse_joint():
    one = made({})
    values = one.random.values.copy()
    values[..., one.random.columns.index(("late error", 0, "rad"))] *= 1e-2
    verdict = answers.late_errors(dict.fromkeys(LAWS, replace(one, random=replace(one.random, values=values))))
    low = verdict.evidence.split(f"{PROPOSED} ")[1].split("(")[1].split(" to")[0]
    assert f"is at least {low} mrad" in verdict.statement


def test_runs_that_stray_are_counted_and_a_lost_one_among_them():
    one = made({})
    assert answers.strays({PROPOSED: one}).statement.startswith("0 of ")
    values = one.screening.values.copy()
    place = one.screening.columns.index(("late error", 1, "rad"))
    values[3, -1, place], values[4, -1] = 2.0, np.nan
    astray = replace(one, screening=replace(one.screening, values=values))
    verdict = answers.strays({PROPOSED: astray})
    assert verdict.statement.startswith("2 of ")
    assert f"{PROPOSED} 2 of" in verdict.evidence


def test_what_was_left_out_is_held_against_the_rule():
    light = made({metric.name: {"m1": 9.0} for metric in metrics(PROPOSED)})
    assert "below the 20 % that the rule asks" in str(left_out(light))
    heavy = made({metric.name: {"phi": 9.0} for metric in metrics(PROPOSED)})
    assert "more than the 20 % that the rule allows" in str(left_out(heavy))


def test_factors_of_a_sum_act_in_no_pair():
    assert "does the interval of S2 lie above 0.02" in acting_pairs(made({"RMSE": {"Q": 3.0, "m1": 2.0}}).shares)


def test_the_course_over_time_is_told_in_numbers():
    one = made({"ISE": {"Q": 9.0}})
    said = course(one, one.shares_over_time(0))
    # all weight on one gain beside eight factors of the arm and the model a ninetieth as strong
    assert "sum to 1.00 \N{PLUS-MINUS SIGN} 0.01 in the first window" in said


def test_windows_whose_indices_are_uncertain_are_told_as_open():
    one = made({"ISE": {"Q": 9.0}})
    indices = one.shares_over_time(0)
    assert "open" not in course(one, indices)
    half = indices.ST.half.copy()
    half[1, 3] = 0.051
    said = course(one, replace(indices, ST=Estimate(indices.ST.value, half)))
    assert "wider than 0.1 about 0.375 s" in said


def test_leaders_are_all_that_the_intervals_do_not_tell_apart():
    total = Estimate(np.array([0.5, 0.45, 0.1]), np.array([0.02, 0.1, 0.01]))
    assert leaders(("a", "b", "c"), total) == ("a", "b")


def test_gradients_foretell_indices_only_of_metrics_that_are_linear():
    names = [factor.name for factor in free(PROPOSED)]
    d = len(names)

    def local(weights):
        w = np.array([[weights.get(name, 0.1) for name in names]] * 2)
        at, ones = np.ones(d), {"RMSE": np.ones(2)}
        found = LocalSensitivities(tuple(names), at, ones, {"RMSE": w}, {"RMSE": w}, {"RMSE": w}, ())
        return Local(tuple(names), found, np.eye(d), np.full(d, 0.1))

    one = made({"RMSE": {"Q": 5.0, "m1": 3.0}})

    def said(local):
        verdict = gradients.foretold({PROPOSED: one}, {PROPOSED: local})
        assert verdict.kind == "found"
        holds, of = local.held("RMSE")
        assert f"{PROPOSED} in {holds} of {of}." in verdict.evidence
        return verdict.statement

    assert said(local({"Q": 5.0, "m1": 3.0})).startswith("For 2 of 2 pairs")
    assert said(local({"Q": 3.0, "m1": 5.0})).startswith("For 0 of 2 pairs")
    assert said(local({"Q": np.nan})).startswith("For 0 of 2 pairs")
    whole = local({"Q": 5.0, "m1": 3.0})
    half = {"RMSE": whole.found.gradient["RMSE"] * np.array([[1.0], [np.nan]])}  # joint 2 alone has no gradient
    second = replace(whole, found=replace(whole.found, gradient=half))
    assert said(second).startswith("For 1 of 2 pairs")
    vars(one)["shares"] = widened(one.shares, 0.051)
    assert gradients.foretold({PROPOSED: one}, {PROPOSED: whole}).kind == "open"
