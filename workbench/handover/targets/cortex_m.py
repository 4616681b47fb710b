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

from workbench.handover.c99.c_code import CCode
from workbench.handover.recording import Recording
from workbench.handover.targets import harness
from workbench.handover.targets.compilers import COUNTED, sizes_of, write_files
from workbench.handover.targets.contract import AbstractTarget, Figures
from workbench.handover.targets.harness import Answers
from workbench.handover.targets.programs import run
from workbench.handover.targets.soft_doubles import SOFT_DOUBLES, SOFT_DOUBLES_FILE, WRAPS

PREFIX = "arm-none-eabi-"
INSTRUCTIONS_A_TICK = 40  # of a timer at 25 MHz
PROGRAM, LAYOUT = "law.elf", "board.ld"
STANDARD = ("-std=c99", "-Wall", "-Wextra", "-mthumb", "-mfloat-abi=hard", "-O2")

BOARD = """\
ENTRY(reset)
MEMORY
{
    CODE (rx) : ORIGIN = 0x00000000, LENGTH = 4M
    DATA (rwx) : ORIGIN = 0x20000000, LENGTH = 4M
}
SECTIONS
{
    .text : { KEEP(*(.vectors)) *(.text*) *(.rodata*) . = ALIGN(8); } > CODE
    .ARM.exidx : { *(.ARM.exidx*) } > CODE
    .data : ALIGN(8) { data_begin = .; *(.data*) . = ALIGN(8); data_end = .; } > DATA AT > CODE
    data_load = LOADADDR(.data);
    .bss (NOLOAD) : ALIGN(8) { bss_begin = .; *(.bss*) *(COMMON) . = ALIGN(8); bss_end = .; } > DATA
    stack_limit = bss_end;
    stack_top = ORIGIN(DATA) + LENGTH(DATA);
}
"""

PLATFORM = """\
#include "platform.h"

#include <string.h>

enum { OPEN = 0x01, CLOSE = 0x02, WRITE = 0x05, READ = 0x06, EXIT = 0x18 };
enum { FOR_READING = 1, FOR_WRITING = 5 };          /* "rb" and "wb" */
enum { FINISHED = 0x20026, FAILED = 0x20023 };
enum { PAINTED = 64 * 1024, FREE = 64, MARK = 0xA5 };

#define TIMER ((volatile uint32_t *)0x40000000)     /* control, value, reload */
#define COPROCESSORS (*(volatile uint32_t *)0xE000ED88)

extern uint32_t data_begin[], data_end[], data_load[], bss_begin[], bss_end[], stack_top[];
int main(void);
void reset(void);
static void fault(void);
static int inputs, answers;
static unsigned char *low, *high;

__attribute__((section(".vectors"), used)) static void *const vectors[16] = {
    stack_top, reset, fault, fault, fault, fault, fault, fault, fault, fault, fault, fault, fault, fault, fault, fault
};

static int ask(int operation, const void *words)
{
    register int r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = words;
    __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

static void leave(int reason)
{
    ask(EXIT, (const void *)reason);
    for (;;) {}
}

static void fault(void) { leave(FAILED); }

void reset(void)
{
    COPROCESSORS |= 0xFu << 20;                     /* the floating-point unit is off at the start */
    __asm__ volatile("dsb\\n isb" ::: "memory");
    memcpy(data_begin, data_load, (size_t)((char *)data_end - (char *)data_begin));
    memset(bss_begin, 0, (size_t)((char *)bss_end - (char *)bss_begin));
    main();
    leave(FAILED);
}

static int opened(const char *name, uint32_t mode)
{
    const uint32_t words[3] = {(uint32_t)name, mode, (uint32_t)strlen(name)};
    const int file = ask(OPEN, words);
    if (file == -1) leave(FAILED);
    return file;
}

void platform_start(void)
{
    inputs = opened("inputs", FOR_READING);
    answers = opened("answers", FOR_WRITING);
    TIMER[2] = 0xFFFFFFFFu;
    TIMER[1] = 0xFFFFFFFFu;
    TIMER[0] = 1u;
}

void platform_read(void *to, size_t bytes)
{
    const uint32_t words[3] = {(uint32_t)inputs, (uint32_t)to, bytes};
    if (ask(READ, words) != 0) leave(FAILED);
}

void platform_write(const void *from, size_t bytes)
{
    const uint32_t words[3] = {(uint32_t)answers, (uint32_t)from, bytes};
    if (bytes != 0 && ask(WRITE, words) != 0) leave(FAILED);
}

uint32_t platform_ticks(void) { return 0xFFFFFFFFu - TIMER[1]; }

__attribute__((noinline)) void platform_paint(void)
{
    unsigned char *at;
    __asm__ volatile("mov %0, sp" : "=r"(high));
    low = high - PAINTED;
    for (at = low; at < high - FREE; at++) *(volatile unsigned char *)at = MARK;
}

__attribute__((noinline)) uint64_t platform_depth(void)
{
    const volatile unsigned char *at = low;
    while (at < high - FREE && *at == MARK) at++;
    return at < high - FREE ? (uint64_t)(high - at) : (uint64_t)FREE;
}

void platform_end(void)
{
    const uint32_t words[1] = {(uint32_t)answers};
    ask(CLOSE, words);
    leave(FINISHED);
}
"""


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

    def answers(self, code: CCode, recording: Recording, folder: Path, seconds: float) -> Answers:
        """The answers of the program."""
        write_files({**harness.program(code), harness.PLATFORM: PLATFORM, LAYOUT: BOARD}, folder)
        sources = [harness.MAIN, harness.PLATFORM, f"{code.name}.c"]
        if self.exact:
            write_files({SOFT_DOUBLES_FILE: SOFT_DOUBLES}, folder)
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

    def figures(self, code: CCode, recording: Recording, folder: Path, seconds: float) -> Figures:
        """Instructions of blocks of calls less those of the loop without the law, and the stack that they touch."""
        rows = recording.inputs[:COUNTED]
        harness.write_inputs(code, rows, folder, counted=True)
        self.emulate(folder, seconds, "-icount", "shift=0")
        whole, empty, most, touched = harness.read_answers(code, len(rows), folder).figures
        options = (*STANDARD[3:], *self.options)
        stack, sizes, smallest = sizes_of(code, folder, f"{PREFIX}gcc", options, f"{PREFIX}size", seconds)
        instructions = INSTRUCTIONS_A_TICK * (whole - empty) / len(rows)
        return Figures(instructions, most * INSTRUCTIONS_A_TICK, stack, touched, *sizes, smallest)


M4F = ("-mcpu=cortex-m4", "-mfpu=fpv4-sp-d16")
CORTEX_M4F = Microcontroller("Cortex-M4F with mended sums, gcc -O2, QEMU", "mps2-an386", M4F, exact=True)
CORTEX_M4F_AS_IT_IS = Microcontroller("Cortex-M4F with libgcc alone, gcc -O2, QEMU", "mps2-an386", M4F)
CORTEX_M7 = Microcontroller("Cortex-M7, gcc -O2, QEMU", "mps2-an500", ("-mcpu=cortex-m7", "-mfpu=fpv5-d16"))
