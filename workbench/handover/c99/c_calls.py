"""The functions of a law in C that its user calls: NAME_step around the law's own lines, NAME_reset and NAME_init."""

from __future__ import annotations

from typing import Any

import numpy as np

from workbench.core import Layout, SampledLaw
from workbench.handover.c99.c_header import prototype
from workbench.handover.c99.c_names import members
from workbench.handover.c99.c_primitives import DOUBLE, SINGLE


def places_of(layout: Layout) -> list[str]:
    """The members of a struct for the numbers of a layout, in their order."""
    names = members(layout)
    return [
        f"{names[entry.name]}{f'[{i}]' if entry.shape else ''}" for entry in layout.entries for i in range(entry.size)
    ]


def step_of(code: Any) -> list[str]:
    """The lines of NAME_step."""
    name, structs, law, real = code.name, code.structs, code.law, SINGLE if code.real == "float" else DOUBLE
    finite = f"{name}_finite{real.mark}"

    def check(port: str, layout: Layout, flag: str) -> list[str]:
        conditions = [f"!{finite}({port}->{place})" for place in places_of(layout)]
        joined = " ||\n        ".join(conditions)
        return [f"    if ({joined}) {{", f"        flags |= (unsigned){name.upper()}_{flag};", "    }"]

    lines = [prototype(code), "{", f"    unsigned flags = (unsigned){name.upper()}_OK;"]
    lines += check("readings", law.readings, "BAD_READING") if "readings" in structs else []
    lines += check("references", law.references, "BAD_REFERENCE") if "references" in structs else []
    call = ", ".join(["state", *(port for port in ("readings", "references") if port in structs), "commands"])
    lines += [f"    if ((flags == 0u) && !{name}_advance({call})) {{"]
    lines += [f"        flags |= (unsigned){name.upper()}_BAD_COMMAND;", "    }", "    if (flags != 0u) {"]
    safe = zip(places_of(law.commands), code.safe.tolist(), strict=True)
    lines += [f"        commands->{place} = {real.literal(value)};" for place, value in safe]
    lines += [f"        state->{place} = {real.literal(value)};" for place, value in _waiting(code)]
    lines += ["    }"]
    lines += ["    state->k += 1u;"] if law.uses_time else []
    return [*lines, "    state->flags = flags;", "    return flags;", "}"]


def _waiting(code: Any) -> list[tuple[str, float]]:
    """The places of commands on their way, with the safe command: none that was meant for another instant comes."""
    law: SampledLaw = code.law
    safe = law.commands.unpack(code.safe)
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


def reset_of(code: Any) -> list[str]:
    """The lines of NAME_reset."""
    law, real = code.law, SINGLE if code.real == "float" else DOUBLE
    start = zip(places_of(law.memory), law.memory.default.tolist(), strict=True)
    lines = [f"    state->{place} = {real.literal(value)};" for place, value in start]
    lines += ["    state->k = 0u;"] if law.uses_time else []
    return [f"void {code.name}_reset({code.name}_state *state)", "{", *lines, "    state->flags = 0u;", "}"]


def init_of(code: Any) -> list[str]:
    """The lines of NAME_init."""
    law = code.law
    lines = []
    if code.settable and law.parameters.size:
        own = zip(places_of(law.parameters), law.parameters.default.tolist(), strict=True)
        lines = [f"    state->parameters.{place} = {value!r};" for place, value in own]
    return [f"void {code.name}_init({code.name}_state *state)", "{", *lines, f"    {code.name}_reset(state);", "}"]
