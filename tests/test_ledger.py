"""The ledger: findings that say what they rest on, and hypotheses linked to claims."""

from dataclasses import replace

import pytest

from workbench.claims.claim_ledger import Finding, Ledger, Line
from workbench.core import Claim

RIGHT = Claim("model", "the model is right", "(1)")
BOUND = Claim("bound", "D is bounded", "(8)")
LEMMA = Claim("lemma", "V falls", "(21)", (RIGHT,))
THEOREM = Claim("theorem", "e tends to zero", "(23)", (LEMMA, BOUND))

PROVED = Finding("proved", "by normal form")
REFUTED = Finding("refuted", "at q = 1", "f(1)")


def ledger(**findings: Finding) -> Ledger:
    claims = {claim.name: claim for claim in (RIGHT, LEMMA, THEOREM)}
    return Ledger.of([(claims[name], lambda finding=finding: finding) for name, finding in findings.items()])


def test_each_claim_is_checked_in_order():
    found = ledger(model=PROVED, theorem=REFUTED)
    assert [(line.claim.name, line.finding.kind) for line in found] == [("model", "proved"), ("theorem", "refuted")]
    assert len(found) == 2
    assert found.count("refuted") == 1


def test_a_claim_knows_what_it_rests_on_however_far_below():
    found = ledger(model=REFUTED, lemma=PROVED, theorem=PROVED)
    assert found.hypotheses("theorem") == (("lemma", "proved"), ("model", "refuted"), ("bound", None))
    assert found.fallen("theorem") == ("model",)
    assert found.fallen("model") == ()


def test_a_claim_that_is_not_there_is_named_with_the_nearest():
    with pytest.raises(
        LookupError, match="There is no 'theorm' among the 1 claims of this ledger. Did you mean 'theorem'?"
    ):
        ledger(theorem=PROVED)["theorm"]


def test_two_lines_of_one_name_are_refused():
    with pytest.raises(ValueError, match="holds each claim once; \\['model'\\] came more than once"):
        Ledger((Line(RIGHT, PROVED), Line(RIGHT, REFUTED)))


def test_a_refutation_without_a_witness_is_refused():
    with pytest.raises(ValueError, match="needs a line of Python"):
        Finding("refuted", "it fails")


def test_a_verdict_without_evidence_is_refused():
    with pytest.raises(ValueError, match="must say on what the verdict rests"):
        Finding("proved", "")


def test_samples_belong_to_what_is_not_refuted():
    with pytest.raises(ValueError, match="belongs to that verdict alone"):
        Finding("proved", "by 5 samples", samples=5)
    with pytest.raises(ValueError, match="belongs to that verdict alone"):
        Finding("not refuted", "never seen")
    assert Finding("not refuted", "by search", samples=1200).verdict == "not refuted in 1,200 samples"


def test_a_verdict_is_one_of_seven():
    with pytest.raises(
        ValueError, match="must be one of 'proved', 'refuted', 'does not hold under', 'not refuted', .*; got 'true'"
    ):
        Finding("true", "it is so")


def test_a_check_must_find_something():
    with pytest.raises(ValueError, match="The check of 'model'"):
        Ledger.of([(RIGHT, lambda: None)])


def test_a_condition_is_named_where_a_claim_fails_under_it():
    under = Finding("does not hold under", "3 is above 2", "f(1)", under="the numbers of a1")
    assert under.verdict == "does not hold under: the numbers of a1"
    with pytest.raises(ValueError, match="names the condition of 'does not hold under', which needs one"):
        Finding("does not hold under", "3 is above 2", "f(1)")
    with pytest.raises(ValueError, match="needs a line of Python"):
        Finding("does not hold under", "3 is above 2", under="the numbers of a1")
    with pytest.raises(ValueError, match="got 'the numbers of a1' with 'proved'"):
        Finding("proved", "by normal form", under="the numbers of a1")
    held = Finding("not refuted", "1 is below 2", samples=20, under="the numbers of a1")
    assert held.verdict == "not refuted in 20 samples, under: the numbers of a1"


def test_a_claim_that_cannot_be_checked_says_what_is_unstated():
    assert Finding("not checkable as published", "no gain is printed", unstated="all gains").verdict == (
        "not checkable as published"
    )
    with pytest.raises(ValueError, match="names what the source does not state"):
        Finding("not checkable as published", "no gain is printed")
    with pytest.raises(ValueError, match="got 'all gains' with 'refuted'"):
        Finding("refuted", "it fails", "f(1)", unstated="all gains")


def test_an_ill_posed_claim_says_why_and_needs_no_witness():
    assert Finding("ill-posed", "a 2 x 1 matrix times a 2 x 1 matrix").verdict == "ill-posed"
    with pytest.raises(ValueError, match="must say on what the verdict rests"):
        Finding("ill-posed", "")


@pytest.mark.parametrize("finding", [REFUTED, Finding("does not hold under", "3 > 2", "f(1)", under="a1")])
def test_a_witness_that_was_not_seen_to_keep_a_hypothesis_is_no_witness(finding):
    margin = Claim("gain", "K > delta", "(40)", (), lambda y: y["K"])
    lemma = Claim("lemma", "V falls", "(40)", (margin,))
    theorem = Claim("theorem", "e tends to zero", "(41)", (lemma,))
    with pytest.raises(
        ValueError, match="'theorem' must keep every hypothesis of the claim.*\\['gain'\\] have margins"
    ):
        Line(theorem, finding)
    assert Line(theorem, replace(finding, kept=("gain",))).finding.kept == ("gain",)
    assert Line(theorem, PROVED).finding is PROVED


def test_a_hypothesis_that_fails_under_a_condition_has_fallen():
    lines = (Line(RIGHT, Finding("does not hold under", "3 > 2", "f(1)", under="a1")), Line(LEMMA, PROVED))
    assert Ledger(lines).fallen("lemma") == ("model",)
