"""A request: a law, and how it shall be written in C."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from workbench.core import Layout, SampledLaw
from workbench.core.validation.refusals import Array
from workbench.engine.machines.c_real import DOUBLE, SINGLE, Real


@dataclass(frozen=True, eq=False)
class Request:
    """A law, and how it shall be written in C.

    Attributes
    ----------
    name
        The prefix of all that is visible.
    precision
        "double" or "single".
    settable
        True if parameters can be changed between two instants.
    safe
        The command where a flag is raised, (nu,).
    warnings, command
        Sentences, and the command that made the code, for whoever reads the header.
    hardware
        "sqrt" and "fma", where the processor's own are called by C's library.
    stack
        The stack of a call in words, where it was measured.
    counts
        Sentences on the instructions of a period, where they were counted.
    """

    name: str
    law: SampledLaw
    precision: str
    settable: bool
    safe: Array
    warnings: tuple[str, ...] = ()
    command: str = ""
    hardware: tuple[str, ...] = ()
    stack: str = ""
    counts: tuple[str, ...] = ()

    @property
    def real(self) -> Real:
        """The format of readings, references, commands and memory."""
        return SINGLE if self.precision == "single" else DOUBLE

    @property
    def fused_products(self) -> bool:
        """True if products are rounded together with sums."""
        return "fma" in self.hardware

    @property
    def structs(self) -> Mapping[str, Layout]:
        """The layouts of the structs by their names, those with members alone."""
        law = self.law
        ports = {"readings": law.readings, "references": law.references, "commands": law.commands}
        ports |= {"parameters": law.parameters} if self.settable else {}
        return {name: layout for name, layout in ports.items() if layout.size}

    @property
    def inputs(self) -> tuple[str, ...]:
        """The structs that a call is handed."""
        return tuple(port for port in ("readings", "references") if port in self.structs)
