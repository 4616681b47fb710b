"""The ledger of the paper on its printed page: the verdicts that must stand, and every witness as it is printed."""

import csv
import json
import re
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from studies.a2_claims import replay, rivals, searches
from studies.a2_claims import study as a2_claims
from studies.a2_claims.printed_statements import DEFINITIONS, PRINTED_STATEMENTS, QUANTIFIERS, decisive
from studies.a2_claims.study import ASSUMED_LEDGER, OUR_LEDGER, PAPER_LEDGER, group_ledgers
from studies.paper.card import LAWS
from tests.support.kept_pages import needs_pages
from tests.support.ledger_rows import Rows, is_printed
from workbench.core import Claim
from workbench.proofs.claim_ledger import BREAKING_KINDS, WITNESS_KINDS, ClaimEntry, ClaimLedger, Ruling
from workbench.report.html_page import html
from workbench.report.number_text import join_units
from workbench.study.case_runs import run
from workbench.study.writeup import document

REPORTS = Path(__file__).parents[2] / "reports"
ILL_POSED = "(33), shapes"


# What a verdict rests on and its witness shows again, some ten seconds of a core: each is computed once.
LONG = ("along_35", "astray", "cost", "drift", "false_rest", "gain_lost", "offset", "v2_over")


@pytest.fixture(scope="module")
def remembered():
    """What replaces attributes until the last test of this file."""
    with pytest.MonkeyPatch.context() as patch:
        yield patch


@pytest.fixture(scope="module")
def results(remembered):
    """What the page is made of: half a minute of a core, for tests before a release alone.

    The laws of a1 are run once for the page and for the witnesses that compare them, and the pairs of weights once.
    """
    for name in LONG:
        remembered.setattr(replay, name, cache(getattr(replay, name)))
    pairs = tuple(replay.PAIRS)
    remembered.setattr(replay, "PAIRS", pairs)
    remembered.setattr(replay, "v2_along", lambda *pair: dict(zip(pairs, replay.v2_over(pairs), strict=True))[pair])
    study, laws = a2_claims.study, replay.comparison_results()
    first, *others = study.cases
    assert [one.name for one in others] == [outcome.case.name for outcome in laws.outcomes]
    own = run(replace(study, cases=(first,), works=()))
    answers = {work.name: tuple(map(work.function, work.over)) for work in study.works}
    return replace(own, outcomes=(*own.outcomes, *laws.outcomes), works=answers)


@pytest.fixture(scope="module")
def ledger(results):
    return a2_claims.ledger(results)


@pytest.fixture(scope="module")
def rows(results):
    """The rows of the printed page."""
    return Rows(html(document(a2_claims.study, results, "workbench run studies/a2_claims"))).rows


@pytest.fixture(scope="module")
def replayed(rows):
    """By claim, what its printed witness gives after the line that the page names, as lists of numbers."""
    names = {}
    exec("from studies.a2_claims.replay import *", names)
    return {name: plain(eval(witness, names)) for name, _, _, witness in rows if witness and name != ILL_POSED}


def plain(value):
    """Arrays and rest points as lists, in whatever holds them."""
    return json.loads(json.dumps(value, default=lambda part: getattr(part, "x", part).tolist()))


def a_rival_is_lower(found):
    """Some rival is below AOSMC-RGS at some joint of some scenario, by more than the margin of a1."""
    return any(
        theirs < ours / 1.02
        for name, values in found.items()
        if not name.endswith("super-twisting") and not name.endswith("AOSMC-RGS")
        for ours, theirs in zip(found[name.split(": ")[0] + ": AOSMC-RGS"], values, strict=True)
    )


def rests_astray(point, times):
    """Whether the estimate rests far from the arm; by hand, q_hat' = 0 asks for qd_hat = L1 (q_hat - q)."""
    return np.linalg.norm(point[:2]) > 6 and np.allclose(point[2:], times * 30 * np.array(point[:2]), rtol=1e-12)


# By the start of a witness: what it must give to show the violation.
SHOWS = {
    "rerun(": lambda found: found[0] > found[1] and found[2] <= 0,  # value, error; the excess over a hypothesis
    "both(": lambda found: not np.allclose(found[0], found[1], rtol=1e-9),
    "printed_dynamics.matrices": lambda found: not np.allclose(*found),
    "skewness(": lambda found: np.abs(found).max() > 3,
    "[mismatch": lambda found: (np.diff(found, axis=1) > 0).all(),
    "v1_rate": lambda found: max(found) > 0,
    "growing_modes": lambda found: found > 0,
    "false_rest": lambda found: all(rests_astray(*one) for one in zip(found, (1, 10, 100), strict=True)),
    "astray": lambda found: found[0] - found[1] > 5,
    "drift": lambda found: (np.abs(found) > 2 * 0.5).all(),  # N m, beyond D; and both ways agree in the evidence
    "[gain_lost": lambda found: all(value + change < 0 for value, change, _ in found),
    "cost(": lambda found: all(ours > 1.0005 * least for ours, least in found),
    "[v2_along": lambda found: all(v > 2 * e for v, e in found[0]) and found[1][0] > 0 > found[2][0],
    "along_35": lambda found: all(value > 1e3 * change for value, change in found.values()),
    "offset": lambda found: np.linalg.norm(found[0]) > 0.01 > 1e6 * np.linalg.norm(found[1]),
    "beside": a_rival_is_lower,
}


def numbers(found):
    """All numbers of a result."""
    if isinstance(found, dict | list):
        return [number for part in (found.values() if isinstance(found, dict) else found) for number in numbers(part)]
    return [] if isinstance(found, str) else [float(found)]


@pytest.mark.release
def test_the_printed_page_shows_each_line_of_the_ledger_with_its_witness_to_the_letter(rows, ledger):
    shown = {name: (verdict, witness) for name, verdict, _, witness in rows}
    assert len(rows) == len(shown) == len(ledger)
    wanted = {line.claim.name: (join_units(line.ruling.verdict), line.ruling.witness) for line in ledger}
    assert shown == wanted  # a page has no-break spaces before units, and none in a witness, which is code


@pytest.mark.release
def test_each_printed_witness_shows_the_violation_that_its_row_states(rows, replayed):
    broken = [row for row in rows if row[1].startswith(WITNESS_KINDS)]
    assert len(broken) > 20
    for name, _, evidence, witness in broken:
        (shows,) = [shows for start, shows in SHOWS.items() if witness.startswith(start)]
        assert shows(replayed[name]), f"{name}: {witness} gives {replayed[name]}"
        if not witness.startswith("cost("):  # whose ratio is printed
            stated = evidence.removesuffix(witness)
            assert any(is_printed(number, stated) for number in numbers(replayed[name])), f"{name}: {replayed[name]}"


@pytest.mark.release
def test_the_product_of_33_is_refused_as_its_row_says(rows):
    ((verdict, witness),) = ((verdict, witness) for name, verdict, _, witness in rows if name == ILL_POSED)
    assert verdict == "ill-posed"
    with pytest.raises(ValueError, match="matmul"):  # NumPy's
        eval(witness, vars(replay))


@pytest.mark.release
def test_what_holds_is_proved_and_what_the_paper_prints_wrong_is_refuted_with_a_witness(ledger):
    for name in ("(2)", "(4)", "Assumption 2", "Assumption 3, derived C", "Assumption 4"):
        assert ledger[name].ruling.kind == "proved"
    for name in ("(3)", "Assumption 3", "Theorem 1", "Theorem 1, gains of section 5", "(24)", "(35)", "(40)"):
        assert ledger[name].ruling.kind == "refuted"
        assert ledger[name].ruling.witness


@pytest.mark.release
def test_no_claim_about_a_limit_is_proved_by_a_run(ledger):
    for line in ledger:
        if "rerun(" in line.ruling.witness:
            assert line.ruling.kind in ("refuted", "not refuted")


@pytest.mark.release
@pytest.mark.parametrize("name", ["(33), gain", "(34), cost", "(40)", "(41), along (10)", "(41), along (35)", "(42)"])
def test_a_witness_prints_the_weights_it_rests_on(name, ledger):
    rests_on = f"{ledger[name].ruling.under} {ledger[name].ruling.evidence}"
    assert all(f"{letter} = " in rests_on for letter in ("Q", "R"))


@pytest.mark.release
@pytest.mark.parametrize("name", ["(33), gain", "(34), cost"])
def test_what_fails_for_some_weights_alone_depends_on_them(name, ledger):
    assert ledger[name].ruling.verdict == "depends on Q and R, which the paper does not state"


@pytest.mark.release
def test_no_claim_is_refuted_over_a_range_that_only_its_reader_chose(ledger):
    for line in ledger:
        if line.ruling.kind == "refuted":
            assert not any(one.is_stronger for one in line.quantifiers)


def test_each_numbered_equation_is_judged_or_is_a_definition():
    numbers = [int(number) for item in PRINTED_STATEMENTS for number in re.findall(r"\((\d+)\)", item.name)]
    assert sorted([*numbers, *DEFINITIONS]) == list(range(1, 44))  # the paper ends with (43)
    assert {name for item in PRINTED_STATEMENTS for name in item.claims} >= set(QUANTIFIERS)


@pytest.mark.release
def test_each_printed_equation_has_a_line_of_the_ledger_with_its_words(ledger):
    for item in PRINTED_STATEMENTS:
        assert decisive(ledger, item).quote == item.quote
        assert item.claims[0] not in group_ledgers(ledger)[OUR_LEDGER].names


@pytest.mark.release
def test_31_is_an_identity_and_its_replacement_is_what_fails(ledger):
    assert ledger["(31)"].ruling.kind == "proved"
    assert ledger["(31), replacement"].ruling.kind == "refuted"


@pytest.mark.release
def test_15_holds_under_its_condition_and_not_for_all_torques_at_once(ledger):
    assert ledger["(15)"].ruling.kind == "proved"
    assert ledger["(15), everywhere"].ruling.kind == "does not hold under"


@pytest.mark.release
def test_every_finding_that_breaks_a_claim_keeps_the_hypotheses_it_names(ledger):
    with_margin = [line for line in ledger if line.ruling.kind in BREAKING_KINDS and line.ruling.kept_hypotheses]
    assert {"(24)", "(40)", "(41), along (35)", "(41), along (10)", "(42)"} <= {line.claim.name for line in with_margin}
    for line in with_margin:
        if "Assumption 4" in line.ruling.kept_hypotheses:
            with pytest.raises(ValueError, match="must keep every hypothesis"):
                ClaimEntry(
                    replace(line.claim, hypotheses=(searches.ASSUMPTION_4,)), replace(line.ruling, kept_hypotheses=())
                )


@pytest.mark.release
def test_a_claim_is_judged_as_published_and_under_the_numbers_of_a1(ledger):
    groups = group_ledgers(ledger)
    published = [line for line in groups[PAPER_LEDGER] if line.ruling.kind == "not checkable as published"]
    # (21), (39), "minimal" errors and rejection, of which a1 has no measure
    assert len(groups[ASSUMED_LEDGER]) == len(published) - 4 == 7
    assert all(line.ruling.unstated_numbers for line in published)
    assert all(line.ruling.under == rivals.OF_A1 for line in groups[ASSUMED_LEDGER])
    for name in groups[ASSUMED_LEDGER].names:
        assert ledger[name.removesuffix(", numbers of a1")].ruling.kind == "not checkable as published"


@needs_pages
def test_what_a2_says_of_a6_and_a3_is_what_their_tables_hold():
    with (REPORTS / "a6_unstated_choices" / "tables" / "cells.csv").open(encoding="utf-8") as file:
        off = [abs(float(row["off [%]"].replace("\N{MINUS SIGN}", "-"))) for row in csv.DictReader(file)]
    assert len(off) == 24
    assert max(off) < 1  # %
    page = (REPORTS / "a6_unstated_choices" / "index.html").read_text(encoding="utf-8")
    assert "6 of 6 rows of the second scenario come" in page
    for scenario, said in (("fs", 1.0), ("ss", 2.1)):
        with (REPORTS / "a3_riccati_gains" / "tables" / f"{scenario}_cost.csv").open(encoding="utf-8") as file:
            ratio = next(float(row["J / J*"]) for row in csv.DictReader(file) if row["P"] == "P(t) of (34)")
        assert 100 * (ratio - 1) == pytest.approx(said, abs=0.05)  # the digits that a2 prints


@pytest.mark.release
def test_the_bounds_of_the_disturbance_are_those_of_its_sines(ledger):
    # by hand: each scenario has one sine of 3 and one of 4 rad/s, so the norm of the amplitudes is not exceeded
    evidence = ledger["Assumption 4"].ruling.evidence
    bounds = [float(found) for found in re.findall(r"\|D\| <= ([0-9.]+) N m", evidence)]
    assert len(bounds) == 2
    assert all(0.5 < bound <= np.hypot(0.5, 0.4) * (1 + 1e-6) for bound in bounds)


@pytest.mark.release
def test_each_claim_is_counted_in_one_group(ledger):
    names = ledger.names
    lines = tuple(ClaimEntry(Claim(name, "said", "here"), Ruling("proved", "seen")) for name in names)
    groups = group_ledgers(ClaimLedger(lines))
    assert sorted(name for group in groups.values() for name in group.names) == sorted(names)
    assert all(groups.values())
    assert not any("repaired" in name for name in groups[PAPER_LEDGER].names)
    assert {"(30), repaired", "Theorem 1, swinging arm"} <= set(groups[OUR_LEDGER].names)


@pytest.mark.release
def test_a_comparison_is_replayed_with_the_numbers_of_a1(replayed):
    found = replayed["reduced overshoot, numbers of a1"]
    assert set(found) == {f"SS: {law}" for law in (*LAWS, "super-twisting")}  # after jumps, which FS has none of
    assert found["SS: AOSMC-RGS"][0] > found["SS: ASMC"][0]
