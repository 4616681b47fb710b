"""The study of what the paper does not state: its readings as numbers, its fits and its findings."""

from dataclasses import replace
from types import SimpleNamespace

import casadi as ca
import numpy as np
import pytest

from studies.a6_unstated_choices import (
    deciding,
    draws,
    experiments,
    findings,
    fits,
    loops,
    ranking,
    rows,
    scope,
    shares,
)
from studies.a6_unstated_choices.blocks import chosen
from studies.paper.card import CARD, INERTIA, LAWS
from studies.paper.laws import ARM, PRINTED_ARM, REFERENCES, plant, rival
from studies.paper.unstated import left_out
from tests.support.samples import made_sample, with_measurement
from workbench.arms.laws import PID, AosmcRgs
from workbench.arms.laws.aosmc_rgs import SHAPES
from workbench.arms.observers import FullState, Luenberger, OracleFilter, PrintedFilter, WithDisturbance
from workbench.blocks.loop import ClosedLoop
from workbench.study.compiled import compile_sweep
from workbench.study.contract import Run, Sweep
from workbench.study.uncertainty import Estimate, Listed, SobolIndices, share


def rates(loop, x, p=None):
    """x' at t = 0.3 s by the names of the states."""
    ode = loop.ode()
    row = ode.parameters.pack(p or {})[0]
    state = ode.states.pack({name: x[name] for name in ode.states.names})[0]
    found = np.array(ode.f(0.3, state, row)).ravel()
    return {name: part[0] for name, part in ode.states.unpack(found[np.newaxis]).items()}


def states(seed=3):
    """Values for all states that any of the loops has."""
    rng = np.random.default_rng(seed)
    K, eta = rng.normal(size=(2, 2)) + 6 * np.eye(2), rng.normal(size=2)
    state = {"q_hat": rng.normal(size=2), "qd_hat": rng.normal(size=2)}
    z = rng.normal(size=2)
    wide = {f"observer.{name}": part for name, part in state.items()} | {"observer.eta": eta, "observer.z": z}
    alone = {f"observer.state.{name}": part for name, part in state.items()}
    own = {"plant.q": rng.normal(size=2), "plant.qd": rng.normal(size=2), "controller.integral": rng.normal(size=2)}
    own |= {"controller.K": K, "controller.P": 3 * np.eye(2) + 0.3}
    return own, wide, alone, eta, z


@pytest.fixture(scope="module")
def proposed():
    return loops.loop(loops.PROPOSED, "SS")


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("printed", [0, 1])
def test_each_reading_as_a_number_is_the_law_with_that_reading(proposed, shape, printed):
    own, wide, alone, eta, z = states()
    model = PRINTED_ARM if printed else ARM
    law = AosmcRgs(
        model,
        *(CARD[name] for name in ("Lambda", "phi", "K(0)", "P(0)", "Q", "R")),
        velocity="printed" if printed else "reference",
        gain_sign="printed" if printed else "raised",
        gain_shape=shape,
    )
    filter_ = PrintedFilter(2, CARD["l"]) if printed else OracleFilter(2, CARD["l"])
    seen = Luenberger(model, CARD["L1"], CARD["L2"], CARD["q_hat(0)"], CARD["qd_hat(0)"])
    genuine = ClosedLoop(plant("SS"), WithDisturbance(seen, filter_), law, REFERENCES["SS"])
    hidden = {"observer.disturbance.D_hat": z if printed else eta, "observer.disturbance.eta": eta}
    expected = rates(genuine, own | alone | hidden)

    places = {"controller.shape": list(SHAPES).index(shape), "controller.printed": printed}
    places |= {"controller.minus": printed}
    places |= {"observer.d_hat": 1 + printed, "observer.inside": 1}
    places |= {"controller.model.misprint": printed, "observer.state.model.misprint": printed}
    got = rates(proposed, own | wide, places)
    for name in ("plant.qd", "controller.K", "controller.P"):
        # the same operations but for their order; P' has products of some thousands
        np.testing.assert_allclose(got[name], expected[name], rtol=1e-11, atol=1e-9)
    np.testing.assert_allclose(got["observer.qd_hat"], expected["observer.state.qd_hat"], rtol=1e-11, atol=1e-9)


@pytest.mark.parametrize("law", LAWS[1:])
def test_a_rival_beside_exact_measurements_is_that_of_a1(law):
    own, wide, _, _, _ = states()
    x = own | wide | {"controller.K": np.array([4.0, 7.0]), "controller.s_slow": np.array([0.1, 0.4])}
    x |= {"controller.W": np.linspace(-1, 1, 10).reshape(5, 2)}
    got, expected = rates(loops.loop(law, "FS"), x), rates(rival("FS", law), x)
    for name, part in expected.items():
        np.testing.assert_allclose(got[name], part, rtol=1e-12, atol=1e-12)


def test_pid_lifts_the_arm_where_it_is_told_to():
    own, wide, _, _, _ = states()
    gains = (3 * 36.0 * INERTIA, 216.0 * INERTIA, 18.0 * INERTIA)
    genuine = ClosedLoop(plant("FS"), FullState(2), PID(*gains, model=ARM), REFERENCES["FS"])
    got = rates(loops.loop(loops.PID, "FS"), own | wide, {"controller.lifted": 1})
    np.testing.assert_allclose(got["plant.qd"], rates(genuine, own)["plant.qd"], rtol=1e-12)


def test_readings_are_equally_likely_and_casadi_takes_the_one_that_is_named():
    spread = loops.Reading(("a", "b", "c", "d"))
    places = spread.quantile((np.arange(1000) + 0.5) / 1000)
    assert np.bincount(places.astype(int)).tolist() == [250] * 4
    assert spread.quantile(np.array([0.0, 1.0])).tolist() == [0.0, 3.0]
    reading = ca.SX.sym("reading")
    pick = ca.Function("pick", [reading], [chosen(reading, *map(ca.SX, (1.0, 2.0, 3.0)))])
    assert [float(pick(place)) for place in (0, 1, 2)] == [1.0, 2.0, 3.0]


@pytest.mark.parametrize("kind", draws.DESIGNS)
def test_a_part_of_a_design_gives_back_the_whole_of_it(kind):
    whole, factors = draws.DESIGNS[kind], loops.factors_of("SMC", "FS")
    part, places = draws.part(kind, factors)
    columns = [loops.NAMES.index(factor.name) for factor in factors]
    np.testing.assert_array_equal(part.points()[places], whole.points()[:, columns])
    # three factors change a run: A, B and what takes one of the three from the other
    assert part.size == (whole.base * (2 + 3) if kind == "paired" else whole.runs)


def test_an_error_that_dies_out_gives_its_rmse_at_every_horizon():
    t = np.arange(1.0, 31.0)
    squares = 7.0 * (1 - np.exp(-3 * t)) / fits.SAMPLE  # the sum over samples: done before the shortest horizon
    values = np.sqrt(squares / (t / fits.SAMPLE + 1))[np.newaxis, :, np.newaxis] * np.ones(2)
    times, rmse = fits.horizons(sampled(t, values))
    # what is left of the exponential at 5 s is 3e-7
    np.testing.assert_allclose(rmse[0, :, 0], np.sqrt(7.0 / (times + fits.SAMPLE)), rtol=1e-6)


def test_the_nearest_choice_to_a_row_is_the_one_that_has_it_at_one_horizon():
    t = np.arange(1.0, 31.0)
    ends = np.array([[0.3538, 0.3542], [0.3538, 0.40], [np.nan, np.nan]])  # at 20 s
    values = ends[:, np.newaxis] * np.sqrt((20 + fits.SAMPLE) / (t + fits.SAMPLE))[:, np.newaxis]
    samples = {"FS": sampled(t, values)}
    row = fits.nearest("AOSMC-RGS", "FS", samples)
    assert row[0] < 1e-9
    assert 0.05 < row[1] < 0.07  # between its joints, 12 % apart
    assert np.isinf(row[2])
    assert fits.nearest("AOSMC-RGS", "FS q2", samples)[1] < fits.CLOSE
    np.testing.assert_array_equal(
        experiments.OneRow("AOSMC-RGS", "FS", 20.0)({"fs": samples["FS"]}) < 1e-9, [True, False, False]
    )


def sampled(t, values):
    """Runs with these values (N, T, 2) of RMSE."""
    columns = (("RMSE (43)", 0, "rad"), ("RMSE (43)", 1, "rad"))
    runs = len(values)
    lost = np.where(np.isnan(values).any(axis=(1, 2)), 1.0, np.nan)
    none = np.empty(0, dtype=int)
    return made_sample(
        "x", (), columns, t, 1e-3, 0, "", np.empty((runs, 0)), values, none, np.empty((0, len(t), 2)), np.empty(0), lost
    )


def test_the_margin_is_below_one_half_where_the_proposed_law_is_first():
    ours = np.array([[1.0, 1.0], [np.nan, 1.0], [1.0, 3.0]])
    rivals = {law: np.full((3, 2), 2.0) for law in LAWS[1:]} | {"PID": np.full((3, 2), np.nan)}
    assert np.allclose(
        draws.margin({"AOSMC-RGS": ours} | rivals), [[1 / 3, 1 / 3], [1, 1 / 3], [1 / 3, 3 / 5]], rtol=1e-15
    )


def made(part, runs=400):
    """Draws in which the proposed law is first in a part of them, and last in the others."""
    rmse = np.tile(np.arange(2.0, 2.0 + len(LAWS)), (runs, 1))
    rmse[:, 0] = np.where(np.arange(runs) < part * runs, 1.0, 9.0)
    return shares.Draws(rmse, np.random.default_rng(0).random((runs, len(loops.NAMES))))


def everywhere(*parts):
    """These draws in all columns, under a prior each, from the first prior on; the last of them under all others."""
    every = zip(draws.PRIORS, [*parts, *[parts[-1]] * len(draws.PRIORS)], strict=False)
    return {(name, column): made(part) for name, part in every for column in shares.COLUMNS}


def again(every, error=0.0):
    """Every draw run at half of the step too, with this error."""
    return {cell: shares.Rerun(one, np.full(len(one.rmse), error)) for cell, one in every.items()}


def test_the_answer_on_who_is_first_is_that_of_all_columns_and_priors():
    for parts, answer, kind in (((0.1,), "no", "found"), ((0.9,), "yes", "found"), ((0.1, 0.5), "undecided", "open")):
        every = everywhere(*parts)
        finding = ranking.first_finding(every, every, again(every))
        assert finding.answer == answer
        assert ("open" if not finding.settled else "found") == kind
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
    assert rerun.undecided.sum() == 20
    assert rerun.beyond.sum() == 20
    assert rerun.moved(1).first().sum() == 30  # 1 + 2.5 is above the first rival
    assert "In 20 the error reaches a rival" in ranking.step_words({("of the card", ("FS", 1)): rerun})


def test_an_error_of_the_step_is_taken_at_the_horizon_of_its_own_draw():
    t = np.arange(1.0, loops.LONGEST + 1)
    _, places = draws.part("random", loops.factors_of(loops.PROPOSED, "FS"))
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
        finding = deciding.deciding_finding(every)
        assert finding.answer == answer
        assert finding.settled == (answer == "b")
        assert [one.words for one in finding.variations] == list(shares.COLUMNS.values())
        assert str(deciding.largest(every)["FS, q1"][0]) == f"b (0.60 ± {half:.2f})"


@pytest.mark.parametrize("name", draws.PRIORS)
def test_a_prior_draws_numbers_evenly_on_its_scales(name):
    prior = draws.PRIORS[name]
    middle = {"linear": lambda low, high: (low + high) / 2, "log": lambda low, high: (low * high) ** 0.5}
    for law in LAWS:
        for factor in prior.factors(law, "SS"):
            spread = factor.distribution
            if isinstance(spread, loops.Reading) or spread.low <= 0:
                continue
            scale = prior.ours if law == loops.PROPOSED and factor.name not in ("a1", "a2", "f") else prior.rest
            expected = middle[scale](spread.low, spread.high)
            assert spread.quantile(np.array([0.5]))[0] == pytest.approx(expected, rel=1e-12)  # rounding
    seconds = prior.horizons(np.array([1e-9, 1 - 1e-9]))
    assert seconds.tolist() == [loops.SHORTEST, loops.LONGEST]


def test_the_prior_of_the_card_is_that_of_the_factors_and_priors_of_the_same_scales_share_runs():
    for law in LAWS:
        for scenario in loops.SCENARIOS:
            assert draws.OF_CARD.factors(law, scenario) == loops.factors_of(law, scenario)
    names = {draws.named("random", law, "FS", prior) for law in LAWS for prior in draws.PRIORS.values()}
    assert len(names) == 2 * len(LAWS)
    assert len({draws.named("random", "AOSMC-RGS", "SS", prior) for prior in draws.PRIORS.values()}) == 4


def test_the_one_experiment_is_the_same_for_all_laws_and_leaves_open_only_what_is_their_own():
    for law in LAWS:
        loop = experiments.shared_loop(law)
        square = loop.reference.square
        assert (tuple(square.amplitude), square.frequency) == (experiments.AMPLITUDES, experiments.FREQUENCY)
        names = {factor.name for factor in experiments.own(law)}
        assert not names & {"a1", "a2", "f", "rivals' measurements"}
        if law not in (loops.PROPOSED, loops.PID):
            assert loop.observer.inside == 1.0


def fitted(miss):
    """Fits of each law to each target with this miss."""
    numbers = {law: np.array([one.distribution.high for one in loops.factors_of(law, "SS")]) for law in LAWS}
    both = dict.fromkeys(loops.SCENARIOS, np.full(2, 0.3))
    one = fits.Fit(np.empty(0), dict.fromkeys(both, 20.0), both, both, miss, 0, 2)
    return {(law, target): replace(one, numbers=numbers[law]) for law in LAWS for target in fits.TARGETS}


def common_searches(miss=0.5):
    """The searches at one horizon and the searches for one row, with runs that are off by this part."""
    printed = {law: np.array([fits.PUBLISHED["FS", joint].values[law] for joint in (1, 2)]) for law in LAWS}
    t = np.arange(1.0, loops.LONGEST + 1)

    def tuned(name):
        law = next((law for law in LAWS if name.startswith(loops.slug("common", law))), loops.PROPOSED)
        values = (1 + miss) * np.broadcast_to(printed[law], (1, len(t), 2))
        return SimpleNamespace(samples={"fs": sampled(t, values)})

    return SimpleNamespace(tuned=tuned)


def test_the_finding_on_one_experiment_is_met_only_if_all_rows_of_both_scenarios_are():
    near, numbers = dict.fromkeys(LAWS, 0.004), dict.fromkeys(LAWS, "")
    one = experiments.Experiment(9.0, near, numbers)
    good = findings.tables_finding(common_searches(), fitted(0.002), one, one)
    assert good.answer == "met"
    assert good.statement.startswith("One experiment for each scenario gives 12 of the 12")
    # what the page of a2 rests on
    assert all(f"6 of 6 rows of the {scenario} scenario come" in good.evidence for scenario in ("first", "second"))
    assert "+0.5 % and -0.3 %" in good.chosen  # by how much the amplitudes were moved by hand
    bad = findings.tables_finding(common_searches(), fitted(0.002), one, replace(one, miss=near | {"PID": 0.02}))
    assert not bad.settled
    assert "11 of the 12" in bad.statement


def test_a_law_whose_four_cells_are_not_met_by_one_choice_reverses_the_finding_on_the_tables():
    one = experiments.Experiment(9.0, dict.fromkeys(LAWS, 0.004), dict.fromkeys(LAWS, ""))
    met = fitted(0.002)
    met["ASMC", "both"] = replace(met["ASMC", "both"], miss=0.035)
    finding = findings.tables_finding(common_searches(0.0), met, one, one)
    assert [(each.words, each.detail) for each in finding.reversals] == [
        ("all cells, same gains, horizons of its own for each law", "ASMC is the farthest, 3.5 %")
    ]


def row(sign, shape, miss):
    """The nearest of a search, with the readings that the search does not vary, and the first of all others."""
    numbers = [factor.distribution.quantile(np.array([0.01]))[0] for factor in rows.factors(sign, shape)]
    fit = fits.Fit(np.array(numbers), {"FS": 40.0}, {}, {}, miss, 0, 1)
    return rows.Row(sign, shape, fit)


def test_the_row_identifies_the_law_only_if_one_sign_alone_meets_it():
    def finding(**near):
        every = [row(*case, near.get(case[0].replace(", two repairs", "_two"), 0.2)) for case in rows.CASES]
        return findings.row_finding(common_searches(), every)

    assert "does not identify the law" in finding(plus=0.002, minus=0.2, minus_two=0.001).statement
    assert "the plus alone meets" in finding(plus=0.002).statement
    assert "No choice" in finding().statement
    assert not finding().settled
    words = [one.words for one in finding().variations]
    assert words[: len(rows.CASES)] == [f"{sign}, {shape}" for sign, shape in rows.CASES]


def test_two_repairs_are_those_of_the_equations_3_and_28():
    one = row(rows.TWO, "outer", 0.001)
    assert one.repairs == ("velocity in (28)", "C of (3)")
    names = {factor.name: factor.distribution for factor in loops.FACTORS[loops.PROPOSED]}
    for fixed in rows.FIXED.values():
        assert all(value in names[name].names for name, value in fixed.items())
    readings = {name for name, spread in names.items() if isinstance(spread, loops.Reading)}
    assert set(rows.PRINTED) == readings - {"shape of (33)"}


def test_a_point_of_a_search_has_the_same_numbers_where_every_reading_is_free():
    rng = np.random.default_rng(4)
    for case in rows.CASES:
        u = rng.random(len(rows.factors(*case)))
        pairs = list(zip(rows.factors(*case), loops.factors_of(loops.PROPOSED, "FS"), u, strict=True))
        numbers = [fixed.distribution.quantile(np.array([at]))[0] for fixed, _, at in pairs]
        for number, (_, free, at) in zip(numbers, pairs, strict=True):
            place = rows.place_of(free, at, number)
            assert free.distribution.quantile(np.array([place]))[0] == number


def test_what_no_factor_varies_is_named_in_every_finding():
    every = everywhere(0.1)
    one = experiments.Experiment(9.0, dict.fromkeys(LAWS, 0.004), dict.fromkeys(LAWS, ""))
    made_of = [
        ranking.first_finding(every, every, again(every)),
        findings.row_finding(common_searches(), [row(*case, 0.2) for case in rows.CASES]),
        findings.tables_finding(common_searches(), fitted(0.002), one, one),
    ]
    missing = {choice.name for choice in left_out(loops.NAMES)} - {"torque limit"}  # which draws of its own vary
    assert missing == {choice.name for choice in scope.OMITTED}
    assert all(name in finding.untried for finding in made_of for name in missing)
    assert all(f"{choice.name}: {choice.assumed}" in finding.chosen for finding in made_of for choice in scope.OMITTED)


@pytest.mark.parametrize("law", ["PID", "AOSMC-RGS"])
def test_a_limited_torque_acts_on_the_arm_and_is_what_the_observer_reads(law):
    own, wide, _, _, _ = states()
    x = own | wide | {"controller.K": 400 * np.eye(2)}
    free, limited = loops.loop(law, "FS"), loops.loop(law, "FS", draws.LIMIT)
    seen = {"observer.inside": 1}  # the observer's own states are what the law reads
    ahead, held = rates(free, x, seen), rates(limited, x, seen)
    tau = np.array(arm_force(x["plant.q"], x["plant.qd"], held["plant.qd"]))
    # what acts, beside the disturbance at 0.3 s, is within the limits, to rounding, and without them it is not
    D = np.array([0.5 * np.sin(0.9), 0.4 * np.cos(1.2)])
    assert (np.abs(tau + D) <= np.array(draws.LIMIT) * (1 + 1e-12)).all()
    outside = np.array(arm_force(x["plant.q"], x["plant.qd"], ahead["plant.qd"]))
    assert (np.abs(outside + D) > np.array(draws.LIMIT)).any()
    q_hat, qd_hat = x["observer.q_hat"], x["observer.qd_hat"]
    correction = CARD["L2"] @ (x["plant.q"] - q_hat)
    read = np.array(arm_force(q_hat, qd_hat, held["observer.qd_hat"] - correction))
    np.testing.assert_allclose(read, tau + D, rtol=1e-9)


def arm_force(q, qd, qdd):
    """M qdd + C qd + G in N m."""
    m, l, g = 1.0, 1.0, 9.81
    c2, s2 = np.cos(q[1]), np.sin(q[1])
    M = np.array([[m * (3 + 2 * c2), m * (1 + c2)], [m * (1 + c2), m]]) * l**2
    C = np.array([[-s2 * qd[1], -s2 * (qd[0] + qd[1])], [s2 * qd[0], 0.0]])
    G = np.array([2 * g * np.sin(q[0]) + g * np.sin(q[0] + q[1]), g * np.sin(q[0] + q[1])])
    return M @ qdd + C @ qd + G


def test_the_draws_with_limited_torques_are_the_first_of_all_draws():
    np.testing.assert_array_equal(draws.LIMITED.points(), draws.RANDOM.points()[: draws.LIMITED.runs])


@pytest.mark.heavy
def test_a_rival_run_by_a_computer_with_a_relay_has_the_rmse_of_its_boundary_layer():
    gentle, factors, layer = np.array([[0.2, 0.2, 0.1], [0.6, 0.4, 0.1]]), loops.FACTORS["SMC"], loops.loop("SMC", "FS")

    def rmse(loop, h):
        one = compile_sweep(Sweep("x", Run(loop, (loops.RMSE,), 4.0, h=h), factors, Listed(gentle), halved=None))
        return one.sample([one.chunk(0, 2)]).values

    # a period of 2 ms holds every torque 1 ms too long, beside the 170 ms of the surface
    np.testing.assert_allclose(rmse(loops.relayed("SMC", layer), loops.PERIOD), rmse(layer, 2e-4), rtol=0.01)
