"""A sampled law as C99: one header and one source, straight lines from the graph that every machine evaluates."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypedDict

import numpy as np

from workbench.core import Layout, SampledLaw
from workbench.core.validation.number_types import Values
from workbench.core.validation.refusals import Array, known_name, numbers, one_of, require
from workbench.core.validation.signatures import check_arguments
from workbench.handover.c99.c_costs import CallCost
from workbench.handover.c99.c_header import header_of
from workbench.handover.c99.c_names import member, members, prefix_of
from workbench.handover.c99.c_request import Request
from workbench.handover.c99.c_source import source_of
from workbench.handover.export_folder import write_files

PRECISIONS, PARAMETERS = ("double", "single"), ("constant", "settable")
WAYS = ("portable", "hardware")


class COptions(TypedDict, total=False):
    """The options of `c_code` by name."""

    precision: str
    parameters: str
    safe: Values | None
    warnings: tuple[str, ...]
    command: str
    sqrt: str
    fma: str


@dataclass(frozen=True, eq=False)
@check_arguments
class CCode:
    """A law in C: what was asked, and the texts of header and source.

    Attributes
    ----------
    costs
        The operations of a call, and its stack as counted.
    """

    request: Request
    costs: CallCost
    header: str
    source: str

    @property
    def name(self) -> str:
        """The prefix of all that is visible in C."""
        return self.request.name

    @property
    def law(self) -> SampledLaw:
        """The law."""
        return self.request.law

    @property
    def safe(self) -> Array:
        """The command where a flag is raised, (nu,)."""
        return self.request.safe

    @property
    def settable(self) -> bool:
        """True if parameters can be changed between two instants."""
        return self.request.settable

    @property
    def hardware(self) -> tuple[str, ...]:
        """The operations, "sqrt" and "fma", for which C's library is called."""
        return self.request.hardware

    @property
    def real(self) -> str:
        """The type of readings, references, commands and memory."""
        return self.request.real.type

    @property
    def structs(self) -> Mapping[str, Layout]:
        """The layouts of the structs by their names, those with members alone."""
        return self.request.structs

    @property
    def files(self) -> dict[str, str]:
        """The texts by the names of their files."""
        return {f"{self.name}.h": self.header, f"{self.name}.c": self.source}

    @check_arguments
    def with_costs(self, stack: str, counts: tuple[str, ...] = ()) -> CCode:
        """The same code, whose comments state the stack of a call as it was measured, and counts of instructions."""
        return _written(replace(self.request, stack=stack, counts=counts))

    @check_arguments
    def write(self, folder: str | Path, overwrite: bool = False) -> Path:
        """Write header and source to a folder, all or nothing; the folder.

        Raises
        ------
        ValueError
            If the folder holds files of these names that no export has written or that were edited since, unless they
            are to be overwritten.
        """
        return write_files(folder, self.files, overwrite)

    def __repr__(self) -> str:
        return f"<CCode '{self.name}': {self.request.precision}, {len(self.source.splitlines())} lines>"


def _written(request: Request) -> CCode:
    """The code that a request asks for."""
    source = source_of(request)
    return CCode(request, source.costs, header_of(request, source.costs), source.text)


@check_arguments
def c_code(
    law: SampledLaw,
    name: str | None = None,
    *,
    precision: str = "double",
    parameters: str = "constant",
    safe: Values | None = None,
    warnings: tuple[str, ...] = (),
    command: str = "",
    sqrt: str = "portable",
    fma: str = "portable",
) -> CCode:
    """A law as C99 without a library: NAME_init, NAME_reset and NAME_step over structs of readings and commands.

    Parameters
    ----------
    name
        The prefix, an identifier of C; by default the name of the law.
    precision
        "double", which gives the same bits as the portable arithmetic, or "single" for reals of 32 bits.
    parameters
        "constant", or "settable" for a struct that can be changed between two instants.
    safe
        By name, the command that is given if a reading, a reference or a result is not finite; by default zero, or the
        limit nearest to zero.
    warnings, command
        Sentences for the header, and the command that made the code.
    sqrt
        "portable", or "hardware" for the root of C's library, an instruction on most processors; both give the same
        bits.
    fma
        "portable", or "hardware" for products that are rounded together with sums by C's library: the bits of the fused
        arithmetic, `simulate(..., arithmetic="fused")`, in double precision alone.

    Raises
    ------
    ValueError
        If a name cannot be one of C, two names become one, or a safe command is beyond a limit.
    LookupError
        If `safe` names no command.

    Examples
    --------
    >>> motor = wb.DCMotor()
    >>> law = wb.PID(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0, low=-24.0, high=24.0)
    >>> loop = wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0))
    >>> sorted(wb.c_code(loop.digital(1e-3).law(), "motor_law").files)
    ['motor_law.c', 'motor_law.h']
    """
    law = require("c_code(law=...)", law, SampledLaw)
    prefix = prefix_of(member(law.name) if name is None else name)
    one_of("c_code(precision=...)", precision, PRECISIONS)
    settable = one_of("c_code(parameters=...)", parameters, PARAMETERS) == "settable"
    for layout in (law.readings, law.references, law.commands, law.memory, law.parameters):
        members(layout)
    hardware = _hardware(precision, sqrt, fma)
    request = Request(prefix, law, precision, settable, safe_command(law, safe), tuple(warnings), command, hardware)
    return _written(request)


def _hardware(precision: str, sqrt: str, fma: str) -> tuple[str, ...]:
    """The operations for which C's own library is asked, or a refusal."""
    asked = {"sqrt": one_of("c_code(sqrt=...)", sqrt, WAYS), "fma": one_of("c_code(fma=...)", fma, WAYS)}
    hardware = tuple(name for name, way in asked.items() if way == "hardware")
    if precision == "single" and "fma" in hardware:
        raise ValueError(
            "`c_code(fma='hardware')` must be in double precision, whose fused arithmetic is simulated here; "
            "got precision='single'. Leave one of the two out."
        )
    return hardware


def safe_command(law: SampledLaw, safe: Values | None) -> Array:
    """The safe command (nu,), within the limits: zero, or the limit next to it, unless it is said."""
    safe = safe or {}
    parts = []
    for name in safe:
        known_name(name, law.commands.names, "commands of the law")
    for entry in law.commands.entries:
        low, high = law.limits.get(entry.name, (-np.inf, np.inf))
        call = f"c_code(safe={{'{entry.name}': ...}})"
        value = numbers(call, safe[entry.name]) if entry.name in safe else np.clip(np.zeros(entry.shape), low, high)
        value = np.asarray(value).reshape(entry.shape) if np.size(value) == entry.size else np.asarray(value)
        if value.shape not in ((), entry.shape) or not np.all((value >= low) & (value <= high) & np.isfinite(value)):
            raise ValueError(
                f"`{call}` must be a finite number, or {entry.size} of them, within the limits of the command, "
                f"{low} to {high}; got {value}."
            )
        parts.append(np.broadcast_to(value, entry.shape).ravel(order="F"))
    return np.concatenate(parts) if parts else np.zeros(0)
