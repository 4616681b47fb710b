"""The functions of a law in C that its user calls: NAME_step around the law's own lines, NAME_reset and NAME_init."""

from __future__ import annotations

import numpy as np

from workbench.core import Layout, SampledLaw
from workbench.handover.c99.c_header import prototype
from workbench.handover.c99.c_names import places_of
from workbench.handover.c99.c_request import Request


def step_of(request: Request) -> list[str]:
    """The lines of NAME_step."""
    name, law, real = request.name, request.law, request.real
    finite = f"{name}_finite{real.mark}"

    def check(port: str, layout: Layout, flag: str) -> list[str]:
        conditions = [f"!{finite}({port}->{place})" for place in places_of(layout)]
        joined = " ||\n        ".join(conditions)
        return [f"    if ({joined}) {{", f"        flags |= (unsigned){name.upper()}_{flag};", "    }"]

    lines = [prototype(request), "{", f"    unsigned flags = (unsigned){name.upper()}_OK;"]
    lines += check("readings", law.readings, "BAD_READING") if "readings" in request.inputs else []
    lines += check("references", law.references, "BAD_REFERENCE") if "references" in request.inputs else []
    call = ", ".join(("state", *request.inputs, "commands"))
    bad = f"(unsigned){name.upper()}_BAD_COMMAND"
    first, held = ("", f"(flags & {bad}) != 0u") if law.answers_missing else ("(flags == 0u) && ", "flags != 0u")
    lines += [f"    if ({first}!{name}_advance({call})) {{"]
    lines += [f"        flags |= {bad};", "    }", f"    if ({held}) {{"]
    safe = zip(places_of(law.commands), request.safe.tolist(), strict=True)
    lines += [f"        commands->{place} = {real.literal(value)};" for place, value in safe]
    lines += [f"        state->{place} = {real.literal(value)};" for place, value in _waiting(request)]
    lines += ["    }"]
    lines += ["    state->k += 1u;"] if law.uses_time else []
    return [*lines, "    state->flags = flags;", "    return flags;", "}"]


def _waiting(request: Request) -> list[tuple[str, float]]:
    """The places of commands on their way, with the safe command: none that was meant for another instant comes."""
    law = request.law
    safe = law.commands.unpack(request.safe)
    return [
        pair
        for entry in law.memory.entries
        if entry.name in (places := queue_places(law))
        for pair in zip(
            places_of(Layout((entry,))),
            np.concatenate([np.ravel(safe[name], order="F") for name in places[entry.name]]).tolist(),
            strict=True,
        )
    ]


def queue_places(law: SampledLaw) -> dict[str, list[str]]:
    """The commands in each place of the queue, by the name that it has in the memory."""
    longest = max(law.delay.values(), default=0)
    return {
        "hold.next" if i == 1 else f"hold.next.{i}": [
            name for name in law.commands.names if law.delay.get(name, 0) >= i
        ]
        for i in range(1, longest + 1)
    }


def reset_of(request: Request) -> list[str]:
    """The lines of NAME_reset."""
    law, real = request.law, request.real
    start = zip(places_of(law.memory), law.memory.default.tolist(), strict=True)
    lines = [f"    state->{place} = {real.literal(value)};" for place, value in start]
    lines += ["    state->k = 0u;"] if law.uses_time else []
    return [f"void {request.name}_reset({request.name}_state *state)", "{", *lines, "    state->flags = 0u;", "}"]


def init_of(request: Request) -> list[str]:
    """The lines of NAME_init."""
    law = request.law
    lines = []
    if request.settable and law.parameters.size:
        own = zip(places_of(law.parameters), law.parameters.default.tolist(), strict=True)
        lines = [f"    state->parameters.{place} = {value!r};" for place, value in own]
    return [
        f"void {request.name}_init({request.name}_state *state)",
        "{",
        *lines,
        f"    {request.name}_reset(state);",
        "}",
    ]
