"""A program around the C of a law, which leaves that as it is: it reads inputs, calls the step, and writes answers.

The file `inputs` holds two whole numbers of 64 bits, the number of periods and 1 if instructions are to be counted;
then a record of readings and references for each period. The file `answers` receives a record of each period: the
commands, then 64 bits each of the flags and of the digest of the memory; behind the last one the memory itself, and
four numbers of 64 bits: ticks of all calls, ticks of the same loop without them, the most ticks of one call, and the
bytes of stack that a call has touched. Ticks and stack are zero where a platform does not count them. All numbers have
their least byte first.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from workbench.core.templates import fill, template_text
from workbench.core.validation.refusals import Array
from workbench.handover.c99.c_files import CCode
from workbench.handover.c99.c_names import members
from workbench.handover.memory_digest import Reals, Words
from workbench.handover.targets.external_programs import TargetError

INPUTS, ANSWERS, MAIN, PLATFORM, HEADER = "inputs", "answers", "main.c", "platform.c", "platform.h"


@dataclass(frozen=True, eq=False)
class TargetAnswers:
    """The commands (N, nu) of a target, its flags and the digests of its memory (N,), and the memory (nz,) at the end.

    Figures are those of the file of answers, or none. Digests and memory are None where a target cannot show them.
    """

    u: Reals
    flags: Words
    digests: Words | None
    memory: Reals | None
    figures: tuple[int, int, int, int] = (0, 0, 0, 0)


def real_of(code: CCode) -> np.dtype[np.floating]:
    """The type of the numbers of a code in the files."""
    return np.dtype("<f4" if code.real == "float" else "<f8")


def program(code: CCode) -> dict[str, str]:
    """The texts of the harness, of its platform's header, and of the law, by the names of their files."""
    law, double = code.law, code.real == "double"
    text = fill(
        "workbench.handover",
        "targets/harness.c.j2",
        name=code.name,
        real=code.real,
        word="uint64_t" if double else "uint32_t",
        nan="UINT64_C(0x7FF8000000000000)" if double else "UINT32_C(0x7FC00000)",
        readings=law.readings.size,
        references=law.references.size,
        commands=law.commands.size,
        memory=law.memory.size,
        members=list(members(law.memory).values()),
    )
    return {MAIN: text, HEADER: platform_header(), **code.files}


def platform_header() -> str:
    """The functions that the program takes from the platform that it runs on."""
    return template_text("workbench.handover", "targets/platform.h")


def hosted_platform() -> str:
    """These functions for an operating system."""
    return template_text("workbench.handover", "targets/hosted_platform.c")


def write_inputs(code: CCode, rows: Array, folder: Path, count_instructions: bool = False) -> None:
    """Write the inputs (N, ny + nr) of a law to a folder."""
    with (folder / INPUTS).open("wb") as file:
        file.write(np.array([len(rows), count_instructions], dtype="<u8").tobytes())
        np.ascontiguousarray(rows, dtype=real_of(code)).tofile(file)


def read_answers(code: CCode, periods: int, folder: Path) -> TargetAnswers:
    """The answers of so many periods in a folder; a TargetError if the file is none of these."""
    law, real = code.law, real_of(code)
    record = np.dtype([("u", real, (law.commands.size,)), ("flags", "<u8"), ("digest", "<u8")])
    end = np.dtype([("memory", real, (law.memory.size,)), ("figures", "<u8", (4,))])
    data = (folder / ANSWERS).read_bytes()
    if len(data) != periods * record.itemsize + end.itemsize:
        raise TargetError(
            f"the answers of {periods} periods must have {periods * record.itemsize + end.itemsize} bytes, "
            f"and {len(data)} were written"
        )
    rows = np.frombuffer(data, record, periods)
    last = np.frombuffer(data, end, 1, periods * record.itemsize)[0]
    first, second, third, fourth = (int(number) for number in last["figures"])
    return TargetAnswers(rows["u"], rows["flags"], rows["digest"], last["memory"], (first, second, third, fourth))
