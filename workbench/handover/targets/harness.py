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
from string import Template
from typing import Any

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.handover.c99.c_code import CCode
from workbench.handover.c99.c_names import members
from workbench.handover.memory_digest import Words
from workbench.handover.targets.programs import TargetError

INPUTS, ANSWERS, MAIN, PLATFORM = "inputs", "answers", "main.c", "platform.c"

PLATFORM_HEADER = """\
#include <stddef.h>
#include <stdint.h>

void platform_start(void);
void platform_read(void *to, size_t bytes);
void platform_write(const void *from, size_t bytes);
uint32_t platform_ticks(void);   /* counts up, and begins again behind its last number */
void platform_paint(void);       /* marks the stack that is free */
uint64_t platform_depth(void);   /* bytes of it that have changed since */
void platform_end(void);
"""

HOSTED = """\
#include "platform.h"

#include <stdio.h>
#include <stdlib.h>

static FILE *inputs, *answers;

void platform_start(void)
{
    inputs = fopen("inputs", "rb");
    answers = fopen("answers", "wb");
    if (inputs == NULL || answers == NULL) exit(2);
}

void platform_read(void *to, size_t bytes)
{
    if (fread(to, 1, bytes, inputs) != bytes) exit(3);
}

void platform_write(const void *from, size_t bytes)
{
    if (fwrite(from, 1, bytes, answers) != bytes) exit(4);
}

uint32_t platform_ticks(void) { return 0; }
void platform_paint(void) {}
uint64_t platform_depth(void) { return 0; }

void platform_end(void)
{
    fclose(inputs);
    exit(fclose(answers) != 0 ? 5 : 0);
}
"""

HARNESS = Template("""\
#include "$name.h"
#include "platform.h"

#include <string.h>

typedef $real real;
typedef $word word;

enum { READINGS = $readings, REFERENCES = $references, COMMANDS = $commands, MEMORY = $memory, BLOCK = 64 };

typedef char readings_fit[sizeof(${name}_readings) == READINGS * sizeof(real) ? 1 : -1];
typedef char commands_fit[sizeof(${name}_commands) == COMMANDS * sizeof(real) ? 1 : -1];

typedef unsigned step_of(${name}_state *state, const ${name}_readings *y, $type${name}_commands *u);

static unsigned idle(${name}_state *s, const ${name}_readings *y, $type${name}_commands *u)
{
    (void)s, (void)y, $void(void)u;
    return 0;
}

static step_of *volatile step = ${name}_step; /* a compiler cannot know which one is called */
static ${name}_state state, saved;
static real rows[BLOCK][READINGS + REFERENCES];
static struct { real u[COMMANDS]; uint64_t flags, digest; } answers[BLOCK];
static uint64_t figures[4];

static uint64_t digested(uint64_t total, const void *at, size_t count)
{
    const unsigned char *from = at;
    while (count-- > 0) {
        real x;
        word bits;
        size_t i;
        memcpy(&x, from, sizeof x);
        memcpy(&bits, from, sizeof bits);
        if (x != x) bits = (word)$nan;
        for (i = 0; i < sizeof bits; i++) {
            total = (total ^ ((bits >> (8 * i)) & 0xFFu)) * UINT64_C(0x100000001B3);
        }
        from += sizeof x;
    }
    return total;
}

static unsigned called(const real *row, real *u)
{
    ${name}_readings y;
$declare
    ${name}_commands out = {0};
    unsigned flags;
    memcpy(&y, row, sizeof y);
$fill
    flags = step(&state, &y, $pass&out);
    memcpy(u, &out, sizeof out);
    return flags;
}

static uint64_t memory_digest(void)
{
    uint64_t total = UINT64_C(0xCBF29CE484222325);
$digest
    return total;
}

static void count(size_t periods)
{
    size_t i;
    uint32_t begin, past;
    real u[COMMANDS];
    saved = state;
    begin = platform_ticks();
    for (i = 0; i < periods; i++) called(rows[i], u);
    figures[0] += (uint32_t)(platform_ticks() - begin);
    step = idle;
    begin = platform_ticks();
    for (i = 0; i < periods; i++) called(rows[i], u);
    figures[1] += (uint32_t)(platform_ticks() - begin);
    step = ${name}_step;
    state = saved;
    for (i = 0; i < periods; i++) {
        begin = platform_ticks();
        called(rows[i], u);
        past = platform_ticks() - begin;
        if (past > figures[2]) figures[2] = past;
    }
    state = saved;
}

static void deepest(const real *row, real *u)
{
    uint64_t depth;
    saved = state;
    platform_paint();
    called(row, u);
    depth = platform_depth();
    if (depth > figures[3]) figures[3] = depth;
    state = saved;
}

int main(void)
{
    uint64_t head[2], left;
    platform_start();
    platform_read(head, sizeof head);
    ${name}_init(&state);
    for (left = head[0]; left > 0;) {
        size_t i, periods = left < BLOCK ? (size_t)left : (size_t)BLOCK;
        platform_read(rows, periods * sizeof rows[0]);
        if (head[1] != 0) {
            count(periods);
            deepest(rows[0], answers[0].u);
        }
        for (i = 0; i < periods; i++) {
            answers[i].flags = called(rows[i], answers[i].u);
            answers[i].digest = memory_digest();
        }
        for (i = 0; i < periods; i++) {
            platform_write(answers[i].u, sizeof answers[i].u);
            platform_write(&answers[i].flags, 2 * sizeof(uint64_t));
        }
        left -= periods;
    }
$write
    platform_write(figures, sizeof figures);
    platform_end();
    return 0;
}
""")


@dataclass(frozen=True, eq=False)
class Answers:
    """The commands (N, nu) of a target, its flags and the digests of its memory (N,), and the memory (nz,) at the end.

    Figures are those of the file of answers, or none. Digests and memory are None where a target cannot show them.
    """

    u: Array
    flags: Words
    digests: Words | None
    memory: Array | None
    figures: tuple[int, int, int, int] = (0, 0, 0, 0)


def real_of(code: CCode) -> Any:
    """The type of the numbers of a code in the files."""
    return np.dtype("<f4" if code.real == "float" else "<f8")


def program(code: CCode) -> dict[str, str]:
    """The texts of the harness, of its platform's header, and of the law, by the names of their files."""
    law, name = code.law, code.name
    kept = [f"state.{member}" for member in members(law.memory).values()]
    double, follows = code.real == "double", law.references.size > 0
    skip = law.readings.size
    text = HARNESS.substitute(
        name=name,
        real=code.real,
        word="uint64_t" if double else "uint32_t",
        nan="UINT64_C(0x7FF8000000000000)" if double else "UINT32_C(0x7FC00000)",
        readings=law.readings.size,
        references=law.references.size,
        commands=law.commands.size,
        memory=law.memory.size,
        declare=f"    {name}_references r;" * follows,
        fill=f"    memcpy(&r, row + {skip}, sizeof r);" * follows,
        type=f"const {name}_references *r, " * follows,
        void="(void)r, " * follows,
        **{"pass": "&r, " * follows},
        digest="\n".join(f"    total = digested(total, &{part}, sizeof {part} / sizeof(real));" for part in kept),
        write="\n".join(f"    platform_write(&{part}, sizeof {part});" for part in kept),
    )
    return {MAIN: text, "platform.h": PLATFORM_HEADER, **code.files}


def write_inputs(code: CCode, rows: Array, folder: Path, counted: bool = False) -> None:
    """Write the inputs (N, ny + nr) of a law to a folder."""
    with (folder / INPUTS).open("wb") as file:
        file.write(np.array([len(rows), counted], dtype="<u8").tobytes())
        np.ascontiguousarray(rows, dtype=real_of(code)).tofile(file)


def read_answers(code: CCode, periods: int, folder: Path) -> Answers:
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
    return Answers(rows["u"], rows["flags"], rows["digest"], last["memory"], (first, second, third, fourth))
