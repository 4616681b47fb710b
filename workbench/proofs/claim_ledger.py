"""The ledger of claims: each claim with its source, its hypotheses, and a verdict with evidence and witness."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, get_args

from workbench.core.claim import Claim
from workbench.core.validation.refusals import describe, known_name, require
from workbench.core.validation.signatures import check_arguments

# The verdict on a claim. A finite simulation can refute one, and never proves one.
BreakingKind = Literal["refuted", "does not hold under"]
WitnessKind = Literal[BreakingKind, "depends on"]  # the kinds that stand on a witness
Kind = Literal["proved", WitnessKind, "not refuted", "not checkable as published", "ill-posed", "not checkable"]
ALL_KINDS, BREAKING_KINDS, WITNESS_KINDS = get_args(Kind), get_args(BreakingKind), get_args(WitnessKind)
OPEN_KINDS, CONDITIONAL_KINDS, UNSTATED_KINDS = (
    ("not refuted",),
    ("does not hold under",),
    ("not checkable as published",),
)
DEPENDENT_KINDS = ("depends on",)
# Of each field of a ruling: the kinds that ask for it, those that may have it, and the rule in words.
FIELDS: Mapping[str, tuple[Sequence[str], Sequence[str], str]] = {
    "evidence": (ALL_KINDS, ALL_KINDS, "must say on what the verdict rests"),
    "witness": (WITNESS_KINDS, ALL_KINDS, "needs a line of Python with which anyone can see a broken claim fail"),
    "samples": (OPEN_KINDS, OPEN_KINDS, "counts what a claim was 'not refuted' in, and belongs to that verdict alone"),
    "under": (
        CONDITIONAL_KINDS,
        CONDITIONAL_KINDS + OPEN_KINDS,
        "names the condition of 'does not hold under', which needs one, or of 'not refuted'",
    ),
    "unstated_numbers": (
        UNSTATED_KINDS,
        UNSTATED_KINDS,
        "names what the source does not state, for 'not checkable as published' alone",
    ),
    "on": (
        DEPENDENT_KINDS,
        DEPENDENT_KINDS,
        "names the numbers on which the truth of a claim depends, for 'depends on' alone",
    ),
}


@dataclass(frozen=True)
@check_arguments
class Ruling:
    """The outcome of a check: its `kind`, the `evidence`, and the fields that belong to the kind.

    The kinds are: `proved` by exact or interval arithmetic; `refuted` by a `witness`, a line of Python that shows it
    again; `does not hold under` a condition `under` that the source does not state, by a witness; `depends on` numbers
    `on` that the source leaves open, by a witness that shows both answers; `not refuted` in a number of `samples`; `not
    checkable as published`, because of `unstated_numbers`; `ill-posed`; and `not checkable`. `evidence` is the reason
    with its numbers and errors, in a sentence. `kept_hypotheses` names the hypotheses that the witness keeps at every
    step.
    """

    kind: Kind
    evidence: str
    witness: str = ""
    samples: int = 0
    under: str = ""
    unstated_numbers: str = ""
    on: str = ""
    kept_hypotheses: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for field, (asked, allowed, rule) in FIELDS.items():
            value = getattr(self, field)
            if (self.kind in asked and not value) or (value and self.kind not in allowed):
                raise ValueError(f"`Ruling({field}=...)` {rule}; got {describe(value)} with {self.kind!r}.")

    @property
    def verdict(self) -> str:
        """The verdict in words, with the number of samples or the condition where it rests on them."""
        if self.kind == "does not hold under":
            return f"{self.kind}: {self.under}"
        if self.kind == "depends on":
            return f"{self.kind} {self.on}"
        under = f", under: {self.under}" if self.under else ""
        return f"not refuted in {self.samples:,} samples{under}" if self.kind == "not refuted" else self.kind


Check = Callable[[], Ruling]


@dataclass(frozen=True)
@check_arguments
class Quantifier:
    """A range over which a claim is judged, in words, and who chose it: the `source` of the claim, or its `reader`.

    `within` is True if the reader's range lies within the source's: whatever fails in it fails in the source's range,
    too.

    Examples
    --------
    >>> wb.proofs.Quantifier("all gains up to 10", "reader").is_stronger
    True
    """

    words: str
    chosen_by: Literal["source", "reader"]
    within: bool = False

    @property
    def is_stronger(self) -> bool:
        """True if the reader asks for more than the source does."""
        return self.chosen_by == "reader" and not self.within


@dataclass(frozen=True)
@check_arguments
class ClaimEntry:
    """A claim with the ruling of its check, the `quote` of its source, and the `quantifiers`: ranges of the judgement.

    A witness against the claim must keep every hypothesis with a margin. A claim is not `refuted` over a range that its
    reader chose, unless this range lies within that of the source; otherwise it `depends on` numbers, or `does not hold
    under` a condition.
    """

    claim: Claim
    ruling: Ruling
    quote: str = ""
    quantifiers: tuple[Quantifier, ...] = ()

    def __post_init__(self) -> None:
        open_ = [
            below.name for below in _below(self.claim) if below.margin and below.name not in self.ruling.kept_hypotheses
        ]
        if self.ruling.kind in WITNESS_KINDS and open_:
            raise ValueError(
                f"`ClaimEntry(ruling=...)`: a witness against '{self.claim.name}' must keep every hypothesis of the "
                f"claim, else it says nothing of it; {open_} have margins and are not among those it was seen to "
                f"keep, {list(self.ruling.kept_hypotheses)}. Measure them along its run, and name them in "
                "`Ruling(kept_hypotheses=...)`."
            )
        stronger = [one.words for one in self.quantifiers if one.is_stronger]
        if self.ruling.kind == "refuted" and stronger:
            raise ValueError(
                f"`ClaimEntry(quantifiers=...)`: '{self.claim.name}' is refuted only if it fails over the range of its "
                f"source; {stronger} are the reader's. Name them in the kind 'depends on' or 'does not hold under'."
            )


@dataclass(frozen=True)
@check_arguments
class ClaimLedger:
    """Claims with their rulings, in order, each once; a claim names its hypotheses among them."""

    lines: tuple[ClaimEntry, ...]

    def __post_init__(self) -> None:
        names = [line.claim.name for line in self.lines]
        if twice := sorted({name for name in names if names.count(name) > 1}):
            raise ValueError(f"`ClaimLedger(lines)` holds each claim once; {twice} came more than once.")

    @staticmethod
    @check_arguments
    def of(checks: Sequence[tuple[Claim, Check]]) -> ClaimLedger:
        """Check each claim, in order."""
        rulings = (require(f"The check of '{claim.name}'", check(), Ruling) for claim, check in checks)
        return ClaimLedger(tuple(ClaimEntry(claim, ruling) for (claim, _), ruling in zip(checks, rulings, strict=True)))

    def __iter__(self) -> Iterator[ClaimEntry]:
        return iter(self.lines)

    def __len__(self) -> int:
        return len(self.lines)

    def __getitem__(self, name: str) -> ClaimEntry:
        return self.lines[self.names.index(known_name(name, self.names, "claims of this ledger"))]

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the claims."""
        return tuple(line.claim.name for line in self.lines)

    @check_arguments
    def count(self, kind: Kind) -> int:
        """The number of claims that have that verdict."""
        return sum(line.ruling.kind == kind for line in self.lines)

    @check_arguments
    def hypotheses(self, name: str) -> tuple[tuple[str, Kind | None], ...]:
        """The claims that a claim rests on, directly or not, each with its verdict: None if not in the ledger."""
        kinds = {line.claim.name: line.ruling.kind for line in self}
        return tuple({below.name: kinds.get(below.name) for below in _below(self[name].claim)}.items())

    @check_arguments
    def broken_hypotheses(self, name: str) -> tuple[str, ...]:
        """The hypotheses of a claim that do not hold, so that a proof of the claim does not apply."""
        return tuple(hypothesis for hypothesis, kind in self.hypotheses(name) if kind in BREAKING_KINDS)


def _below(claim: Claim) -> Iterator[Claim]:
    for hypothesis in claim.hypotheses:
        yield hypothesis
        yield from _below(hypothesis)
