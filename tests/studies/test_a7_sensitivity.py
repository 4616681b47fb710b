"""The study of sensitivities: its factors, and verdicts that turn with the figures."""

from dataclasses import replace

import numpy as np
import pytest

from studies.a7_sensitivity import findings, late_errors, sweeps
from studies.a7_sensitivity.results import numbers_of
from studies.a7_sensitivity.sweeps import HELD_FACTORS, LAWS, PROPOSED_LAW, free, loop
from studies.a7_sensitivity.torque_variation import first_second, torque_variation
from studies.paper import factors as drawn
from studies.paper.factors import SPAN, TOLERANCE, factors, group_of
from tests.support.drawn_indices import NO_RUNS, SOME, T, local, made, usual, widened, with_values
from workbench.engine.factors import Space
from workbench.study.uncertainty import Estimate


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
    assert set(HELD_FACTORS[law]) <= {factor.name for factor in factors(law)}


def test_arm_and_model_are_factors_of_their_own():
    ode = loop(PROPOSED_LAW).ode()
    by_name = {factor.name: factor for factor in factors(PROPOSED_LAW)}
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
        assert finding.is_decided is settled
        if settled:  # of two gains that are alike, the last digits decide which is first on the screening, too
            assert "the screening's mu* in place of ST" not in [one.words for one in finding.reversals]
        either = (said, said.replace("Q or Lambda", "Lambda or Q"))  # by the last digits of two that are alike
        assert finding.statement.startswith(
            tuple(f"The gain that decides most about the RMSE of AOSMC-RGS is {one}, if" for one in either)
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
    line = findings.answer({PROPOSED_LAW: one})
    assert "The arm causes 64 % and 64 % of" in line  # 16 of 25 squares
    assert "the gains cause 36 % and 36 %, or 0 % and 0 % if all" in line
    assert len(line.split()) <= 40


def test_equal_ranges_are_those_of_what_is_stated():
    for factor, other in zip(sweeps.equal_ranges(PROPOSED_LAW), free(PROPOSED_LAW), strict=True):
        assert factor.name == other.name
        assert factor.distribution.reach() == (1 - TOLERANCE, 1 + TOLERANCE)


def test_gains_are_as_idle_as_the_upper_end_of_their_interval_says():
    # linear runs: the effect of l is a third of that of m1, that of the other gains a ninetieth
    assert "is at most 1 % of the effect of the strongest factor" in findings.idle_gains(made({"RMSE": {"m1": 9.0}}))
    third = made({"RMSE": {"m1": 9.0, "l": 3.0}})
    assert "is at most 33 % of the effect of the strongest factor" in findings.idle_gains(third)
    size = third.effects.mu_star
    vars(third)["effects"] = replace(third.effects, mu_star=Estimate(size.value, 0.5 * size.value))
    assert "is at most 50 % of the effect of the strongest factor" in findings.idle_gains(third)


def test_the_late_error_belongs_to_the_model_only_as_long_as_gains_do_nothing():
    def part(weights):
        finding = late_errors.late_error_of(made({"late error": weights}), NO_RUNS)
        assert finding.kind == "found"
        return float(finding.statement.split("at most ")[1].split(" %")[0])

    assert part({"m1": 9.0, "model m1": 9.0}) <= 1
    assert part({"m1": 9.0, "Q": 9.0}) == pytest.approx(50, abs=2)  # half of the squares


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
        assert (judge(one).is_decided, judge(wide).kind) == (True, "open")
    assert "With these runs included, the part of the gains is open." in judges[2](wide).statement
    assert "is open" not in judges[2](one).statement
    for law, opening in ((one, ""), (wide, "open: ")):
        cell = findings.leaders_table({PROPOSED_LAW: law}).rows[0][2]
        assert cell[0].startswith(opening)
        assert (cell[0] == "open: ") is bool(opening)


def test_the_torque_varies_by_the_group_that_the_figures_say():
    model, gains = made({"TV": {"model l2": 9.0, "Q": 2.0}}), made({"TV": {"model l2": 2.0, "Q": 9.0}})
    for one in (model, gains):
        verdict = torque_variation(one)
        leader = "the law's model of the arm causes" if one is model else "the law's gains cause"
        assert f"over 5 s, {leader} the largest part, 95 % and 95 % at joints" in verdict.statement  # 81 / 85
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
    assert "no group causes the largest part at both joints" in mixed.statement


def test_the_part_of_the_first_second_is_that_of_the_sums():
    # of every run the TV from the start to t grows as t, and so the sum up to t as its square
    assert first_second(usual().indices) == pytest.approx([1 / T**2] * 2, rel=1e-12)
    assert "4 % and 4 % of the TV occur in the first second" in torque_variation(usual()).evidence


def test_the_indices_within_a_window_are_those_of_what_is_added_in_it():
    one = usual()

    def change(values, column):
        del column
        at = one.indices.measurement.place("TV", 0)
        u = one.indices.factor_values[:, SOME.index("R")]
        values[:, :, at] = np.where(np.arange(T) < 1, 1.0, (1.0 + u[:, np.newaxis]) / one.indices.t)

    shares = with_values(one, "indices", change).shares_within("TV", 1.0, 3.0)["TV of joint 1"]
    assert shares.S1.value[SOME.index("R")] == pytest.approx(1.0, abs=1e-6)  # what is added is the u of R alone
