"""The findings of a9 on laws as sampled-data loops: limits by other roads, and answers that change with the runs."""

from dataclasses import replace

import numpy as np
import pytest

from studies.a9_sampling import findings, pages, period_findings, trust
from studies.a9_sampling.evidence import PERIODS, Curve, Evidence, curve, plan, printed
from studies.a9_sampling.loops import NOISY, Audit, Computer, digital, first_torque, sweep
from studies.paper.card import LAWS, PUBLISHED
from studies.paper.laws import mass_matrices as masses
from studies.paper.linearization import SEVEN
from studies.paper.period_rules import GAINLESS, PeriodRules, gains
from studies.paper.quiet_periods import (
    ACTING,
    CLOSE,
    COMMANDED,
    GRID,
    HORIZON,
    MOMENTUM,
    ON_REFERENCE,
    PARTS,
    QUIET,
    RMSE,
    SCENARIOS,
    TV,
    QuietPeriod,
    QuietSearch,
    bracket_words,
    computed,
    ends,
    in_ms,
    metrics,
    middle,
    paper_searches,
    quiet_period,
)
from workbench.core import rk4
from workbench.engine import simulate
from workbench.engine.metrics import measure
from workbench.study.compiled import compile_sweep
from workbench.study.evidence import LargestSetting, LoopTrial, Threshold, find_largest


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
    """The longest quiet period of SMC, a period late, in the second scenario, which is the shorter one."""
    return quiet_period(QuietSearch("SMC", "SS", delay=True))


@pytest.mark.heavy
def test_the_longest_quiet_period_of_smc_is_between_a_quiet_and_a_loud_one(smc):
    low, high = ends(smc)
    for period, quiet in ((low, True), (high, False)):
        variation = exact("SMC", "SS", Computer(period, True))
        assert bool((variation <= QUIET * smc.TV).all()) is quiet
    assert smc.found.sure


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
    limited = computed(QuietSearch("SMC", delay=True, limit=10.0), 1e-3).ode()
    run = simulate(limited.step(1), until=0.5)
    assert np.abs(run["tau_applied"]).max() == 10.0  # from the paper's start SMC asks for more


def moving(search, period, until):
    """The states of a computed loop at the instants of its computer, by their names, and the commands."""
    equation = computed(search, period).ode()
    return simulate(equation.step(1), until=until)


def test_an_observer_that_counts_on_the_command_has_the_torque_of_now_and_the_plant_that_of_before():
    told = QuietSearch(LAWS[0], delay=True, counts_on=COMMANDED)
    run, first = moving(told, 1e-4, 2e-3), first_torque(LAWS[0], "FS")["tau"]
    expected = np.vstack([first, run["tau"][0, :-1]])
    np.testing.assert_allclose(run["tau_applied"][0], expected, rtol=1e-14)  # held, and shown by another graph
    late = moving(replace(told, counts_on=ACTING), 1e-4, 2e-3)
    # both plants have been moved by the same two torques; then the observers differ
    np.testing.assert_allclose(run["q"][0, :3], late["q"][0, :3], rtol=1e-14)
    assert np.abs(run["e_hat"][0, -1] - late["e_hat"][0, -1]).max() > 1e-12


def test_smc_moves_the_same_with_a_late_computer_and_a_late_drive():
    search = QuietSearch("SMC", delay=True)  # its observer counts on no torque
    one, other = (moving(replace(search, counts_on=told), 5e-4, 0.2) for told in (ACTING, COMMANDED))
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
    assert replace(smc, search=replace(smc.search, counts_on=COMMANDED)).rule == smc.rules.rule / 2
    told = QuietSearch(LAWS[0], delay=True, counts_on=COMMANDED)
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
    lost_runs = {way: audit("AOSMC-RGS", "FS", Computer(1e-2, stepping=way)).lost for way in ("euler", "cayley34")}
    assert lost_runs["euler"].all()
    assert not lost_runs["cayley34"].any()


def test_every_period_divides_the_sample_time_of_the_printed_error():
    parts = 1e-2 / np.array(PERIODS)
    np.testing.assert_allclose(parts, np.round(parts), rtol=1e-12)


def flat(rmse, tv, errors=1e-3):
    """Figures that are the same for each joint and run, with errors relative to them, a thousandth if not given."""
    values = {name: np.full(2, float(size)) for name, size in {RMSE: rmse, TV: tv}.items()}
    noisy = {name: np.tile(array, (NOISY, 1)) for name, array in values.items()}
    return Audit(values, {name: errors * array for name, array in values.items()}, noisy)


def order_of(law):
    return 1.0 + 0.1 * SEVEN.index(law)


def quiet(law):
    return flat(order_of(law), 10 * order_of(law))


def turned(law):
    return flat(3 - order_of(law), 30 - 10 * order_of(law))


def lost(law):
    return flat(np.nan, np.nan)


def always(law, scenario, computer):
    return True


def found_at(low, high):
    """A search that ends between two periods in s, quiet at the first and not at the second."""
    trials = tuple((LoopTrial({TV: np.full(2, share)}, {TV: np.zeros(2)}),) for share in (0.5, 50.0))
    return LargestSetting(Threshold((low, high), (True, False)), trials)


def quiet_of(search, low=1e-3, high=1.1e-3, rule=1e-3):
    """The answer of a search: all laws are quiet up to 1 ms, and half of that a period late, if not given."""
    size = 0.5 if search.delay else 1.0
    rules = None if search.law in GAINLESS else PeriodRules(5.0, rule, rule / 2)
    return QuietPeriod(search, found_at(size * low, size * high), np.ones(2), rules)


def evidence(changed=quiet, matches=always, **ends):
    """Laws that no computer touches, AOSMC-RGS first, the others in their order, but for what is changed."""
    still = {(law, scenario, None): quiet(law) for law in SEVEN for scenario in SCENARIOS}
    audits = {key: (changed if matches(*key) else quiet)(key[0]) for key in plan()}
    return Evidence(still | audits, tuple(quiet_of(search, **ends) for search in paper_searches()))


def words(finding):
    """The statement of a finding, its formulas left out."""
    parts = (finding.statement,) if isinstance(finding.statement, str) else finding.statement
    return "".join(part for part in parts if isinstance(part, str))


def lost_by(*ways):
    """Evidence in which AOSMC-RGS is lost at 10 ms in the first scenario, where its memories step in these ways."""
    where = ("AOSMC-RGS", "FS", 1e-2)
    return evidence(lost, lambda law, at, computer: (law, at, computer.period) == where and computer.stepping in ways)


@pytest.mark.parametrize(
    ("name", "answer"),
    [
        ("chattering", "AOSMC-RGS, ASMC, Fuzzy-ASMC, RBF-ASMC, PID, SMC and super-twisting"),
        ("rule_of_thumb", "too long for none"),
        ("lost_runs", "no run is lost"),
        ("longest_period", "quiet at 0.25 ms"),
    ],
)
def test_every_finding_is_calm_of_laws_that_no_computer_touches(name, answer):
    assert getattr(findings, name)(evidence()).answer == answer


@pytest.mark.parametrize(
    ("name", "changed", "matches", "answer"),
    [
        ("chattering", lambda law: flat(1.0, 1e3), lambda law, *_: law != "PID", "PID"),
        ("published_order", turned, always, "0"),
    ],
)
def test_a_finding_changes_with_the_runs(name, changed, matches, answer):
    assert getattr(findings, name)(evidence(changed, matches)).answer == answer


@pytest.mark.parametrize(
    ("low", "high", "inside", "long"),
    [(1.2e-3, 1.3e-3, 0, False), (0.97e-3, 1.04e-3, 10, False), (0.7e-3, 0.8e-3, 0, True)],
)
def test_a_rule_is_too_long_where_both_ends_of_its_search_are_below_it(low, high, inside, long):
    found = findings.rule_of_thumb(evidence(low=low, high=high))
    assert f"in {inside} of 10 loops" in words(found)
    assert ("AOSMC-RGS in FS" in found.answer) is long
    assert found.answer.endswith("none") is not long
    answers = {one.words: one.answer for one in found.variations}
    assert answers["the bound in place of the eigenvalue"] == "too long for none"  # it is half of the rule here


def test_the_rule_is_compared_within_each_scenario():
    made = evidence()
    short = quiet_of(QuietSearch("SMC", "SS"), 1e-4, 1.1e-4, 5e-5)
    quiet = tuple(short if one.search == short.search else one for one in made.quiet)
    ratios = period_findings.ratios_of(replace(made, quiet=quiet).searched(start="paper", delay=False))
    assert ratios["SMC", "FS"] == pytest.approx((1.0, 1.1))
    assert ratios["SMC", "SS"] == pytest.approx((2.0, 2.2))
    assert set(ratios) == {(law, at) for law in SEVEN if law not in GAINLESS for at in SCENARIOS}


@pytest.mark.parametrize(
    ("ways", "kind", "answer"),
    [
        (("euler",), "found", "the integrator"),
        (("euler", "cayley34"), "depends", "the integrator"),
        (("euler", "fine"), "open", "unsettled"),
        (("euler", "cayley34", "cayley", "fine"), "found", "the law"),
        ((), "open", "no run is lost"),
    ],
)
def test_a_loss_is_the_integrators_where_finer_steps_keep_the_run(ways, kind, answer):
    found = findings.lost_runs(lost_by(*ways))
    assert (found.answer, found.kind) == (answer, kind)


def test_a_run_counts_as_lost_by_its_error_too():
    wild = evidence(
        lambda law: flat(3 * order_of(law), 10.0),
        lambda law, at, computer: (law, at, computer.period, computer.stepping) == ("AOSMC-RGS", "FS", 1e-2, "euler"),
    )
    found = findings.lost_runs(wild)
    assert found.answer == "no run is lost"
    answers = {one.words: one.answer for one in found.variations}
    assert answers["lost: more than 2 times the RMSE of continuous time"] == "the integrator"
    assert answers["lost: more than 5 times the RMSE of continuous time"] == "no run is lost"


def test_the_runs_lost_a_period_late_are_blamed_as_the_others():
    where = ("AOSMC-RGS", "FS", Computer(5e-3, True, "euler"))
    found = findings.lost_runs(evidence(lost, lambda *one: one == where))
    assert found.answer == "no run is lost"  # without a delay
    (late,) = (one for one in found.variations if one.words == "torque a period late")
    assert (late.answer, late.detail) == ("the integrator", "of 8 runs 8 by the integrator, 0 by the law")


def test_the_lost_runs_are_counted_and_named():
    euler = lost_by("euler")
    found = findings.lost_runs(euler)
    assert "With explicit Euler 8 of 784 runs diverge, all of AOSMC-RGS" in words(found)
    assert "Of these 8 stay finite if (34) alone takes a Cayley step, and 8 with 16 Runge-Kutta steps" in words(found)
    assert "16 Runge-Kutta steps); the run by explicit Euler diverges." in found.evidence
    rows = {row[0]: row[1:] for row in pages.lost_table(euler).rows}
    assert rows["AOSMC-RGS, Euler"] == (0, 0, 0, 0, 0, 0, 8)
    assert rows["AOSMC-RGS, Cayley"] == (0,) * 7
    smc = evidence(lost, lambda law, scenario, computer: law == "SMC" and computer.period == 1e-2)
    assert "With explicit Euler 16 of 784 runs diverge, 0 of them of AOSMC-RGS" in words(findings.lost_runs(smc))


def test_the_runs_that_the_late_searches_lose_are_named():
    assert "these runs diverge: none." in findings.lost_runs(evidence()).evidence
    made = evidence()
    trials = tuple((LoopTrial({TV: np.full(2, share)}, {TV: np.zeros(2)}),) for share in (0.5, np.nan))
    lost = LargestSetting(Threshold((1e-3, 5e-3), (True, False)), trials)
    searched = (replace(one, found=lost) if one.search == period_findings.BASE else one for one in made.quiet)
    found = findings.lost_runs(replace(made, quiet=tuple(searched)))
    assert "these runs diverge: AOSMC-RGS in FS at 5 ms." in found.evidence


def test_the_longest_period_is_answered_for_every_start_scenario_and_delay():
    found = period_findings.longest_period(evidence())
    searches = [one for one in paper_searches() if one.law == "AOSMC-RGS"]
    assert len(found.variations) == len(searches) - 1 + 3  # but for the answer itself, with three other limits
    assert found.kind == "found"
    assert period_findings.longest_period(evidence(low=4e-4, high=5e-4)).kind == "depends"  # 0.2 ms a period late


def test_another_limit_of_the_total_variation_is_read_from_the_same_search():
    found = quiet_of(QuietSearch("SMC"))
    assert ends(found) == (1e-3, 1.1e-3)
    assert ends(found, 0.9) == (0.0, 1e-3)  # at the first period TV is as large as in continuous time
    assert ends(found, 200.0) == (1.1e-3, np.inf)


def test_the_published_figures_put_in_for_ours_turn_no_printed_pair():
    found = printed(lambda law, scenario, joint: (PUBLISHED[scenario, joint + 1].values[law], 0.0))
    assert len(found["below"]) + len(found["undecided"]) == 60
    assert not found["above"]


def test_a_law_that_diverges_falls_behind_all_that_do_not():
    found = printed(evidence(lost, lambda law, _, computer: law == LAWS[0]).at(RMSE, 5e-3))
    assert {pair for pair in found["below"] if pair[2] == LAWS[0]} == set()
    assert len([pair for pair in found["above"] if pair[2] == LAWS[0]]) == 4 * (len(LAWS) - 1)


@pytest.mark.parametrize(("later", "ratio"), [((100.1, 100.2), 1.002), ((150, 300), 3.0), ((50, 25), 4.0)])
def test_the_change_with_the_step_is_the_largest_total_variation_over_the_smallest(later, ratio):
    TVs = np.tile(np.array([100.0, *later])[:, np.newaxis], (1, 2))
    steps = Curve("SMC", "clip", True, np.array([1e-3, 5e-4, 2e-4]), TVs)
    (row,) = trust.steps_table([steps]).rows
    assert row[-1] == pytest.approx(ratio)
