"""The ledger: findings that say what they rest on, and hypotheses linked to claims."""

import pytest

from workbench.core import Claim
from workbench.verify.claims import Finding, Ledger, Line

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


def test_a_verdict_is_one_of_four():
    with pytest.raises(
        ValueError, match="must be one of 'proved', 'refuted', 'not refuted', 'not checkable'; got 'true'"
    ):
        Finding("true", "it is so")


def test_a_check_must_find_something():
    with pytest.raises(ValueError, match="The check of 'model'"):
        Ledger.of([(RIGHT, lambda: None)])
