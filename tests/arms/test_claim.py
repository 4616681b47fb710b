"""A claim is data, and blocks declare theirs."""

import pytest

from workbench.arms.laws import AosmcRgs, ArmPID, SlidingMode
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.arms.observers import ArmFullState, Luenberger, OracleFilter, StateAndDisturbanceObserver
from workbench.blocks.loop import ClosedLoop
from workbench.blocks.signals import Constant
from workbench.core import Claim
from workbench.core.claim import claims_of

ARM = paper_arm()


def test_a_claim_without_words_or_source_is_refused():
    for field in ("name", "statement", "source"):
        words = {"name": "a", "statement": "b", "source": "c"} | {field: ""}
        with pytest.raises(ValueError, match=f"`Claim\\({field}=...\\)` must be text that says something, .*; got ''"):
            Claim(**words)


def test_a_hypothesis_is_a_claim():
    with pytest.raises(ValueError, match="must be a tuple of `Claim`; got 'M is symmetric' at"):
        Claim("a", "b", "c", ("M is symmetric",))
    assert Claim("a", "b", "c", [held := Claim("d", "e", "f")]).hypotheses == (held,)


def test_a_margin_is_a_function():
    with pytest.raises(ValueError, match="must be a function or None; got 3"):
        Claim("a", "b", "c", (), 3)


def test_a_loop_declares_what_its_blocks_do_with_their_paths():
    observer = StateAndDisturbanceObserver(
        Luenberger(ARM, [[30, 0], [0, 30]], [[50, 0], [0, 50]], 0.0), OracleFilter(2, l=20.0)
    )
    law = SlidingMode(ARM, Lambda=6.0, K=5.0, phi=0.01)
    found = claims_of(ClosedLoop(Manipulator(ARM, q=0.0), observer, law, Constant("q", "rad", [0, 0])))
    assert [(said.path, said.kind) for said in found] == [
        ("observer.state.", "Luenberger"),
        ("observer.disturbance.", "OracleFilter"),
        ("controller.", "SlidingMode"),
    ]


def test_a_block_that_promises_nothing_declares_nothing():
    assert claims_of(ArmPID([1.0], [0.0], [0.0])) == ()
    assert claims_of(ArmFullState(1)) == ()


def test_every_declared_claim_names_a_source_and_no_two_of_a_block_share_a_name():
    for kind in (SlidingMode, AosmcRgs, Luenberger, OracleFilter):
        names = [claim.name for claim in kind.claims]
        assert len(set(names)) == len(names) > 0
        assert all(claim.source for claim in kind.claims)
