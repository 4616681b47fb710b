"""The study of what the paper does not state: its readings as numbers, its fits and its words."""

import casadi as ca
import numpy as np
import pytest

from studies.a6_unstated_choices import draws as draws
from studies.a6_unstated_choices import fits as fits
from studies.a6_unstated_choices import loops as loops
from studies.a6_unstated_choices import pages as pages
from studies.a6_unstated_choices import priors as priors
from studies.a6_unstated_choices import ranking as ranking
from studies.a6_unstated_choices import results as found
from studies.a6_unstated_choices import shared_choices as shared
from studies.paper.card import CARD, INERTIA, LAWS
from studies.paper.laws import ARM, PRINTED_ARM, REFERENCES, plant, rival
from workbench.controllers import PID, AosmcRgs
from workbench.controllers.aosmc_rgs import SHAPES
from workbench.loop import ClosedLoop
from workbench.observers import FullState, Luenberger, OracleFilter, PrintedFilter, WithDisturbance
from workbench.study.compiled import compile_sweep
from workbench.study.contract import Run
from workbench.study.sample import Sample
from workbench.study.sweep import Sweep
from workbench.study.uncertainty import Listed, MonteCarlo, SobolDesign


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


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("printed", [0, 1])
def test_each_reading_as_a_number_is_the_law_with_that_reading(shape, printed):
    own, wide, alone, eta, z = states()
    model = PRINTED_ARM if printed else ARM
    law = AosmcRgs(
        model,
        CARD["Lambda"],
        CARD["phi"],
        CARD["K(0)"],
        CARD["P(0)"],
        CARD["Q"],
        CARD["R"],
        velocity="printed" if printed else "reference",
        gain_sign="printed" if printed else "raised",
        gain_shape=shape,
    )
    filter_ = PrintedFilter(2, CARD["l"]) if printed else OracleFilter(2, CARD["l"])
    seen = Luenberger(model, CARD["L1"], CARD["L2"], CARD["q_hat(0)"], CARD["qd_hat(0)"])
    genuine = ClosedLoop(plant("SS"), WithDisturbance(seen, filter_), law, REFERENCES["SS"])
    hidden = {"observer.disturbance.D_hat": z if printed else eta, "observer.disturbance.eta": eta}
    expected = rates(genuine, own | alone | hidden)

    places = {"controller.shape": list(SHAPES).index(shape), "controller.minus": printed, "controller.printed": printed}
    places |= {"observer.d_hat": 1 + printed, "observer.inside": 1}
    places |= {"controller.model.misprint": printed, "observer.state.model.misprint": printed}
    found = rates(loops.loop(loops.PROPOSED, "SS"), own | wide, places)
    for ours, theirs in (("plant.qd", "plant.qd"), ("controller.K", "controller.K"), ("controller.P", "controller.P")):
        # the same operations but for their order; P' has products of some thousands
        np.testing.assert_allclose(found[ours], expected[theirs], rtol=1e-11, atol=1e-9)
    np.testing.assert_allclose(found["observer.qd_hat"], expected["observer.state.qd_hat"], rtol=1e-11, atol=1e-9)


@pytest.mark.parametrize("law", LAWS[1:])
def test_a_rival_beside_exact_measurements_is_that_of_a1(law):
    own, wide, _, _, _ = states()
    x = own | wide | {"controller.K": np.array([4.0, 7.0]), "controller.s_slow": np.array([0.1, 0.4])}
    x |= {"controller.W": np.linspace(-1, 1, 10).reshape(5, 2)}
    found, expected = rates(loops.loop(law, "FS"), x), rates(rival("FS", law), x)
    for name, part in expected.items():
        np.testing.assert_allclose(found[name], part, rtol=1e-12, atol=1e-12)


def test_pid_lifts_the_arm_where_it_is_told_to():
    own, wide, _, _, _ = states()
    gains = (3 * 36.0 * INERTIA, 216.0 * INERTIA, 18.0 * INERTIA)
    genuine = ClosedLoop(plant("FS"), FullState(2), PID(*gains, model=ARM), REFERENCES["FS"])
    found = rates(loops.loop(loops.PID, "FS"), own | wide, {"controller.lifted": 1})
    np.testing.assert_allclose(found["plant.qd"], rates(genuine, own)["plant.qd"], rtol=1e-12)


def test_readings_are_equally_likely():
    spread = loops.Reading(("a", "b", "c", "d"))
    places = spread.quantile((np.arange(1000) + 0.5) / 1000)
    assert np.bincount(places.astype(int)).tolist() == [250] * 4
    assert spread.quantile(np.array([0.0, 1.0])).tolist() == [0.0, 3.0]


@pytest.mark.parametrize("whole", [MonteCarlo(6, 40, 1), SobolDesign(6, 8, seed=1)])
def test_a_part_of_a_design_gives_back_the_whole_of_it(whole):
    part = draws.Part(whole, (4, 1))
    np.testing.assert_array_equal(part.points()[part.places], whole.points()[:, [4, 1]])
    np.testing.assert_array_equal(part.points(3, 9), part.points()[3:9])
    # of six factors two change a run: A, B and what takes one of the two from the other
    expected = 40 if isinstance(whole, MonteCarlo) else 8 * (2 + 2)
    assert part.size == expected


def test_an_error_that_dies_out_gives_its_rmse_at_every_horizon():
    t = np.arange(1.0, 31.0)
    squares = 7.0 * (1 - np.exp(-3 * t)) / fits.SAMPLE  # the sum over samples: done before the shortest horizon
    values = np.sqrt(squares / (t / fits.SAMPLE + 1))[np.newaxis, :, np.newaxis] * np.ones(2)
    times, rmse = fits.horizons(sampled(t, values))
    exact = np.sqrt(7.0 / (times + fits.SAMPLE))
    # what is left of the exponential at 5 s is 3e-7
    np.testing.assert_allclose(rmse[0, :, 0], exact, rtol=1e-6)


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


def sampled(t, values):
    """Runs with these values (N, T, 2) of RMSE."""
    columns = (("RMSE (43)", 0, "rad"), ("RMSE (43)", 1, "rad"))
    runs = len(values)
    lost = np.where(np.isnan(values).any(axis=(1, 2)), 1.0, np.nan)
    none = np.empty(0, dtype=int)
    return Sample(
        "x", (), columns, t, 1e-3, 0, "", np.empty((runs, 0)), values, none, np.empty((0, len(t), 2)), np.empty(0), lost
    )


def test_the_margin_is_below_one_half_where_the_proposed_law_is_first():
    ours = np.array([[1.0, 1.0], [np.nan, 1.0], [1.0, 3.0]])
    rivals = {law: np.full((3, 2), 2.0) for law in LAWS[1:]}
    rivals["PID"] = np.full((3, 2), np.nan)
    held = draws.Drawn({"AOSMC-RGS": ours} | rivals)
    assert np.allclose(held.margin, [[1 / 3, 1 / 3], [1, 1 / 3], [1 / 3, 3 / 5]], rtol=1e-15)
    assert held.ordered(1, ("AOSMC-RGS", "SMC")).tolist() == [True, False, True]


def test_the_verdict_on_who_is_first_turns_with_the_draws_of_any_prior():
    seldom, most = made(np.arange(400) < 40), priors.share(np.arange(400) < 60)
    for part, kind in ((0.1, "found"), (0.9, "depends"), (0.5, "open")):
        ranked = {"one": {("FS", 1): seldom}, "other": {("FS", 1): made(np.arange(400) < 400 * part)}}
        assert priors.first_verdict(ranked, most, "").kind == kind


def test_a_rival_that_is_better_under_one_prior_alone_is_said_to_turn_with_it():
    worse, better = made(np.arange(400) < 40), made(np.arange(400) < 360)
    alike = {"one": {("FS", 1): worse}, "other": {("FS", 1): worse}}
    everyone = "ASMC, Fuzzy-ASMC, RBF-ASMC, PID, SMC"
    assert priors.pairs_verdict(alike, "").kind == "found"
    assert f"under each prior and in each column: {everyone}" in priors.pairs_verdict(alike, "").evidence
    apart = priors.pairs_verdict({"one": {("FS", 1): worse}, "other": {("FS", 1): better}}, "")
    assert apart.kind == "depends"
    assert "than ASMC in 10 % to 90 %" in apart.statement
    assert f"and worse in another: {everyone}" in apart.evidence
    assert "ASMC 10 % (6 to 15) to 90 % (85 to 94)" in apart.evidence


def test_one_of_sixteen_shares_beyond_one_half_by_its_own_interval_alone_leaves_the_majority_open():
    wins = np.arange(512) < 0.55 * 512
    assert priors.share(wins).low > 0.5
    others = [made(np.arange(512) < 26).first] * 15
    assert priors.majority([*others, made(wins).first]) == "open"
    assert priors.majority([*others, made(np.arange(512) < 0.6 * 512).first]) == priors.TURNS


def test_draws_whose_error_stands_still_have_none_after_the_shortest_horizon():
    t = np.arange(1.0, 31.0)
    total = np.stack([np.full(30, 7.0), 7.0 + 0.04 * (t - 5), np.full(30, np.nan)])  # integrals of squares
    values = np.sqrt(total / (t + fits.SAMPLE))[..., np.newaxis] * np.ones(2)
    assert pages.late(sampled(t, values[::2])) == pytest.approx(0, abs=1e-6)  # the root of rounding
    assert pages.late(sampled(t, values)) == pytest.approx(0.2, rel=1e-9)  # rounding


def test_the_majority_of_the_draws_is_told_only_where_all_intervals_agree():
    low, high, half = (0.1, 0.05, 0.2), (0.8, 0.7, 0.9), (0.5, 0.4, 0.6)
    assert priors.majority([low, low]) == "no, under each"
    assert priors.majority([high, high]) == "yes, under each"
    assert priors.majority([low, high]) == priors.TURNS
    assert priors.majority([low, half]) == priors.majority([high, half]) == "open"


def made(wins):
    """A ranking in which the proposed law is first in these draws, and last in the others."""
    values = {law: np.full(len(wins), 2.0 + i) for i, law in enumerate(LAWS)}
    values["AOSMC-RGS"] = np.where(wins, 1.0, 9.0)
    return ranking.counted(ranking.paired(values, metric="RMSE", unit="rad"), LAWS, wins)


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
    assert seconds.tolist() == [draws.SHORTEST, draws.LONGEST]


def test_the_prior_of_the_card_is_that_of_the_factors():
    for law in LAWS:
        for scenario in loops.SCENARIOS:
            assert draws.OF_CARD.factors(law, scenario) == draws.factors_of(law, scenario)


def test_priors_with_the_same_scales_of_a_law_share_its_runs():
    names = {draws.named("random", law, "FS", prior) for law in LAWS for prior in draws.PRIORS.values()}
    assert len(names) == 2 * len(LAWS)
    assert len({draws.named("random", "AOSMC-RGS", "SS", prior) for prior in draws.PRIORS.values()}) == 4


def test_the_one_experiment_is_the_same_for_all_laws_and_leaves_open_only_what_is_their_own():
    for law in LAWS:
        loop = shared.shared_loop(law)
        square = loop.reference.square
        assert (tuple(square.amplitude), square.frequency) == (shared.AMPLITUDES, shared.FREQUENCY)
        names = {factor.name for factor in shared.own(law)}
        assert not names & {"a1", "a2", "f", "rivals' measurements"}
        if law not in (loops.PROPOSED, loops.PID):
            assert loop.observer.inside == 1.0


def test_the_verdict_on_one_experiment_holds_only_if_all_rows_are_met():
    near, numbers = dict.fromkeys(LAWS, 0.004), dict.fromkeys(LAWS, "")
    assert shared.shared_verdict(shared.Shared(9.0, near, numbers)).kind == "found"
    verdict = shared.shared_verdict(shared.Shared(9.0, near | {"PID": 0.02}, numbers))
    assert verdict.kind == "open"
    assert "5 of 6 rows" in verdict.statement
    assert "+0.5 % and -0.3 %" in verdict.evidence  # by how much the amplitudes were moved by hand


def test_casadi_takes_the_reading_that_is_named():
    parts = [ca.SX(v) for v in (1.0, 2.0, 3.0)]
    from studies.a6_unstated_choices.blocks import chosen

    reading = ca.SX.sym("reading")
    pick = ca.Function("pick", [reading], [chosen(reading, *parts)])
    assert [float(pick(place)) for place in (0, 1, 2)] == [1.0, 2.0, 3.0]


def fitted(law, target, miss, horizon=20.0):
    """A fit that misses its cells by so much."""
    values = {scenario: np.full(2, 0.3) for scenario in fits.TARGETS[target]}
    numbers = {factor.name: factor.distribution.high for factor in draws.factors_of(law, "SS")}
    return fits.Fit(law, target, numbers, dict.fromkeys(values, horizon), values, values, miss, miss / 2)


def findings(misses, spread):
    """What was found for each law, with the misses of its targets and the values of its factors that fit."""
    laws = {}
    for law in LAWS:
        width = len(draws.factors_of(law, "SS"))
        u = np.array([np.full(width, 0.05), np.full(width, 0.05 + spread)])
        factors = draws.factors_of(law, "SS")
        close = np.stack([f.distribution.quantile(column) for f, column in zip(factors, u.T, strict=True)], axis=1)
        every = {target: fitted(law, target, misses) for target in fits.TARGETS}
        sought = dict.fromkeys(fits.TARGETS, np.array([0.002, 0.005, 0.3]))
        laws[law] = found.Found(law, every, {}, sought, dict.fromkeys(fits.TARGETS, close))
    return laws


def test_the_verdicts_on_the_fits_turn_with_their_misses_and_their_spread():
    good, bad = pages.verdicts(findings(0.002, 0.9)), pages.verdicts(findings(0.2, 0.001))
    assert [verdict.kind for verdict in good] == ["found"] * 4
    assert [verdict.kind for verdict in bad] == ["open", "open", "open", "found"]
    # two of the four shapes of (33) are no more than half of them
    assert [verdict.statement.split(" of ")[0] for verdict in good[1:]] == ["24", "For 6", "31"]
    assert bad[3].statement.startswith("0 of the 32 ")
    assert "a choice of it misses by 10 %. At the step of the search 2 of its choices come" in bad[2].evidence


def test_what_is_searched_over_orders_of_magnitude_is_spread_over_its_logarithm():
    factor = next(f for f in draws.factors_of("AOSMC-RGS", "FS") if f.name == "Q")
    # 0.01 to 1000 are five decades, of which 1 to 100 are two
    assert abs(found.span_of(factor, np.array([1.0, 100.0])) - 0.4) < 1e-3


def test_a_rival_run_by_a_computer_with_a_relay_has_the_rmse_of_its_boundary_layer():
    metrics, gentle = (draws.RMSE,), np.array([[0.2, 0.2, 0.1], [0.6, 0.4, 0.1]])
    factors = draws.factors_of("SMC", "FS")

    def rmse(loop, h):
        sweep = Sweep("x", Run(loop, metrics, 4.0, h=h), factors, Listed(gentle), halved=None)
        one = compile_sweep(sweep)
        return one.sample([one.chunk(0, 2)]).values

    relay = rmse(loops.searched("SMC", "FS"), loops.PERIOD)
    layer = rmse(loops.loop("SMC", "FS"), 2e-4)
    # a period of 2 ms holds every torque 1 ms too long, beside the 170 ms of the surface
    np.testing.assert_allclose(relay, layer, rtol=0.01)
