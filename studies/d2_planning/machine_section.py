"""The section and the finding on what the laws cost on a Cortex-M7."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

import workbench as wb
from studies.d2_planning.choices import Item, items
from studies.d2_planning.designs import BY_KEY, laws_of
from studies.d2_planning.machine import CLOCK, PERIODS, TARGET, Cost
from studies.d2_planning.problems import PROBLEMS

FITS, TOO_MUCH, NOT_RUN = "fits", "does not fit", "not run"
CYCLES = (2, 4)
SMALL_CLOCK = wb.handover.CLOCKS["cortex-m4f"]


def gather(results: wb.Results) -> dict[Item, Cost]:
    """The costs by plant and law."""
    choices = zip(items(), results.work("choices"), strict=True)
    return {item: choice.cost for item, choice in choices if choice.cost is not None}


def share(costs: Mapping[Item, Cost], key: str, law: str, cycles: float = 1.0, clock: float = CLOCK) -> float:
    """The share of its period that a law takes at most."""
    return cycles * costs[Item(key, law)].most / (PROBLEMS[key].period * clock)


def fits(costs: Mapping[Item, Cost], keys: tuple[str, ...], cycles: float = 1.0, clock: float = CLOCK) -> str:
    """True in words if the predictive law of some plants takes at most its period."""
    shares = [share(costs, key, "mpc", cycles, clock) for key in keys]
    if not np.isfinite(shares).all():
        return NOT_RUN
    return FITS if max(shares) <= 1 else TOO_MUCH


def most(costs: Mapping[Item, Cost], keys: tuple[str, ...], cycles: float = 1.0, clock: float = CLOCK) -> str:
    """The largest share in per cent."""
    shares = [share(costs, key, "mpc", cycles, clock) for key in keys]
    return f"{100 * max(shares):.2g} % of a period" if np.isfinite(shares).all() else ""


def finding(costs: Mapping[Item, Cost]) -> wb.Finding:
    """The cost of the predictive law."""
    keys = tuple(PROBLEMS)
    ratios = [costs[Item(key, "mpc")].instructions / costs[Item(key, "lqr")].instructions for key in keys]
    governor = [costs[Item(key, "governor")].instructions / costs[Item(key, "lqr")].instructions for key in keys]
    counts = ", ".join(f"{PROBLEMS[key].name} {costs[Item(key, 'mpc')].instructions:,.0f}" for key in keys)
    shares = ", ".join(f"{100 * share(costs, key, 'mpc'):.2g} %" for key in keys)
    ran = bool(np.isfinite(ratios).all())
    equal = sum(one.equal for one in costs.values())
    variations = [wb.Variation(f"{PROBLEMS[key].name} alone", fits(costs, (key,)), most(costs, (key,))) for key in keys]
    variations += [
        wb.Variation(f"{n} cycles per instruction", fits(costs, keys, n), most(costs, keys, n)) for n in CYCLES
    ]
    variations.append(
        wb.Variation(
            f"a clock of {SMALL_CLOCK / 1e6:g} MHz",
            fits(costs, keys, 1, SMALL_CLOCK),
            most(costs, keys, 1, SMALL_CLOCK),
        )
    )
    return wb.Finding(
        name="cost_on_a_cortex_m7",
        statement=f"MPC takes at most {shares} of its period on a Cortex-M7 at {CLOCK / 1e6:g} MHz, and "
        f"in the mean {min(ratios):.0f} to {max(ratios):.0f} times the instructions of clipped LQR."
        if ran
        else "The emulator of the Cortex-M7 was not installed, so that no instruction was counted.",
        evidence=f"Instructions of a period in the mean, with the Kalman filter: {counts}. The governor takes "
        f"{min(governor):.1f} to {max(governor):.1f} times those of clipped LQR. "
        f"{equal} of {len(costs)} laws give the bits of the reference arithmetic."
        if ran
        else "",
        statistic="The largest number of instructions of a period for its part, and the mean for the ratio, as QEMU "
        "counts them, at one instruction per cycle.",
        sample=f"{PERIODS} periods of each law in single precision.",
        information="The C code of each law with its observer.",
        assumptions="One instruction per cycle; the sweeps that the design of each predictive law derives.",
        fitted_numbers="None.",
        answer=fits(costs, keys),
        variations=tuple(variations),
        limitations="Caches, wait states of the memory, and other compilers.",
        is_decided=ran,
    )


def section(costs: Mapping[Item, Cost]) -> wb.Section:
    """The costs of all laws."""
    words = (
        "Each law is written as C in single precision with its observer, compiled for a Cortex-M7, and run in QEMU on "
        "the readings of its loop. QEMU counts instructions, not cycles. The operations are those of the exported "
        "graph, with each pass of a loop; where no limit acts, a predictive law leaves most of them out. Instructions "
        "are means of the periods. The part of the period belongs to the largest number."
    )
    rows: list[tuple[wb.document.Cell, ...]] = []
    for problem in PROBLEMS.values():
        for k, law in enumerate(laws_of(problem)):
            one = costs[Item(problem.key, law.key)]
            figures = [
                wb.document.MissingCell("not run") if np.isnan(value) else int(value)
                for value in (one.instructions, one.most, one.code, one.stack)
            ]
            part = share(costs, problem.key, law.key)
            percent = wb.document.MissingCell("not run") if np.isnan(part) else 100 * part
            first = (f"{problem.name}, {1e3 * problem.period:g} ms" if k == 0 else "", BY_KEY[law.key].name)
            rows.append((*first, int(one.operations), *figures[:2], percent, *figures[2:]))
    columns = (
        wb.document.TableColumn("plant and period"),
        wb.document.TableColumn("law"),
        wb.document.TableColumn("operations", align="right"),
        wb.document.TableColumn("instructions", align="right"),
        wb.document.TableColumn("at most", align="right"),
        wb.document.TableColumn("part of the period", "%", "right", digits=2),
        wb.document.TableColumn("code", "bytes", "right"),
        wb.document.TableColumn("stack", "bytes", "right"),
    )
    caption = f"What each law costs in a period on a Cortex-M7 ({TARGET}) at {CLOCK / 1e6:g} MHz."
    return wb.Section(
        "What it costs", (wb.Paragraph(words), wb.document.ReportTable("machine", caption, columns, tuple(rows)))
    )
