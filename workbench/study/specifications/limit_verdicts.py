"""Verdicts on limits: the figure with its bounds, its distance from the limit, the evidence, and a witness."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Literal

from workbench.core.claim import Claim
from workbench.core.validation.notebook_display import table_to_html
from workbench.core.validation.refusals import known_name
from workbench.core.validation.signatures import check_arguments
from workbench.proofs.claim_ledger import ClaimEntry, ClaimLedger, Ruling
from workbench.study.document.phrases_and_tables import Cell, Code, ReportTable, Strong, TableColumn, ValueWithError
from workbench.study.specifications.limits import FigureKind, FigureLimit
from workbench.study.specifications.point_figures import LoopFigure

AtPoint = Literal["holds", "fails", "undecided"]
OverBox = Literal["proved", "refuted", "not refuted"]
VerdictKind = Literal[AtPoint, OverBox, "not checkable"]
GOOD = ("holds", "proved", "not refuted")
SOURCE = "the specification"


@dataclass(frozen=True)
class LimitVerdict:
    """The verdict on one limit, at a point or over a box of parameters.

    At a point a limit `holds` or `fails` if all values between the bounds of the figure do, else it is `undecided`.
    Over a box it is `proved`, `refuted` by the draw `witness`, or `not refuted` in so many `draws`; the figure is that
    of the worst draw that was found. It is `undecided` where the bounds of that figure lie on both sides of the limit,
    and `not checkable` where there is no figure; the evidence has the reason. `arguments` are those of `linear_loop`
    beside the values, as they were written.
    """

    limit: FigureLimit
    kind: VerdictKind
    figure: LoopFigure
    evidence: str
    witness: Mapping[str, float] = field(default_factory=dict)
    draws: int = 0
    arguments: str = ""

    @property
    def name(self) -> str:
        """The name of the figure, as `Specification` has it."""
        return self.limit.kind.name

    @property
    def margin(self) -> float:
        """The distance of the figure from its limit that is certain, negative beyond it; NaN without a figure."""
        return math.nan if self.figure.value is None else self.limit.margin_of(self.figure.value)

    @property
    def verdict(self) -> str:
        """The verdict in words."""
        if self.kind == "proved":
            return "proved over the box"
        if self.kind == "refuted":
            return "refuted by a draw"
        if self.kind == "not refuted":
            return f"holds at {self.draws:,} draws"
        return f"{self.kind} at the worst of {self.draws:,} draws" if self.draws else self.kind

    @property
    def witness_line(self) -> str:
        """The line of Python that gives the loop at the witness, for the `loop` in question."""
        values = f", values={dict(self.witness)}" if self.witness else ""
        return f"linear_loop(loop{values}{self.arguments})"

    @property
    def ruling(self) -> Ruling:
        """The same as a ruling of a ledger of claims."""
        if self.kind in ("proved", "holds"):
            return Ruling("proved", self.evidence)
        if self.kind in ("refuted", "fails"):
            return Ruling("refuted", self.evidence, witness=self.witness_line)
        if self.kind == "not refuted":
            return Ruling("not refuted", self.evidence, samples=self.draws)
        return Ruling("not checkable", self.evidence)

    def __str__(self) -> str:
        where = f", at {draw_words(self.witness)}" if self.witness else ""
        margin = "" if self.figure.value is None else f", margin {self.margin:.4g}"
        return f"{self.limit.words}: {self.verdict}{margin}{where}. {self.evidence}".strip()


@dataclass(frozen=True)
class SpecificationVerdicts:
    """The verdicts on a specification, in the order of its limits; `box` says over which parameters, if any vary."""

    verdicts: tuple[LimitVerdict, ...]
    subject: str
    box: str = ""

    def __iter__(self) -> Iterator[LimitVerdict]:
        return iter(self.verdicts)

    def __len__(self) -> int:
        return len(self.verdicts)

    def __getitem__(self, name: str) -> LimitVerdict:
        names = [one.name for one in self.verdicts]
        return self.verdicts[names.index(known_name(name, names, "limits of this specification"))]

    @property
    def holds(self) -> bool:
        """True if no limit fails, is refuted, or stays without an answer; a search alone proves none."""
        return all(one.kind in GOOD for one in self.verdicts)

    @property
    def is_proved(self) -> bool:
        """True if each limit is proved: at a point by bounds that hold, over a box by a proof."""
        return all(one.kind in ("holds", "proved") and one.figure.is_proved for one in self.verdicts)

    @property
    def ledger(self) -> ClaimLedger:
        """The verdicts as a ledger of claims."""
        return ClaimLedger(
            tuple(
                ClaimEntry(Claim(one.limit.words, f"{one.limit.kind.words}: {one.limit.words}.", SOURCE), one.ruling)
                for one in self.verdicts
            )
        )

    @check_arguments
    def table(self, name: str = "specification", caption: str = "") -> ReportTable:
        """The verdicts as a table, a block of a section of a report."""
        columns = (
            TableColumn("limit"),
            TableColumn("verdict"),
            TableColumn("figure"),
            TableColumn("margin"),
            TableColumn("evidence and witness"),
        )
        where = f" over {self.box}" if self.box else ""
        rows = tuple(_row(one) for one in self.verdicts)
        return ReportTable(name, caption or f"The specification of {self.subject}{where}.", columns, rows)

    def __str__(self) -> str:
        return "\n".join(map(str, self.verdicts))

    def __repr__(self) -> str:
        words = ", ".join(f"{one.name} {one.verdict}" for one in self.verdicts)
        return f"<verdicts on {self.subject}: {words}>"

    def _repr_html_(self) -> str:
        rows = [(one.limit.words, one.verdict, _text(one), one.evidence) for one in self.verdicts]
        return table_to_html(f"Specification of {self.subject}", ("limit", "verdict", "figure", "evidence"), rows)


def figure_clause(kind: FigureKind, figure: LoopFigure) -> str:
    """The figure as a clause, with the power of ten within which it is known: 'the peak of S is 1.08 within 1e-15'."""
    value = figure.value
    if value is None:
        return f"the {kind.words} is not known"
    subject = f"the {kind.words} {figure.of}".rstrip()
    if math.isinf(value.value):
        return f"{subject} is infinite"
    bounds = "" if figure.is_proved else " by estimated bounds"
    known_to = f" within 1e{math.ceil(math.log10(value.error))}" if 0 < value.error < math.inf else ""
    return f"{subject} is {value.value:.6g}{f' {kind.unit}' if kind.unit else ''}{known_to}{bounds}"


def draw_words(values: Mapping[str, float]) -> str:
    """The numbers of a draw: 'plant.m = 0.8, plant.k = 1.2'."""
    return ", ".join(f"{name} = {value:.6g}" for name, value in values.items())


def _row(one: LimitVerdict) -> tuple[Cell, ...]:
    value = one.figure.value
    stressed = Strong(one.verdict) if one.kind in ("proved", "holds", "fails", "refuted") else one.verdict
    finite = value is not None and math.isfinite(value.value) and math.isfinite(value.error)
    shown: Cell = ValueWithError(value.value, value.error) if value is not None and finite else _text(one) or None
    margin: Cell = f"{one.margin:.4g}" if value is not None else None
    witness = (" ", Code(one.witness_line)) if one.witness else ()
    return one.limit.words, stressed, shown, margin, (one.evidence, *witness)


def _text(one: LimitVerdict) -> str:
    value = one.figure.value
    return "" if value is None else f"{value.value:.6g}"
