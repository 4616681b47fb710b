"""The laws of a9 as sampled-data loops: their computers, their searches, and limits by other roads."""

from dataclasses import replace

import numpy as np
import pytest

from studies.a9_sampling.evidence import PERIODS, curve
from studies.a9_sampling.loops import NOISY, Audit, Computer, digital, first_torque, sweep
from studies.paper import quiet_periods
from studies.paper.card import LAWS
from studies.paper.laws import mass_matrices as masses
from studies.paper.period_rules import gains
from studies.paper.quiet_periods import (
    ACTING_TORQUE,
    CLOSE,
    COMMANDED_TORQUE,
    GRID,
    HORIZON,
    MOMENTUM,
    ON_REFERENCE,
    PARTS,
    QUIET,
    TV,
    QuietSearch,
    bracket_words,
    computer_loop,
    ends,
    in_ms,
    metrics,
    middle,
    quiet_period,
)
from workbench.core import rk4
from workbench.engine import simulate
from workbench.engine.metrics import measure
from workbench.study.compiled_sweep import compile_sweep
from workbench.study.evidence import find_largest


def audit(*one):
    """The audit of a law in a scenario by a computer, from the runs of its sweep."""
    made = compile_sweep(sweep(*one))
    return Audit.of(made.sample([made.chunk(*ends) for ends in made.chunks]))


def exact(law, scenario, computer):
    """The total variation (2,) with exact readings, at the step of a search."""
    h = computer.period / computer.substeps
    asked, equation = metrics(computer.period), digital(law, scenario, computer).ode()
    found = measure(equation, asked, until=HORIZON[scenario], every=HORIZON[scenario], h=h)
    return np.array([found.score(TV, joint).pair[0] for joint in (0, 1)])


def longest(quiet):
    """The search of a9, for a criterion of its own."""
    return find_largest(quiet, [GRID / part for part in PARTS], ratio=CLOSE, between=middle)


@pytest.mark.parametrize("edge", [2.7e-5, 3.1e-4, 7e-4, 4e-3, 8.2e-3, 9.6e-3])
def test_the_search_brackets_the_longest_safe_period_between_neighbours_of_the_grid_too(edge):
    found = longest(lambda period: period <= edge)
    assert found.largest <= edge < found.next
    assert found.next / found.largest <= CLOSE


def test_a_search_that_finds_no_end_says_so():
    everywhere, nowhere = longest(lambda period: True), longest(lambda period: False)
    assert in_ms((everywhere.largest, everywhere.next)) == "10 or more"
    assert in_ms((nowhere.largest, nowhere.next)) == "below 0.025"
    assert bracket_words((everywhere.largest, everywhere.next)) == "10, the longest tried"
    assert bracket_words((nowhere.largest, nowhere.next)) == "not 0.025"
    assert bracket_words((5e-3, 1e-2)) == "5, not 10"


@pytest.fixture(scope="module")
def smc():
    """The longest quiet period of SMC, a period late, in the second scenario, which is the shorter one.

    Looked for from 0.2 to 0.5 ms on, which narrows no less than from the ends of the whole search.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(quiet_periods, "PARTS", (50, 20))
        return quiet_period(QuietSearch("SMC", "SS", delay=True))


@pytest.mark.heavy
def test_the_longest_quiet_period_of_smc_is_between_a_quiet_and_a_loud_one(smc):
    low, high = ends(smc)
    for period, quiet in ((low, True), (high, False)):
        variation = exact("SMC", "SS", Computer(period, True))
        assert bool((variation <= QUIET * smc.TV).all()) is quiet
    assert smc.largest_setting.sure


@pytest.mark.heavy
def test_the_total_variation_of_a_search_is_that_of_the_continuous_torque(smc):
    run = simulate(rk4(QuietSearch("SMC", "SS").loop.ode(), 2.5e-4), until=HORIZON["SS"], every=1e-3)
    # a change each millisecond, summed by NumPy; the step of the search is the same
    own = np.abs(np.diff(run["tau"][0], axis=0)).sum(axis=0) / HORIZON["SS"]
    np.testing.assert_allclose(smc.TV, own, rtol=2e-2)


def test_on_the_reference_arm_and_observer_start_where_and_as_fast_as_is_wanted():
    loop = QuietSearch(LAWS[0], "FS", ON_REFERENCE).loop
    speed = (2.0, 1.5)  # of (sin 2t, 0.5 sin 3t) at t = 0
    for block, q, qd in ((loop.plant, "q", "qd"), (loop.observer.state, "q_hat", "qd_hat")):
        np.testing.assert_allclose(getattr(block, q), 0.0, atol=1e-15)
        np.testing.assert_allclose(getattr(block, qd), speed, rtol=1e-15)


def test_on_the_reference_an_observer_of_the_momentum_takes_no_motion_for_a_disturbance():
    loop = QuietSearch(LAWS[0], "FS", ON_REFERENCE, True, MOMENTUM).loop
    # M(0) = [[5, 2], [2, 1]] at a speed of (2, 1.5), by hand
    np.testing.assert_allclose(loop.observer.disturbance.p_hat, (13.0, 5.5), rtol=1e-15)
    ode = loop.ode()
    seen = ode.outputs_at(0.0, ode.states.default)
    np.testing.assert_allclose(seen["d_error"], seen["d"], atol=1e-12)  # D_hat = 0
    assert np.abs(seen["tau"]).max() < 1e-12  # at q = 0 the reference needs none, and D_hat adds none


def test_a_limited_torque_stays_within_its_limit():
    limited = computer_loop(QuietSearch("SMC", delay=True, limit=10.0), 1e-3).ode()
    run = simulate(limited.step(1), until=0.5)
    assert np.abs(run["tau_applied"]).max() == 10.0  # from the paper's start SMC asks for more


def moving(search, period, until):
    """The states of a computed loop at the instants of its computer, by their names, and the commands."""
    equation = computer_loop(search, period).ode()
    return simulate(equation.step(1), until=until)


def test_an_observer_that_counts_on_the_command_has_the_torque_of_now_and_the_plant_that_of_before():
    told = QuietSearch(LAWS[0], delay=True, counts_on=COMMANDED_TORQUE)
    run, first = moving(told, 1e-4, 2e-3), first_torque(LAWS[0], "FS")["tau"]
    expected = np.vstack([first, run["tau"][0, :-1]])
    np.testing.assert_allclose(run["tau_applied"][0], expected, rtol=1e-14)  # held, and shown by another graph
    late = moving(replace(told, counts_on=ACTING_TORQUE), 1e-4, 2e-3)
    # both plants have been moved by the same two torques; then the observers differ
    np.testing.assert_allclose(run["q"][0, :3], late["q"][0, :3], rtol=1e-14)
    assert np.abs(run["e_hat"][0, -1] - late["e_hat"][0, -1]).max() > 1e-12


def test_smc_moves_the_same_with_a_late_computer_and_a_late_drive():
    search = QuietSearch("SMC", delay=True)  # its observer counts on no torque
    one, other = (moving(replace(search, counts_on=told), 5e-4, 0.2) for told in (ACTING_TORQUE, COMMANDED_TORQUE))
    np.testing.assert_allclose(one["q"], other["q"], rtol=0, atol=1e-12)


@pytest.mark.heavy
def test_the_rule_is_the_limit_of_the_sampled_error_and_half_of_it_a_period_late(smc):
    M, K, phi = np.array([[5.0, 2.0], [2.0, 1.0]]), 5 * np.eye(2), 0.01  # the arm is stretched
    np.testing.assert_allclose(masses(np.zeros((3, 2))), np.tile(M, (3, 1, 1)), rtol=1e-14)
    np.testing.assert_array_equal(gains("SMC", np.full((1, 2), 5.0))[0], K)
    rule = 2 * phi / np.linalg.eigvals(np.linalg.solve(M, K)).max()
    for share, stable in ((0.99, True), (1.01, False)):
        A = np.linalg.solve(M, K) / phi
        now, late = np.eye(2) - share * rule * A, np.block([[np.eye(2), -share * rule / 2 * A], [np.eye(2), 0 * A]])
        for step in (now, late):
            assert (np.abs(np.linalg.eigvals(step)).max() < 1) is np.bool_(stable)
    assert smc.rule == smc.rules.rule / 2
    assert replace(smc, search=replace(smc.search, delay=False)).rule == smc.rules.rule
    assert replace(smc, search=replace(smc.search, counts_on=COMMANDED_TORQUE)).rule == smc.rules.rule / 2
    told = QuietSearch(LAWS[0], delay=True, counts_on=COMMANDED_TORQUE)
    assert replace(smc, search=told).rule == smc.rules.rule
    assert replace(smc, search=replace(told, observer=MOMENTUM)).rule == smc.rules.rule / 2
    assert smc.rules.bound <= smc.rules.rule


@pytest.mark.heavy
def test_the_rule_of_smc_lies_between_the_ends_of_its_search(smc):
    low, high = ends(smc)
    assert low < smc.rule < high


def test_smc_is_quiet_below_its_limit_and_chatters_above():
    below, above = (exact("SMC", "FS", Computer(period)) for period in (5e-4, 1e-3))
    assert below.max() < 20  # N m/s: the reference alone asks for 17.5
    assert (above > 100 * below).all()


def test_a_late_computer_starts_with_the_torque_of_the_first_instant():
    late = digital("SMC", "FS", Computer(1e-3, True)).ode()
    np.testing.assert_array_equal(late.states["hold.next"].default, first_torque("SMC", "FS")["tau"])


@pytest.mark.heavy
def test_the_first_run_of_an_audit_has_exact_readings_and_the_others_have_not():
    found, alone = audit("SMC", "FS", Computer(5e-4)), exact("SMC", "FS", Computer(5e-4))
    # the audit's step is half of the search's; noise is a hundred times the variation
    np.testing.assert_allclose(found.values[TV], alone, rtol=1e-3)
    assert found.noisy[TV].shape == (NOISY, 2)
    assert (found.noisy[TV] > 100 * found.values[TV]).all()
    assert len(set(found.noisy[TV][:, 0])) == NOISY


@pytest.mark.heavy
def test_chattering_of_a_computer_does_not_know_the_step_of_the_simulation():
    assert np.ptp(curve(("SMC", "sign", True)).TV, axis=0).max() < 1.0  # of some 5000 N m/s


@pytest.mark.heavy
def test_at_10_ms_euler_loses_aosmc_rgs_and_a_cayley_step_of_34_keeps_it():
    lost_runs = {way: audit("AOSMC-RGS", "FS", Computer(1e-2, stepping=way)).is_lost for way in ("euler", "cayley34")}
    assert lost_runs["euler"].all()
    assert not lost_runs["cayley34"].any()


def test_every_period_divides_the_sample_time_of_the_printed_error():
    parts = 1e-2 / np.array(PERIODS)
    np.testing.assert_allclose(parts, np.round(parts), rtol=1e-12)
