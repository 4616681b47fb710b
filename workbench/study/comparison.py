"""Laws side by side: tables of metrics, and a paper's rankings held against ours."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

from workbench.metrics import AbstractMetric
from workbench.study.document.document import Cell, Column, Diverged, Emphasis, Measured, Table
from workbench.study.study import Outcome
from workbench.validation.refusals import described, finite, nearest
from workbench.validation.signatures import door


@door
def side_by_side(
    name: str,
    caption: str,
    outcomes: Sequence[Outcome],
    metrics: Sequence[str] = (),
    joint: int = 0,
    notes: Sequence[str] = (),
    margin: float = 0.0,
) -> Table:
    """One row a law, one column a metric, for one number of each; in bold what is below all others, as `order` judges.

    The metrics are all that were taken where none is named. Where a metric does not exist in a case the cell is empty.

    Raises
    ------
    ValueError
        If there is no outcome.
    LookupError
        If a metric exists in no case, or the number is not there; the message names those that do.

    Examples
    --------
    >>> from workbench.study.runner import run
    >>> motor = wb.Run(wb.open_loop(wb.DCMotor(), "motor"), (wb.effort("omega"),), until=1.0, h=1e-2)
    >>> study = wb.Study("s", "T", "Q?", "M.", lambda results: [], cases=(wb.Case("speed", "no law", motor),))
    >>> [column.header for column in wb.side_by_side("laws", "All laws", run(study).outcomes).columns]
    ['law', 'effort of omega']
    """
    if not outcomes:
        raise ValueError(f"`side_by_side('{name}', outcomes=...)` needs at least one outcome; got none.")
    finite("side_by_side(margin=...)", margin, low=0)
    known = {m: score.metric for o in reversed(outcomes) for m, score in o.measurement.scores.items()}
    for m in metrics:
        if m not in known:
            there = f" It knows: {', '.join(known) or 'none'}."
            raise LookupError(
                f"`side_by_side('{name}', ...)` knows no metric {described(m)}.{nearest(m, known)}{there}"
            )
    metrics = metrics or tuple(known)
    best = {m: _best(outcomes, m, joint, margin) for m in metrics}
    about = tuple(f"{m}: {known[m].about}." for m in metrics)
    rows = tuple((o.label, *(_cell(o, m, joint, bold=best[m] is o) for m in metrics)) for o in outcomes)
    remarks = _remarks(outcomes)
    columns = (Column("law"), *(Column(m, unit=_unit(known[m], joint), align="right") for m in metrics))
    return Table(name, caption, columns, rows, (" ".join(about), *notes, *remarks))


def _unit(metric: AbstractMetric, place: int) -> str:
    return metric.units[place] if place < len(metric.units) else metric.unit


def _cell(outcome: Outcome, metric: str, joint: int, *, bold: bool) -> Cell:
    if metric not in outcome.measurement.scores:
        return None
    if outcome.diverged_at is not None:
        return Diverged(outcome.diverged_at)
    value, error = outcome.score(metric, joint)
    if value == float("inf"):
        return "never"
    if value != value or error != error or error == float("inf"):
        return "no error estimate"
    return Emphasis(Measured(value, error)) if bold else Measured(value, error)


def _best(outcomes: Sequence[Outcome], metric: str, joint: int, margin: float) -> Outcome | None:
    """The outcome that is below every other; None if there is none."""
    ran = [o for o in outcomes if o.diverged_at is None and metric in o.measurement.scores]
    finite = [o for o in ran if o.score(metric, joint)[0] < float("inf")]
    for a in finite:
        if all(a is b or order(a.score(metric, joint), b.score(metric, joint), margin) == "below" for b in finite):
            return a
    return None


@door
def order(a: tuple[float, float], b: tuple[float, float], margin: float = 0.0) -> str:
    """Whether value a lies "below" or "above" value b, or is "undecided".

    That is where the gap is within the sum of both errors, or within `margin` of the smaller value.
    """
    gap, error = b[0] - a[0], a[1] + b[1]
    if not abs(gap) > max(error, margin * min(abs(a[0]), abs(b[0]))):
        return "undecided"
    return "below" if gap > 0 else "above"


@dataclass(frozen=True)
@door
class Published:
    """One column of a published table: a law's name to its printed value, for one metric and joint."""

    where: str
    metric: str
    joint: int
    values: Mapping[str, float]
    digits: int


@door
def against_published(name: str, caption: str, published: Published, outcomes: Mapping[str, Outcome]) -> Table:
    """Printed / ours / difference, one row a law; a printed zero has no percent.

    Raises
    ------
    LookupError
        If a printed law has no outcome; the message names the nearest.
    """
    _check_laws("against_published", published, outcomes)
    scores = (outcomes[law].measurement.scores.get(published.metric) for law in published.values)
    unit = next((_unit(score.metric, published.joint) for score in scores if score is not None), "")
    rows: list[tuple[Cell, ...]] = []
    for law, printed in published.values.items():
        outcome = outcomes[law]
        if outcome.diverged_at is not None:
            rows.append((outcome.label, f"{printed:.{published.digits}f}", Diverged(outcome.diverged_at), None, None))
            continue
        value, error = outcome.score(published.metric, published.joint)
        rows.append(
            (
                outcome.label,
                f"{printed:.{published.digits}f}",
                Measured(value, error),
                f"{value - printed:+.{published.digits}f}",
                f"{100 * (value - printed) / printed:+.1f}" if printed else None,
            )
        )
    columns = (
        Column("law"),
        Column("printed", unit, "right"),
        Column("ours", unit, "right"),
        Column("difference", unit, "right"),
        Column("difference", "%", "right"),
    )
    return Table(name, caption, columns, tuple(rows), _remarks(outcomes.values()))


def _check_laws(call: str, published: Published, outcomes: Mapping[str, Outcome]) -> None:
    for law in published.values:
        if law not in outcomes:
            raise LookupError(
                f"`{call}(...)` needs an outcome for each law of {published.where}; there is none for '{law}'."
                f"{nearest(law, outcomes)}"
            )


def _remarks(outcomes: Iterable[Outcome]) -> tuple[str, ...]:
    """What must stand beside a law's name, one note for all laws of which the same must be said."""
    alike: dict[str, list[str]] = {}
    for outcome in outcomes:
        if outcome.notes:
            alike.setdefault("; ".join(outcome.notes), []).append(outcome.label)
    return tuple(f"{', '.join(labels)}: {said}." for said, labels in alike.items())


@dataclass(frozen=True)
@door
class Ranking:
    """How one published ranking of laws fares here: pairs that hold, that are turned round, that stay open."""

    published: Published
    holds: tuple[tuple[str, str], ...]
    fails: tuple[tuple[str, str], ...]
    undecided: tuple[tuple[str, str], ...]
    printed_order: tuple[str, ...]
    our_order: tuple[str, ...]

    @door
    def sentence(self, winner: str) -> str:
        """In plain words, with the pairs that concern `winner` named."""
        pairs = len(self.holds) + len(self.fails) + len(self.undecided)
        lost = [b for a, b in self.fails if a == winner]
        against = (
            f" {winner} is printed below {_listed(lost)}, and is above here."
            if lost
            else f" All printed advantages of {winner} hold here or are too close to call."
        )
        return (
            f"{self.published.where}: of {pairs} printed pairs {len(self.holds)} hold, "
            f"{len(self.fails)} are turned round, {len(self.undecided)} are too close to call.{against}"
        )


@door
def ranking(published: Published, outcomes: Mapping[str, Outcome], margin: float = 0.0) -> Ranking:
    """Each pair of laws in its printed order, judged by our values; see `order` for when it stays open."""
    _check_laws("ranking", published, outcomes)
    scores = {law: _score(outcomes[law], published) for law in published.values}
    laws = sorted(published.values, key=lambda law: published.values[law])
    judged: dict[str, list[tuple[str, str]]] = {"below": [], "above": [], "undecided": []}
    for a, b in combinations(laws, 2):
        judged[order(scores[a], scores[b], margin)].append((a, b))
    ours = sorted(laws, key=lambda law: scores[law][0])
    return Ranking(
        published,
        tuple(judged["below"]),
        tuple(judged["above"]),
        tuple(judged["undecided"]),
        tuple(laws),
        tuple(ours),
    )


def _score(outcome: Outcome, published: Published) -> tuple[float, float]:
    """A diverged run is worse than any other."""
    if outcome.diverged_at is not None:
        return float("inf"), 0.0
    return outcome.score(published.metric, published.joint)


def _listed(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
