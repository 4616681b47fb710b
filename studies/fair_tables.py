"""Tables of a8 that are its own: conditions, objective, tuned numbers, margins."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from fair_conditions import HELD_OUT, NOISE_Q, NOISE_QD, TRAINING, Scenario
from fair_evidence import ratio
from fair_laws import Entrant
from fair_objective import TERMS

from workbench.study.document import Cell, Column, Emphasis, Measured, Table
from workbench.study.evidence import Comparison, Ranks
from workbench.study.tuning import Tuned


def scenarios() -> Table:
    """Training and held-out ones, and what differs."""
    rows: list[tuple[Cell, ...]] = [_conditions("training", one) for one in TRAINING]
    rows += [_conditions("held out", one) for one in HELD_OUT]
    heads = ("name", "for", "what", "true masses", "noise", "disturbance", "torque limit", "period")
    units = ("", "", "", "of the model's", "times", "times, as fast", "N m", "ms")
    columns = tuple(Column(head, unit, "left") for head, unit in zip(heads, units, strict=True))
    note = (
        f"Noise: normal, {NOISE_Q:g} rad of positions and {NOISE_QD:g} rad/s of velocities, fresh at each reading. "
        "Disturbance: the paper's sines, as many times as large and as fast."
    )
    return Table(
        "scenarios",
        "The scenarios; of the model all laws have masses of 1 kg and no friction.",
        columns,
        tuple(rows),
        (note,),
    )


def _conditions(use: str, one: Scenario) -> tuple[Cell, ...]:
    pairs = (f"{a:g}, {b:g}" for a, b in (one.mass, (one.push, one.pace), one.limit))
    mass, push, limit = pairs
    return one.name, use, one.words, mass, one.noise, push, limit, 1e3 * one.period


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
        settled = "settled" if tuned.settled else "not settled"
        edge = f"{settled}; at an end: {', '.join(tuned.at_edge)}" if tuned.at_edge else settled
        rows.append(
            (entrant.name, len(entrant.tuned), Measured(tuned.objective, tuned.step_error), bests, tuned.failed, edge)
        )
    columns = (
        Column("law"),
        Column("numbers", align="right"),
        Column("least cost", align="right"),
        Column("of each search"),
        Column("not admissible", align="right"),
        Column("remarks"),
    )
    notes = (
        "Least cost: the mean over both training scenarios, at half the step, in brackets its change from the step. A "
        "search has settled if its last quarter gained no more than 1 %.",
        f"Of each law: {next(iter(found.values())).tuning.evaluations:,} evaluations a search, "
        f"{len(next(iter(found.values())).tuning.seeds)} searches.",
    )
    return Table("searches", "The searches, all with the same budget.", columns, tuple(rows), notes)


def numbers(found: Mapping[str, Tuned], entrants: Sequence[Entrant]) -> Table:
    """All numbers as tuned."""
    rows: list[tuple[Cell, ...]] = []
    for entrant in entrants:
        best = found[entrant.key].best
        for one in entrant.tuned:
            row = (one.name, one.unit, f"{one.low:g} to {one.high:g}", f"{one.card:.4g}", f"{best[one.name]:.4g}")
            rows.append((entrant.name, *row))
    heads = ("law", "number", "unit", "range", "as assumed", "as tuned")
    return Table(
        "numbers",
        "The numbers as tuned.",
        tuple(map(Column, heads)),
        tuple(rows),
        ("Sought on a scale of logarithms.",),
    )


def margins(held: Mapping[str, Comparison], chances: Mapping[str, Ranks]) -> Table:
    """In each scenario the law of least median cost, how far the next is, and how often it is first."""
    rows: list[tuple[Cell, ...]] = []
    for scenario, one in held.items():
        laws = one.paired.laws
        first, second = (laws[i] for i in np.argsort(one.level.value)[:2])
        times, low, high = ratio(one.paired, second, first)
        ranks = chances[scenario].ranks
        i = laws.index(first)
        value, half = (
            100 * float(x)
            for x in (ranks.value[i, 0], max(ranks.high[i, 0] - ranks.value[i, 0], ranks.value[i, 0] - ranks.low[i, 0]))
        )
        leaders = [law for law in one.leaders if law != first]
        rows.append(
            (
                scenario,
                Emphasis(first) if one.best else first,
                second,
                f"{100 * (times - 1):+.3g} % ({100 * (low - 1):+.3g} to {100 * (high - 1):+.3g})",
                Measured(value, half),
                "yes" if one.best else f"no: {', '.join(leaders)} may be as good",
            )
        )
    columns = (
        Column("scenario"),
        Column("least median cost"),
        Column("next"),
        Column("next costs more by"),
        Column("first is first", "% of draws", "right"),
        Column("significant against all"),
    )
    notes = (
        "Next costs more by: the median over the draws of the ratio of both costs, with its own 95 % interval. First is "
        "first: the share of the draws in which it has the least cost, in brackets half of the interval.",
    )
    return Table("margins", "Who is first in each held-out scenario, and by how much.", columns, tuple(rows), notes)


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
