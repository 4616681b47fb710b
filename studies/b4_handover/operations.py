"""The single operations of each target on operands that are hard to round, compared with IEEE 754."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np

from studies.b4_handover.loops import SEED, handed
from workbench.core import Entry, Layout, SampledLaw
from workbench.core.validation.refusals import Array
from workbench.handover.c99.c_code import c_code
from workbench.handover.memory_digest import BASIS
from workbench.handover.recording import record
from workbench.handover.replays import TargetResult, compare
from workbench.handover.targets import TARGETS
from workbench.study import Results, Table, Work
from workbench.study.document.document import Column

PAIRS = 40_000
NAMES = ("sum", "difference", "product", "reciprocal", "root")
FARTHEST = 70  # binary digits from one operand to the other


def law() -> SampledLaw:
    """A law without memory that adds, subtracts, multiplies, inverts and takes the root."""
    a, b, none, one = ca.SX.sym("a"), ca.SX.sym("b"), ca.SX(0, 1), np.zeros(())
    readings, commands = (Layout(tuple(Entry(name, one) for name in names)) for names in (("a", "b"), NAMES))
    u = ca.vertcat(a + b, a - b, a * b, 1 / b, ca.sqrt(ca.fabs(a)))
    empty, y = Layout(), ca.vertcat(a, b)
    return SampledLaw(
        "operations", 1.0, empty, readings, empty, commands, empty, ca.SX.sym("k"), none, y, none, none, u, none
    )


def operands() -> Array:
    """Pairs (N, 2): every second first one a power of two, the second up to `FARTHEST` binary digits below."""
    rng = np.random.default_rng(SEED)
    signs = rng.choice((-1.0, 1.0), (PAIRS, 2))
    shares = 1 + rng.random((PAIRS, 2))
    shares[::2, 0] = 1.0  # there the difference loses a digit, and the rounding moves by one
    near, far = rng.integers(-3, 4, PAIRS), rng.integers(0, FARTHEST, PAIRS)
    return signs * shares * 2.0 ** np.stack([near, near - far], axis=1)


def operations_work() -> Work:
    """Each target against NumPy."""
    return Work("operations", operations_of, tuple(TARGETS), seconds=1.0)


def operations_of(key: str) -> TargetResult:
    """A target against NumPy, whose processor is that of IEEE 754."""
    one, own, y = handed()[0].digital(), law(), operands()
    a, b = y.T
    u = np.stack([a + b, a - b, a * b, 1 / b, np.sqrt(np.abs(a))], axis=1)
    digests = np.full(PAIRS, BASIS, dtype=np.uint64)
    rows = replace(record(one, one.law(), 1), law=own, y=y, r=np.zeros((PAIRS, 0)), u=u, digests=digests)
    return compare(TARGETS[key], c_code(own, "operations"), rows)


def operations_by_target(results: Results) -> dict[str, int]:
    """By target that ran, the number of bits that differ from IEEE 754."""
    return {one.target: one.differing for one in results.work("operations") if one.ran}


def operations_table(results: Results) -> Table:
    """The targets whose operations are not rounded as IEEE 754 requires."""
    rows = [
        (one.target.split(",")[0], one.bits, one.differing, one.first or "none")
        for one in results.work("operations")
        if one.ran
    ]
    columns = (
        Column("target"),
        *(Column(head, align="right") for head in ("bits compared", "bits that differ")),
        Column("first difference"),
    )
    notes = (
        f"{', '.join(NAMES)} of {PAIRS:,} pairs of operands, up to {FARTHEST} binary digits apart; half of the pairs "
        "have a power of two. A law has the bits of the portable arithmetic only where each of these is rounded to the "
        "nearest number.",
    )
    caption = "Single operations in double precision on each target, compared with IEEE 754."
    return Table("operations", caption, columns, tuple(rows), notes)
