"""The ledger of claims: each claim with its source, its hypotheses, and a verdict with evidence and witness."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, get_args

from workbench.core.claim import Claim
from workbench.validation.refusals import described, known, require
from workbench.validation.signatures import door

# The verdict on a claim. A finite simulation can refute one, and never proves one.
Broken = Literal["refuted", "does not hold under"]  # the kinds that stand on a witness
Kind = Literal["proved", Broken, "not refuted", "not checkable as published", "ill-posed", "not checkable"]
ALL, BROKEN = get_args(Kind), get_args(Broken)
OPEN, UNDER, UNSTATED = ("not refuted",), ("does not hold under",), ("not checkable as published",)
# Of each field of a finding: the kinds that ask for it, those that may have it, and the rule in words.
FIELDS: Mapping[str, tuple[Sequence[str], Sequence[str], str]] = {
    "evidence": (ALL, ALL, "must say on what the verdict rests"),
    "witness": (BROKEN, ALL, "needs a line of Python with which anyone can see a broken claim fail"),
    "samples": (OPEN, OPEN, "counts what a claim was 'not refuted' in, and belongs to that verdict alone"),
    "under": (
        UNDER,
        UNDER + OPEN,
        "names the condition of 'does not hold under', which needs one, or of 'not refuted'",
    ),
    "unstated": (UNSTATED, UNSTATED, "names what the source does not state, for 'not checkable as published' alone"),
}


@dataclass(frozen=True)
@door
class Finding:
    """The outcome of a check, whose fields are those that belong to its kind.

    `proved` by exact or interval arithmetic; `refuted` by a `witness`, a line of Python that shows it again; `does not
    hold under` a named condition beside the claim's own hypotheses, by a witness; `not refuted` in so many `samples`;
    `not checkable as published`, because something is `unstated`; `ill-posed` or `not checkable`. `evidence` is the
    reason with its numbers and errors, in a sentence; `kept` names the hypotheses that the witness keeps at every step.
    """

    kind: Kind
    evidence: str
    witness: str = ""
    samples: int = 0
    under: str = ""
    unstated: str = ""
    kept: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for field, (asked, allowed, rule) in FIELDS.items():
            value = getattr(self, field)
            if (self.kind in asked and not value) or (value and self.kind not in allowed):
                raise ValueError(f"`Finding({field}=...)` {rule}; got {described(value)} with {self.kind!r}.")

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
    """A claim with the finding of its check, whose witness against it must keep every hypothesis with a margin."""

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
    """Claims with their findings, in order, each once; a claim's hypotheses are found among them by name."""

    lines: tuple[Line, ...]

    def __post_init__(self) -> None:
        names = [line.claim.name for line in self.lines]
        if twice := sorted({name for name in names if names.count(name) > 1}):
            raise ValueError(f"`Ledger(lines)` holds each claim once; {twice} came more than once.")

    @staticmethod
    @door
    def of(checks: Sequence[tuple[Claim, Check]]) -> Ledger:
        """Check each claim, in order."""
        findings = (require(f"The check of '{claim.name}'", check(), Finding) for claim, check in checks)
        return Ledger(tuple(Line(claim, finding) for (claim, _), finding in zip(checks, findings, strict=True)))

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
        """The number of claims that have that verdict."""
        return sum(line.finding.kind == kind for line in self.lines)

    @door
    def hypotheses(self, name: str) -> tuple[tuple[str, Kind | None], ...]:
        """The claims that a claim rests on, directly or not, each with its verdict: None if not in the ledger."""
        kinds = {line.claim.name: line.finding.kind for line in self}
        return tuple({below.name: kinds.get(below.name) for below in _below(self[name].claim)}.items())

    @door
    def fallen(self, name: str) -> tuple[str, ...]:
        """The hypotheses of a claim that do not hold, so that a proof of the claim does not apply."""
        return tuple(hypothesis for hypothesis, kind in self.hypotheses(name) if kind in BROKEN)


def _below(claim: Claim) -> Iterator[Claim]:
    for hypothesis in claim.hypotheses:
        yield hypothesis
        yield from _below(hypothesis)
