"""The ledger: rulings that say what they rest on, and hypotheses linked to claims."""

from dataclasses import replace

import pytest

from workbench.core import Claim
from workbench.proofs.claim_ledger import ClaimEntry, ClaimLedger, Quantifier, Ruling

RIGHT = Claim("model", "the model is right", "(1)")
BOUND = Claim("bound", "D is bounded", "(8)")
LEMMA = Claim("lemma", "V falls", "(21)", (RIGHT,))
THEOREM = Claim("theorem", "e tends to zero", "(23)", (LEMMA, BOUND))

PROVED = Ruling("proved", "by normal form")
REFUTED = Ruling("refuted", "at q = 1", "f(1)")


def ledger(**rulings: Ruling) -> ClaimLedger:
    claims = {claim.name: claim for claim in (RIGHT, LEMMA, THEOREM)}
    return ClaimLedger.of([(claims[name], lambda ruling=ruling: ruling) for name, ruling in rulings.items()])


def test_each_claim_is_checked_in_order():
    found = ledger(model=PROVED, theorem=REFUTED)
    assert [(line.claim.name, line.ruling.kind) for line in found] == [("model", "proved"), ("theorem", "refuted")]
    assert len(found) == 2
    assert found.count("refuted") == 1


def test_a_claim_knows_what_it_rests_on_however_far_below():
    found = ledger(model=REFUTED, lemma=PROVED, theorem=PROVED)
    assert found.hypotheses("theorem") == (("lemma", "proved"), ("model", "refuted"), ("bound", None))
    assert found.broken_hypotheses("theorem") == ("model",)
    assert found.broken_hypotheses("model") == ()


def test_a_claim_that_is_not_there_is_named_with_the_nearest():
    with pytest.raises(
        LookupError, match="There is no 'theorm' among the 1 claims of this ledger. Did you mean 'theorem'?"
    ):
        ledger(theorem=PROVED)["theorm"]


def test_two_lines_of_one_name_are_refused():
    with pytest.raises(ValueError, match="holds each claim once; \\['model'\\] came more than once"):
        ClaimLedger((ClaimEntry(RIGHT, PROVED), ClaimEntry(RIGHT, REFUTED)))


def test_a_refutation_without_a_witness_is_refused():
    with pytest.raises(ValueError, match="needs a line of Python"):
        Ruling("refuted", "it fails")


def test_a_verdict_without_evidence_is_refused():
    with pytest.raises(ValueError, match="must say on what the verdict rests"):
        Ruling("proved", "")


def test_samples_belong_to_what_is_not_refuted():
    with pytest.raises(ValueError, match="belongs to that verdict alone"):
        Ruling("proved", "by 5 samples", samples=5)
    with pytest.raises(ValueError, match="belongs to that verdict alone"):
        Ruling("not refuted", "never seen")
    assert Ruling("not refuted", "by search", samples=1200).verdict == "not refuted in 1,200 samples"


def test_a_verdict_is_one_of_eight():
    with pytest.raises(
        ValueError, match="must be one of 'proved', 'refuted', 'does not hold under', 'depends on', .*; got 'true'"
    ):
        Ruling("true", "it is so")


def test_a_check_must_find_something():
    with pytest.raises(ValueError, match="The check of 'model'"):
        ClaimLedger.of([(RIGHT, lambda: None)])


def test_a_condition_is_named_where_a_claim_fails_under_it():
    under = Ruling("does not hold under", "3 is above 2", "f(1)", under="the numbers of a1")
    assert under.verdict == "does not hold under: the numbers of a1"
    with pytest.raises(ValueError, match="names the condition of 'does not hold under', which needs one"):
        Ruling("does not hold under", "3 is above 2", "f(1)")
    with pytest.raises(ValueError, match="needs a line of Python"):
        Ruling("does not hold under", "3 is above 2", under="the numbers of a1")
    with pytest.raises(ValueError, match="got 'the numbers of a1' with 'proved'"):
        Ruling("proved", "by normal form", under="the numbers of a1")
    held = Ruling("not refuted", "1 is below 2", samples=20, under="the numbers of a1")
    assert held.verdict == "not refuted in 20 samples, under: the numbers of a1"


def test_a_claim_that_cannot_be_checked_says_what_is_unstated():
    assert Ruling("not checkable as published", "no gain is printed", unstated_numbers="all gains").verdict == (
        "not checkable as published"
    )
    with pytest.raises(ValueError, match="names what the source does not state"):
        Ruling("not checkable as published", "no gain is printed")
    with pytest.raises(ValueError, match="got 'all gains' with 'refuted'"):
        Ruling("refuted", "it fails", "f(1)", unstated_numbers="all gains")


def test_an_ill_posed_claim_says_why_and_needs_no_witness():
    assert Ruling("ill-posed", "a 2 x 1 matrix times a 2 x 1 matrix").verdict == "ill-posed"
    with pytest.raises(ValueError, match="must say on what the verdict rests"):
        Ruling("ill-posed", "")


@pytest.mark.parametrize("ruling", [REFUTED, Ruling("does not hold under", "3 > 2", "f(1)", under="a1")])
def test_a_witness_that_was_not_seen_to_keep_a_hypothesis_is_no_witness(ruling):
    margin = Claim("gain", "K > delta", "(40)", (), lambda y: y["K"])
    lemma = Claim("lemma", "V falls", "(40)", (margin,))
    theorem = Claim("theorem", "e tends to zero", "(41)", (lemma,))
    with pytest.raises(
        ValueError, match="'theorem' must keep every hypothesis of the claim.*\\['gain'\\] have margins"
    ):
        ClaimEntry(theorem, ruling)
    assert ClaimEntry(theorem, replace(ruling, kept_hypotheses=("gain",))).ruling.kept_hypotheses == ("gain",)
    assert ClaimEntry(theorem, PROVED).ruling is PROVED


def test_a_hypothesis_that_fails_under_a_condition_has_fallen():
    lines = (ClaimEntry(RIGHT, Ruling("does not hold under", "3 > 2", "f(1)", under="a1")), ClaimEntry(LEMMA, PROVED))
    assert ClaimLedger(lines).broken_hypotheses("lemma") == ("model",)


def test_a_claim_is_not_refuted_over_a_range_that_its_reader_chose():
    ours, narrower = Quantifier("all Q and R", "reader"), Quantifier("Q = R = I", "reader", within=True)
    with pytest.raises(ValueError, match="'model' is refuted only if it fails over the range of its source"):
        ClaimEntry(RIGHT, REFUTED, "the model is right", (ours,))
    depends = Ruling("depends on", "true for one pair, false for another", "f(1), f(2)", on="Q and R")
    assert ClaimEntry(RIGHT, depends, "", (ours,)).ruling.verdict == "depends on Q and R"
    for allowed in (narrower, Quantifier("all states", "source")):
        assert ClaimEntry(RIGHT, REFUTED, "", (allowed,)).quantifiers == (allowed,)


def test_what_depends_on_numbers_names_them_and_has_a_witness():
    with pytest.raises(ValueError, match="names the numbers on which the truth of a claim depends"):
        Ruling("depends on", "true for one pair", "f(1)")
    with pytest.raises(ValueError, match="needs a line of Python"):
        Ruling("depends on", "true for one pair", on="Q and R")
