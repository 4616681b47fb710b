"""Tables of laws: metrics side by side, a paper's numbers and rankings against ours, and the information of each."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from string import ascii_uppercase

from workbench.core import Roles, information_classes
from workbench.core.validation.refusals import describe, finite, known_name, nearest, refusal, whole
from workbench.core.validation.signatures import check_arguments
from workbench.study.document.document import Cell, Phrase, ReportTable, TableColumn
from workbench.study.document.words import join_names
from workbench.study.evidence.bold_cells import bold_if, outcome_below_all
from workbench.study.evidence.value_order import order
from workbench.study.result_marks import cell, metric_source
from workbench.study.study import Outcome

HEADS = ("law", "group", "observer", "state", "model", "D", "memory")
NOTE = (
    "The table follows from the equations of each loop. Group: laws with the same letter have the same measurements, "
    "and the same model terms in law and observer taken together. State: how positions and velocities reach the law, "
    "one word if both do so alike. Read: used directly. Filtered: used only through a filter. Estimated: inferred "
    "from other signals. Model: the matrices M, C and G of the assumed arm that are used, in law / observer. D: the "
    "disturbance. Memory: the count of numbers that are remembered, in law / observer."
)
OF_PLANTS = "Model f: the equations of the assumed plant are used, in the observer."


@check_arguments
def side_by_side(
    name: str,
    caption: str,
    outcomes: Sequence[Outcome],
    metrics: Sequence[str] = (),
    signal: int | str = 0,
    notes: Sequence[str] = (),
    margin: float = 0.0,
) -> ReportTable:
    """A table with one row per law and one column per metric; a value that is surely below all others is bold.

    It is so if the gap exceeds the sum of both errors, and `margin` times the smaller value (`evidence.order`).
    `signal` is a label, or a number from 0. By default all metrics are shown. If a case does not have a metric, the
    cell is empty.

    Raises
    ------
    ValueError
        If there is no outcome.
    LookupError
        If a metric exists in no case, or has no such signal.

    Examples
    --------
    >>> from workbench.study.case_runs import run
    >>> motor = wb.Run(wb.open_loop(wb.DCMotor(), "motor"), (wb.effort("omega"),), until=1.0, h=1e-2)
    >>> study = wb.Study("s", "T", "Q?", "M.", lambda results: [], cases=(wb.Case("speed", "no law", motor),))
    >>> [column.header for column in wb.side_by_side("laws", "All laws", run(study).outcomes).columns]
    ['law', 'effort of omega']
    """
    if not outcomes:
        raise ValueError(f"`side_by_side('{name}', outcomes=...)` needs at least one outcome; got none.")
    finite("side_by_side(margin=...)", margin, low=0)
    taken = {m.name: m for o in reversed(outcomes) for m in o.measurement.metrics}
    for m in metrics:
        if m not in taken:
            there = f" It knows: {', '.join(taken) or 'none'}."
            raise LookupError(f"`side_by_side('{name}', ...)` knows no metric {describe(m)}.{nearest(m, taken)}{there}")
    metrics = metrics or tuple(taken)
    best = {m: outcome_below_all(outcomes, m, signal, margin) for m in metrics}
    about = tuple(f"{m}: {taken[m].about}." for m in metrics)
    rows = tuple((o.label, *(bold_if(best[m] is o, cell(o, m, signal)) for m in metrics)) for o in outcomes)
    columns = (TableColumn("law"), *(TableColumn(m, unit=_unit(outcomes, m, signal), align="right") for m in metrics))
    return ReportTable(name, caption, columns, rows, (" ".join(about), *notes))


def _unit(outcomes: Iterable[Outcome], metric: str, signal: int | str) -> str:
    """The unit of a metric where it was taken first; empty where it never was."""
    taken = (o for o in outcomes if metric in o.measurement.names)
    return next((metric_source(o, metric, signal).unit for o in taken), "")


def _score(outcome: Outcome, metric: str, signal: int | str) -> tuple[float, float]:
    return outcome.score(metric, signal).pair


@dataclass(frozen=True)
@check_arguments
class PublishedColumn:
    """One column of a published table `where`: printed `values` by law, with `digits` decimals, for one metric.

    Examples
    --------
    >>> wb.evidence.PublishedColumn("Table 1", "effort of omega", 0, {"no law": 0.0}, 2).digits
    2
    """

    where: str
    metric: str
    signal: int | str
    values: Mapping[str, float]
    digits: int


@check_arguments
def against_published(name: str, caption: str, column: PublishedColumn, outcomes: Mapping[str, Outcome]) -> ReportTable:
    """A table of printed value, our value and difference, one row per law, each of which needs an outcome.

    The difference from a printed zero has no percentage.

    Examples
    --------
    >>> motor = wb.Run(wb.open_loop(wb.DCMotor(), "motor"), (wb.effort("omega"),), until=1.0, h=1e-2)
    >>> study = wb.Study("s", "T", "Q?", "M.", lambda results: [], cases=(wb.Case("speed", "no law", motor),))
    >>> printed = wb.evidence.PublishedColumn("Table 1", "effort of omega", 0, {"no law": 0.0}, 2)
    >>> ours = {"no law": wb.study.run(study)["speed", "no law"]}
    >>> wb.evidence.against_published("table_1", "Printed and ours.", printed, ours).rows[0][0]
    'no law'
    """
    ours = {law: outcomes[known_name(law, outcomes, f"outcomes beside {column.where}")] for law in column.values}
    unit = _unit(ours.values(), column.metric, column.signal)
    rows: list[tuple[Cell, ...]] = []
    for law, printed in column.values.items():
        outcome, shown = ours[law], f"{printed:.{column.digits}f}"
        mine = cell(outcome, column.metric, column.signal)
        if outcome.diverged_at is not None:
            rows.append((outcome.label, shown, mine, None, None))
            continue
        value, _ = _score(outcome, column.metric, column.signal)
        off = f"{value - printed:+.{column.digits}f}"
        percent = f"{100 * (value - printed) / printed:+.1f}" if printed else None
        rows.append((outcome.label, shown, mine, off, percent))
    columns = (
        TableColumn("law"),
        TableColumn("printed", unit, "right"),
        TableColumn("ours", unit, "right"),
        TableColumn("difference", unit, "right"),
        TableColumn("difference", "%", "right"),
    )
    return ReportTable(name, caption, columns, tuple(rows))


@dataclass(frozen=True)
@check_arguments
class Ranking:
    """The pairs of a published ranking of laws that hold here, that are reversed, and that stay open."""

    column: PublishedColumn
    kept_pairs: tuple[tuple[str, str], ...]
    reversed_pairs: tuple[tuple[str, str], ...]
    undecided_pairs: tuple[tuple[str, str], ...]

    @check_arguments
    def sentence(self, winner: str) -> str:
        """The ranking in plain words, with the pairs that concern `winner` named."""
        pairs = len(self.kept_pairs) + len(self.reversed_pairs) + len(self.undecided_pairs)
        lost = [b for a, b in self.reversed_pairs if a == winner]
        against = (
            f" {winner} has a smaller printed value than {join_names(lost)}, and a larger one here."
            if lost
            else f" All printed advantages of {winner} hold here or are too close to call."
        )
        return (
            f"{self.column.where}: of {pairs} printed pairs {len(self.kept_pairs)} hold, "
            f"{len(self.reversed_pairs)} are reversed, {len(self.undecided_pairs)} are too close to call.{against}"
        )


@check_arguments
def ranking(column: PublishedColumn, outcomes: Mapping[str, Outcome], margin: float = 0.0) -> Ranking:
    """Each pair of laws in its printed order, judged by our values; `order` says when a pair stays undecided.

    Examples
    --------
    >>> motor = wb.Run(wb.open_loop(wb.DCMotor(), "motor"), (wb.effort("omega"),), until=1.0, h=1e-2)
    >>> study = wb.Study("s", "T", "Q?", "M.", lambda results: [], cases=(wb.Case("speed", "no law", motor),))
    >>> printed = wb.evidence.PublishedColumn("Table 1", "effort of omega", 0, {"no law": 0.0}, 2)
    >>> wb.evidence.ranking(printed, {"no law": wb.study.run(study)["speed", "no law"]}).kept_pairs
    ()
    """
    scores = {}
    for law in column.values:
        outcome = outcomes[known_name(law, outcomes, f"outcomes beside {column.where}")]
        lost = outcome.diverged_at is not None  # which is worse than any other
        scores[law] = (float("inf"), 0.0) if lost else _score(outcome, column.metric, column.signal)
    laws = sorted(column.values, key=lambda law: column.values[law])
    judged: dict[str, list[tuple[str, str]]] = {"below": [], "above": [], "undecided": []}
    for a, b in combinations(laws, 2):
        judged[order(scores[a], scores[b], margin)].append((a, b))
    return Ranking(column, *(tuple(judged[way]) for way in ("below", "above", "undecided")))


@check_arguments
def information_table(
    name: str, caption: Phrase, loops: Mapping[str, object], searched_numbers: Mapping[str, int] | None = None
) -> ReportTable:
    """A table of what each law is given: positions and velocities, model, estimate of the disturbance, states.

    `loops` has by law a loop or its `Roles`, and `searched_numbers` by law the number of its tuned numbers.

    Raises
    ------
    ValueError
        If there is no law, a loop cannot say its roles, or `searched_numbers` has other laws.

    Examples
    --------
    >>> motor = wb.DCMotor()
    >>> law = wb.PID(motor.outputs, motor.inputs, Kp=10.0, Ki=20.0)
    >>> loop = wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0))
    >>> wb.evidence.information_table("laws", "The measurements of each law.", {"PI": loop}).rows[0][0]
    'PI'
    """
    if not loops:
        raise ValueError("`information_table(loops)` must map each law to its loop, at least one; got none.")
    if searched_numbers is not None and set(searched_numbers) != set(loops):
        raise ValueError(
            f"`information_table(searched_numbers=...)` must have a number for each of {describe(list(loops))}; got "
            f"{describe(list(searched_numbers))}."
        )
    roles = {law: _roles_of(law, loop) for law, loop in loops.items()}
    classes = {law: _letter(k) for k, laws in enumerate(information_classes(roles)) for law in laws}
    rows: list[tuple[Cell, ...]] = [(law, classes[law], *_role_cells(held)) for law, held in roles.items()]
    heads = [TableColumn(head) for head in (*HEADS, *(() if searched_numbers is None else ("tuned",)))]
    if searched_numbers is not None:
        counts = [
            whole(f"information_table(searched_numbers={{'{law}': ...}})", searched_numbers[law], 0) for law in loops
        ]
        rows = [(*row, n) for row, n in zip(rows, counts, strict=True)]
    notes = (NOTE, OF_PLANTS) if any("f" in held for one in roles.values() for held in one.models.values()) else (NOTE,)
    return ReportTable(name, caption, tuple(heads), tuple(rows), notes)


def _roles_of(law: str, given: object) -> Roles:
    """The roles of a loop, or of an object with that loop as its `loop`."""
    held = given if isinstance(given, Roles) else getattr(getattr(given, "loop", given), "roles", None)
    if not isinstance(held, Roles):
        raise refusal(f"information_table(loops={{'{law}': ...}})", "a `ClosedLoop` or the `Roles` of one", given)
    return held


def _letter(k: int) -> str:
    return ascii_uppercase[k] if k < len(ascii_uppercase) else str(k + 1)


def _role_cells(held: Roles) -> tuple[Cell, ...]:
    observed = bool(held.observer_states or held.observer)
    pairs = ((_model(held, "controller"), _model(held, "observer")), (held.law_states, held.observer_states))
    model, states = (f"{law} / {observer}" if observed else f"{law}" for law, observer in pairs)
    return (
        held.observer or None,
        _state(held),
        None if model == "–" else model,
        "oracle" if held.truths else "estimated" if held.unread else None,
        states,
    )


def _state(held: Roles) -> str:
    """The way in which the outputs of the plant come, in one word where they come alike."""
    ways = [" and ".join(ways) or "unused" for ways in held.readings.values()]
    return ways[0] if len(set(ways)) == 1 else ", ".join(ways)


def _model(held: Roles, socket: str) -> str:
    """The matrices of the arm, or equations of another plant, that act in a law or an observer."""
    models = [matrices for path, matrices in held.models.items() if path.startswith(socket)]
    acting = "".join(matrix for matrix in "MCGf" if any(matrix in matrices for matrices in models))
    return acting or ("unused" if models else "–")
