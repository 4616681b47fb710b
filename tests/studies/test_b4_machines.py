"""The findings of b4 on machines: targets with other bits, and operations that round otherwise."""

from dataclasses import replace

import numpy as np
import pytest

import workbench as wb
from studies.b4_handover import machine_tables, machines, operations
from studies.b4_handover.loops import PID, handover_loops
from tests.support.handed_loops import BY_NAME, M4F
from workbench.handover.replays import TargetResult
from workbench.handover.targets import TARGETS
from workbench.handover.targets.target import TargetCost
from workbench.study import Results


def replays(**changes):
    """Each law on two targets with equal bits, of which one result is changed."""
    fine = {"periods": 10, "bits": 640}
    here = TargetResult("gcc -O0", **fine, figures=TargetCost(900.0, stack=300, code=10, data=0))
    there = replace(here, target=M4F, **changes)
    return {one.name: (here, there if one.name == PID else replace(here, target=M4F)) for one in handover_loops()}


def replayed(**changes):
    """Results with these replays, in single precision too, and with one operation that rounds otherwise."""
    each = tuple(replays(**changes).values())
    alone = TargetResult("gcc -O0", bits=5), TargetResult(M4F, bits=5, differing_bits=7, first="period 3")
    return {"replays": each, "single_replays": tuple(replays().values()), "operations": alone}


@pytest.mark.parametrize(
    ("changes", "answer", "words"),
    [
        ({}, "no target differs", "on 2 of 2 targets."),
        (
            {"differing_bits": 3, "first": "period 4"},
            "Cortex-M4F with mended sums differs",
            "on 1 of 2 targets; on the Cortex-M4F",
        ),
        ({"memories": 1, "first": "period 4"}, "Cortex-M4F with mended sums differs", "1 of 6 laws differs (PID)"),
        ({"reason": "install it"}, "no target differs", "on 2 of 2 targets."),
    ],
)
def test_the_targets_with_other_bits_are_counted_and_named(changes, answer, words):
    found = machines.bits_finding(Results(works=replayed(**changes)))
    assert found.answer == answer
    assert words in found.statement
    variations = {one.words: one.answer for one in found.variations}
    assert variations["PID alone"] == answer
    assert variations["SMC alone"] == "no target differs"
    assert variations["single operations in place of laws"] == "Cortex-M4F with mended sums differs"


def test_every_target_is_replayed_also_the_library_with_a_fault(monkeypatch):
    asked = {}
    monkeypatch.setattr(wb, "replay", lambda sampled, **how: asked.update(how) or replace_results())
    machines.in_doubles(BY_NAME[PID].key)
    assert asked["targets"] == tuple(TARGETS)
    assert "cortex-m4f-libgcc" in asked["targets"]


def replace_results():
    """A replay without results."""
    return type("Replay", (), {"results": ()})()


def test_a_target_that_is_not_installed_is_named():
    absent = TargetResult("gcc -O0", reason="install gcc with `apt-get install gcc`")
    works = dict.fromkeys(("replays", "single_replays"), ((absent,),) * 6) | {"operations": (absent,)}
    found = machines.bits_finding(Results(works=works))
    assert found.kind == "open"
    assert "Not run: gcc -O0." in found.evidence
    rows = machine_tables.bits_table(Results(works=works)).rows
    assert rows == (("gcc -O0", None, None, None, None, None, "not run"),)


def test_operands_reach_the_roundings_that_are_hard():
    a, b = operations.operands().T
    apart = np.frexp(a)[1] - np.frexp(b)[1]
    two = np.frexp(np.abs(a))[0] == 0.5
    assert (np.bincount(apart[two & (apart > 0)], minlength=60)[1:60] > 100).all()
    assert not two[1::2].any()


def test_operations_that_round_otherwise_are_listed():
    first = "period 3, 'difference': 1 instead of 2"
    good, bad = TargetResult("one", bits=5), TargetResult("two", bits=5, differing_bits=7, first=first)
    results = Results(works={"operations": (good, bad)})
    assert operations.operations_by_target(results) == {"one": 0, "two": 7}
    other = "pair 3, 'subtraction': 1 instead of 2"
    assert operations.operations_table(results).rows == (("one", 5, 0, "none"), ("two", 5, 7, other))
