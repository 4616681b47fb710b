"""The ledger of claims: each claim with its source, its hypotheses, and a verdict with evidence and witness."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

from workbench.core.claim import Claim
from workbench.validation.doors import door
from workbench.validation.words import described, known, require

# How it stands with a claim. A finite simulation can refute one, and never proves one.
Kind = Literal["proved", "refuted", "not refuted", "not checkable"]


@dataclass(frozen=True)
@door
class Finding:
    """What a check came to.

    Attributes
    ----------
    kind
        `proved` by exact or interval arithmetic, `refuted` by a witness, `not refuted` in so many `samples`, or
        `not checkable`, in which case the evidence says why.
    evidence
        What was seen or derived, with its numbers and their errors, in a sentence.
    witness
        A line of Python that shows it again.
    samples
        How many states or runs were looked at, where that is the evidence.

    Raises
    ------
    ValueError
        If there is no evidence, a refutation has no witness, or a claim is not refuted in no samples.
    """

    kind: Kind
    evidence: str
    witness: str = ""
    samples: int = 0

    def __post_init__(self) -> None:
        if not self.evidence:
            raise ValueError(f"`Finding('{self.kind}', evidence)` must say on what the verdict rests; got nothing.")
        if self.kind == "refuted" and not self.witness:
            raise ValueError(
                "`Finding('refuted', witness=...)` needs a line of Python with which anyone can see the claim fail; "
                f"got none for: {described(self.evidence)}"
            )
        if (self.kind == "not refuted") != (self.samples > 0):
            raise ValueError(
                "`Finding(samples=...)` counts what a claim was not refuted in, and belongs to that verdict alone; got "
                f"{self.samples} with {self.kind!r}."
            )

    @property
    def verdict(self) -> str:
        """The verdict in words, with the number of samples where it rests on them."""
        return f"not refuted in {self.samples:,} samples" if self.kind == "not refuted" else self.kind


Check = Callable[[], Finding]


@dataclass(frozen=True)
@door
class Line:
    """A claim and what became of it."""

    claim: Claim
    finding: Finding


@dataclass(frozen=True)
@door
class Ledger:
    """Claims with their findings, in order; a claim's hypotheses are found among them by name.

    Raises
    ------
    ValueError
        If two lines bear one name.
    """

    lines: tuple[Line, ...]

    def __post_init__(self) -> None:
        names = [line.claim.name for line in self.lines]
        if twice := sorted({name for name in names if names.count(name) > 1}):
            raise ValueError(f"`Ledger(lines)` holds each claim once; {twice} came more than once.")

    @staticmethod
    @door
    def of(checks: Sequence[tuple[Claim, Check]]) -> Ledger:
        """Check each claim, in order."""
        lines = []
        for claim, check in checks:
            finding = require(f"The check of '{claim.name}'", check(), Finding)
            lines.append(Line(claim, finding))
        return Ledger(tuple(lines))

    def __iter__(self) -> Iterator[Line]:
        return iter(self.lines)

    def __len__(self) -> int:
        return len(self.lines)

    def __getitem__(self, name: str) -> Line:
        return self.lines[self.names.index(known(name, self.names, "claims of this ledger"))]

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the claims."""
        return tuple(line.claim.name for line in self.lines)

    @door
    def count(self, kind: Kind) -> int:
        """How many claims have that verdict."""
        return sum(line.finding.kind == kind for line in self.lines)

    @door
    def hypotheses(self, name: str) -> tuple[tuple[str, Kind | None], ...]:
        """What a claim rests on, directly or not, each with its verdict: None for what is not in the ledger."""
        found: dict[str, Kind | None] = {}
        for hypothesis in _below(self[name].claim):
            found[hypothesis.name] = self[hypothesis.name].finding.kind if hypothesis.name in self.names else None
        return tuple(found.items())

    @door
    def fallen(self, name: str) -> tuple[str, ...]:
        """The refuted hypotheses of a claim: beside one of them, a proof of it says nothing of the case."""
        return tuple(hypothesis for hypothesis, kind in self.hypotheses(name) if kind == "refuted")


def _below(claim: Claim) -> Iterator[Claim]:
    for hypothesis in claim.hypotheses:
        yield hypothesis
        yield from _below(hypothesis)
