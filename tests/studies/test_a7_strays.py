"""The findings of a7 on runs that stray, arrive late or are heavy: second looks at the runs of a law."""

from dataclasses import replace

import numpy as np
import pytest

from studies.a7_sensitivity import late_errors, second_looks, stray_runs, sweeps
from studies.a7_sensitivity.second_looks import Later, Numbers
from studies.a7_sensitivity.sweeps import PROPOSED_LAW, free, loop
from studies.paper.factors import group_of
from tests.support.drawn_indices import NO_RUNS, SOME, made, usual, with_values
from workbench.engine.factors import Space
from workbench.engine.metrics import late_error, measure
from workbench.study.uncertainty import MonteCarlo


def test_a_run_with_much_of_the_variance_of_the_late_error_is_named():
    def change(values, place):  # all about 0.1
        values[7, -1, place], values[8, -1, place] = 3.1, 1.1  # squares of 9 and 1 beside those of all others

    said = (
        "causes 90 % of the variance at joint 2 (3.10 rad; the next largest is 1.10 rad); the heaviest 1 % of the runs"
    )
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


def stray_finding(one, later, redrawn=NO_RUNS, others=None):
    laws = {PROPOSED_LAW: one, **(others or {})}
    looks = {law: later if law == PROPOSED_LAW else () for law in laws}
    return stray_runs.strays(laws, looks, redrawn, dict.fromkeys(laws, 1.54))


def test_runs_stray_if_they_are_far_off_early_and_late_and_a_lost_one_is_among_them():
    def change(values, place):
        values[3, -1, place], values[4, -1], values[5, -1, place] = 2.5, np.nan, 0.6

    none = stray_finding(usual(), ())
    assert " in 0 of " in none.statement
    assert none.answer == "none"
    one = with_values(usual(), "screening", change)
    (runs,) = second_looks.suspects(one)
    assert (runs.values == one.screening.factor_values[3:6]).all()
    stay, back = np.array([[0.1, 2.5], [np.nan] * 2, [0.1, 0.6]]), np.array([[0.1, 0.2], [np.nan] * 2, [0.1, 0.2]])
    for errors, counts in ((stay, (2, 3, 2)), (back, (1, 1, 1))):
        verdict = stray_finding(one, (Later(errors),))
        assert " in 2 of " in verdict.statement
        assert f", and in {counts[0]} of these also between 18 and 20 s." in verdict.statement
        assert verdict.answer == "fewer than 1 %"
        for variation, count in zip(verdict.variations[:2], counts[1:], strict=True):
            assert f", {count} of these also from 18 to 20 s" in variation.detail


def test_a_law_that_arrives_late_is_told_from_one_that_strays():
    def far(values, place):
        values[:, -1, place] = 1.2

    slow = replace(with_values(usual(), "indices", far), law="SMC")
    runs = len(slow.indices)
    for error, answer, lasting in ((0.1, "none", 0), (1.1, "1 % or more", runs)):
        looks = {PROPOSED_LAW: (), "SMC": (Later(np.full((runs, 2), error)),)}
        own = {PROPOSED_LAW: 0.1, "SMC": 1.54}
        verdict = stray_runs.strays({PROPOSED_LAW: usual(), "SMC": slow}, looks, NO_RUNS, own)
        assert next(one.answer for one in verdict.variations if one.words == "SMC") == answer
        every = sum(map(len, slow.samples))
        said = f"SMC exceeds 1 rad in {runs:,} of {every:,} runs from 3 to 5 s"
        assert said in verdict.evidence
        assert f"and in {lasting:,} of these also from 18 to 20 s" in verdict.evidence
        assert "is 1.54 rad" in verdict.evidence


def test_second_looks_are_given_to_the_law_whose_runs_they_are():
    def far(values, place):
        values[2, -1, place] = 1.2

    laws = {PROPOSED_LAW: with_values(with_values(usual(), "indices", far), "random", far), "SMC": usual()}
    answers = tuple(Later(np.full((1, 2), float(i))) for i in range(2))
    by_law = stray_runs.later_by_law(laws, answers)
    assert by_law == {PROPOSED_LAW: answers, "SMC": ()}


def test_the_numbers_of_a_run_are_those_of_its_sweep():
    ode, some = loop(PROPOSED_LAW).ode(), free(PROPOSED_LAW)
    space, points = Space(some, ode.parameters, ode.states), MonteCarlo(len(some), 5, 3).points()
    for own, swept in zip(
        Numbers(PROPOSED_LAW, tuple(SOME), space.values(points)).rows(ode), space.rows(points), strict=True
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
    assert again.values.shape == (second_looks.REDRAW_COUNT, len(SOME))
    assert (again.values[:, rest] == one.indices.factor_values[7, rest]).all()
    for factor in free(PROPOSED_LAW):
        drawn = again.values[:, SOME.index(factor.name)]
        low, high = factor.distribution.reach()
        if group_of(factor.name) == "gains":
            assert low <= drawn.min() < low + 0.05 * (high - low)
            assert high - 0.05 * (high - low) < drawn.max() <= high
    errors = np.zeros((second_looks.REDRAW_COUNT, 2))
    errors[:3, 1], errors[3] = 1.5, np.nan
    words = "model of run 8, and 400 random draws of the gains (Lambda, Q, R, L1, L2), 4 runs exceed 1 rad: the"
    assert words in second_looks.redrawn_words(one, Later(errors))
    assert second_looks.redrawn_words(one, Later(0 * errors[:3])).endswith("0 runs exceed 1 rad.")


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
