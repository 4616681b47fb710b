"""The ledger of the paper: the verdicts that must stand, and every witness replayed as a reader would."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent.parent / "studies"))

import a2_claims
import claims_groups
import claims_hunts
import claims_law
import claims_model
import claims_observers
from claims_groups import grouped
from claims_identities import both
from claims_phrases import phrase
from claims_replay import (
    astray,
    beside,
    cost,
    derived,
    escape,
    false_rest,
    gain_lost,
    mismatch,
    offset,
    skewness,
    v1_rate,
)
from paper_card import LAWS

from workbench.core import Claim
from workbench.notation.formula import Power, Symbol
from workbench.verify.claims import Finding, Ledger, Line
from workbench.verify.rest import RestPoint

STUDIES = Path(a2_claims.__file__).parent
CHECKS = (*claims_model.CHECKS, *claims_observers.CHECKS, *claims_law.CHECKS)
LEDGER = Ledger.of(CHECKS)
WITH_WITNESS = [line for line in LEDGER if line.finding.witness]


def replayed(lines: list[str]) -> list[str]:
    """What a new process prints for each line, or the kind of error that it ends with."""
    script = "import sys, json\nfrom claims_replay import *\n" + "".join(
        f"try:\n    print(json.dumps(str(({line}))))\nexcept ValueError:\n    print(json.dumps('ValueError'))\n"
        for line in lines
    )
    environment = {**os.environ, "PYTHONPATH": str(STUDIES.parent)}
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=STUDIES, env=environment, capture_output=True, text=True, check=True
    )
    return [json.loads(line) for line in done.stdout.splitlines()]


@pytest.mark.parametrize(
    "name", ["(3)", "Assumption 3", "Theorem 1", "Theorem 1, gains of section 5", "(24)", "(33), shapes", "(33), gain"]
)
def test_what_the_paper_prints_wrong_is_refuted_with_a_witness(name):
    assert LEDGER[name].finding.kind == "refuted"
    assert LEDGER[name].finding.witness


@pytest.mark.parametrize("name", ["(2)", "(4)", "Assumption 2", "Assumption 3, derived C", "Assumption 4"])
def test_what_holds_for_the_derived_arm_is_proved(name):
    assert LEDGER[name].finding.kind == "proved"


def test_no_claim_about_a_limit_is_proved_by_a_run():
    for line in LEDGER:
        if "replay(" in line.finding.witness:
            assert line.finding.kind in ("refuted", "not refuted")


def test_every_witness_runs_in_a_new_process():
    lines = [line.finding.witness for line in WITH_WITNESS]
    printed = dict(zip((line.claim.name for line in WITH_WITNESS), replayed(lines), strict=True))
    assert printed["(33), shapes"] == "ValueError"  # NumPy refuses the product, as it must
    assert "1.54030231" in printed["(3)"]  # 1 + cos 1, where 0 is right
    assert printed["Theorem 1"] == "2"
    for name, text in printed.items():
        if text.startswith("Replay"):
            assert "same=True" in text, name


@pytest.mark.parametrize("name", sorted(claims_hunts.TABLE))
def test_every_stored_run_replays_on_the_equations_of_today(name):
    example, again = claims_hunts.stored(name), claims_hunts.replay(name)
    assert again.same
    refuting = claims_hunts.found(name).kind == "refuted"
    assert not refuting or again.value - again.error > 0
    assert example.seed == claims_hunts.SEED


def test_the_false_rest_of_the_observer_is_one():
    point = false_rest()
    assert point.radius is not None
    assert point.attracts
    assert np.linalg.norm(point.x[:2]) > 6  # rad of error, for ever
    # by hand: q_hat' = 0 asks for qd_hat = L1 (q_hat - q)
    np.testing.assert_allclose(point.x[2:], 30 * point.x[:2], rtol=1e-12)


def test_the_printed_c_is_not_skew_and_the_derived_one_is():
    assert np.abs(skewness(claims_model.PRINTED, (0.5, 1), (1, -1))).max() == pytest.approx(2 * (1 + np.cos(1)))
    np.testing.assert_allclose(skewness(derived, (0.5, 1), (1, -1)), 0, atol=1e-15)


def test_the_mismatch_grows_with_the_torque_without_end():
    # by hand: the first column of M^-1 is (1, -1 - cos q2) / (1 + sin^2 q2), so between q2 = 0 and 1 it changes by
    change = np.array([1, -2]) - np.array([1, -1 - np.cos(1)]) / (1 + np.sin(1) ** 2)
    sizes = [mismatch((0, 1), (torque, 0)) for torque in (1e4, 1e5)]
    np.testing.assert_allclose(np.diff(sizes) / 9e4, np.linalg.norm(change), rtol=1e-5)  # gravity is left at 1e4 N m


def test_a_misspelt_name_of_an_identity_s_value_is_named():
    with pytest.raises(LookupError, match="knows q_hat"):
        both("(31)", S=(1, 0))


def test_a_typed_claim_is_printed_with_its_letters():
    found = phrase("V1' <= x1~^T P1 x1~, from qd_hat(0) on")
    assert Symbol("V", "1", dots=1) in found
    assert Power(Symbol("x", "1", accent="tilde"), Symbol("T")) in found
    assert Symbol("q", dots=1, accent="hat") in found
    assert " \N{LESS-THAN OR EQUAL TO} " in found
    assert phrase("rad^2/s^3") == ("rad\N{SUPERSCRIPT TWO}/s\N{SUPERSCRIPT THREE}",)
    assert phrase("the same word") == ("the same word",)


@pytest.mark.parametrize("name", ["(33), gain", "(34), cost", "(33), repaired", "(40)", "(41)", "(42)"])
def test_a_refutation_prints_the_numbers_it_rests_on(name):
    line = LEDGER[name]
    assert all(f"{letter} = " in line.finding.evidence for letter in ("Q", "R", "l"))
    assert "For all Q, R > 0" in line.claim.statement


def test_other_weights_differ_as_the_page_says():
    value, change, _ = gain_lost("outer", 30, Q=0.01)
    assert value - change > 0
    (with_34, error), (without, error_0) = cost("forward", 0.1, 10), cost("frozen", 0.1, 10)
    assert with_34 + error < without - error_0


def test_the_loop_escapes_under_the_hypotheses_of_theorem_2():
    assert LEDGER.fallen("Theorem 2, bounded signals") == ()  # C is the derived one, and so skew
    fine, coarse, turned = escape()
    assert turned < fine  # K is lost first
    assert fine == pytest.approx(coarse, abs=0.02)  # s: the escape sharpens what a step of 1e-4 s blurs


@pytest.mark.parametrize("times", [10, 100])
def test_larger_gains_keep_the_false_rest(times):
    point = false_rest(times)
    assert point.radius is not None
    assert np.linalg.norm(point.x[:2]) > 6  # rad


@pytest.mark.parametrize(
    ("module", "name", "value", "check"),
    [
        (claims_observers, "drift", (np.array([0.5, 0.4]), np.array([0.5, 0.4])), claims_observers.integral_of_eta),
        (claims_observers, "drift", (np.zeros(2), np.zeros(2)), claims_observers.integral_of_eta),
        (claims_observers, "mismatch", 1.0, claims_observers.lipschitz),
        (claims_observers, "v1_rate", (-1.0, -1.0), claims_observers.lyapunov),
        (claims_observers, "false_rest", RestPoint(np.zeros(4), 1e-7, True, np.zeros(4)), claims_observers.paper_gains),
        (claims_law, "offset", (np.zeros(2), np.zeros(2)), claims_law.convergence),
        (claims_law, "escape", (np.nan, np.nan, np.nan), claims_law.unbounded),
        (claims_law, "gain_lost", (1.0, 0.0, 1), claims_law.gains),
        (claims_law, "cost", (1.0, 0.0), claims_law.least_cost),
    ],
)
def test_a_verdict_follows_its_numbers(monkeypatch, module, name, value, check):
    monkeypatch.setattr(module, name, lambda *args, **options: value)
    assert check().kind == "not refuted"


def test_the_replay_of_22_shows_a_rate_that_is_not_negative():
    there, back = v1_rate((0, 1), (1, 1))
    assert max(there, back) > 0
    assert there == pytest.approx(-back)  # odd in the velocity error


def test_the_replay_of_41_shows_an_error_that_stays():
    error, change = offset()
    assert np.linalg.norm(error) > 0.01 > 1e6 * np.linalg.norm(change)


def test_the_witness_of_the_swinging_arm_prints_what_the_evidence_says():
    line, (size, error) = LEDGER["Theorem 1, swinging arm"], astray()
    assert line.finding.witness == "astray()"
    assert f"is {size:.2f} rad" in line.finding.evidence
    assert size - error > 5  # rad, the claim


def test_the_bounds_of_the_disturbance_are_those_of_its_sines():
    # by hand: each scenario has one sine of 3 and one of 4 rad/s, so the norm of the amplitudes is not exceeded
    evidence = LEDGER["Assumption 4"].finding.evidence
    bounds = [float(found) for found in re.findall(r"\|D\| <= ([0-9.]+) N m", evidence)]
    assert len(bounds) == 2
    assert all(0.5 < bound <= np.hypot(0.5, 0.4) * (1 + 1e-6) for bound in bounds)


def test_each_claim_is_counted_in_one_group():
    names = (*LEDGER.names, *claims_groups.OF_BLOCKS)
    lines = tuple(Line(Claim(name, "said", "here"), Finding("proved", "seen")) for name in names)
    groups = grouped(Ledger(lines))
    assert sorted(name for group in groups.values() for name in group.names) == sorted(names)
    assert set(groups[claims_groups.OURS].names) == set(claims_groups.OF_OURS)
    assert all(groups.values())
    assert not any("repaired" in name for name in groups[claims_groups.PAPER].names)


def test_the_study_has_the_comparisons_of_a1():
    assert {case.scenario for case in a2_claims.study.cases} == {"FS", "SS"}
    assert len(a2_claims.study.cases) == 14


def test_a_comparison_is_replayed_with_the_numbers_of_a1():
    found = beside("overshoot")
    assert set(found) == {f"SS: {law}" for law in (*LAWS, "super-twisting")}  # after jumps, which FS has none of
    assert found["SS: AOSMC-RGS"][0] > found["SS: ASMC"][0]
