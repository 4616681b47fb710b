"""Pairs as lines of LLVM IR: in the odd lanes of a vector the steps are twice as long as in the even ones.

So a run and the same run at twice the step go side by side. An odd lane takes its step when the even ones have
taken two, and keeps its state until then. Its constants lie behind those of the even lanes, and so does its table.
"""

from __future__ import annotations

from workbench.simulate.kernel.emission import Emission
from workbench.simulate.kernel.plan import Plan

TABLE = """
  %size = mul i64 %groups, {rows}
  %wide_table = getelementptr {vector}, ptr %table, i64 %size
  %wide_constants = getelementptr double, ptr %constants, i64 {numbers}
  %wide_begin = lshr i64 %begin, 1
  %wide_groups_less = lshr i64 %groups, 1
  %wide_groups = add i64 %wide_groups_less, 1"""

PLACE = """
  %odd = trunc i64 %k to i1
  %wide_k = lshr i64 %k, 1
  %wide_begin = lshr i64 %begin, 1
  %wide_here = sub i64 %wide_k, %wide_begin"""


def table(plan: Plan, width: int) -> str:
    """Where the table of the odd lanes lies, and which of their steps are in it."""
    return TABLE.format(rows=len(plan.table), vector=f"<{width} x double>", numbers=len(plan.numbers))


def groups(even: int) -> int:
    """How many groups of steps there is room for beside those of the even lanes."""
    return even // 2 + 1


def constant(e: Emission, plan: Plan, place: int) -> str:
    """A constant, of each lane its own."""
    return _apart(e, "%constants", place, "%constants", place + len(plan.numbers))


def timed(e: Emission, place: int) -> str:
    """What a table has at a place for the step of each lane."""
    return _apart(e, "%time_here", place, "%wide_time_here", place)


def steps(e: Emission) -> str:
    """The number of the step in each lane."""
    return e.line(f"lshr {e.integers} {e.splat('%k', 'i64')}, {_alternating(e, 'i64 0', 'i64 1')}")


def taken(e: Emission, states: list[str]) -> list[str]:
    """The states after this step of the even lanes, and after that of the odd ones if it ends now."""
    now = e.do("or", e.splat("%odd", "i1"), _alternating(e, "i1 true", "i1 false"))
    return [e.do("select", now, state, f"%x{i}") for i, state in enumerate(states)]


def _apart(e: Emission, even: str, place: int, odd: str, other: int) -> str:
    """The double at a place of an array in the even lanes, and of another in the odd ones."""
    vector = "poison"
    for i, (base, at) in enumerate(((even, place), (odd, other))):
        pointer = e.line(f"getelementptr double, ptr {base}, i64 {at}")
        number = e.line(f"load double, ptr {pointer}, align 8")
        vector = e.line(f"insertelement {e.type} {vector}, double {number}, i64 {i}")
    lanes = _alternating(e, "i32 0", "i32 1")
    return e.line(f"shufflevector {e.type} {vector}, {e.type} poison, <{e.width} x i32> {lanes}")


def _alternating(e: Emission, even: str, odd: str) -> str:
    return f"<{', '.join([even, odd] * (e.width // 2))}>"
