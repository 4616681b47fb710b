"""The ledger of claims: each claim with its source, its hypotheses, and a verdict with evidence and witness."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

from workbench.core.claim import Claim
from workbench.validation.refusals import described, known, require
from workbench.validation.signatures import door

# How it stands with a claim. A finite simulation can refute one, and never proves one.
Kind = Literal[
    "proved",
    "refuted",
    "does not hold under",
    "not refuted",
    "not checkable as published",
    "ill-posed",
    "not checkable",
]
BROKEN = ("refuted", "does not hold under")  # the kinds that stand on a witness
CONDITIONAL = ("does not hold under", "not refuted")


@dataclass(frozen=True)
@door
class Finding:
    """The outcome of a check.

    Attributes
    ----------
    kind
        `proved` by exact or interval arithmetic; `refuted` by a witness; `does not hold under` a named condition, by
        a witness; `not refuted` in so many samples; `not checkable as published`, because something is unstated;
        `ill-posed`, in which case the evidence says why there is nothing to check; `not checkable`, in which case
        the evidence says why the check could not decide.
    evidence
        The observation or derivation, with its numbers and their errors, in a sentence.
    witness
        A line of Python that shows it again.
    samples
        The number of states or runs in which a claim was not refuted.
    under
        The condition beside the claim's own hypotheses: a choice of numbers, a repair.
    unstated
        The quantities whose values a check would need and the source does not give.
    kept
        The names of the hypotheses with a margin that the witness keeps at every step.

    Raises
    ------
    ValueError
        If a text, a witness or a number that belongs to the kind is missing, or one that does not is given.
    """

    kind: Kind
    evidence: str
    witness: str = ""
    samples: int = 0
    under: str = ""
    unstated: str = ""
    kept: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not self.evidence:
            raise ValueError(f"`Finding('{self.kind}', evidence)` must say on what the verdict rests; got nothing.")
        if self.kind in BROKEN and not self.witness:
            raise ValueError(
                f"`Finding('{self.kind}', witness=...)` needs a line of Python with which anyone can see the claim "
                f"fail; got none for: {described(self.evidence)}"
            )
        if (self.kind == "not refuted") != (self.samples > 0):
            raise ValueError(
                "`Finding(samples=...)` counts what a claim was not refuted in, and belongs to that verdict alone; got "
                f"{self.samples} with {self.kind!r}."
            )
        if (self.kind == "does not hold under" and not self.under) or (self.under and self.kind not in CONDITIONAL):
            raise ValueError(
                "`Finding(under=...)` names the condition of 'does not hold under', which needs one, or of "
                f"'not refuted'; got {described(self.under)} with {self.kind!r}."
            )
        if (self.kind == "not checkable as published") != bool(self.unstated):
            raise ValueError(
                "`Finding(unstated=...)` names what the source does not state, which 'not checkable as published' "
                f"needs and no other verdict has; got {described(self.unstated)} with {self.kind!r}."
            )

    @property
    def verdict(self) -> str:
        """The verdict in words, with the number of samples or the condition where it rests on them."""
        if self.kind == "does not hold under":
            return f"{self.kind}: {self.under}"
        under = f", under: {self.under}" if self.under else ""
        return f"not refuted in {self.samples:,} samples{under}" if self.kind == "not refuted" else self.kind


Check = Callable[[], Finding]


@dataclass(frozen=True)
@door
class Line:
    """A claim with the finding of its check.

    Raises
    ------
    ValueError
        If the witness of a claim that does not hold was not seen to keep a hypothesis that has a margin.
    """

    claim: Claim
    finding: Finding

    def __post_init__(self) -> None:
        open_ = [below.name for below in _below(self.claim) if below.margin and below.name not in self.finding.kept]
        if self.finding.kind in BROKEN and open_:
            raise ValueError(
                f"`Line(finding=...)`: a witness against '{self.claim.name}' must keep every hypothesis of the claim, "
                f"else it says nothing of it; {open_} have margins and are not among those it was seen to keep, "
                f"{list(self.finding.kept)}. Measure them along its run, and name them in `Finding(kept=...)`."
            )


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
        """The hypotheses of a claim that do not hold: beside one of them, a proof of it says nothing of the case."""
        return tuple(hypothesis for hypothesis, kind in self.hypotheses(name) if kind in BROKEN)


def _below(claim: Claim) -> Iterator[Claim]:
    for hypothesis in claim.hypotheses:
        yield hypothesis
        yield from _below(hypothesis)
