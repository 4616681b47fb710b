"""The machines of b4: each law replayed on every target that is installed here, and the share of its period."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from studies.b4_handover.loops import PERIODS, Handed, by_key, handed
from studies.b4_handover.margins import scans
from studies.b4_handover.operations import operations_finding
from workbench.handover.replays import CLOCKS, Fit, TargetResult, fits, replay
from workbench.handover.targets import TARGETS, USUAL
from workbench.study import Itemize, Paragraph, Results, Section, Table, Verdict, Work
from workbench.study.document.document import Cell, Column

SINGLY = ("gcc-O2", "clang-O2", "arm64", "cortex-m4f", "cortex-m7")  # in single precision
FEW = 1000  # periods of a replay in single precision, whose reference goes period by period
SHOWN = ("gcc-O0", "gcc-O2", "clang-O2", "arm64", "cortex-m4f", "cortex-m7")  # whose instructions are told
BOARDS = {key: clock for key, clock in CLOCKS.items() if key in USUAL}  # Hz
STACK = 4096  # bytes, at most


TargetResults = tuple[TargetResult, ...]


def replay_works() -> tuple[Work, Work]:
    """The replays of all loops, in double and in single precision."""
    keys = tuple(one.key for one in handed())
    return Work("replays", in_doubles, keys, seconds=30.0), Work("single_replays", in_singles, keys, seconds=10.0)


def in_doubles(key: str) -> TargetResults:
    """The replay of a loop on all targets."""
    return replay(by_key(key).digital(), name=key, periods=PERIODS).results


def in_singles(key: str) -> TargetResults:
    """The replay of a loop's law in single precision, which reads what the loop in doubles has read."""
    return replay(by_key(key).digital(), name=key, periods=FEW, targets=SINGLY, precision="single").results


def replays(results: Results, work: str = "replays") -> Mapping[str, TargetResults]:
    """The results of all targets by the name of the loop."""
    return dict(zip((one.name for one in handed()), results.work(work), strict=True))


def by_target(results: Results) -> dict[str, dict[str, TargetResult]]:
    """The results of each target, by target and law."""
    by_law = replays(results)
    names = [one.target for one in next(iter(by_law.values()))]
    return {name: {law: next(r for r in each if r.target == name) for law, each in by_law.items()} for name in names}


def fit_of(results: Results, one: Handed, key: str) -> Fit | None:
    """The count of a law at the clock of a microcontroller, on the longest period that sampling allows."""
    count = by_target(results)[TARGETS[key].name][one.name].figures.instructions
    return fits(count, scans(results).periods[one.key].threshold.largest, CLOCKS[key]) if count else None


def machine_findings(results: Results) -> tuple[Verdict, ...]:
    """The findings of the replays."""
    counted = any(fit_of(results, one, key) for one in handed() for key in BOARDS)
    return (bits_finding(results), operations_finding(results), *([fit_finding(results)] if counted else []))


def bits_finding(results: Results) -> Verdict:
    """The bits that differ."""
    by_law = replays(results)
    each = [(law, result) for law, of_law in by_law.items() for result in of_law]
    ran = [(law, result) for law, result in each if result.ran]
    other = [(law, result) for law, result in ran if not result.equal]
    targets = {result.target for _, result in ran}
    missing = sorted({result.target for _, result in each} - targets)
    compared, differing = (sum(getattr(result, part) for _, result in ran) for part in ("bits", "differing"))
    lost = "; ".join(f"{law} on {result.target}: {result.first}" for law, result in other)
    return Verdict(
        "holds" if ran and not other else "fails" if other else "open",
        f"All {len(by_law)} laws have the bits of the portable arithmetic on all {len(targets)} targets that ran."
        if ran and not other
        else f"{len(ran) - len(other)} of {len(ran)} replays have the bits of the portable arithmetic.",
        f"{compared:,} bits were compared, of commands and of the memory behind each period; {differing:,} of commands "
        f"differ. {lost + '. ' if lost else ''}Not run: {', '.join(missing) or 'none'}.",
        estimand=f"{PERIODS:,} periods of each law on each target, with the inputs of the loop that the portable "
        "arithmetic closes: while commands are equal, a machine in the loop is in this one.",
        given="Each law's C in double precision, or its graph, with the same readings and references.",
        reversal="One differing bit: a compiler that fuses or reorders, or a library of another rounding.",
    )


def fit_finding(results: Results) -> Verdict:
    """The count of instructions beside the period."""
    rows = [(one, key, fit) for one in handed() for key in BOARDS if (fit := fit_of(results, one, key))]
    worst, key, most = max(rows, key=lambda row: row[2].share)
    stacks = [r.figures.stack for each in replays(results).values() for r in each if r.figures.stack]
    listed = "; ".join(
        f"{short(TARGETS[each].name)} at {clock / 1e6:g} MHz: "
        f"{', '.join(f'{one.name} {share(fit)}' for one, at, fit in rows if at == each)}"
        for each, clock in BOARDS.items()
    )
    return Verdict(
        "found",
        f"By the count of instructions {sum(fit.fits for *_, fit in rows)} of {len(rows)} pairs of law and "
        f"microcontroller fit the longest period that sampling allows; the fullest is {worst.name} on "
        f"{short(TARGETS[key].name)}, with {share(most)} of it.",
        f"{listed}. The deepest stack that is known, of any target and level, takes {max(stacks):,} bytes.",
        estimand="The mean count of a period under QEMU, at one instruction a cycle, over the longest period of the "
        "scan. Instructions are no cycles: waits for memory, and divisions, take more.",
        given="Double precision, which the Cortex-M4F has in software alone; gcc -O2.",
        reversal="More than so many cycles an instruction, other work of the same processor, or another clock.",
    )


def short(name: str) -> str:
    """The name of a target without its compiler, where it has but one."""
    return name.split(",")[0]


def share(fit: Fit) -> str:
    """The share of a period in per cent."""
    return f"{100 * fit.share:.2g} %"


def machines_section(results: Results) -> Section:
    """The tables of the targets."""
    words = (
        "Each law's C, unchanged, is compiled for a machine with a small program around it that reads the recorded "
        "inputs and writes commands, flags and a digest of the memory; each machine starts with the memory at its "
        "start and goes on from its own. The browser's engine runs the same graph as WebAssembly. Counts belong to the "
        "compilers that are installed here. QEMU counts instructions and knows no cycles."
    )
    missing = [
        f"{name}: {r.reason}" for name, laws in by_target(results).items() if (r := next(iter(laws.values()))).reason
    ]
    absent = (Paragraph("Not run here:"), Itemize(tuple(missing))) if missing else ()
    return Section(
        "The same bits on every machine",
        (Paragraph(words), *absent, *(make(results) for make in (bits_table, counts_table, sizes_table, single_table))),
    )


def bits_table(results: Results) -> Table:
    """A row for each target, over all laws."""
    rows: list[tuple[Cell, ...]] = []
    for name, laws in by_target(results).items():
        ran = [result for result in laws.values() if result.ran]
        parts = ("periods", "bits", "differing", "memories", "flags")
        sums = (sum(getattr(result, part) for result in ran) for part in parts)
        first = "; ".join(f"{law}: {result.first}" for law, result in laws.items() if result.first)
        rows.append((short(name), *sums, first or "none") if ran else (short(name), *(None,) * 5, "not run"))
    heads = ("periods", "bits compared", "differing in commands", "periods with another memory", "flags")
    columns = (Column("target"), *(Column(head, align="right") for head in heads), Column("first difference"))
    notes = (
        f"Over all {len(handed())} laws. A flag is raised where a number is not finite. 64-bit ARM and both Cortex "
        "under QEMU, by gcc -O2; V8, Chrome's engine, in Node.",
    )
    return Table("bits", "Bits of commands and memories, against the portable arithmetic.", columns, tuple(rows), notes)


def counts_table(results: Results) -> Table:
    """Instructions a period, by law and target."""
    names = [TARGETS[key].name for key in SHOWN]
    by = by_target(results)
    rows = [(one.name, *(rounded(by[name][one.name].figures.instructions) for name in names)) for one in handed()]
    columns = (Column("law"), *(Column(short(name), align="right") for name in names))
    notes = (
        "The mean: under Callgrind for this machine's compilers, under QEMU for the others, by gcc -O2. A Cortex-M4F "
        "has no double precision in hardware, and calls routines of its compiler for each operation.",
    )
    return Table("counts", "Instructions a period.", columns, tuple(rows), notes)


def single_table(results: Results) -> Table:
    """The same in single precision: bits against NumPy's floats, and instructions."""
    rows: list[tuple[Cell, ...]] = []
    for law, each in replays(results, "single_replays").items():
        ran = [result for result in each if result.ran]
        differing = sum(result.differing + result.memories for result in ran)
        counts = [rounded(result.figures.instructions) for result in each]
        rows.append((law, sum(result.bits for result in ran), differing, *counts))
    heads = [short(TARGETS[key].name) for key in SINGLY]
    columns = (Column("law"), Column("bits compared", align="right"), Column("differing", align="right"))
    notes = (
        f"{FEW:,} periods of each law, over readings of the loop that doubles close, each from its own memory, against "
        "NumPy's numbers of 32 bits. The columns of targets are instructions a period; a Cortex-M4F has these numbers "
        "in hardware.",
    )
    all_columns = (*columns, *(Column(head, align="right") for head in heads))
    return Table("single", "The laws in single precision.", all_columns, tuple(rows), notes)


def sizes_table(results: Results) -> Table:
    """Stack, code and data, and the share of the period, on the microcontrollers."""
    rows: list[tuple[Cell, ...]] = []
    for one in handed():
        for key in BOARDS:
            result = by_target(results)[TARGETS[key].name][one.name]
            figures, fit = result.figures, fit_of(results, one, key)
            own: Cell = 100 * result.fit.share if result.fit else None
            longest: Cell = 100 * fit.share if fit else None
            rows.append((one.name, short(TARGETS[key].name), figures.stack, figures.code, figures.data, own, longest))
    columns = (
        Column("law"),
        Column("machine"),
        *(Column(head, "bytes", "right") for head in ("stack", "code", "data")),
        Column("of its period", "%", "right", digits=2),
        Column("of the longest", "%", "right", digits=2),
    )
    clocks = " and ".join(f"{short(TARGETS[key].name)} at {clock / 1e6:g} MHz" for key, clock in BOARDS.items())
    notes = (
        f"Shares: the count of a period at one instruction a cycle, {clocks}, over the declared period and over the "
        "longest that sampling allows. Stack: the deepest chain of calls from the step, as the compiler tells; at most "
        f"{STACK:,} bytes are wanted. Code: with constants, at -O2; data: that changes, beside the state.",
    )
    return Table("sizes", "What each law takes of a microcontroller.", columns, tuple(rows), notes)


def rounded(value: float | None) -> Cell:
    """A count as a whole number."""
    return None if value is None else int(np.round(value))
