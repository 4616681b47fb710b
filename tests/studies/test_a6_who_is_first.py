"""The findings of a6 on who is first, from given errors: columns, priors, rivals, and errors of the step."""

from types import SimpleNamespace

import numpy as np

from studies.a6_unstated_choices import deciding_factors, draws, loops, ranking, shares
from studies.paper.card import LAWS
from tests.support.drawn_errors import again, everywhere, made, sampled
from tests.support.samples import with_measurement
from workbench.study.uncertainty import Estimate, SobolIndices, share


def test_the_margin_is_below_one_half_where_the_proposed_law_is_first():
    ours = np.array([[1.0, 1.0], [np.nan, 1.0], [1.0, 3.0]])
    rivals = {law: np.full((3, 2), 2.0) for law in LAWS[1:]} | {"PID": np.full((3, 2), np.nan)}
    assert np.allclose(
        draws.margin({"AOSMC-RGS": ours} | rivals), [[1 / 3, 1 / 3], [1, 1 / 3], [1 / 3, 3 / 5]], rtol=1e-15
    )


def test_the_answer_on_who_is_first_is_that_of_all_columns_and_priors():
    for parts, answer, kind in (((0.1,), "no", "found"), ((0.9,), "yes", "found"), ((0.1, 0.5), "undecided", "open")):
        every = everywhere(*parts)
        finding = ranking.first_finding(every, every, again(every))
        assert finding.answer == answer
        assert ("open" if not finding.is_decided else "found") == kind
    every = everywhere(0.1, 0.9)
    finding = ranking.first_finding(every, every, again(every))
    assert finding.answer == "mixed"
    cells = [one for one in finding.variations if one.words == "prior 'of the card', FS, q1"]
    assert [one.answer for one in cells] == ["no"]


def test_no_column_prior_rival_or_reading_is_left_out_of_the_variations():
    every = everywhere(0.1)
    first = {one.words for one in ranking.first_finding(every, every, again(every)).variations}
    below = {one.words for one in ranking.below_variations(every, every, again(every))}
    cells = {f"prior '{prior}', {column}" for prior in draws.PRIORS for column in shares.COLUMNS.values()}
    readings = {
        f"{factor.name}: {value}"
        for law in LAWS
        for factor in loops.FACTORS[law]
        if isinstance(factor.distribution, loops.Reading)
        for value in factor.distribution.names
    }
    for words in (first, below):
        assert cells | {f"{cell}, {ranking.LIMITS}" for cell in cells} | readings <= words
    assert {f"without {rival}" for rival in LAWS[1:]} <= first


def test_the_variation_of_a_reading_has_the_draws_of_that_reading_alone():
    one = made(0.5)
    column = loops.NAMES.index("sign of (33)")
    plus = one.reading("sign of (33)", "plus")
    np.testing.assert_array_equal(plus.points, one.points[one.points[:, column] < 0.5])
    assert len(plus.rmse) + len(one.reading("sign of (33)", "minus").rmse) == len(one.rmse)


def test_without_the_rival_that_is_ahead_the_proposed_law_is_first():
    one = made(0.0)
    one.rmse[:, 0] = 2.5 + np.arange(len(one.rmse)) % 2  # below all but the first rival, or two of them
    ahead = replace_rival(one, "PID", 1.0)
    assert not ahead.first().any()
    assert ahead.first(without="PID").mean() == 0.5


def replace_rival(one, rival, value):
    rmse = one.rmse.copy()
    rmse[:, LAWS.index(rival)] = value
    return shares.Draws(rmse, one.points)


def test_the_rivals_that_are_beaten_are_those_of_any_cell():
    every = everywhere(0.9)
    assert ranking.beaten(every) == ", ".join(LAWS[1:])
    mixed = {cell: replace_rival(one, "SMC", 0.5) for cell, one in every.items()}
    assert ranking.beaten(mixed) == ", ".join(LAWS[1:-1])
    assert ranking.beaten(everywhere(0.9, 0.1)) == ", ".join(LAWS[1:])
    assert ranking.beaten(everywhere(0.1)) == ranking.NONE
    assert ranking.most(everywhere(0.9, 0.1), "SMC") == shares.MIXED


def test_one_of_sixteen_shares_beyond_one_half_by_its_own_interval_alone_leaves_the_answer_undecided():
    part = np.arange(512) < 0.55 * 512
    assert share(part).low > 0.5
    assert shares.answer_of(share(part, shares.TOGETHER)) == shares.UNDECIDED
    others = [share(np.arange(512) < 0.05 * 512, shares.TOGETHER)] * 15
    assert shares.answer_of_all(others) == shares.NO
    assert shares.answer_of_all([*others, share(part, shares.TOGETHER)]) == shares.UNDECIDED
    assert shares.answer_of_all([*others, share(np.arange(512) < 0.6 * 512, shares.TOGETHER)]) == shares.MIXED


def test_a_rank_is_not_known_where_the_error_of_the_step_reaches_a_rival():
    one = made(0.5, 100)  # 1 beside rivals from 3 on, or 9 beside rivals up to 7
    errors = np.where(np.arange(100) < 20, 2.5, 0.005)
    rerun = shares.Rerun(one, errors)
    assert rerun.is_undecided.sum() == 20
    assert rerun.is_inaccurate.sum() == 20
    assert rerun.shifted_draws(1).first().sum() == 30  # 1 + 2.5 is above the first rival
    assert "In 20 the error reaches a rival" in ranking.step_words({("of the card", ("FS", 1)): rerun})


def test_an_error_of_the_step_is_taken_at_the_horizon_of_its_own_draw():
    t = np.arange(1.0, loops.LONGEST + 1)
    _, places = draws.part("random", loops.factors_of(loops.PROPOSED_LAW, "FS"))
    values = np.ones((len(places), len(t), 2))
    looked_at = np.arange(0, len(places), 4)
    errors = np.broadcast_to(t[:, np.newaxis], (len(looked_at), len(t), 2))  # the error is the time

    def run(name):
        nan = np.full(len(looked_at), np.nan)
        one = sampled(t, values)
        return with_measurement(one, looked_at=looked_at, errors=errors, half_diverged_at=nan, limits=nan)

    rows_, found = shares._errors(SimpleNamespace(sample=run), "FS", draws.OF_CARD)
    np.testing.assert_array_equal(found[:, 0], draws.OF_CARD.horizons_of("random", "FS")[rows_])
    np.testing.assert_array_equal(places[rows_], looked_at)


def test_the_finding_on_what_decides_is_open_where_no_two_indices_can_be_separated():
    value = np.tile([0.1, 0.6, 0.3, 0.0], (4, 1))
    for half, answer in ((0.1, "b"), (0.2, "none")):
        ST = Estimate(value, np.full((4, 4), half))
        every = SobolIndices(tuple(shares.COLUMNS.values()), tuple("abcd"), ST, ST, None, np.ones(4), {}, ())
        finding = deciding_factors.deciding_finding(every)
        assert finding.answer == answer
        assert finding.is_decided == (answer == "b")
        assert [one.words for one in finding.variations] == list(shares.COLUMNS.values())
        assert str(deciding_factors.largest(every)["FS, q1"][0]) == f"b (0.60 ± {half:.2f})"
