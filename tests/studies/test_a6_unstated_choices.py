"""The study of what the paper does not state: its readings as numbers, its fits and its findings."""

import casadi as ca
import numpy as np
import pytest

from studies.a6_unstated_choices import draws, experiments, findings, fits, loops, ranking, rows, scope
from studies.a6_unstated_choices.blocks import pick_part
from studies.paper.card import CARD, INERTIA, LAWS
from studies.paper.laws import ARM, PRINTED_ARM, REFERENCES, plant, rival
from studies.paper.unstated_choices import omitted_choices
from tests.support.drawn_errors import again, common_searches, everywhere, fitted, row, sampled
from workbench.arms.laws import AosmcRgs, ArmPID
from workbench.arms.laws.aosmc_rgs import SHAPES
from workbench.arms.observers import ArmFullState, Luenberger, OracleFilter, PrintedFilter, StateAndDisturbanceObserver
from workbench.blocks.loop import ClosedLoop
from workbench.study.compiled_sweep import compile_sweep
from workbench.study.run_and_sweep import Run, Sweep
from workbench.study.uncertainty import ListedPoints


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
    return loops.loop(loops.PROPOSED_LAW, "SS")


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
    genuine = ClosedLoop(plant("SS"), StateAndDisturbanceObserver(seen, filter_), law, REFERENCES["SS"])
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
    genuine = ClosedLoop(plant("FS"), ArmFullState(2), ArmPID(*gains, model=ARM), REFERENCES["FS"])
    got = rates(loops.loop(loops.PID, "FS"), own | wide, {"controller.lifted": 1})
    np.testing.assert_allclose(got["plant.qd"], rates(genuine, own)["plant.qd"], rtol=1e-12)


def test_readings_are_equally_likely_and_casadi_takes_the_one_that_is_named():
    spread = loops.Reading(("a", "b", "c", "d"))
    places = spread.quantile((np.arange(1000) + 0.5) / 1000)
    assert np.bincount(places.astype(int)).tolist() == [250] * 4
    assert spread.quantile(np.array([0.0, 1.0])).tolist() == [0.0, 3.0]
    reading = ca.SX.sym("reading")
    pick = ca.Function("pick", [reading], [pick_part(reading, *map(ca.SX, (1.0, 2.0, 3.0)))])
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


@pytest.mark.parametrize("name", draws.PRIORS)
def test_a_prior_draws_numbers_evenly_on_its_scales(name):
    prior = draws.PRIORS[name]
    middle = {"linear": lambda low, high: (low + high) / 2, "log": lambda low, high: (low * high) ** 0.5}
    for law in LAWS:
        for factor in prior.factors(law, "SS"):
            spread = factor.distribution
            if isinstance(spread, loops.Reading) or spread.low <= 0:
                continue
            scale = prior.ours if law == loops.PROPOSED_LAW and factor.name not in ("a1", "a2", "f") else prior.rest
            expected = middle[scale](spread.low, spread.high)
            assert spread.quantile(np.array([0.5]))[0] == pytest.approx(expected, rel=1e-12)  # rounding
    seconds = prior.horizons(np.array([1e-9, 1 - 1e-9]))
    assert seconds.tolist() == [loops.SHORTEST, loops.LONGEST]


def test_the_prior_of_the_card_is_that_of_the_factors_and_priors_of_the_same_scales_share_runs():
    for law in LAWS:
        for scenario in loops.SCENARIOS:
            assert draws.OF_CARD.factors(law, scenario) == loops.factors_of(law, scenario)
    names = {draws.sweep_name("random", law, "FS", prior) for law in LAWS for prior in draws.PRIORS.values()}
    assert len(names) == 2 * len(LAWS)
    assert len({draws.sweep_name("random", "AOSMC-RGS", "SS", prior) for prior in draws.PRIORS.values()}) == 4


def test_two_repairs_are_those_of_the_equations_3_and_28():
    one = row(rows.TWO, "outer", 0.001)
    assert one.repairs == ("velocity in (28)", "C of (3)")
    names = {factor.name: factor.distribution for factor in loops.FACTORS[loops.PROPOSED_LAW]}
    for fixed in rows.FIXED_READINGS.values():
        assert all(value in names[name].names for name, value in fixed.items())
    readings = {name for name, spread in names.items() if isinstance(spread, loops.Reading)}
    assert set(rows.PRINTED_READINGS) == readings - {"shape of (33)"}


def test_a_point_of_a_search_has_the_same_numbers_where_every_reading_is_free():
    rng = np.random.default_rng(4)
    for case in rows.CASES:
        u = rng.random(len(rows.factors(*case)))
        pairs = list(zip(rows.factors(*case), loops.factors_of(loops.PROPOSED_LAW, "FS"), u, strict=True))
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
    missing = {choice.name for choice in omitted_choices(loops.NAMES)} - {"torque limit"}  # which draws of its own vary
    assert missing == {choice.name for choice in scope.OMITTED_CHOICES}
    assert all(name in finding.limitations for finding in made_of for name in missing)
    assert all(
        f"{choice.name}: {choice.assumption}" in finding.assumptions
        for finding in made_of
        for choice in scope.OMITTED_CHOICES
    )


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
    np.testing.assert_array_equal(draws.LIMITED_DESIGN.points(), draws.RANDOM.points()[: draws.LIMITED_DESIGN.runs])


@pytest.mark.heavy
def test_a_rival_run_by_a_computer_with_a_relay_has_the_rmse_of_its_boundary_layer():
    gentle, factors, layer = np.array([[0.2, 0.2, 0.1], [0.6, 0.4, 0.1]]), loops.FACTORS["SMC"], loops.loop("SMC", "FS")

    def rmse(loop, h):
        one = compile_sweep(
            Sweep("x", Run(loop, (loops.RMSE,), 4.0, h=h), factors, ListedPoints(gentle), half_step_every=None)
        )
        return one.sample([one.chunk(0, 2)]).values

    # a period of 2 ms holds every torque 1 ms too long, beside the 170 ms of the surface
    np.testing.assert_allclose(rmse(loops.with_relay("SMC", layer), loops.PERIOD), rmse(layer, 2e-4), rtol=0.01)
