"""The study of sensitivities: its factors, and verdicts that turn with the figures."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from samples import made_sample, with_measurement

from studies.a7_sensitivity import findings, late_errors, sweeps
from studies.a7_sensitivity.results import Derivatives, LawResults, leaders, numbers_of
from studies.a7_sensitivity.study import acting_pairs, left_table
from studies.a7_sensitivity.sweeps import HELD, LAWS, PROPOSED, SPAN, TOLERANCE, factors, free, group_of, loop, metrics
from workbench.study.uncertainty import Estimate, MonteCarlo, MorrisDesign, SobolDesign
from workbench.study.uncertainty.factors import Space
from workbench.study.uncertainty.local import LocalSensitivities

T = 4
EVERY, SOME = ([factor.name for factor in of(PROPOSED)] for of in (factors, free))
DESIGNS = (EVERY, MorrisDesign(len(EVERY), 60)), (SOME, SobolDesign(len(SOME), 256, True)), (EVERY, MonteCarlo(19, 128))


def sampled(names, design, weights, joint_weights):
    """Runs whose metrics are 1 + 0.01 w . (u - 1/2), by metric and factor."""
    u = design.points() - 0.5
    columns, values = [], []
    for metric in [*(metric.name for metric in metrics(PROPOSED)), "ISE"]:
        for joint, chosen in enumerate((weights, joint_weights)):
            w = np.array([chosen.get(metric, {}).get(name, 0.1) for name in names])
            columns.append((metric, joint, "rad"))
            values.append(0.1 * (1 + 0.01 * u @ w))
    grown = np.stack(values, axis=1)[:, np.newaxis] * np.linspace(1 / T, 1, T)[:, np.newaxis]
    again = np.arange(0, len(u), 16)
    lost = np.full(len(u), np.nan)
    t, zeros, limits = 0.25 * np.arange(1, T + 1), np.zeros((len(again), T, len(columns))), np.full(len(again), np.inf)
    return made_sample(
        "made", tuple(names), tuple(columns), t, 1e-3, 0, "", u, grown, again, zeros, limits, lost, design
    )


def made(weights, joint_weights=None):
    """A law whose metrics are linear in its factors; those of joint 2 are alike if not said."""
    return LawResults(PROPOSED, *(sampled(*each, weights, joint_weights or weights) for each in DESIGNS))


@cache
def usual():
    return made({"RMSE": {"Q": 5.0, "m1": 3.0}})


def with_values(one, kind, change):
    """The same results with other values of a sample: `change` is given the column of the late error of joint 2."""
    sample = getattr(one, kind)
    values = sample.values.copy()
    change(values, sample.measurement.place("late error", 1))
    return replace(one, **{kind: with_measurement(sample, values=values)})


def widened(one, half=0.051):
    """The same results with wider intervals of the indices."""
    parts = {name: getattr(one.shares, name) for name in ("S1", "ST", "sums1", "sumsT")}
    wide = {name: Estimate(e.value, 0 * e.value + half) for name, e in parts.items()}
    other = replace(one)
    vars(other)["shares"] = replace(one.shares, **wide)
    return other


@pytest.mark.parametrize("law", LAWS)
def test_every_factor_moves_numbers_of_its_loop_within_the_stated_shares(law):
    ode = loop(law).ode()
    p, _ = Space(factors(law), ode.parameters, ode.states).rows(np.array([np.zeros(len(factors(law)))]))
    ratio = p[0][ode.parameters.default != 0] / ode.parameters.default[ode.parameters.default != 0]
    assert f"within a factor of {SPAN:g} of" in sweeps.__doc__
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
    for weights, settled, said in (
        ((q,), True, ("Q", "Q")),
        ((q, lam), True, ("Q", "Lambda")),
        ((q, both), False, ("Q", " or ")),
        ((both,), False, (" or ", " or ")),
    ):
        finding = findings.deciding_gain(made(*weights))
        assert finding.settled is settled
        assert "the screening's mu* in place of ST" not in [one.words for one in finding.reversals]
        for part, words in zip(finding.statement.split("ranges, ")[1].split(", and "), said, strict=True):
            assert words in part


def test_gains_are_as_idle_as_the_upper_end_of_their_interval_says():
    # linear runs: the effect of l is a third of that of m1, that of the other gains a ninetieth
    assert "by at most 1 % of what" in findings.idle_gains(made({"RMSE": {"m1": 9.0}}))
    third = made({"RMSE": {"m1": 9.0, "l": 3.0}})
    assert "by at most 33 % of what" in findings.idle_gains(third)
    size = third.effects.mu_star
    vars(third)["effects"] = replace(third.effects, mu_star=Estimate(size.value, 0.5 * size.value))
    assert "by at most 50 % of what" in findings.idle_gains(third)


def test_the_late_error_belongs_to_the_model_only_as_long_as_gains_do_nothing():
    def part(weights):
        finding = late_errors.late_error_of(made({"late error": weights}))
        assert finding.kind == "found"
        return float(finding.statement.split("at most ")[1].split(" %")[0])

    assert part({"m1": 9.0, "model m1": 9.0}) <= 1
    assert part({"m1": 9.0, "Q": 9.0}) == pytest.approx(50, abs=2)  # half of the squares


def test_a_run_with_much_of_the_variance_of_the_late_error_is_named():
    def change(values, place):  # all about 0.1
        values[7, -1, place], values[8, -1, place] = 3.1, 1.1  # squares of 9 and 1 beside those of all others

    said = "has 90 % of the variance at joint 2 (3.10 rad; the next is 1.10), and the heaviest 1 % of them 100 %"
    assert said in late_errors.heaviest(with_values(usual(), "indices", change).indices)
    assert late_errors.heaviest(usual().indices) in late_errors.late_error_of(usual()).evidence


def test_a_sentence_that_rests_on_a_wide_interval_stays_open():
    weights = {"RMSE": {"Q": 5.0, "m1": 9.0}, "TV": {"model l2": 9.0, "Q": 2.0}, "late error": {"m1": 9.0}}
    one = made(weights)
    wide = widened(one)
    for judge in (findings.deciding_gain, findings.chattering, late_errors.late_error_of):
        assert (judge(one).settled, judge(wide).kind) == (True, "open")
    for law, opening in ((one, ""), (wide, "open: ")):
        cell = findings.leaders_table({PROPOSED: law}).rows[0][1]
        assert cell[0].startswith(opening)
        assert (cell[0] == "open: ") is bool(opening)


def test_chattering_is_that_of_the_model_or_of_the_gains_as_the_figures_say():
    model, gains = made({"TV": {"model l2": 9.0, "Q": 2.0}}), made({"TV": {"model l2": 2.0, "Q": 9.0}})
    for one, figures in ((model, ("95 % and 95 %", "5 % and 5 %")), (gains, ("5 % and 5 %", "95 % and 95 %"))):
        verdict = findings.chattering(one)
        assert verdict.kind == "found"
        assert f"The model has {figures[0]} of" in verdict.statement  # 81 / 85 and 4 / 85
        assert f"all gains together {figures[1]}." in verdict.statement


def test_runs_that_stray_are_counted_and_a_lost_one_among_them():
    def change(values, place):
        values[3, -1, place], values[4, -1] = 2.0, np.nan

    assert findings.strays({PROPOSED: usual()}).statement.startswith("0 of ")
    verdict = findings.strays({PROPOSED: with_values(usual(), "screening", change)})
    assert verdict.statement.startswith("2 of ")
    assert verdict.answer == "some"


def test_factors_left_at_their_values_are_held_against_the_rule():
    def told(one):
        return left_table({PROPOSED: one}).rows[0][-1]

    one = made({metric.name: {"m1": 9.0, "phi": 0.9} for metric in metrics(PROPOSED)})
    assert told(one) == "yes"
    size = one.effects.mu_star
    vars(one)["effects"] = replace(one.effects, mu_star=Estimate(size.value, 0 * size.value + 0.2 * size.value.max()))
    assert told(one) == "open"  # 10 % of the largest, but up to 30 %
    assert told(made({metric.name: {"phi": 9.0} for metric in metrics(PROPOSED)})) == "no"


def test_factors_of_a_sum_act_in_no_pair():
    assert acting_pairs(usual().shares).endswith("for none.")


def test_leaders_are_all_that_the_intervals_do_not_tell_apart():
    total = Estimate(np.array([0.5, 0.45, 0.1]), np.array([0.02, 0.1, 0.01]))
    assert leaders(("a", "b", "c"), total) == ("a", "b")


def test_gradients_foretell_indices_only_of_metrics_that_are_linear():
    d = len(SOME)

    def local(weights):
        w = np.array([[weights.get(name, 0.1) for name in SOME]] * 2)
        at, ones = np.ones(d), {"RMSE": np.ones(2)}
        found = LocalSensitivities(tuple(SOME), at, ones, {"RMSE": w}, {"RMSE": w}, {"RMSE": w}, ())
        return Derivatives(tuple(SOME), found, np.eye(d), np.full(d, 0.1))

    def said(local):
        verdict = findings.foretold({PROPOSED: usual()}, {PROPOSED: local})
        assert verdict.settled
        assert f"{PROPOSED} in {local.slopes('RMSE')}." in verdict.evidence
        return verdict.statement

    whole = local({"Q": 5.0, "m1": 3.0})
    assert said(whole).startswith("For 2 of 2 pairs")
    assert said(local({"Q": 3.0, "m1": 5.0})).startswith("For 0 of 2 pairs")
    assert said(local({"Q": np.nan})).startswith("For 0 of 2 pairs")
    half = {"RMSE": whole.sensitivities.gradient["RMSE"] * np.array([[1.0], [np.nan]])}  # no gradient of joint 2
    second = replace(whole, sensitivities=replace(whole.sensitivities, gradient=half))
    assert said(second).startswith("For 1 of 2 pairs")
    assert findings.foretold({PROPOSED: widened(usual())}, {PROPOSED: whole}).kind == "open"


def test_the_part_of_the_gains_in_the_late_error_is_also_computed_without_its_heaviest_runs():
    # the late error follows m1 alone, but for one run of 9 rad: that run alone gives the gains their part
    def change(values, place):
        values[7, -1, place] = 9.0

    one = made({"late error": {"m1": 9.0}})
    heavy = with_values(one, "indices", change)
    parts = {words: part for words, (part, _) in late_errors.late_parts(heavy).items()}
    usual_part = late_errors.late_parts(one)[""][0]
    assert parts[""] > 0.3
    assert parts["the largest 1 % of the runs lowered to the rest"] == pytest.approx(usual_part, abs=0.02)
    finding = late_errors.late_error_of(heavy)
    assert {one.words for one in finding.variations} == set(parts) - {""}
    assert "the largest 1 % of the runs lowered to the rest" in [one.words for one in finding.reversals]


def test_the_table_of_heavy_runs_names_the_heaviest():
    def change(values, place):
        values[7, -1, place] = 9.0

    rows = late_errors.heavy_table(with_values(usual(), "indices", change).indices).rows
    assert next(row for row in rows if row[0] == 2)[1:3] == ("8", "9.00")
