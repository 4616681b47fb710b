"""The tables of the machines of b4: bits, instructions, sizes, and single precision."""

from __future__ import annotations

import numpy as np

import workbench as wb
from studies.b4_handover.loops import FAR_START, NEAR_START, handover_loops
from studies.b4_handover.machines import BOARDS, FEW, SINGLY, by_target, fit_of, replays, without_compiler
from studies.b4_handover.operations import operations_table

TABLE_TARGETS = ("gcc-O0", "gcc-O2", "clang-O2", "arm64", "cortex-m4f", "cortex-m4f-libgcc", "cortex-m7")
STACK = 4096  # bytes, at most


def machines_section(results: wb.Results) -> wb.Section:
    """The tables of the targets."""
    words = (
        "Each law's C code is compiled unchanged for each machine, with a small program that reads the recorded "
        "inputs and writes commands, flags and a digest of the memory. Each machine starts with the initial memory, "
        "and continues with the memory that it computes. The browser's engine runs the law's graph of operations, "
        "compiled to WebAssembly. Sines, cosines, exponentials and powers are functions of our own in that code, on "
        "all targets. "
        "A Cortex-M4F has no double precision in hardware; GCC's library, libgcc, computes it, and rounds some "
        "differences wrongly. 'With mended sums' means that our own routine replaces this library where the exponents "
        "of the two operands of a difference are 33 apart. 'With libgcc alone' means that it does not. Counts belong "
        "to the compilers that are installed here. QEMU "
        "counts instructions, not cycles."
    )
    missing = [
        f"{name}: {r.reason}" for name, laws in by_target(results).items() if (r := next(iter(laws.values()))).reason
    ]
    absent = (wb.Paragraph("Not run here:"), wb.document.Itemize(tuple(missing))) if missing else ()
    return wb.Section(
        "The same bits on every machine",
        (
            wb.Paragraph(words),
            *absent,
            *(make(results) for make in (bits_table, operations_table, counts_table, sizes_table, single_table)),
        ),
    )


def bits_table(results: wb.Results) -> wb.document.ReportTable:
    """A row for each target, over all laws."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for name, laws in by_target(results).items():
        ran = [result for result in laws.values() if result.ran]
        parts = ("periods", "bits", "differing_bits", "memories", "flags")
        sums = (sum(getattr(result, part) for result in ran) for part in parts)
        first = "; ".join(f"{law}: {result.first}" for law, result in laws.items() if result.first)
        rows.append(
            (without_compiler(name), *sums, first or "none")
            if ran
            else (without_compiler(name), *(None,) * 5, "not run")
        )
    heads = ("periods", "bits compared", "bits of commands that differ", "periods whose memory differs", "flags")
    columns = (
        wb.document.TableColumn("target"),
        *(wb.document.TableColumn(head, align="right") for head in heads),
        wb.document.TableColumn("first mismatch"),
    )
    notes = (
        f"All {len(handover_loops())} laws together. A flag is raised where a number is not finite. 64-bit ARM and "
        "the Cortex processors run under QEMU, compiled by gcc -O2. V8 is Chrome's engine; it runs in Node. An FMU "
        "shows no memory, so that only its commands are compared.",
    )
    caption = "Bits of commands and memories on each target, compared with the reference implementation."
    return wb.document.ReportTable("bits", caption, columns, tuple(rows), notes)


def counts_table(results: wb.Results) -> wb.document.ReportTable:
    """Instructions per period, by law and target."""
    names = [wb.handover.TARGETS[key].name for key in TABLE_TARGETS]
    by = by_target(results)
    rows = [
        (one.name, *(count_cell(by[name][one.name].figures.instructions) for name in names)) for one in handover_loops()
    ]
    columns = (
        wb.document.TableColumn("law"),
        *(wb.document.TableColumn(without_compiler(name), align="right") for name in names),
    )
    notes = (
        "The mean over the periods, counted by Callgrind for this machine's compilers, and by QEMU for the other "
        "targets, which gcc -O2 compiles. A Cortex-M4F calls a routine for each operation in double precision.",
    )
    return wb.document.ReportTable("counts", "Instructions per period.", columns, tuple(rows), notes)


def single_table(results: wb.Results) -> wb.document.ReportTable:
    """The laws in single precision: bits compared with NumPy's floats, and instructions."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for law, each in replays(results, "single_replays").items():
        ran = [result for result in each if result.ran]
        differing = sum(result.differing_bits + result.memories for result in ran)
        counts = [count_cell(result.figures.instructions) for result in each]
        rows.append((law, sum(result.bits for result in ran), differing, *counts))
    heads = [without_compiler(wb.handover.TARGETS[key].name) for key in SINGLY]
    columns = (
        wb.document.TableColumn("law"),
        wb.document.TableColumn("bits compared", align="right"),
        wb.document.TableColumn("bits that differ", align="right"),
    )
    notes = (
        f"{FEW:,} periods of each law on the readings of the loop in double precision, compared with NumPy's numbers "
        "of 32 bits. The columns of the targets give instructions per period. A Cortex-M4F has single precision in "
        "hardware.",
    )
    all_columns = (*columns, *(wb.document.TableColumn(head, align="right") for head in heads))
    return wb.document.ReportTable("single", "The laws in single precision.", all_columns, tuple(rows), notes)


def sizes_table(results: wb.Results) -> wb.document.ReportTable:
    """Stack, code and data, the time of a period, and its share of the longest period allowed, by microcontroller."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for one in handover_loops():
        for key, clock in BOARDS.items():
            figures = by_target(results)[wb.handover.TARGETS[key].name][one.name].figures
            time: wb.document.Cell = 1e6 * figures.instructions / clock if figures.instructions else None
            shares: list[wb.document.Cell] = []
            for precision in ("double", "single"):
                fitted = (fit_of(results, one, key, start, precision) for start in (NEAR_START, FAR_START))
                shares += [100 * fit.share if fit else None for fit in fitted]
            name = without_compiler(wb.handover.TARGETS[key].name)
            rows.append((one.name, name, figures.stack, figures.code, figures.data, time, *shares))
    shared = (f"{precision} precision, {start}" for precision in ("double", "single") for start in ("near", "far"))
    columns = (
        wb.document.TableColumn("law"),
        wb.document.TableColumn("machine"),
        *(wb.document.TableColumn(head, "bytes", "right") for head in ("stack", "code", "data")),
        wb.document.TableColumn("time, double precision", "\N{MICRO SIGN}s", "right", digits=3),
        *(wb.document.TableColumn(head, "% of the longest period", "right", digits=2) for head in shared),
    )
    clocks = " and ".join(
        f"{without_compiler(wb.handover.TARGETS[key].name)} at {clock / 1e6:g} MHz"
        for key, clock in BOARDS.items()
        if key != "cortex-m4f-libgcc"
    )
    notes = (
        f"Time: the instructions of a period at one instruction per cycle, {clocks}. Per cent: this time, in double "
        "and in single precision, over the longest period allowed from the near and from the far start. Stack: that of "
        f"the deepest chain of calls from the step, as the compiler reports it; the limit asked for is {STACK:,} "
        "bytes. Code: with constants, at -O2. Data: variables, without the state.",
    )
    return wb.document.ReportTable(
        "sizes",
        "The memory and the time per period that each law takes on a microcontroller.",
        columns,
        tuple(rows),
        notes,
    )


def count_cell(value: float | None) -> wb.document.Cell:
    """A count as a whole number."""
    return None if value is None else int(np.round(value))
