"""export: a sampled law in the form that another machine takes, as files in a folder."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Unpack

from workbench.core import SampledLaw, SampledSystem
from workbench.core.validation.refusals import known_name, require
from workbench.core.validation.signatures import check_arguments
from workbench.handover.c99.c_files import CCode, COptions, c_code
from workbench.handover.c99.c_names import member, prefix_of
from workbench.handover.export_folder import write_files
from workbench.handover.replays import Replay
from workbench.handover.targets.binary_size import measured_stack

SUBSTEPS, STATES = 4, 10_000  # of the plant in a period; random states of which a bound is stated

Files = Mapping[str, str | bytes]


@dataclass(frozen=True)
class ExportRequest:
    """The law to be written, its name, and what was asked of it beside."""

    law: SampledLaw
    name: str
    options: COptions
    interfaces: Mapping[str, str | Sequence[str]] | None
    counts: tuple[str, ...] = ()

    @property
    def code(self) -> CCode:
        """The law in C, its stack measured where GCC is, with the counts of a replay."""
        code = c_code(self.law, self.name, **self.options)
        return code.with_costs(measured_stack(code), self.counts)


def _c(order: ExportRequest) -> Files:
    return order.code.files


def _cortex_m4(order: ExportRequest) -> Files:
    from workbench.handover.targets.soft_doubles import SOFT_DOUBLES_FILE, soft_doubles

    return {**order.code.files, SOFT_DOUBLES_FILE: soft_doubles()}


def _python(order: ExportRequest) -> Files:
    from workbench.handover.programs.python_law import python_law

    return {f"{order.name}.py": python_law(order.law, order.name, safe=order.options.get("safe"))}


def _casadi(order: ExportRequest) -> Files:
    from workbench.handover.programs.casadi_law import casadi_law

    return {f"{order.name}_casadi.py": casadi_law(order.law, order.name)}


def _control(order: ExportRequest) -> Files:
    from workbench.handover.programs.linear_law import as_control

    return {f"{order.name}_control.py": as_control(order.law.with_name(order.name))}


def _mat(order: ExportRequest) -> Files:
    from workbench.handover.programs.linear_law import mat_of

    return {f"{order.name}.mat": mat_of(order.law.with_name(order.name))}


def _simulink(order: ExportRequest) -> Files:
    from workbench.handover.wrappers.simulink import simulink

    return {**order.code.files, **simulink(order.code)}


def _ros2(order: ExportRequest) -> Files:
    from workbench.handover.wrappers.ros2 import ros2

    return ros2(order.code, interfaces=order.interfaces)


def _fmu(version: str) -> Callable[[ExportRequest], Files]:
    def files(order: ExportRequest) -> Files:
        from workbench.handover.fmi.archive import fmu

        return {f"{order.name}.fmu": fmu(order.law, version, order.name).content()}

    return files


FORMS: Mapping[str, Callable[[ExportRequest], Files]] = {
    "c": _c,
    "cortex-m4": _cortex_m4,
    "python": _python,
    "casadi": _casadi,
    "control": _control,
    "mat": _mat,
    "simulink": _simulink,
    "ros2": _ros2,
    "fmi2": _fmu("2.0"),
    "fmi3": _fmu("3.0"),
}


OPTIONS = ("precision", "parameters", "safe", "warnings", "command", "sqrt", "fma")
TEXT_OPTIONS = ("warnings", "command")  # which are only said
FORM_OPTIONS = {
    "python": ("safe", *TEXT_OPTIONS),
    **dict.fromkeys(("casadi", "control", "mat", "fmi2", "fmi3"), TEXT_OPTIONS),
}


@check_arguments
def export(
    law: SampledLaw | SampledSystem,
    form: str = "c",
    folder: str | Path | None = None,
    *,
    name: str | None = None,
    interfaces: Mapping[str, str | Sequence[str]] | None = None,
    overwrite: bool = False,
    replay: Replay | None = None,
    **options: Unpack[COptions],
) -> list[Path]:
    """Write a law to a folder in a form for another machine, and return the paths of the files.

    Parameters
    ----------
    law
        The law of a loop, or a loop in a computer, `loop.digital(period)`, whose law is written.
    form
        "c" is C99 without a library; "cortex-m4" is the same with its own sums of doubles for Cortex-M3 and M4, where
        GCC rounds them wrongly. "python" is a module that needs no package, and "casadi" one that needs CasADi alone.
        "control" is a linear law for python-control, and "mat" one for MATLAB. "simulink" is an S-function and "ros2" a
        controller of ros2_control, both around the C. "fmi2" and "fmi3" are FMUs.
    folder
        The folder; by default one with the name of the law in the working directory.
    name
        An identifier of C; by default the name of the law.
    interfaces
        For "ros2": by signal, the hardware interface of each of its numbers.
    overwrite
        True to replace files that no export has written, or that were edited since.
    replay
        A replay of this law, whose counts of instructions and stacks then stand at the head of the C.
    options
        Options of C and of the forms around it, see `c_code`: precision, parameters, safe, sqrt, fma, warnings,
        command.

    Raises
    ------
    ValueError
        If the law has no such form, a file is there that no export wrote or that was edited since, or the replay is of
        another law or precision.

    Examples
    --------
    >>> motor = wb.DCMotor()
    >>> law = wb.PID(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0, low=-24.0, high=24.0)
    >>> loop = wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0))
    >>> [path.name for path in wb.export(loop.digital(1e-3), "c", "motor", name="motor_law")]
    ['motor_law.h', 'motor_law.c']
    """
    if isinstance(law, SampledSystem) and options.get("precision") == "single":
        options["warnings"] = (*options.get("warnings", ()), loss_in_single_precision(law, law.law()))
    alone: SampledLaw = require("export(law=...)", law.law() if isinstance(law, SampledSystem) else law, SampledLaw)
    _refuse_options(known_name(form, FORMS, "forms of a law"), options)
    chosen = prefix_of(member(alone.name) if name is None else name)
    files = FORMS[form](ExportRequest(alone, chosen, options, interfaces, _counts(replay, alone, options)))
    target = write_files(chosen if folder is None else folder, files, overwrite)
    return [target / path for path in files]


def _refuse_options(form: str, options: Iterable[str]) -> None:
    """Refuse options that a form does not have."""
    for option in options:
        if known_name(option, OPTIONS, "options of an export") not in FORM_OPTIONS.get(form, OPTIONS):
            raise ValueError(f"`export(form='{form}')` takes no `{option}`: only the forms with C have this option.")


def _counts(replay: Replay | None, law: SampledLaw, options: COptions) -> tuple[str, ...]:
    """The counts of a replay in sentences; one of another law is refused."""
    if replay is None:
        return ()
    own: Replay = require("export(replay=...)", replay, Replay)
    replayed, precision = own.code.request, options.get("precision", "double")
    if (replayed.law.fingerprint, replayed.precision) != (law.fingerprint, precision):
        raise ValueError(
            f"`export(replay=...)` must be a replay of the exported law in {precision} precision, as its counts are "
            f"printed with it; got one of '{replayed.law.name}' in {replayed.precision} precision, with other "
            "equations or numbers. Replay the same loop."
        )
    return own.counts


@check_arguments
def loss_in_single_precision(sampled_loop: SampledSystem, law: SampledLaw, periods: int = 1000) -> str:
    """The sentence that says by how much a law in single precision differs, in a box around a run of its loop."""
    from workbench.handover.recording import record
    from workbench.handover.single.rounding_statement import box_of, stated_bound

    run = record(sampled_loop, law, periods, substeps=SUBSTEPS)
    return stated_bound(law, *box_of(run.memory(0, periods - 1), run.y, run.r), samples=STATES).sentence
