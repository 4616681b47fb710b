"""The header of a law in C: all that whoever calls it must know."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import ArrayLike

from workbench import __version__
from workbench.core import Entry, Layout, SampledLaw
from workbench.core.units import ANY
from workbench.core.validation.refusals import Array
from workbench.engine.machines.c_real import DOUBLE, SINGLE
from workbench.handover.c99.c_costs import FRAME, CallCost
from workbench.handover.c99.c_names import comment, members
from workbench.handover.c99.c_request import Request
from workbench.handover.c99.c_scope import ROOM
from workbench.handover.export_seal import MARK
from workbench.handover.law_graph import graph_of_law

WIDTH = 100
FUSED_WORDS = "each product rounded together with the sum that it is for: the fused"
PORTABLE = "each product and each sum rounded by itself: the portable"
OPTIONS = {"sqrt": "-fno-math-errno", "fma": "(on x86) -mfma"}
STRUCTS: Mapping[str, str] = {
    "readings": "What the instruments read at the instant.",
    "references": "What is wanted at the instant.",
    "commands": "What acts on the plant from the instant to the next.",
    "parameters": "Numbers of the law; NAME_init sets those it was designed with. Change them between two instants.",
}
FLAGS = {
    "OK": (0, ""),
    "BAD_READING": (1, "a reading is not finite: the safe command"),
    "BAD_REFERENCE": (2, "a reference is not finite: the same"),
    "BAD_COMMAND": (4, "a command, also before its limits, or the memory would not be finite: the same"),
}

ANSWERED = FLAGS | {
    "BAD_READING": (1, "a reading is not finite, which the law answers"),
    "BAD_REFERENCE": (2, "a reference is not finite: the same"),
    "BAD_COMMAND": (4, "a command, also before its limits, or the memory would not be finite: the safe command"),
}


def header_of(request: Request, costs: CallCost) -> str:
    """The text of NAME.h."""
    name, law = request.name, request.law
    guard = f"{name.upper()}_H"
    lines = [*block(about(request, costs)), f"#ifndef {guard}", f"#define {guard}", "", "#include <stdint.h>", ""]
    lines += ["#ifdef __cplusplus", 'extern "C" {', "#endif", ""]
    lines += [
        f"#define {name.upper()}_PERIOD {float(law.period)!r} /* s, from one call of {name}_step to the next */",
        "",
    ]
    lines += [f"enum {{ /* flags of {name}_step, which may come together */"]
    lines += [
        f"    {name.upper()}_{flag} = {n},{f' /* {what} */' if what else ''}"
        for flag, (n, what) in (ANSWERED if law.answers_missing else FLAGS).items()
    ]
    lines[-1] = lines[-1].replace(",", "", 1)
    lines += ["};", ""]
    for struct, layout in request.structs.items():
        real = "double" if struct == "parameters" else request.real.type
        start = law.parameters.default if struct == "parameters" else None
        lines += _struct(f"{name}_{struct}", STRUCTS[struct].replace("NAME", name), layout, real, start)
    lines += [f"/* All that the law keeps from one instant to the next; {name}_init fills it. */", "typedef struct {"]
    lines += [f"    {name}_parameters parameters;"] if request.settable and law.parameters.size else []
    lines += ["    uint64_t k; /* number of the instant */"] if law.uses_time else []
    lines += list(_members(law.memory, request.real.type))
    lines += [f"    {request.real.type} {ROOM}[{costs.room}]; /* of the loops of a call */"] if costs.room else []
    lines += [f"    unsigned flags; /* those of the last {name}_step */", f"}} {name}_state;", ""]
    lines += _functions(request)
    lines += ["", "#ifdef __cplusplus", "}", "#endif", "", "#endif"]
    return "\n".join(lines) + "\n"


def about(request: Request, costs: CallCost) -> Iterator[str]:
    """The lines of the comment at the head of both files."""
    law = request.law
    yield f"{law.name}: a control law that runs once in {law.period:g} s."
    yield ""
    yield from _wrapped(f"Made by {MARK} {__version__}{f' with: {request.command}' if request.command else ''}.")
    yield f"Fingerprint of its equations and numbers: {law.fingerprint[:16]}"
    size = "32 bits (single precision)" if request.real is SINGLE else "64 bits (double precision)"
    rounding = FUSED_WORDS if request.fused_products else PORTABLE
    yield from _wrapped(f"Numbers of {size}, {rounding} arithmetic.")
    yield from _wrapped(
        "Compile it without options that change arithmetic, such as -ffast-math, -funsafe-math-optimizations, or "
        "-ffp-contract=fast of clang."
    )
    if request.real is DOUBLE:
        yield from _wrapped(
            "On Cortex-M3 and M4 GCC's library rounds some differences wrongly: take the form cortex-m4."
        )
    yield from _costs(request, costs)
    yield ""
    for name, layout in (("reads", law.readings), ("follows", law.references), ("commands", law.commands)):
        if layout.size:
            yield from _wrapped(f"It {name} {', '.join(map(_quantity, layout.entries))}.")
    for name, (low, high) in law.limits.items():
        yield from _wrapped(f"Limits of {name}: {_numbers(low)} to {_numbers(high)} {law.commands[name].unit}.")
    if law.delay:
        waits = ", ".join(f"{name} {count} period{'' if count == 1 else 's'}" for name, count in law.delay.items())
        yield from _wrapped(
            f"Delay: a command is given so long after it is computed: {waits}. The law does this itself: hand what a "
            "call gives to the actuator as the instant begins. The first commands come from the start of the memory."
        )
    raised = f"the flag {request.name.upper()}_BAD_COMMAND" if law.answers_missing else "a flag"
    yield from _wrapped(
        f"Safe command, where {raised} is raised: {safe_text(request)}. The memory then stays, but for commands on "
        "their way, which become the safe one; after a long gap call the reset."
    )
    yield from _wrapped(
        "All is in the state: one for each loop, whose calls do not overlap. A period without a call is lost."
    )
    if request.settable and request.real is SINGLE:
        yield from _wrapped("Parameters have 64 bits, and what depends on them alone is computed so, once a period.")
    lost = _lost(law) if request.real is SINGLE else []
    if lost:
        yield from _wrapped(f"Note: zero in 32 bits, and no guard of a division any more: {', '.join(lost)}.")
    for note in (*law.notes, *request.warnings):
        yield from _wrapped(f"Note: {note}.".replace("..", "."))


def _costs(request: Request, costs: CallCost) -> Iterator[str]:
    """The lines on operations, stack and libraries."""
    yield ""
    yield from _wrapped(f"A call makes {costs.operations}.")
    stack = request.stack or f"{costs.stack} bytes at most, counted: 8 for each variable and call, and {FRAME} a frame"
    yield from _wrapped(f"Stack of a call: {stack}.")
    yield from _wrapped(_static_memory(request, costs))
    for sentence in request.counts:
        yield from _wrapped(sentence)
    if not request.hardware:
        yield from _wrapped("Link flags: none, not even -lm. It calls no function of a library.")
        return
    names = " and ".join(request.hardware)
    yield from _wrapped(
        f"Link flags: -lm. It calls {names} of C's library, instructions where the processor has "
        f"them: compile it with {' '.join(OPTIONS[name] for name in request.hardware)}. The bits are the same without."
    )


def _static_memory(request: Request, costs: CallCost) -> str:
    """The sentence on the bytes of the state, the arrays of loops among them, and of tables."""
    law, size = request.law, 4 if request.real is SINGLE else 8
    own = 8 * (law.parameters.size * request.settable + law.uses_time)
    total = own + size * (law.memory.size + costs.room) + 4  # the flags
    bytes_ = 8 * -(-total // 8) if size == 8 or own else total
    loops = f", {size * costs.room:,} of them for the arrays of loops" if costs.room else ""
    tables = f" Tables of its numbers: {size * costs.constants:,} bytes of constants." if costs.constants else ""
    return f"Static memory: {bytes_:,} bytes of state{loops}.{tables}"


def _lost(law: SampledLaw) -> list[str]:
    """The numbers of a law that single precision has no number but zero for."""
    numbers = set(graph_of_law(law).numbers.values())
    with np.errstate(under="ignore", over="ignore"):
        return [f"{x:g}" for x in sorted(numbers) if x != 0.0 and np.float32(x) == 0.0]


def block(lines: Iterator[str] | list[str]) -> list[str]:
    """A comment of several lines."""
    return ["/*", *(f" * {comment(line)}".rstrip() for line in lines), " */"]


def _wrapped(text: str) -> list[str]:
    return textwrap.wrap(text, WIDTH, subsequent_indent="    ")


def _quantity(entry: Entry) -> str:
    size = f" ({', '.join(map(str, entry.shape))})" if entry.shape else ""
    return f"{entry.name}{size}{f' [{unit_of(entry)}]' if unit_of(entry) else ''}"


def unit_of(entry: Entry) -> str:
    """The unit of a quantity; none where nobody told it."""
    return "" if entry.unit == ANY else entry.unit


def _numbers(values: ArrayLike) -> str:
    flat = np.unique(np.ravel(values))
    return ", ".join(f"{x:g}" for x in (flat if len(flat) == 1 else np.ravel(values)))


def safe_text(request: Request) -> str:
    """The safe command in words."""
    law = request.law
    parts = law.commands.unpack(request.safe)
    return ", ".join(f"{name} = {_numbers(part)} {law.commands[name].unit}".rstrip() for name, part in parts.items())


def _struct(name: str, about: str, layout: Layout, real: str, start: Array | None = None) -> list[str]:
    values: Mapping[str, Array] = {} if start is None else layout.unpack(start)
    return [f"/* {comment(about)} */", "typedef struct {", *_members(layout, real, values), f"}} {name};", ""]


def _members(layout: Layout, real: str, values: Mapping[str, Array] | None = None) -> Iterator[str]:
    names = members(layout)
    for entry in layout.entries:
        size = f"[{entry.size}]" if entry.shape else ""
        rows = f"{entry.shape[0]} x {entry.shape[1]}, column by column" if len(entry.shape) == 2 else ""
        label = entry.name if member_differs(entry.name, names[entry.name]) else ""
        value = _numbers(values[entry.name]) if values and entry.size <= 4 else ""
        said = "; ".join(
            part for part in (f"{label} [{unit_of(entry)}]" if unit_of(entry) else label, rows, value) if part
        )
        yield f"    {real} {names[entry.name]}{size};{f' /* {comment(said.strip())} */' if said else ''}"


def member_differs(name: str, own: str) -> bool:
    """True if the member of a struct has another name than its quantity."""
    return name != own


def _functions(request: Request) -> list[str]:
    name, law = request.name, request.law
    return [
        f"/* Fill the state: the memory at its start{', the numbers of the design' if request.settable else ''}. */",
        f"void {name}_init({name}_state *state);",
        "",
        f"/* Put the memory{' and the clock' if law.uses_time else ''} back to the start. */",
        f"void {name}_reset({name}_state *state);",
        "",
        "/* One instant: from readings to commands. Returns the flags. */",
        f"{prototype(request)};",
    ]


def prototype(request: Request, returns: str = "unsigned", verb: str = "step") -> str:
    """The declaration of NAME_step, or of another function with its arguments, without a semicolon."""
    name = request.name
    inputs = [f"const {name}_{port} *{port}" for port in request.inputs]
    arguments = [f"{name}_state *state", *inputs, f"{name}_commands *commands"]
    head = f"{returns} {name}_{verb}("
    line = f"{head}{', '.join(arguments)})"
    return line if len(line) <= WIDTH else head + f",\n{' ' * len(head)}".join(arguments) + ")"
