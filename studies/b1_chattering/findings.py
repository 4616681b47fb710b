"""The findings of b1: the layer, the balance of a relay, and its exact cycle."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

import workbench as wb
from studies.b1_chattering.loops import LAGS, LATE, NEARLY, PERIODS, PHI, STARTS, K, Row


def errors_of(rows: Sequence[Row]) -> np.ndarray:
    """Errors of the balance of a relay in %, (2, rows): of frequency and of amplitude."""
    pairs = [r.relay for r in rows]
    frequency = [abs(one.frequency / (run.frequency or np.nan) - 1) for one, run in pairs]
    return 100 * np.array([frequency, [abs(one.amplitude / run.amplitude - 1) for one, run in pairs]])


def agreement_count(rows: Sequence[Row], near: float = NEARLY) -> str:
    """In how many of the rows with an exact cycle the simulated amplitude is its smallest one."""
    regular = [(r.cycle.amplitude, r.relay[1].amplitude) for r in rows if r.cycle]
    return f"{sum(exact / near <= run <= exact * near for exact, run in regular)} of {len(regular)}"


def variations(
    every: Sequence[Sequence[Row]], word: Callable[[Sequence[Row]], str], detail: Callable[[Sequence[Row]], str]
) -> tuple[wb.Variation, ...]:
    """The answer from each other start, and without each lag and each period by turns."""
    made = [
        wb.Variation(
            f"a start at {push[0]:g} and {push[1]:g} rad/s".replace("-", "\N{MINUS SIGN}"), word(rows), detail(rows)
        )
        for push, rows in zip(STARTS, every[1:], strict=True)
    ]
    for name, values in (("lag", LAGS), ("period", PERIODS)):
        for value in values:
            rest = [r for r in every[0] if getattr(r, name) != value]
            made.append(wb.Variation(f"leaving out the {name} of {1e3 * value:g} ms", word(rest), detail(rest)))
    return tuple(made)


def findings(every: Sequence[Sequence[Row]]) -> tuple[wb.Finding, wb.Finding, wb.Finding]:
    """The least width of the layer, and the balance and the exact cycle of a relay."""
    return layer_finding(every), balance_finding(every), cycle_finding(every)


INFORMATION = f"SMC with K = {K:g} N m reads exact positions and velocities."
ASSUMPTIONS = "Lags, periods and starts; the folded arm, where M is diagonal and each joint is a loop by itself."


def sample_of(rows: Sequence[Row]) -> str:
    """The runs of a finding."""
    return f"s of joint 1 from {LATE:g} s on, one run for each of {len(rows)} pairs of lag and period, from one start."


def agreement(rows: Sequence[Row]) -> str:
    """The verdict on the layer."""
    agreed = sum(r.layer_agrees for r in rows)
    return "all" if agreed == len(rows) else f"{agreed} of {len(rows)}"


def nearer(rows: Sequence[Row]) -> str:
    """The number in which the balance is nearer, in the median."""
    frequency, amplitude = np.median(errors_of(rows), axis=1)
    return "frequency" if frequency < amplitude else "amplitude"


def medians(rows: Sequence[Row]) -> str:
    """Both medians in words."""
    frequency, amplitude = np.median(errors_of(rows), axis=1)
    return f"{frequency:.0f} % and {amplitude:.0f} %"


def spans(every: Sequence[Sequence[Row]]) -> tuple[str, str]:
    """The median errors of frequency and of amplitude in %, each the least and the largest over the starts."""
    both = np.array([np.median(errors_of(rows), axis=1) for rows in every]).T
    ends = ((f"{one.min():.0f}", f"{one.max():.0f}") for one in both)
    first, second = (low if low == high else f"{low} to {high}" for low, high in ends)
    return first, second


def smallest(rows: Sequence[Row]) -> str:
    """The verdict on exact cycles."""
    return "all" if all_or(agreement_count(rows)).startswith("all ") else agreement_count(rows)


def all_or(part: str) -> str:
    """A count such as '7 of 8' as it stands, and '8 of 8' as 'all 8'."""
    count, total = part.split(" of ")
    return f"all {total}" if count == total else part


def layer_finding(every: Sequence[Sequence[Row]]) -> wb.Finding:
    """Rest or oscillation in the layer."""
    rows = every[0]
    agreed, thin = sum(r.layer_agrees for r in rows), sum(r.layer[0].least_phi >= PHI for r in rows)
    nearest = 100 * min(abs(r.layer[0].least_phi / PHI - 1) for r in rows)
    return wb.Finding(
        name="layer_ends_chattering",
        statement=f"In {all_or(f'{agreed} of {len(rows)}')} pairs of lag and period, harmonic balance predicts "
        f"correctly whether the boundary layer of {PHI:g} rad/s ends the chattering of joint 1.",
        evidence=f"In {thin} pairs the layer is thinner than the least width by harmonic balance, and the arm should "
        "oscillate; in all other pairs the arm should come to rest. Below the least width, the linear loop in the "
        f"layer is unstable. No pair is a close case: the least width differs from {PHI:g} rad/s by "
        f"{np.floor(nearest):.0f} % or more in each.",
        statistic="Whether s of joint 1 comes to rest or oscillates.",
        sample=sample_of(rows),
        information=INFORMATION,
        assumptions=ASSUMPTIONS,
        answer=agreement(rows),
        variations=variations(every, agreement, lambda some: f"{sum(r.layer_agrees for r in some)} of {len(some)}"),
        limitations="a pose where M couples the joints and both switch",
    )


def balance_finding(every: Sequence[Sequence[Row]]) -> wb.Finding:
    """The errors of harmonic balance for a relay."""
    rows, (frequency, amplitude) = every[0], spans(every)
    worst = np.max([errors_of(some).max(axis=1) for some in every], axis=0)
    pairs = [(r.relay[1], o.relay[1]) for others in every[1:] for r, o in zip(rows, others, strict=True)]
    moved = sum(abs((one.frequency or 0) / (other.frequency or np.inf) - 1) > NEARLY - 1 for one, other in pairs)
    return wb.Finding(
        name="balance_of_a_relay",
        statement=f"For a relay, the median error of harmonic balance is {frequency} % in frequency and {amplitude} % "
        f"in amplitude, over {len(every)} starts; the largest errors are {worst[0]:.0f} % and {worst[1]:.0f} %.",
        evidence="A sampled relay switches only at sampling instants, so that half a period of its oscillation is a "
        "whole number of sampling periods. Harmonic balance does not know this restriction. In "
        f"{moved} of {len(pairs)} runs from other starts, the relay oscillates at another frequency.",
        statistic="Error relative to the simulated oscillation. The answer is the quantity with the smaller median "
        "error.",
        sample=f"s of joint 1 from {LATE:g} s on, {len(rows)} pairs of lag and period, {len(every)} starts.",
        information=INFORMATION,
        assumptions=ASSUMPTIONS,
        answer=nearer(rows),
        variations=variations(every, nearer, medians),
        limitations="other gains K and other poses",
    )


def cycle_finding(every: Sequence[Sequence[Row]]) -> wb.Finding:
    """The exact cycles of a relay, compared with its runs."""
    rows = every[0]
    regular = sum(r.cycle is not None for r in rows)
    return wb.Finding(
        name="exact_cycle",
        statement=f"Of {len(rows)} pairs, {regular} oscillate regularly. In {all_or(agreement_count(rows))} of these, "
        "the amplitude of s is that of the exact cycle at the simulated switching period.",
        evidence="The amplitude is half of the peak-to-peak value. An exact cycle may have an offset of s, which "
        "changes its peak but not this amplitude. From the other starts, the counts are "
        f"{', '.join(map(agreement_count, every[1:]))}.",
        statistic=f"Half of the difference between the highest and the lowest s, to {100 * (NEARLY - 1):.1g} %, where "
        "the oscillation is symmetric about its offset and its periods are equal.",
        sample=sample_of(rows),
        information=f"{INFORMATION} The exact cycle is given the simulated switching period.",
        assumptions=ASSUMPTIONS,
        answer=smallest(rows),
        variations=variations(every, smallest, agreement_count),
        limitations="other gains K and other poses",
    )
