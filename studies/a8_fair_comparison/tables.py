"""Tables of a8 that are its own: conditions, objective, and what a verdict depends on."""

from __future__ import annotations

import numpy as np

from studies.a8_fair_comparison import findings as findings
from studies.a8_fair_comparison.conditions import HELD_OUT, HORIZON, NOISE_Q, NOISE_QD, TRAINING
from studies.a8_fair_comparison.entrants import GIVEN
from studies.a8_fair_comparison.evidence import ASKED
from studies.a8_fair_comparison.objective import TERMS
from studies.a8_fair_comparison.results import Found
from workbench.study.document.document import Cell, Column, Emphasis, Table
from workbench.study.evidence import Intervals


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


def dependence(found: Found) -> Table:
    """The law that is best most often, under each statistic and whatever else was done."""
    rows: list[tuple[Cell, ...]] = []
    words = list(findings.conditions(found, GIVEN[0].key))
    for given in GIVEN:
        under = findings.conditions(found, given.key)
        together = found.together[given.key].best or "open"
        rows.append((given.name, *(_champion(*under[one]) for one in words), together))
    columns = (Column("given"), *map(Column, words), Column("all scenarios together"))
    notes = (
        "The law that is best in most held-out scenarios, with their number; where none is, those that are best most "
        "often, in "
        "brackets. First by each statistic. Then by the mean: the laws of least training cost alone, as tuned; the "
        "same as "
        "another search tuned them; and with the best numbers, at the step and under the noise of their own search, "
        "of as "
        "many first evaluations as half of the shortest search. Last the law of the least mean cost over all scenarios "
        "together, where that is significant.",
    )
    return Table("dependence", "What the verdict depends on.", columns, tuple(rows), notes)


def _champion(held: findings.Standings, words: str) -> str:
    counts = findings.tally(held, words)
    if not counts:
        return "open everywhere"
    most = max(counts.values())
    shown = ", ".join(f"{law} {count}" for law, count in counts.items() if count == most)
    return shown if findings.champion(held, words) else f"({shown})"


def worth(found: Found) -> Table:
    """What each law's mean cost is behind all that it is given."""
    judged = {given: found.together[given.key].by[ASKED.words] for given in GIVEN}
    rows: list[tuple[Cell, ...]] = []
    for i, law in enumerate(next(iter(judged.values())).paired.laws):
        cells = [_level(one.level, i) for one in judged.values()]
        rows.append(
            (law, *(Emphasis(c) if one.best == law else c for c, one in zip(cells, judged.values(), strict=True)))
        )
    columns = (Column("law"), *(Column(given.name, align="right") for given in GIVEN))
    notes = (
        "Mean cost over all draws and scenarios, these with equal weight, with its interval; each pair tuned by "
        "itself. "
        "Bold: significantly less than for each other law of the column. Between columns a law is given something "
        "else: "
        "they tell what an observer is worth to this law, not which law is better. One scenario may decide: 'slow' "
        "costs "
        "some laws thirty times what the others do.",
    )
    return Table("worth", "Mean cost over all scenarios together.", columns, tuple(rows), notes)


def _level(level: Intervals, i: int) -> str:
    value, low, high = (float(part[i]) for part in (level.value, level.low, level.high))
    return f"{value:.3g} ({low:.3g} to {high:.3g})" if np.isfinite(value) else "infinite: a run diverged"


def weights(found: Found) -> Table:
    """In how many scenarios each law is best as the terms of the cost weigh otherwise."""
    rows = tuple((words, findings.told(held)) for words, held in found.weighted.items())
    return Table(
        "weights",
        f"In how many held-out scenarios each law has the least {findings.MEASURE}, with other weights of the terms.",
        (Column("weights"), Column("best in")),
        rows,
        ("The runs are those of laws tuned for the first row. Open: no law is significantly best.",),
    )
