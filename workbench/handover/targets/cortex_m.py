"""Cortex-M4F and Cortex-M7 under QEMU: a law on a bare processor, which reads and writes files by semihosting.

QEMU counts instructions, not cycles: with `-icount shift=0` each takes a nanosecond of its clock, which a timer of the
board counts in ticks of 40.

References
----------
Arm, Semihosting for AArch32 and AArch64, 2.0, section 5: the operations. Arm, CMSDK technical reference manual, section
4.4: the timer.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from workbench.core.templates import template_text
from workbench.handover.c99.c_files import CCode
from workbench.handover.recording import Recording
from workbench.handover.targets import harness
from workbench.handover.targets.compilers import COUNTED_PERIODS, sizes_of, write_files
from workbench.handover.targets.external_programs import run
from workbench.handover.targets.harness import TargetAnswers
from workbench.handover.targets.soft_doubles import SOFT_DOUBLES_FILE, WRAPS, soft_doubles
from workbench.handover.targets.target import AbstractTarget, TargetCost

PREFIX = "arm-none-eabi-"
INSTRUCTIONS_A_TICK = 40  # of a timer at 25 MHz
PROGRAM, LAYOUT = "law.elf", "board.ld"
STANDARD = ("-std=c99", "-Wall", "-Wextra", "-mthumb", "-mfloat-abi=hard", "-O2")


def board_files() -> dict[str, str]:
    """The start and the semihosting of a board, and the layout of its memory for the linker."""
    platform = template_text("workbench.handover", "targets/cortex_m_platform.c")
    return {harness.PLATFORM: platform, LAYOUT: template_text("workbench.handover", "targets/cortex_m_board.ld")}


@dataclass(frozen=True)
class Microcontroller(AbstractTarget):
    """A Cortex-M of a board of QEMU, with the options by which GCC compiles for it.

    One without instructions for doubles takes its sums from GCC's library, or, `exact`, from `soft_doubles` where that
    rounds wrongly.
    """

    name: str
    board: str
    options: tuple[str, ...]
    exact: bool = False

    @property
    def programs(self) -> tuple[str, ...]:
        """GCC for it, and the emulator."""
        return (f"{PREFIX}gcc", "qemu-system-arm")

    @property
    def support_files(self) -> dict[str, str]:
        """The start of the board, its files by semihosting and the layout of its memory, for a program of your own."""
        return {**board_files(), harness.HEADER: harness.platform_header()}

    @property
    def compiler_options(self) -> tuple[str, ...]:
        """The options of GCC for the processor, with the level of optimisation, for C and C++."""
        return (*STANDARD[3:], *self.options)

    def answers(self, code: CCode, recording: Recording, folder: Path, seconds: float) -> TargetAnswers:
        """The answers of the program."""
        write_files({**harness.program(code), **board_files()}, folder)
        sources = [harness.MAIN, harness.PLATFORM, f"{code.name}.c"]
        if self.exact:
            write_files({SOFT_DOUBLES_FILE: soft_doubles()}, folder)
            sources += [SOFT_DOUBLES_FILE, *WRAPS]
        bare = ["-nostartfiles", "-T", LAYOUT, "-Wl,--no-warn-rwx-segments"]
        run([f"{PREFIX}gcc", *STANDARD, *self.options, *bare, *sources, "-o", PROGRAM], folder, seconds)
        harness.write_inputs(code, recording.inputs, folder)
        self.emulate(folder, seconds)
        return harness.read_answers(code, recording.periods, folder)

    def emulate(self, folder: Path, seconds: float, *options: str) -> None:
        """Run the program of a folder to its end."""
        board = ["-M", self.board, "-display", "none", "-monitor", "none", "-serial", "none", "-nodefaults"]
        hosting = ["-semihosting-config", "enable=on,target=native"]
        run(["qemu-system-arm", *board, *hosting, *options, "-kernel", PROGRAM], folder, seconds)

    def figures(self, code: CCode, recording: Recording, folder: Path, seconds: float) -> TargetCost:
        """Instructions of blocks of calls less those of the loop without the law, and the stack that they touch."""
        rows = recording.inputs[:COUNTED_PERIODS]
        harness.write_inputs(code, rows, folder, count_instructions=True)
        self.emulate(folder, seconds, "-icount", "shift=0")
        whole, empty, most, touched = harness.read_answers(code, len(rows), folder).figures
        options = self.compiler_options
        stack, sizes, smallest = sizes_of(code, folder, f"{PREFIX}gcc", options, f"{PREFIX}size", seconds)
        instructions = INSTRUCTIONS_A_TICK * (whole - empty) / len(rows)
        return TargetCost(instructions, most * INSTRUCTIONS_A_TICK, stack, touched, *sizes, smallest)


M4F = ("-mcpu=cortex-m4", "-mfpu=fpv4-sp-d16")
CORTEX_M4F = Microcontroller("Cortex-M4F with mended sums, gcc -O2, QEMU", "mps2-an386", M4F, exact=True)
CORTEX_M4F_AS_IT_IS = Microcontroller("Cortex-M4F with libgcc alone, gcc -O2, QEMU", "mps2-an386", M4F)
CORTEX_M7 = Microcontroller("Cortex-M7, gcc -O2, QEMU", "mps2-an500", ("-mcpu=cortex-m7", "-mfpu=fpv5-d16"))
