"""Tables of a8 that are its own: conditions, objective, tuned numbers, margins."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from fair_conditions import HELD_OUT, HORIZON, NOISE_Q, NOISE_QD, TRAINING
from fair_evidence import FAMILY, ratio
from fair_laws import Entrant
from fair_objective import TERMS

from workbench.notation.formula import symbol
from workbench.study.cells import raised
from workbench.study.document import Cell, Column, Emphasis, Measured, Phrase, Table
from workbench.study.evidence import Comparison, Ranks
from workbench.study.tuning import Tuned


def scenarios() -> Table:
    """Training and held-out ones, and what differs."""
    rows: list[tuple[Cell, ...]] = [(one.name, "training", one.words) for one in TRAINING]
    rows += [(one.name, "held out", one.words) for one in HELD_OUT]
    usual = HELD_OUT[0]
    limit, viscous, coulomb = (f"{a:g} and {b:g}" for a, b in (usual.limit, usual.viscous, usual.coulomb))
    note = (
        f"Unless said otherwise: the model's masses, {limit} N m of torque, a period of {1e3 * usual.period:g} ms, "
        f"friction of {viscous} N m s/rad and {coulomb} N m, the paper's disturbance, and normal "
        f"noise of {NOISE_Q:g} rad and {NOISE_QD:g} rad/s, fresh at each reading. 'A slower motion' has amplitudes of "
        "0.6 and 0.8 rad at 1.5 and 2.2 rad/s, 'a faster motion' 0.9 and 0.6 rad at 3.5 and 5 rad/s. A run takes "
        f"{HORIZON:g} s."
    )
    heads = (Column("name"), Column("for"), Column("what is wanted, and what is unusual"))
    return Table("scenarios", "The scenarios.", heads, tuple(rows), (note,))


def terms() -> Table:
    """The objective."""
    rows = tuple((term.metric, term.acceptable, term.unit, term.why) for term in TERMS)
    return Table(
        "objective",
        "The terms of the cost: each metric, both joints together, over what is called acceptable.",
        (Column("metric"), Column("acceptable", align="right"), Column("unit"), Column("what it stands for")),
        rows,
    )


def searches(found: Mapping[str, Tuned], entrants: Sequence[Entrant]) -> Table:
    """What each search found."""
    rows: list[tuple[Cell, ...]] = []
    for entrant in entrants:
        tuned = found[entrant.key]
        bests = ", ".join(f"{best:.4g}" for best in tuned.bests)
        edge = f"; at an end: {', '.join(tuned.at_edge)}" if tuned.at_edge else ""
        least = Measured(tuned.objective, tuned.step_error)
        unstable = [t.name for t in tuned.tuning.trials if not t.h <= tuned.stable_steps[t.name]]
        step = f"; step not known to be stable in {', '.join(unstable)}" if unstable else ""
        remark = f"{'settled' if tuned.settled else 'not settled'}{edge}{step}"
        rows.append((entrant.name, len(entrant.tuned), least, bests, tuned.failed, remark))
    columns = (
        Column("law"),
        Column("numbers", align="right"),
        Column("least cost", align="right"),
        Column("of each search"),
        Column("not admissible", align="right"),
        Column("remarks"),
    )
    asked = next(iter(found.values())).tuning
    notes = (
        "Least cost: the mean over both training scenarios, at half the step, in brackets its change from the step. A "
        "search has settled if its last quarter gained no more than 1 %. Not admissible: a run diverged.",
        f"Of each law {len(asked.seeds)} searches of {asked.evaluations:,} evaluations, {asked.population} at once; "
        f"seeds {', '.join(map(str, asked.seeds))}; step {1e3 * asked.trials[0].h:g} ms.",
    )
    return Table("searches", "The searches, all with the same budget.", columns, tuple(rows), notes)


def numbers(found: Mapping[str, Tuned], entrants: Sequence[Entrant]) -> Table:
    """All numbers as tuned."""
    rows: list[tuple[Cell, ...]] = []
    for entrant in entrants:
        best = found[entrant.key].best
        for one in entrant.tuned:
            spread = f"{one.low:g} to {one.high:g}"
            row = (_letter(one.name), raised(one.unit), spread, f"{one.card:.4g}", f"{best[one.name]:.4g}")
            rows.append((entrant.name, *row))
    heads = tuple(map(Column, ("law", "number", "unit", "range", "as assumed", "as tuned")))
    return Table("numbers", "The numbers as tuned.", heads, tuple(rows), ("Sought on a scale of logarithms.",))


def _letter(name: str) -> Phrase:
    """A number's name as it is printed: K(0) by its letter too."""
    letter, bracket, rest = name.partition("(")
    return (symbol(letter), bracket + rest) if bracket else name if name == "lag" else symbol(name)


def margins(held: Mapping[str, Comparison], chances: Mapping[str, Ranks]) -> Table:
    """In each scenario the law of least median cost, how far the next is, and how often it is first."""
    rows = tuple(_margin(scenario, one, chances[scenario]) for scenario, one in held.items())
    columns = (
        Column("scenario"),
        Column("least median cost"),
        Column("next"),
        Column("next costs more by"),
        Column("first is first", "% of draws", "right"),
        Column("significant"),
    )
    share = 100 * next(iter(held.values())).margin
    notes = (
        "Next costs more by: the ratio of both medians over the draws, with its own 95 % interval. First is first: the "
        "share of the draws in which that law has the least cost, in brackets half of its own 95 % interval. "
        "Significant: against all other laws and in all "
        f"scenarios at once, with {100 * FAMILY:g} %, and by more than {share:g} %.",
    )
    return Table("margins", "Who is first in each held-out scenario, and by how much.", columns, rows, notes)


def _margin(scenario: str, one: Comparison, chances: Ranks) -> tuple[Cell, ...]:
    laws, ranks = one.paired.laws, chances.ranks
    first, second = (int(i) for i in np.argsort(one.level.value)[:2])
    more = [f"{100 * (times - 1):+.3g}".replace("-", "−") for times in ratio(one.paired, laws[second], laws[first])]
    value, low, high = (100 * float(part[first, 0]) for part in (ranks.value, ranks.low, ranks.high))
    return (
        scenario,
        Emphasis(laws[first]) if one.best else laws[first],
        laws[second],
        f"{more[0]} % ({more[1]} to {more[2]})",
        Measured(value, max(value - low, high - value)),
        "yes" if one.best else f"no: perhaps {' or '.join(law for law in one.leaders if law != laws[first])}",
    )


def weights(held: Mapping[str, Mapping[str, Comparison]]) -> Table:
    """In how many scenarios each law is best as the terms of the cost weigh otherwise."""
    laws = next(iter(next(iter(held.values())).values())).paired.laws
    rows: list[tuple[Cell, ...]] = []
    for words, by_scenario in held.items():
        counts = [sum(one.best == law for one in by_scenario.values()) for law in laws]
        most = max(counts)
        alone = counts.count(most) == 1
        cells = (Emphasis(count) if alone and count == most else count for count in counts)
        rows.append((words, *cells, sum(one.best is None for one in by_scenario.values())))
    columns = (Column("weights"), *(Column(law, align="right") for law in laws), Column("open", align="right"))
    return Table(
        "weights",
        "In how many held-out scenarios each law is significantly best, with other weights of the terms.",
        columns,
        tuple(rows),
        ("The runs are those of laws tuned for the first row. Bold: the most of a row, where one law has it alone.",),
    )
