"""What a9 says of one period: ways to switch, delay and noise, theory, and how far its numbers can be trusted."""

from collections.abc import Sequence

import numpy as np

from studies.a9_sampling.card import LATE, NOISY, PERIODS, REALISTIC, SEED
from studies.a9_sampling.evidence import PLACES, ROWS, SOME, Evidence
from studies.a9_sampling.figures import steps
from studies.a9_sampling.folded import K, Row
from studies.a9_sampling.loops import LATE_ERROR, RMSE, SWITCHING, TV, WAYS, Computer
from studies.a9_sampling.sections import MS, UNITS, cell
from studies.a9_sampling.steps import Curve
from workbench.design.chattering import Cycle
from workbench.study.document.document import Cell, Column, Paragraph, Section, Table

USUAL = SOME.index(REALISTIC)
KINDS = {"layer": "clip", "relay": "sign", "implicit": "implicit"}


def switching_section(evidence: Evidence) -> Section:
    """Layer, relay, implicit relay."""
    unit, scale = UNITS[TV]
    rows: list[tuple[Cell, ...]] = []
    for law in SWITCHING["sign"]:
        for name, kind in KINDS.items():
            if kind == "implicit" and law not in SWITCHING[kind]:
                continue
            found = [evidence.audits[law, "FS", Computer(period, switching=kind)] for period in SOME]
            late, rough = found[USUAL].score(LATE_ERROR, 0), found[USUAL].noisy_score(TV, 0)
            rows.append((law, name, *(cell(a.score(TV, 0), scale) for a in found), cell(rough, scale), cell(late, 1e3)))
    columns = (
        Column("law"),
        Column("switching"),
        *(Column(f"TV, {1e3 * period:g} ms", unit, "right") for period in SOME),
        Column(f"TV with noise, {MS}", unit, "right"),
        Column(f"late error, {MS}", "mrad", "right"),
    )
    notes = (
        f"Late error: the largest from {LATE:g} s on. With noise: the mean over {NOISY} runs, and twice its standard "
        "error.",
    )
    return Section(
        "Layer, relay and implicit relay",
        (
            Paragraph(
                "The layer is that of the paper. The relay is sign(s), taken as it is at each instant. The implicit "
                "relay is the torque that brings s to rest at the end of the period by the model, if K allows "
                "(backward Euler of a set-valued sign). AOSMC-RGS has none, as nothing keeps its K such that one "
                "exists; PID does not switch."
            ),
            Table("switching", "TV and late error of joint 1, first scenario.", columns, tuple(rows), notes),
        ),
    )


def rough_section(evidence: Evidence) -> Section:
    """Delay and noise, one by one."""
    return Section(
        "Delay and noise",
        (
            Paragraph(
                f"At {MS}: exact readings; a torque that is a period late; readings with noise and steps, as the mean "
                f"of {NOISY} runs with twice its standard error; and both."
            ),
            *(_rough(evidence, metric) for metric in (RMSE, TV)),
        ),
    )


def _rough(evidence: Evidence, metric: str) -> Table:
    unit, scale = UNITS[metric]
    heads = ("continuous", MS, "late", "noisy", "both")
    columns = (Column("law"), Column("where"), *(Column(head, unit, "right") for head in heads))
    rough = ((False, False), (True, False), (False, True), (True, True))
    rows = []
    for law, way, label in ROWS:
        kinds = (evidence.still(metric), *(evidence.at(metric, REALISTIC, *how, stepping=way) for how in rough))
        for scenario, joint in PLACES:
            cells = (cell(scores(law, scenario, joint), scale) for scores in kinds)
            rows.append((label, f"{scenario}, joint {joint + 1}", *cells))
    name = "rough_rmse" if metric == RMSE else "rough_tv"
    notes = (
        () if metric == RMSE else (f"In kN m/s, TV at {MS} is also the mean change of a torque in a period, in N m.",)
    )
    return Table(name, f"{metric} at {MS}, with delay and noise.", columns, tuple(rows), notes)


def theory_section(rows: Sequence[Row]) -> Section:
    """Foreseen chattering."""
    columns = (
        Column("period", "ms"),
        Column("delay"),
        Column("balance", "Hz, rad/s", "right"),
        Column("exact cycle", "Hz, rad/s", "right"),
        Column("simulated", "Hz, rad/s", "right"),
        Column("TV foreseen", "N m/s", digits=4),
        Column("TV simulated", "N m/s", digits=4),
    )
    notes = (
        "An exact cycle keeps an offset, so its amplitude has a range. TV foreseen: 4 K times the frequency of the "
        "cycle; the simulated torque also moves with s, by its other terms.",
    )
    caption = "Frequency and amplitude of s of joint 1, and the total variation of its torque."
    return Section(
        "Chattering foreseen",
        (
            Paragraph(
                f"A relay of K = {K:g} N m holds the folded arm, where M is diagonal and theory is exact (b1). With a "
                "period of delay it varies less, at a lower frequency and a greater amplitude."
            ),
            Table("foreseen", caption, columns, tuple(map(_foreseen, rows)), notes),
        ),
    )


def _foreseen(row: Row) -> tuple[Cell, ...]:
    balance, cycle, run = row.balance, row.cycle, row.run
    return (
        1e3 * row.period,
        "one period" if row.delay else "none",
        None if balance is None else _pair(balance.frequency, f"{balance.amplitude:.4f}"),
        None if cycle is None else _pair(cycle.frequency, _range(cycle)),
        _pair(run.frequency or 0.0, f"{run.amplitude:.4f}"),
        row.foreseen,
        row.variation,
    )


def _range(cycle: Cycle) -> str:
    return f"{cycle.amplitude:.4f}-{cycle.highest:.4f}"


def _pair(frequency: float, amplitude: str) -> str:
    return f"{frequency / (2 * np.pi):.1f}, {amplitude}"


def _by_way(evidence: Evidence) -> str:
    """How many of all lost runs each way to step the memories has."""
    lost = {way: sum(int(a.lost.sum()) for key, a in evidence.audits.items() if key[2].stepping == way) for way in WAYS}
    return ", ".join(f"{lost[way]} with {words}" for way, words in WAYS.items())


def trust_section(evidence: Evidence, curves: Sequence[Curve]) -> Section:
    """Steps and errors."""
    columns = (
        Column("period", "ms"),
        Column("substep", "ms", digits=3),
        Column("RMSE (43)", "%", digits=2),
        Column("TV", "%", digits=2),
    )
    rows = tuple(
        (
            1e3 * period,
            1e3 * period / (2 * Computer(period).substeps),
            100 * evidence.worst_step(RMSE, period),
            100 * evidence.worst_step(TV, period),
        )
        for period in PERIODS
    )
    caption = (
        "Largest step error over all laws, with both steps of AOSMC-RGS, joints and scenarios, with exact readings and "
        "no delay."
    )
    lost = sum(found.diverged_at is not None for found in evidence.audits.values())
    rough = sum(int(np.isnan(found.noisy[RMSE][:, 0]).sum()) for found in evidence.audits.values())
    return Section(
        "How far these numbers can be trusted",
        (
            Paragraph(
                "Values are those at half the substep, errors the change from the whole one. In continuous time RK4 "
                "runs at the steps of a1 and at half of them. A run that chatters depends on what it rounds: at 5 and "
                "10 ms one run of an adaptive law stands for many, of which the noisy ones show how they differ. So "
                "places are said to change only where both agree."
            ),
            Table("trust", caption, columns, rows),
            Paragraph(
                f"Of {len(evidence.audits)} loops with a computer {lost} diverged with exact readings, and {rough} "
                f"of {NOISY * len(evidence.audits)} runs with noise, {_by_way(evidence)}. They are named, count as "
                f"above all others and are never averaged away. The seed of the noise is {SEED}."
            ),
            steps(curves),
        ),
    )
