"""The single operations of each target on operands that are hard to round, compared with IEEE 754."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np

import workbench as wb
from studies.b4_handover.loops import SEED, handover_loops

PAIRS = 40_000
NAMES = ("sum", "difference", "product", "reciprocal", "root")
FARTHEST = 70  # binary digits from one operand to the other


def law() -> wb.SampledLaw:
    """A law without memory that adds, subtracts, multiplies, inverts and takes the root."""
    a, b, none, one = ca.SX.sym("a"), ca.SX.sym("b"), ca.SX(0, 1), np.zeros(())
    readings, commands = (wb.Layout(tuple(wb.core.Entry(name, one) for name in names)) for names in (("a", "b"), NAMES))
    u = ca.vertcat(a + b, a - b, a * b, 1 / b, ca.sqrt(ca.fabs(a)))
    empty, y = wb.Layout(), ca.vertcat(a, b)
    return wb.SampledLaw(
        "operations", 1.0, empty, readings, empty, commands, empty, ca.SX.sym("k"), none, y, none, none, u, none
    )


def operands() -> wb.Array:
    """Pairs (N, 2): every second first one a power of two, the second up to `FARTHEST` binary digits below."""
    rng = np.random.default_rng(SEED)
    signs = rng.choice((-1.0, 1.0), (PAIRS, 2))
    shares = 1 + rng.random((PAIRS, 2))
    shares[::2, 0] = 1.0  # there the difference loses a digit, and the rounding moves by one
    near, far = rng.integers(-3, 4, PAIRS), rng.integers(0, FARTHEST, PAIRS)
    return signs * shares * 2.0 ** np.stack([near, near - far], axis=1)


def operations_work() -> wb.Work:
    """Each target against NumPy."""
    return wb.Work("operations", operations_of, tuple(wb.handover.TARGETS), seconds=1.0)


def operations_of(key: str) -> wb.handover.TargetResult:
    """A target against NumPy, whose processor is that of IEEE 754."""
    one, own, y = handover_loops()[0].digital(), law(), operands()
    a, b = y.T
    u = np.stack([a + b, a - b, a * b, 1 / b, np.sqrt(np.abs(a))], axis=1)
    digests = np.full(PAIRS, wb.handover.BASIS, dtype=np.uint64)
    rows = replace(wb.record(one, one.law(), 1), law=own, y=y, r=np.zeros((PAIRS, 0)), u=u, digests=digests)
    return wb.handover.compare(wb.handover.TARGETS[key], wb.c_code(own, "operations"), rows)


def operations_by_target(results: wb.Results) -> dict[str, int]:
    """By target that ran, the number of bits that differ from IEEE 754."""
    return {one.target: one.differing_bits for one in results.work("operations") if one.ran}


def first_words(first: str) -> str:
    """The first mismatch of a target: its pair of operands, and the operation by its noun."""
    return first.replace("period", "pair", 1).replace("'difference'", "'subtraction'")


def operations_table(results: wb.Results) -> wb.document.ReportTable:
    """The targets whose operations are not rounded as IEEE 754 requires."""
    rows = [
        (one.target.split(",")[0], one.bits, one.differing_bits, first_words(one.first) or "none")
        for one in results.work("operations")
        if one.ran
    ]
    columns = (
        wb.document.TableColumn("target"),
        *(wb.document.TableColumn(head, align="right") for head in ("bits compared", "bits that differ")),
        wb.document.TableColumn("first mismatch"),
    )
    notes = (
        f"The operations are sum, subtraction, product, reciprocal and root, of {PAIRS:,} pairs of operands that are "
        f"up to {FARTHEST} binary digits apart. In half of the pairs, one operand is a power of two. A law computes "
        "the bits of the reference implementation only where each operation is rounded to the nearest number.",
    )
    caption = "Single operations in double precision on each target, compared with IEEE 754."
    return wb.document.ReportTable("operations", caption, columns, tuple(rows), notes)
