"""The computed parts of the study: both logs with their fits, repeated logs, and what no log can tell."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

import workbench as wb
from studies.c0_identify_arm.arm import (
    BASE,
    BEGIN,
    FREE,
    FRICTIONS,
    NOMINAL,
    SHORT,
    TRUTH,
    Conditions,
    Numbers,
    plant_of,
)
from studies.c0_identify_arm.estimates import (
    CUTOFFS,
    Curves,
    LogFit,
    RepeatedFits,
    as_numbers,
    curves_of,
    output_error,
    repeated_output_errors,
    repeated_regressions,
)
from studies.c0_identify_arm.logs import DESIGNED_LOG, LAW_LOG, Excitation, design, law_loop, played_loop, record
from studies.c0_identify_arm.requirements import CheckedGains, all_checks, check_true

FIRST, LAW_SEED, DESIGNED_SEED = 0, 1000, 500_000
REPEATED, BATCH, FEW = 64, 16, 4  # logs of a kind, those of an item, and those under each odd condition
ROD = (0.6, 0.5, 0.1)  # shares of a link at which its centre of mass lies, and an inertia in kg m^2: of rigid links


@dataclass(frozen=True)
class LawLog:
    """The log under the law of the paper: its fit, that of its first seconds, and what such a log cannot tell."""

    fit: LogFit
    short: LogFit
    curves: Curves
    lengthless: tuple[str, ...]  # directions that change nothing if gravity is unknown, too
    rigid: tuple[str, ...]  # the same for rigid links of known lengths
    checks: tuple[CheckedGains, ...]


@dataclass(frozen=True)
class DesignedLog:
    """The log of a designed experiment: the design, the fit, repeated logs, and how near the arm came to limits."""

    plan: Excitation
    fit: LogFit
    curves: Curves
    largest_sizes: tuple[tuple[str, float], ...]  # the largest |q|, |qd| and |tau| of the true arm
    output_errors: tuple[RepeatedFits, ...]  # for the stated conditions, then the odd ones
    regressions: tuple[RepeatedFits, ...]  # by cutoff
    checks: tuple[CheckedGains, ...]


@dataclass(frozen=True)
class Batch:
    """Some logs under the law of the paper, by the seeds of their noise."""

    case: Conditions
    first: int
    count: int


@dataclass(frozen=True)
class RepeatedLogs:
    """Their fits, and for the stated conditions their regressions by cutoff."""

    output_errors: RepeatedFits
    regressions: tuple[RepeatedFits, ...]


def batches(odd: tuple[Conditions, ...]) -> tuple[Batch, ...]:
    """All repeated logs under the law."""
    base = tuple(Batch(BASE, 1 + BATCH * i, BATCH) for i in range(REPEATED // BATCH))
    return (*base, *(Batch(case, 1, FEW) for case in odd))


def law_log(what: str) -> LawLog:
    """The first log under the law of the paper."""
    log = record(law_loop(BASE), what, BASE, LAW_SEED + FIRST)
    fit = output_error(log, BASE)
    early = record(law_loop(SHORT), what, SHORT, LAW_SEED + FIRST)
    held, short = as_numbers(fit), as_numbers(output_error(early, SHORT))
    return LawLog(held, short, curves_of(log, fit), *null_directions(log), all_checks("law's log", held))


def null_directions(log: wb.Dataset) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Directions without effect of the arm's numbers with gravity, and of rigid links of known lengths."""
    plant = plant_of(TRUTH)
    lengthless = wb.identifiability(wb.open_loop(plant), log, (*FREE, "arm.gravity"), ["q"])
    share, other, inertia = ROD
    links = tuple(
        wb.arms.mechanics.Link(mass, length, com * length, inertia=inertia)
        for mass, length, com in zip(TRUTH[:2], TRUTH[2:4], (share, other), strict=True)
    )
    rods = wb.open_loop(replace(plant, arm=wb.arms.mechanics.PlanarArm(links)))
    names = [f"arm.links[{i}].{word}" for i in (0, 1) for word in ("mass", "com", "inertia")]
    rigid = wb.identifiability(rods, log, (*names, *FRICTIONS), ["q"])
    return lengthless.sentences, rigid.sentences


def law_logs(batch: Batch) -> RepeatedLogs:
    """Repeated logs under the law of the paper."""
    loop = law_loop(batch.case)
    logs = [record(loop, LAW_LOG, batch.case, LAW_SEED + batch.first + k) for k in range(batch.count)]
    few = CUTOFFS if batch.case == BASE else ()
    return RepeatedLogs(
        repeated_output_errors(iter(logs), batch.case), tuple(repeated_regressions(iter(logs), one) for one in few)
    )


@dataclass(frozen=True)
class Basis:
    """The arm for which an experiment is designed: after a log under the law, or as the paper has it."""

    after_log: bool
    odd: tuple[Conditions, ...] = ()


def designed_log(basis: Basis) -> DesignedLog:
    """A designed experiment, run on the true arm, with repeated logs if it is designed after a log."""
    plan = design(numbers_of(basis))
    loop = played_loop(BASE, plan)
    log = record(loop, DESIGNED_LOG, BASE, DESIGNED_SEED + FIRST)
    fit, largest_sizes = output_error(log, BASE), reached_limits(loop)
    held = as_numbers(fit)
    if not basis.after_log:
        return DesignedLog(plan, held, curves_of(log, fit), largest_sizes, (), (), ())
    logs = [record(loop, DESIGNED_LOG, BASE, DESIGNED_SEED + 1 + k) for k in range(REPEATED)]
    repeats = [repeated_output_errors(iter(logs), BASE)]
    for case in basis.odd:
        repeats.append(repeated_output_errors(odd_logs(case, plan), case))
    regressions = tuple(repeated_regressions(iter(logs), one) for one in CUTOFFS)
    checks = all_checks("designed log", held)
    truths = (check_true("nominal", NOMINAL), check_true("true", TRUTH))
    return DesignedLog(plan, held, curves_of(log, fit), largest_sizes, tuple(repeats), regressions, (*checks, *truths))


def numbers_of(basis: Basis) -> Numbers:
    """The numbers of the arm for which an experiment is designed."""
    if not basis.after_log:
        return (*NOMINAL[:4], *((BEGIN,) * 4))
    return as_numbers(output_error(record(law_loop(BASE), LAW_LOG, BASE, LAW_SEED + FIRST), BASE)).numbers


def odd_logs(case: Conditions, plan: Excitation) -> Iterator[wb.Dataset]:
    """Logs of a designed experiment under odd conditions."""
    loop = played_loop(case, plan)
    return (record(loop, DESIGNED_LOG, case, DESIGNED_SEED + 1 + k) for k in range(FEW))


def reached_limits(loop: wb.SampledSystem) -> tuple[tuple[str, float], ...]:
    """The largest |q| in rad, |qd| in rad/s and |tau| in N m of the true arm in a designed experiment."""
    runs = wb.simulate(loop.step(2), until=BASE.span, every=loop.period)
    parts = []
    for name, label in (("q", "q"), ("qd", "qd"), ("hold.tau", "tau")):
        parts += [(f"{label}[{j}]", float(np.abs(runs[name][0][:, j]).max())) for j in (0, 1)]
    return tuple(parts)
