"""The section on the batch: PI and PID laws at one limit, beside two rules."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

import workbench as wb
from studies.d1_benchmarks.batch import COUNT_IN_PRINT, FORMULAS, Process, batch
from studies.d1_benchmarks.batch_designs import LIMIT, ProcessDesigns, TunedLaw

FAMILIES = {family: i for i, family in enumerate(FORMULAS)}
LAWS = ("PI", "PID", "simc", "amigo")
NAMES = {"PI": "optimum PI", "PID": "optimum PID", "simc": "SIMC (PI)", "amigo": "AMIGO (PI)"}
TOLERANCE = 1e-3  # relative, beyond which a rule counts as above the limit
CLOSE = 0.02  # relative: what is closer is no difference to an engineer


@dataclass(frozen=True)
class Row:
    """A process with its laws."""

    process: Process
    designs: ProcessDesigns

    def law(self, key: str) -> TunedLaw:
        """One of the laws by its key."""
        one: TunedLaw = getattr(self.designs, key)
        return one

    @property
    def late_share(self) -> float:
        """The normalised dead time of the model on which the rules act, L / (L + T)."""
        late, lag = self.designs.late, self.designs.lag
        return late / (late + lag) if np.isfinite(lag) else 0.0


def rows_of(results: wb.Results) -> list[Row]:
    """All processes with their laws."""
    return [Row(process, found) for process, found in zip(batch(), results.work("batch"), strict=True)]


def peak(one: TunedLaw) -> float:
    """The larger of the certified peaks."""
    return max(one.Ms, one.Mt)


def count_above(rows: Sequence[Row], key: str) -> int:
    """The number of processes with which a law exceeds the limit."""
    return sum(peak(row.law(key)) > LIMIT * (1 + TOLERANCE) for row in rows)


def quotient(rows: Sequence[Row], key: str, other: str, what: str) -> wb.Array:
    """A number of one law over that of another, for all processes that have both."""
    found = [(getattr(row.law(key), what), getattr(row.law(other), what)) for row in rows]
    return np.array([one / two for one, two in found if np.isfinite(one) and np.isfinite(two)])


def section(results: wb.Results) -> wb.Section:
    """The batch in pictures and tables."""
    rows = rows_of(results)
    about = (
        "The test batch of Astrom and Hagglund (2006, Advanced PID Control, chapter 7) has nine families. With the "
        f"parameters that are printed for them they have {len(rows)} processes, while the literature counts "
        f"{COUNT_IN_PRINT}. We do not know which one is missing, and added none. Each process gets the PI law and the "
        f"PID law with the largest integral gain for which neither |S| nor |T| exceeds {LIMIT:g}, and PI laws by two "
        "rules. The peaks are certified by margins that share no code with the designs. The rules act on a model with "
        "one lag T and a delay L. The half rule makes it, or, where a process has complex poles (P9), its step "
        "response. Times are in s, and the gain of each process has no unit."
    )
    blocks = (wb.Paragraph(about), gain_figure(rows), peak_figure(rows), family_table(rows), process_table(rows))
    return wb.Section("The batch of processes", blocks)


def points(rows: Sequence[Row], value: dict[str, list[float]]) -> tuple[wb.document.Mark, ...]:
    """A point for each process, in the style of its family."""
    return tuple(
        wb.document.Points(
            family,
            np.array([row.late_share for row in rows if row.process.family == family]),
            np.array(value[family]),
            style=i,
        )
        for family, i in FAMILIES.items()
        if value[family]
    )


def gain_figure(rows: Sequence[Row]) -> wb.document.Figure:
    """The integral gains of the PID law and of the rules over that of the PI law."""
    panels = []
    for key in ("PID", "simc", "amigo"):
        value: dict[str, list[float]] = {family: [] for family in FAMILIES}
        for row in rows:
            value[row.process.family].append(row.law(key).ki / row.law("PI").ki)
        panels.append(
            wb.document.Panel(
                "ki / ki of PI",
                points(rows, value),
                "L / (L + T)",
                yscale="log",
                title=NAMES[key],
                hlines=(1.0,),
            )
        )
    caption = (
        f"The integral gain of three laws over that of the optimum PI law at the limit {LIMIT:g}, against the "
        "normalised dead time L / (L + T) of the model with one lag. A PI law by a rule that lies above one exceeds "
        "the limit."
    )
    return wb.document.Figure("batch_gains", caption, tuple(panels), columns=3)


def peak_figure(rows: Sequence[Row]) -> wb.document.Figure:
    """The certified peaks of the rules."""
    panels = []
    for key in ("simc", "amigo"):
        value: dict[str, list[float]] = {family: [] for family in FAMILIES}
        for row in rows:
            value[row.process.family].append(peak(row.law(key)))
        panels.append(
            wb.document.Panel(
                "larger of Ms and Mt",
                points(rows, value),
                "L / (L + T)",
                title=NAMES[key],
                hlines=(LIMIT,),
            )
        )
    caption = f"The larger peak of S and T of PI laws by two rules; the line is the limit {LIMIT:g}."
    return wb.document.Figure("batch_peaks", caption, tuple(panels), columns=2)


def family_table(rows: Sequence[Row]) -> wb.document.ReportTable:
    """The laws family by family."""
    lines: list[tuple[wb.document.Cell, ...]] = []
    for family, formula in FORMULAS.items():
        own = [row for row in rows if row.process.family == family]
        with_derivative = quotient(own, "PID", "PI", "ki")
        share = [float(np.median(quotient(own, key, "PI", "ki"))) for key in ("simc", "amigo")]
        above = [
            f"{sum(peak(row.law(key)) > LIMIT * (1 + TOLERANCE) for row in own)} of {len(own)}"
            for key in ("simc", "amigo")
        ]
        lines.append((family, formula, len(own), float(np.median(with_derivative)), *share, *above))
    columns = (
        wb.document.TableColumn("family"),
        wb.document.TableColumn("process"),
        wb.document.TableColumn("count", align="right"),
        wb.document.TableColumn("PID", "", "right", digits=3),
        wb.document.TableColumn("SIMC", "", "right", digits=3),
        wb.document.TableColumn("AMIGO", "", "right", digits=3),
        wb.document.TableColumn("SIMC above", align="right"),
        wb.document.TableColumn("AMIGO above", align="right"),
    )
    notes = (
        "PID, SIMC and AMIGO: the median over the family of the integral gain over that of the optimum PI law. Above: "
        f"the processes for which the larger peak of the rule exceeds {LIMIT:g}. The bandwidth N of the filter of each "
        "PID law is ten times the frequency at which the PI law meets the limit. SIMC has its usual time constant, the "
        "delay of the model.",
    )
    caption = (
        "The integral gains of three laws over that of the optimum PI law by family, and how often a rule exceeds the "
        f"limit {LIMIT:g}."
    )
    return wb.document.ReportTable("batch_families", caption, columns, tuple(lines), notes)


def process_table(rows: Sequence[Row]) -> wb.document.ReportTable:
    """All gains, process by process."""
    lines: list[tuple[wb.document.Cell, ...]] = []
    for row in rows:
        first, second = row.law("PI"), row.law("PID")
        lines.append(
            (
                row.process.name,
                *(first.k, first.ki, _iae(first)),
                *(second.k, second.ki, second.kd, second.N, _iae(second)),
            )
        )
    units = {"k": "", "ki": "1/s", "kd": "s", "N": "rad/s", "IAE": "s"}
    gains = [
        wb.document.TableColumn(f"{form} {name}", units[name], "right", digits=4)
        for form, names in (("PI", ("k", "ki", "IAE")), ("PID", ("k", "ki", "kd", "N", "IAE")))
        for name in names
    ]
    caption = f"The optimum laws of all processes at the limit {LIMIT:g}, with IAE after a unit step of load."
    return wb.document.ReportTable(
        "batch_processes", caption, (wb.document.TableColumn("process"), *gains), tuple(lines)
    )


def _iae(one: TunedLaw) -> float | wb.document.MissingCell:
    return one.IAE if np.isfinite(one.IAE) else wb.document.MissingCell("unsure")


def finding(results: wb.Results) -> wb.Finding:
    """The worth of a derivative and of an optimum, beside rules."""
    rows = rows_of(results)
    above = {key: count_above(rows, key) for key in ("simc", "amigo")}
    inside = [max(row.law(key).Ms, row.law(key).Mt) for row in rows for key in ("PI", "PID")]
    gain = quotient(rows, "PID", "PI", "ki")
    absolute = quotient(rows, "PI", "PID", "IAE")
    below = sum(share < 1 for share in gain)
    variations = [
        wb.Variation(f"only {family}", *_more(quotient(own, "PID", "PI", "ki")))
        for family, own in ((f, [row for row in rows if row.process.family == f]) for f in FAMILIES)
    ]
    variations.append(wb.Variation("by IAE in the place of the integral gain", *_more(absolute)))
    return wb.Finding(
        name="batch_of_processes",
        statement=f"A derivative multiplies the largest integral gain by {np.median(gain):.3g} in the median of "
        f"{len(rows)} processes, and by {gain.min():.3g} to {gain.max():.3g} over all, at the limit {LIMIT:g} of both "
        f"peaks. The rule SIMC exceeds this limit in {above['simc']} of them and AMIGO in {above['amigo']}.",
        evidence=f"The largest certified peak of the optimum laws is {max(inside):.6g}. IAE after a step of load is "
        f"smaller with this PID law by the factor {np.median(absolute):.3g} in the median. The integral gain is "
        f"smaller with the derivative in {below} processes. AMIGO aims at this limit and SIMC does not: the median of "
        f"its larger peak is {np.median([peak(row.law('simc')) for row in rows]):.3g}.",
        statistic="The integral gain of the optimum PID law over that of the optimum PI law, and its median.",
        sample=f"All {len(rows)} processes of the nine families; the literature counts {COUNT_IN_PRINT}.",
        information="The exact process for the optimum laws. The rules have a model with one lag and a delay.",
        assumptions="The bandwidth of the derivative's filter, ten times the frequency at which the PI law meets the "
        "limit; the models of the rules by the half rule, and from the step response for P9; the usual time constant "
        "of SIMC.",
        answer=_more(gain)[0],
        variations=tuple(variations),
        limitations="Another limit, another filter, the PID law with the least IAE, and noise, which a derivative "
        "amplifies.",
    )


def _more(quotients: wb.Array) -> tuple[str, str]:
    """The answer in words, whether a derivative helps in the median, and the median."""
    middle = float(np.median(quotients)) if len(quotients) else np.nan
    return "better with a derivative" if middle > 1 + CLOSE else "alike", f"{middle:.3g} times"
