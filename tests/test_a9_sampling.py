"""What a9 says of laws as sampled-data loops: its limits by other roads, and verdicts that turn with their figures."""

from dataclasses import replace

import numpy as np
import pytest

from studies.a9_sampling import study as findings
from studies.a9_sampling.evidence import (
    CLOSE,
    GRID,
    PARTS,
    PERIODS,
    Curve,
    Evidence,
    Safe,
    Search,
    curve,
    in_ms,
    longest_quiet,
    middle,
    plan,
    printed,
)
from studies.a9_sampling.loops import (
    HORIZON,
    NOISY,
    RMSE,
    SCENARIOS,
    TV,
    Audit,
    Computer,
    digital,
    first_torque,
    metrics,
    sweep,
)
from studies.paper.card import LAWS, PUBLISHED
from studies.paper.linearization import SEVEN
from workbench.metrics import measure
from workbench.study.compiled import compile_sweep
from workbench.study.evidence import Threshold, find_largest


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


@pytest.mark.parametrize("edge", [2.3e-5, 3.1e-4, 7e-4, 4e-3])
def test_the_search_brackets_the_longest_safe_period(edge):
    found = longest(lambda period: period <= edge)
    assert found.largest <= edge < found.next
    parts = round(GRID / found.largest)
    assert found.next / found.largest <= CLOSE or round(GRID / found.next) == parts - 1


def test_a_search_that_finds_no_end_says_so():
    assert in_ms(longest(lambda period: True)) == "10 or more"
    assert in_ms(longest(lambda period: False)) == "below 0.02"


def test_the_longest_quiet_period_of_smc_is_between_a_quiet_and_a_loud_one():
    most = 40.0  # N m/s: twice what the reference alone asks for, and a tenth of what chattering takes
    found = longest_quiet(Search("SMC", True, ((most, most), (most, most))))
    ends = found.threshold.largest, found.threshold.next
    below, above = ([exact("SMC", scenario, Computer(period, True)).max() for scenario in SCENARIOS] for period in ends)
    assert max(below) <= most < max(above)
    assert found.sure


def test_smc_is_quiet_below_its_limit_and_chatters_above():
    below, above = (exact("SMC", "FS", Computer(period)) for period in (5e-4, 1e-3))
    assert below.max() < 20  # N m/s: the reference alone asks for 17.5
    assert (above > 100 * below).all()


def test_a_late_computer_starts_with_the_torque_of_the_first_instant():
    late = digital("SMC", "FS", Computer(1e-3, True)).ode()
    np.testing.assert_array_equal(late.states["hold.next"].default, first_torque("SMC", "FS")["tau"])


def test_the_first_run_of_an_audit_has_exact_readings_and_the_others_have_not():
    found, alone = audit("SMC", "FS", Computer(5e-4)), exact("SMC", "FS", Computer(5e-4))
    # the audit's step is half of the search's; noise is a hundred times the variation
    np.testing.assert_allclose(found.values[TV], alone, rtol=1e-3)
    assert found.noisy[TV].shape == (NOISY, 2)
    assert (found.noisy[TV] > 100 * found.values[TV]).all()
    assert len(set(found.noisy[TV][:, 0])) == NOISY


def test_chattering_of_a_computer_does_not_know_the_step_of_the_simulation():
    assert np.ptp(curve(("SMC", "sign", True)).TV, axis=0).max() < 1.0  # of some 5000 N m/s


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


SHORT = Threshold((1e-3, 1.1e-3), (True, False)), Threshold((5e-4, 5.5e-4), (True, False))
SAFE = Safe(1e-3, SHORT)


def evidence(changed=quiet, matches=always, **safe):
    """Laws that no computer touches, AOSMC-RGS first, the others in their order, but for what is changed."""
    still = {(law, scenario, None): quiet(law) for law in SEVEN for scenario in SCENARIOS}
    audits = {key: (changed if matches(*key) else quiet)(key[0]) for key in plan()}
    return Evidence(still | audits, dict.fromkeys(SEVEN, replace(SAFE, **safe)))


def words(verdict):
    """The statement of a finding, its formulas left out."""
    assert verdict.kind == "found"
    parts = (verdict.statement,) if isinstance(verdict.statement, str) else verdict.statement
    return "".join(part for part in parts if isinstance(part, str))


def lost_by(*ways):
    """Evidence in which AOSMC-RGS is lost at 10 ms in the first scenario, where its memories step in these ways."""
    where = ("AOSMC-RGS", "FS", 1e-2)
    return evidence(lost, lambda law, at, computer: (law, at, computer.period) == where and computer.stepping in ways)


@pytest.mark.parametrize(
    ("name", "figures"),
    [
        ("finite", "784 of 784 runs of all laws"),
        ("unseen", "by up to 0.00 %"),
        ("survives", "hold at 1 ms"),
        ("thumb", "of 7 of 7 laws"),
    ],
)
def test_every_finding_is_calm_of_laws_that_no_computer_touches(name, figures):
    assert figures in words(getattr(findings, name)(evidence()))


@pytest.mark.parametrize(
    ("name", "changed", "matches", "figures"),
    [
        ("finite", lost, lambda law, scenario, computer: law == "SMC" and computer.period == 1e-2, "768 of 784"),
        ("unseen", turned, always, "by up to 100.00 %"),
        ("survives", turned, always, " 0 hold at 1 ms"),
    ],
)
def test_a_finding_turns_with_its_figures(name, changed, matches, figures):
    assert figures in words(getattr(findings, name)(evidence(changed, matches)))


@pytest.mark.parametrize(
    ("name", "changes", "figures"),
    [
        ("thumb", {"rule": 2e-3}, "of 0 of 7 laws"),
        ("thumb", {"rule": 1e-3, "quiet": (Threshold((9e-4, 1.1e-3), (True, False)), SHORT[1])}, "of 0 of 7 laws"),
    ],
)
def test_a_finding_on_safe_periods_turns_with_them(name, changes, figures):
    assert figures in words(getattr(findings, name)(evidence(**changes)))


@pytest.mark.parametrize(
    ("ways", "kind", "figures"),
    [
        (("euler",), "found", "8 stay finite with a Cayley step of (34) alone; the law itself loses 0, and 0 are"),
        (("euler", "cayley34"), "open", "0 stay finite with a Cayley step of (34) alone; the law itself loses 0"),
        (("euler", "fine"), "open", "the law itself loses 0, and 8 are unsettled."),
        (("euler", "cayley34", "cayley", "fine"), "found", "the law itself loses 8"),
        ((), "open", "Of 0 runs"),
    ],
)
def test_a_loss_is_the_integrators_where_other_steps_keep_the_run(ways, kind, figures):
    found = findings.integrator(lost_by(*ways))
    assert found.kind == kind
    assert figures in found.statement


def test_what_only_euler_loses_is_told_apart():
    euler = lost_by("euler")
    assert "784 of 784 runs of all laws stay finite up to 10 ms; with explicit Euler of all memories 776 do" in words(
        findings.finite(euler)
    )
    assert "by explicit Euler: 8 of AOSMC-RGS at 10 ms (FS)." in findings.finite(euler).evidence
    assert "776 of 784 runs of all laws" in words(findings.finite(lost_by("euler", "cayley")))


def test_the_published_figures_put_in_for_ours_turn_no_printed_pair():
    found = printed(lambda law, scenario, joint: (PUBLISHED[scenario, joint + 1].values[law], 0.0))
    assert len(found["below"]) + len(found["undecided"]) == 60
    assert not found["above"]


def test_a_law_that_diverges_falls_behind_all_that_do_not():
    found = printed(evidence(lost, lambda law, _, computer: law == LAWS[0]).at(RMSE, 5e-3))
    assert {pair for pair in found["below"] if pair[2] == LAWS[0]} == set()
    assert len([pair for pair in found["above"] if pair[2] == LAWS[0]]) == 4 * (len(LAWS) - 1)


@pytest.mark.parametrize(("later", "figures"), [((100.1, 100.2), "at most 0.2 %"), ((150, 300), "at most 2e+02 %")])
def test_what_the_step_changes_with_a_computer_is_said(later, figures):
    TVs = np.tile(np.array([100.0, *later])[:, np.newaxis], (1, 2))
    curves = [Curve("SMC", "clip", digital, np.array([1e-3, 5e-4, 2e-4]), TVs) for digital in (True, False)]
    unsure = evidence(lambda law: flat(1.0, 10.0, errors=0.03), lambda law, _, computer: computer.stepping == "cayley")
    for found, all_laws in ((evidence(), "by up to 0.1 %"), (unsure, "by up to 3 %")):
        assert figures in words(findings.computers(found, curves))
        assert all_laws in words(findings.computers(found, curves))
