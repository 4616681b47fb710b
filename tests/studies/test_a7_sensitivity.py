"""The study of sensitivities: its factors, and verdicts that turn with the figures."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from studies.a7_sensitivity import findings, late_errors, second_looks, stray_runs, sweeps
from studies.a7_sensitivity.gradients import foretold, gap
from studies.a7_sensitivity.results import Derivatives, LawResults, leaders, numbers_of
from studies.a7_sensitivity.second_looks import Later, Numbers
from studies.a7_sensitivity.study import acting_pairs, left_table
from studies.a7_sensitivity.sweeps import HELD, LAWS, PROPOSED, free, loop, metrics
from studies.a7_sensitivity.torque_variation import first_second, torque_variation
from studies.paper import factors as drawn
from studies.paper.factors import SPAN, TOLERANCE, factors, group_of
from tests.support.samples import made_sample, with_measurement
from workbench.engine.factors import Space
from workbench.engine.metrics import late_error, measure
from workbench.study.uncertainty import Estimate, MonteCarlo, MorrisDesign, SobolDesign
from workbench.study.uncertainty.local import LocalSensitivities

T = 5
EVERY, SOME = ([factor.name for factor in of(PROPOSED)] for of in (factors, free))
DESIGNS = (EVERY, MorrisDesign(len(EVERY), 60)), (SOME, SobolDesign(len(SOME), 256, True)), (EVERY, MonteCarlo(19, 128))
EQUAL = SOME, SobolDesign(len(SOME), 128)


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
    t, zeros, limits = np.arange(1.0, T + 1), np.zeros((len(again), T, len(columns))), np.full(len(again), np.inf)
    return made_sample(
        "made", tuple(names), tuple(columns), t, 1e-3, 0, "", u, grown, again, zeros, limits, lost, design
    )


def made(weights, joint_weights=None, equal=None):
    """A law whose metrics are linear in its factors; joint 2 and equal ranges have the same weights unless given."""
    samples = [sampled(*each, weights, joint_weights or weights) for each in DESIGNS]
    alike = sampled(*EQUAL, equal or weights, equal or joint_weights or weights)
    return LawResults(PROPOSED, *samples, None, alike)


def local(weights):
    """Derivatives of the RMSE by the factors, all of one range, which are the slopes of the runs."""
    w = np.array([[weights.get(name, 0.1) for name in SOME]] * 2)
    at, ones = np.ones(len(SOME)), {"RMSE": np.ones(2)}
    found = LocalSensitivities(tuple(SOME), at, ones, {"RMSE": w}, {"RMSE": w}, {"RMSE": w}, ())
    return Derivatives(tuple(SOME), found, np.eye(len(SOME)), np.full(len(SOME), 0.1))


NO_RUNS = Later(np.zeros((4, 2)))


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
    assert f"within a factor of {SPAN:g} of" in drawn.__doc__
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
        ((q,), True, "Q at both joints"),
        ((q, lam), True, "Q at joint 1 and Lambda at joint 2"),
        ((q, both), False, "Q at joint 1 and Q or Lambda at joint 2"),
        ((both,), False, "Q or Lambda at both joints"),
    ):
        finding = findings.deciding_gain(made(*weights), local({"Q": 5.0}))
        assert finding.settled is settled
        assert "the screening's mu* in place of ST" not in [one.words for one in finding.reversals]
        either = (said, said.replace("Q or Lambda", "Lambda or Q"))  # by the last digits of two that are alike
        assert finding.statement.startswith(
            tuple(f"The gain of AOSMC-RGS that decides most about its RMSE is {one}, as" for one in either)
        )


def test_the_gain_that_decides_with_equal_ranges_is_a_variation_of_its_own():
    ranges = np.where(np.array(SOME) == "Q", 1.0, 0.1)  # Q has most of the variance by its range alone
    near = replace(local({"Q": 2.0, "L2": 5.0}), deviations=ranges)
    finding = findings.deciding_gain(made({"RMSE": {"Q": 5.0}}, equal={"RMSE": {"L2": 5.0}}), near)
    assert near.shares("RMSE", 0).argmax() == SOME.index("Q")
    assert finding.answer == "Q at both joints"
    assert finding.statement.endswith("With 10 % for all numbers it is L2 at both joints.")
    changed = {one.words for one in finding.reversals if one.answer == "L2 at both joints"}
    assert changed == {
        "10 % for all numbers",
        "the same range for all numbers, by the exact gradient",
        "the same range for all numbers, by slopes of runs over 1 %",
    }


def test_the_answer_has_the_parts_of_arm_and_gains_by_both_ranges():
    one = made({"RMSE": {"Q": 3.0, "m1": 4.0}}, equal={"RMSE": {"m1": 9.0}})
    line = findings.answer({PROPOSED: one})
    assert "the arm's numbers cause 64 % and 64 % of" in line  # 16 of 25 squares
    assert "Its gains cause 36 % and 36 %, or 0 % and 0 % if all" in line
    assert len(line.split()) <= 40


def test_equal_ranges_are_those_of_what_is_stated():
    for factor, other in zip(sweeps.equal_ranges(PROPOSED), free(PROPOSED), strict=True):
        assert factor.name == other.name
        assert factor.distribution.reach() == (1 - TOLERANCE, 1 + TOLERANCE)


def test_gains_are_as_idle_as_the_upper_end_of_their_interval_says():
    # linear runs: the effect of l is a third of that of m1, that of the other gains a ninetieth
    assert "is at most 1 % of that of the strongest factor" in findings.idle_gains(made({"RMSE": {"m1": 9.0}}))
    third = made({"RMSE": {"m1": 9.0, "l": 3.0}})
    assert "is at most 33 % of that of the strongest factor" in findings.idle_gains(third)
    size = third.effects.mu_star
    vars(third)["effects"] = replace(third.effects, mu_star=Estimate(size.value, 0.5 * size.value))
    assert "is at most 50 % of that of the strongest factor" in findings.idle_gains(third)


def test_the_late_error_belongs_to_the_model_only_as_long_as_gains_do_nothing():
    def part(weights):
        finding = late_errors.late_error_of(made({"late error": weights}), NO_RUNS)
        assert finding.kind == "found"
        return float(finding.statement.split("at most ")[1].split(" %")[0])

    assert part({"m1": 9.0, "model m1": 9.0}) <= 1
    assert part({"m1": 9.0, "Q": 9.0}) == pytest.approx(50, abs=2)  # half of the squares


def test_a_run_with_much_of_the_variance_of_the_late_error_is_named():
    def change(values, place):  # all about 0.1
        values[7, -1, place], values[8, -1, place] = 3.1, 1.1  # squares of 9 and 1 beside those of all others

    said = "has 90 % of the variance at joint 2 (3.10 rad; the next largest is 1.10 rad); the heaviest 1 % of the runs"
    sample = with_values(usual(), "indices", change).indices
    assert late_errors.heaviest(sample).startswith("Run 8 of ")
    assert said in late_errors.heaviest(sample)
    assert second_looks.heaviest_run(sample) == (7, 1)
    assert late_errors.heaviest(usual().indices) in late_errors.late_error_of(usual(), NO_RUNS).evidence


@pytest.mark.parametrize(
    ("factor", "words"), [("Q", "other runs of the design differ"), ("m1", "No other run of the design")]
)
def test_a_heavy_run_is_seen_by_the_indices_of_gains_only_if_others_differ_from_it_in_a_gain(factor, words):
    place = 1 + SOME.index(factor)  # the first point of A with this coordinate of B: it differs from A in it alone

    def change(values, column):
        values[place, -1, column] = 9.0

    assert words in late_errors.beside(with_values(usual(), "indices", change))


def test_a_sentence_that_rests_on_a_wide_interval_stays_open():
    weights = {"RMSE": {"Q": 5.0, "m1": 9.0}, "TV": {"model l2": 9.0, "Q": 2.0}, "late error": {"m1": 9.0}}
    one = made(weights)
    wide = widened(one)
    judges = (
        lambda law: findings.deciding_gain(law, local({"Q": 5.0})),
        torque_variation,
        lambda law: late_errors.late_error_of(law, NO_RUNS),
    )
    for judge in judges:
        assert (judge(one).settled, judge(wide).kind) == (True, "open")
    assert "With these runs their part is open." in judges[2](wide).statement
    assert "is open" not in judges[2](one).statement
    for law, opening in ((one, ""), (wide, "open: ")):
        cell = findings.leaders_table({PROPOSED: law}).rows[0][2]
        assert cell[0].startswith(opening)
        assert (cell[0] == "open: ") is bool(opening)


def test_the_torque_varies_by_the_group_that_the_figures_say():
    model, gains = made({"TV": {"model l2": 9.0, "Q": 2.0}}), made({"TV": {"model l2": 2.0, "Q": 9.0}})
    for one in (model, gains):
        verdict = torque_variation(one)
        leader = "the law's model of the arm" if one is model else "the law's gains"
        assert f"over 5 s, the largest part is due to {leader}: 95 % and 95 % at joints" in verdict.statement  # 81 / 85
    assert torque_variation(model).answer == "the model"
    assert torque_variation(gains).answer == "the gains"
    assert "chattering" not in verdict.statement + verdict.name


def test_another_group_late_in_the_run_makes_the_answer_depend_on_the_time():
    alike = {"model l2": 9.0, "Q": 2.0}
    late = torque_variation(made({"TV": alike, "late TV": {"m1": 9.0}}))
    assert late.kind == "depends"
    assert [one.words.split(", ")[0] for one in late.reversals] == ["the TV from 3 s on"] * 2  # with and without a tail
    assert {one.answer for one in late.reversals} == {"the arm"}
    assert torque_variation(made({"TV": alike, "late TV": alike})).kind == "found"
    mixed = torque_variation(made({"TV": {"model l2": 9.0}}, {"TV": {"Q": 9.0}}))
    assert mixed.kind == "open"
    assert "no part is the largest at both joints" in mixed.statement


def test_the_part_of_the_first_second_is_that_of_the_sums():
    # of every run the TV from the start to t grows as t, and so the sum up to t as its square
    assert first_second(usual().indices) == pytest.approx([1 / T**2] * 2, rel=1e-12)
    assert "4 % and 4 % of the TV fall in the first second" in torque_variation(usual()).evidence


def test_the_indices_within_a_window_are_those_of_what_is_added_in_it():
    one = usual()

    def change(values, column):
        del column
        at = one.indices.measurement.place("TV", 0)
        u = one.indices.drawn[:, SOME.index("R")]
        values[:, :, at] = np.where(np.arange(T) < 1, 1.0, (1.0 + u[:, np.newaxis]) / one.indices.t)

    shares = with_values(one, "indices", change).shares_within("TV", 1.0, 3.0)["TV of joint 1"]
    assert shares.S1.value[SOME.index("R")] == pytest.approx(1.0, abs=1e-6)  # what is added is the u of R alone


def stray_finding(one, later, redrawn=NO_RUNS, others=None):
    laws = {PROPOSED: one, **(others or {})}
    looks = {law: later if law == PROPOSED else () for law in laws}
    return stray_runs.strays(laws, looks, redrawn, dict.fromkeys(laws, 1.54))


def test_runs_stray_if_they_are_far_off_early_and_late_and_a_lost_one_is_among_them():
    def change(values, place):
        values[3, -1, place], values[4, -1], values[5, -1, place] = 2.5, np.nan, 0.6

    none = stray_finding(usual(), ())
    assert " in 0 of " in none.statement
    assert none.answer == "none"
    one = with_values(usual(), "screening", change)
    (runs,) = second_looks.suspects(one)
    assert (runs.values == one.screening.drawn[3:6]).all()
    stay, back = np.array([[0.1, 2.5], [np.nan] * 2, [0.1, 0.6]]), np.array([[0.1, 0.2], [np.nan] * 2, [0.1, 0.2]])
    for errors, counts in ((stay, (2, 3, 2)), (back, (1, 1, 1))):
        verdict = stray_finding(one, (Later(errors),))
        assert " in 2 of " in verdict.statement
        assert f", and in {counts[0]} of these between 18 and 20 s, too." in verdict.statement
        assert verdict.answer == "fewer than 1 %"
        for variation, count in zip(verdict.variations[:2], counts[1:], strict=True):
            assert f", {count} of these from 18 to 20 s" in variation.detail


def test_a_law_that_arrives_late_is_told_from_one_that_strays():
    def far(values, place):
        values[:, -1, place] = 1.2

    slow = replace(with_values(usual(), "indices", far), law="SMC")
    runs = len(slow.indices)
    for error, answer, lasting in ((0.1, "none", 0), (1.1, "1 % or more", runs)):
        looks = {PROPOSED: (), "SMC": (Later(np.full((runs, 2), error)),)}
        own = {PROPOSED: 0.1, "SMC": 1.54}
        verdict = stray_runs.strays({PROPOSED: usual(), "SMC": slow}, looks, NO_RUNS, own)
        assert next(one.answer for one in verdict.variations if one.words == "SMC") == answer
        every = sum(map(len, slow.samples))
        said = f"SMC exceeds 1 rad in {runs:,} of {every:,} runs from 3 to 5 s"
        assert said in verdict.evidence
        assert f"and in {lasting:,} of these from 18 to 20 s, too" in verdict.evidence
        assert "is 1.54 rad" in verdict.evidence


def test_second_looks_are_given_to_the_law_whose_runs_they_are():
    def far(values, place):
        values[2, -1, place] = 1.2

    laws = {PROPOSED: with_values(with_values(usual(), "indices", far), "random", far), "SMC": usual()}
    answers = tuple(Later(np.full((1, 2), float(i))) for i in range(2))
    by_law = stray_runs.later_by_law(laws, answers)
    assert by_law == {PROPOSED: answers, "SMC": ()}


def test_the_numbers_of_a_run_are_those_of_its_sweep():
    ode, some = loop(PROPOSED).ode(), free(PROPOSED)
    space, points = Space(some, ode.parameters, ode.states), MonteCarlo(len(some), 5, 3).points()
    for own, swept in zip(
        Numbers(PROPOSED, tuple(SOME), space.values(points)).rows(ode), space.rows(points), strict=True
    ):
        assert (own == swept).all()


def test_a_second_look_has_the_late_errors_of_the_metric():
    names = tuple(factor.name for factor in free("SMC"))
    values = np.random.default_rng(4).uniform(0.9, 1.1, (3, len(names)))
    runs = Numbers("SMC", names, values)
    ode = loop("SMC").ode()
    found = measure(ode, (late_error(0.3),), *runs.rows(ode), until=0.5, h=sweeps.STEPS["SMC"])
    expected = np.stack([found.score("late error", joint).value for joint in (0, 1)], axis=1)
    assert (second_looks.late_errors(runs, 0.3, 0.5) == expected).all()


def test_the_gains_of_the_heaviest_run_alone_are_drawn_again():
    def change(values, place):
        values[7, -1, place] = 9.0

    one = with_values(usual(), "indices", change)
    again = second_looks.redrawn_gains(one)
    gains = [SOME.index(name) for name in one.groups["gains"]]
    rest = [i for i in range(len(SOME)) if i not in gains]
    assert again.values.shape == (second_looks.REDRAWN, len(SOME))
    assert (again.values[:, rest] == one.indices.drawn[7, rest]).all()
    for factor in free(PROPOSED):
        drawn = again.values[:, SOME.index(factor.name)]
        low, high = factor.distribution.reach()
        if group_of(factor.name) == "gains":
            assert low <= drawn.min() < low + 0.05 * (high - low)
            assert high - 0.05 * (high - low) < drawn.max() <= high
    errors = np.zeros((second_looks.REDRAWN, 2))
    errors[:3, 1], errors[3] = 1.5, np.nan
    words = (
        "model of run 8, and 400 random draws of its gains (Lambda, Q, R, L1, L2), 4 runs exceed 1 rad: the gains help"
    )
    assert words in second_looks.redrawn_words(one, Later(errors))
    assert second_looks.redrawn_words(one, Later(0 * errors[:3])).endswith("0 runs exceed 1 rad.")


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
    words = acting_pairs(usual().shares)
    assert "does not lie wholly above 0.02 for any of them. It reaches beyond 0.02 for 0 of 1,092," in words
    size = usual().shares.S2
    wide = replace(usual().shares, S2=Estimate(size.value, 0 * size.half + 0.03))
    assert "for any of them. It reaches beyond 0.02 for 1,092 of 1,092," in acting_pairs(wide)
    sure = replace(usual().shares, S2=Estimate(0 * size.value + 0.06, 0 * size.half + 0.03))
    assert "lies wholly above 0.02 for Lambda and Q (RMSE of joint 1)," in acting_pairs(sure)


def test_leaders_are_all_that_the_intervals_do_not_tell_apart():
    total = Estimate(np.array([0.5, 0.45, 0.1]), np.array([0.02, 0.1, 0.01]))
    assert leaders(("a", "b", "c"), total) == ("a", "b")


def said_of_gradients(near, one=None):
    verdict = foretold({PROPOSED: one or usual()}, {PROPOSED: near})
    return verdict, verdict.statement.replace(", the exact gradient at the numbers of the card foretells every", ":")


def test_gradients_foretell_indices_only_of_metrics_that_are_linear():
    whole = local({"Q": 5.0, "m1": 3.0})
    verdict, said = said_of_gradients(whole)
    assert said == "For 2 of 2 pairs of law and joint: first-order index of the RMSE within 0.1."
    assert (verdict.answer, verdict.settled) == ("foretold", True)
    assert f"{2 * len(SOME) - 4} of the {2 * len(SOME)} indices are below 0.1 themselves." in verdict.evidence
    assert "the slope of neighbouring runs in all derivatives." in verdict.evidence
    for near in (local({"Q": 3.0, "m1": 5.0}), local({"Q": np.nan})):
        said = said_of_gradients(near)[1]
        assert said.startswith("For 0 of 2 pairs")
        assert said.endswith("It is farther off for AOSMC-RGS at both joints.")
    half = {"RMSE": whole.sensitivities.gradient["RMSE"] * np.array([[1.0], [np.nan]])}  # no gradient of joint 2
    second = replace(whole, sensitivities=replace(whole.sensitivities, gradient=half))
    assert said_of_gradients(second)[1].endswith("It is farther off for AOSMC-RGS at joint 2.")
    assert said_of_gradients(whole, widened(usual()))[0].kind == "open"


def test_a_gradient_that_is_no_slope_of_the_runs_is_near_by_luck_alone():
    whole = local({"Q": 5.0, "m1": 3.0})
    steep = {"RMSE": 2 * whole.sensitivities.slope["RMSE"]}
    verdict, said = said_of_gradients(replace(whole, sensitivities=replace(whole.sensitivities, slope=steep)))
    assert said.startswith("For 0 of 2 pairs")
    assert "It comes as near for AOSMC-RGS at both joints, but by luck" in said
    assert verdict.answer == "near by luck"
    assert [one.answer for one in verdict.variations if "slopes of runs" in one.words] == ["foretold", "foretold"]
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
    finding = late_errors.late_error_of(heavy, NO_RUNS)
    assert {one.words for one in finding.variations} == set(parts) - {""}
    assert "the largest 1 % of the runs lowered to the rest" in [one.words for one in finding.reversals]


def test_the_table_of_heavy_runs_names_the_heaviest():
    def change(values, place):
        values[7, -1, place] = 9.0

    rows = late_errors.heavy_table(with_values(usual(), "indices", change).indices).rows
    assert next(row for row in rows if row[0] == 2)[1:3] == ("8", "9.00")
