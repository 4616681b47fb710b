"""The single operations of each target, on operands where a rounding is hard: are they those of IEEE 754?"""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np

from studies.b4_handover.loops import SEED, handed
from workbench.core import Entry, Layout, SampledLaw
from workbench.handover.c99.c_code import c_code
from workbench.handover.memory_digest import BASIS
from workbench.handover.recording import record
from workbench.handover.replays import TargetResult, compare
from workbench.handover.targets import TARGETS
from workbench.study import Results, Verdict, Work
from workbench.validation.refusals import Array

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


def operations_finding(results: Results) -> Verdict:
    """The targets whose operations are rounded as IEEE 754 says."""
    ran = {one.target: one for one in results.work("operations") if one.ran}
    other = {name: one for name, one in ran.items() if not one.equal}
    named = "; ".join(f"{name}: {one.differing:,} bits, first in {one.first}" for name, one in other.items())
    return Verdict(
        "fails" if other else "holds" if ran else "open",
        f"The single operations of {', '.join(other)} are not those of IEEE 754."
        if other
        else f"The single operations of all {len(ran)} targets that ran are those of IEEE 754.",
        f"{named + '. ' if named else ''}A law can have the bits of the portable arithmetic only where its sums, "
        "products, reciprocals and roots are rounded to the nearest number.",
        estimand=f"Bits of {', '.join(NAMES)} over {PAIRS:,} pairs of operands, half of them with a power of two, up "
        f"to {FARTHEST} binary digits apart.",
        given="Double precision, in software where a processor has none: then the compiler's library rounds.",
        reversal="Another library for double precision in software, which rounds every operation.",
    )
