"""The study of what the paper does not state: its readings as numbers, its fits and its verdicts."""

from dataclasses import replace
from types import SimpleNamespace

import casadi as ca
import numpy as np
import pytest
from samples import made_sample, with_measurement

from studies.a6_unstated_choices import findings, fits, loops, ranking
from studies.a6_unstated_choices.blocks import chosen
from studies.paper.card import CARD, INERTIA, LAWS
from studies.paper.laws import ARM, PRINTED_ARM, REFERENCES, plant, rival
from workbench.controllers import PID, AosmcRgs
from workbench.controllers.aosmc_rgs import SHAPES
from workbench.loop import ClosedLoop
from workbench.observers import FullState, Luenberger, OracleFilter, PrintedFilter, WithDisturbance
from workbench.study.compiled import compile_sweep
from workbench.study.contract import Run, Sweep
from workbench.study.evidence import paired
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
        gain_sign="raised",
        gain_shape=shape,
    )
    filter_ = PrintedFilter(2, CARD["l"]) if printed else OracleFilter(2, CARD["l"])
    seen = Luenberger(model, CARD["L1"], CARD["L2"], CARD["q_hat(0)"], CARD["qd_hat(0)"])
    genuine = ClosedLoop(plant("SS"), WithDisturbance(seen, filter_), law, REFERENCES["SS"])
    hidden = {"observer.disturbance.D_hat": z if printed else eta, "observer.disturbance.eta": eta}
    expected = rates(genuine, own | alone | hidden)

    places = {"controller.shape": list(SHAPES).index(shape), "controller.printed": printed}
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


@pytest.mark.parametrize("kind", loops.DESIGNS)
def test_a_part_of_a_design_gives_back_the_whole_of_it(kind):
    whole, factors = loops.DESIGNS[kind], loops.factors_of("SMC", "FS")
    part, places = loops.part(kind, factors)
    columns = [loops.NAMES.index(factor.name) for factor in factors]
    np.testing.assert_array_equal(part.points()[places], whole.points()[:, columns])
    # three factors change a run: A, B and what takes one of the three from the other
    assert part.size == (whole.runs if kind == "random" else whole.base * (2 + 3))


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
        fits.OneRow("AOSMC-RGS", "FS", 20.0)({"fs": samples["FS"]}) < 1e-9, [True, False, False]
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
        loops.margin({"AOSMC-RGS": ours} | rivals), [[1 / 3, 1 / 3], [1, 1 / 3], [1 / 3, 3 / 5]], rtol=1e-15
    )


def made(part, runs=400):
    """Ranks in which the proposed law is first in a part of the draws, and last in the others."""
    values = {law: np.full(runs, 2.0 + i) for i, law in enumerate(LAWS)}
    values["AOSMC-RGS"] = np.where(np.arange(runs) < part * runs, 1.0, 9.0)
    return ranking.ranks(paired(values, metric="RMSE", unit="rad"), ranking.TOGETHER)


def of_columns(*parts):
    """These ranks in all columns, under a prior each."""
    return {str(i): dict.fromkeys(ranking.COLUMNS, made(part)) for i, part in enumerate(parts)}


def test_the_verdict_on_who_is_first_turns_with_the_draws_of_any_prior_and_tells_of_the_step():
    for part, kind in ((0.1, "found"), (0.9, "depends"), (0.5, "open")):
        verdict = ranking.first_verdict(of_columns(0.1, part), "The step moves one.")
        assert verdict.kind == kind
        assert verdict.evidence.endswith("The step moves one.")


def test_a_rival_that_is_better_under_one_prior_alone_is_said_to_turn_with_it():
    alike = ranking.pairs_verdict(of_columns(0.1, 0.1), "")
    assert alike.kind == "found"
    assert "; ".join(f"{rival} no, under each" for rival in LAWS[1:]) in alike.evidence
    apart = ranking.pairs_verdict(of_columns(0.1, 0.9), "")
    assert apart.kind == "depends"
    assert "than ASMC in 10 % to 90 %" in apart.statement
    assert "; ".join(f"{rival} depends on the prior" for rival in LAWS[1:]) in apart.evidence
    assert "ASMC 10 % (6 to 15) to 90 % (85 to 94)" in apart.evidence


def test_one_of_sixteen_shares_beyond_one_half_by_its_own_interval_alone_leaves_the_majority_open():
    assert share(np.arange(512) < 0.55 * 512).low > 0.5
    others = [ranking.ahead(made(0.05, 512))] * 15
    assert ranking.majority([*others, ranking.ahead(made(0.55, 512))]) == "open"
    assert ranking.majority([*others, ranking.ahead(made(0.6, 512))]) == ranking.TURNS


def test_the_majority_of_the_draws_is_told_only_where_all_intervals_agree():
    low, high, half = (0.1, 0.05, 0.2), (0.8, 0.7, 0.9), (0.5, 0.4, 0.6)
    assert ranking.majority([low, low]) == "no, under each"
    assert ranking.majority([high, high]) == "yes, under each"
    assert ranking.majority([low, high]) == ranking.TURNS
    assert ranking.majority([low, half]) == ranking.majority([high, half]) == "open"


def test_the_step_that_moves_one_draw_of_the_second_scenario_most_is_told_with_it():
    t, values = np.array([30.0]), np.ones((2, 1, 2))
    errors = {"FS": 0.002, "SS": 2.0}

    def run(name):
        one, again = sampled(t, values), np.arange(2)
        error = np.full((2, 1, 2), errors["SS" if "_ss_" in name else "FS"])
        lost, limits = np.full(2, np.nan), np.full(2, np.inf)
        return with_measurement(one, looked_at=again, errors=error, half_diverged_at=lost, limits=limits)

    words = ranking.step_words(SimpleNamespace(sample=run))
    # two priors of the first scenario and four of the second share their runs: 6 samples, 2 runs, 2 joints
    assert "of 24 values" in words
    assert "16 are off by more than 1 %" in words
    assert "a draw of the second scenario is off most, by 2 rad" in words


def test_the_verdict_on_what_decides_is_open_where_two_indices_cannot_be_told_apart():
    value = np.tile([0.1, 0.6, 0.3, 0.0], (4, 1))
    for half, kind in ((0.1, "found"), (0.2, "open")):
        ST = Estimate(value, np.full((4, 4), half))
        every = SobolIndices(tuple(ranking.COLUMNS.values()), tuple("abcd"), ST, ST, None, np.ones(4), {}, ())
        verdict = ranking.deciding_verdict(every)
        assert verdict.kind == kind
        assert f"FS, q1: b (0.60 ± {half:.2f}), c (0.30 ± {half:.2f}), a" in verdict.evidence


@pytest.mark.parametrize("name", loops.PRIORS)
def test_a_prior_draws_numbers_evenly_on_its_scales(name):
    prior = loops.PRIORS[name]
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
            assert loops.OF_CARD.factors(law, scenario) == loops.factors_of(law, scenario)
    names = {loops.named("random", law, "FS", prior) for law in LAWS for prior in loops.PRIORS.values()}
    assert len(names) == 2 * len(LAWS)
    assert len({loops.named("random", "AOSMC-RGS", "SS", prior) for prior in loops.PRIORS.values()}) == 4


def test_the_one_experiment_is_the_same_for_all_laws_and_leaves_open_only_what_is_their_own():
    for law in LAWS:
        loop = fits.shared_loop(law)
        square = loop.reference.square
        assert (tuple(square.amplitude), square.frequency) == (fits.AMPLITUDES, fits.FREQUENCY)
        names = {factor.name for factor in fits.own(law)}
        assert not names & {"a1", "a2", "f", "rivals' measurements"}
        if law not in (loops.PROPOSED, loops.PID):
            assert loop.observer.inside == 1.0


def test_the_verdict_on_one_experiment_holds_only_if_all_rows_are_met():
    near, numbers = dict.fromkeys(LAWS, 0.004), dict.fromkeys(LAWS, "")
    assert findings.shared_verdict(fits.Shared(9.0, near, numbers)).kind == "found"
    verdict = findings.shared_verdict(fits.Shared(9.0, near | {"PID": 0.02}, numbers))
    assert verdict.kind == "open"
    assert "5 of 6 rows" in verdict.statement
    assert "+0.5 % and -0.3 %" in verdict.evidence  # by how much the amplitudes were moved by hand


def fitted(miss):
    """Fits of each law to each target with this miss."""
    numbers = {law: np.array([one.distribution.high for one in loops.factors_of(law, "SS")]) for law in LAWS}
    both = dict.fromkeys(loops.SCENARIOS, np.full(2, 0.3))
    one = fits.Fit(np.empty(0), dict.fromkeys(both, 20.0), both, both, miss, 0, 2)
    return {(law, target): replace(one, numbers=numbers[law]) for law in LAWS for target in fits.TARGETS}


def test_the_verdicts_on_the_fits_turn_with_their_misses():
    good, bad = findings.fit_verdicts(fitted(0.002)), findings.fit_verdicts(fitted(0.2))
    assert [verdict.kind for verdict in good] == ["found"] * 3
    assert [verdict.kind for verdict in bad] == ["open"] * 3
    assert [verdict.statement.split(" of ")[0] for verdict in good[1:]] == ["24", "For 6"]
    assert "at the step of the search 2 of its choices come" in bad[2].evidence


def test_a_rival_run_by_a_computer_with_a_relay_has_the_rmse_of_its_boundary_layer():
    gentle, factors, layer = np.array([[0.2, 0.2, 0.1], [0.6, 0.4, 0.1]]), loops.FACTORS["SMC"], loops.loop("SMC", "FS")

    def rmse(loop, h):
        one = compile_sweep(Sweep("x", Run(loop, (loops.RMSE,), 4.0, h=h), factors, Listed(gentle), halved=None))
        return one.sample([one.chunk(0, 2)]).values

    # a period of 2 ms holds every torque 1 ms too long, beside the 170 ms of the surface
    np.testing.assert_allclose(rmse(loops.relayed("SMC", layer), loops.PERIOD), rmse(layer, 2e-4), rtol=0.01)
