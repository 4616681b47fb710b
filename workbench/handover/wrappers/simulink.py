"""A block of Simulink around the C of a law: a Level-2 S-function in C, and the command that builds it."""

from __future__ import annotations

from typing import NamedTuple

from workbench.core.layout import Entry, Layout
from workbench.core.notation.comments import harmless
from workbench.core.templates import fill
from workbench.core.validation.refusals import require
from workbench.core.validation.signatures import check_arguments
from workbench.handover.c99.c_files import CCode
from workbench.handover.c99.c_names import members
from workbench.handover.export_seal import MARK


@check_arguments
def simulink(code: CCode) -> dict[str, str]:
    """The files of a Simulink block, by name: NAME_sfun.c, NAME_build.m, and the header and source of the law.

    The block runs once in the period of the law. It has an input port for each reading, then for each reference; an
    output port for each command, then one for the flags (uint32). Parameters that can be set are those of its dialog,
    in the order of the header, a matrix as MATLAB holds it.
    """
    code = require("simulink(code=...)", code, CCode)
    law = code.law
    parameters = law.parameters if code.settable else Layout()
    names = {"name": code.name, "mark": MARK}
    source = fill(
        "workbench.handover",
        "simulink/s_function.c.j2",
        **names,
        upper=code.name.upper(),
        title=harmless(law.name),
        period=repr(law.period),
        inputs=[*_ports(law.readings, "readings"), *_ports(law.references, "references")],
        outputs=_ports(law.commands, "commands"),
        parameters=_ports(parameters, "parameters"),
        references=law.references.size,
        port_type="SS_SINGLE" if code.real == "float" else "SS_DOUBLE",
    )
    build = fill("workbench.handover", "simulink/build.m.j2", **names)
    return {f"{code.name}_sfun.c": source, f"{code.name}_build.m": build, **code.files}


class _Port(NamedTuple):
    """A port or a parameter of the block: its place in the structures of the law, and a line about it."""

    struct: str
    member: str
    size: int
    about: str


def _ports(layout: Layout, struct: str) -> list[_Port]:
    names = members(layout)
    return [_Port(struct, names[entry.name], entry.size, _line_about(entry)) for entry in layout.entries]


def _line_about(entry: Entry) -> str:
    unit = f" [{entry.unit}]" if entry.unit else ""
    return harmless(f"{entry.name}{unit}, {entry.size} number{'s' * (entry.size != 1)}")
