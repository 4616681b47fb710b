"""A program around a solver for the Cortex-M7 of QEMU: it solves from one state after the other, and is counted."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import workbench as wb

COMPILER, CXX_COMPILER, EMULATOR = "arm-none-eabi-gcc", "arm-none-eabi-g++", "qemu-system-arm"
PROGRAM = "law.elf"  # which the board runs
TICK = 40  # instructions
SECONDS = 600.0  # of one program
Limit = float | wb.Array  # of all inputs, or of each
OWN = Path(__file__).parent / "solver_programs"
BARE = ("-nostartfiles", "-T", "board.ld", "-Wl,--no-warn-rwx-segments")


@dataclass(frozen=True, eq=False)
class SolverRun:
    """Instructions, iterations and success (T,) of a solver from state to state, and its inputs (T, nu)."""

    instructions: wb.Array
    iterations: wb.Array
    successes: wb.Array
    u: wb.Array


def missing_programs() -> str:
    """The compilers and the emulator that are not here, in words; empty if all are."""
    missing = [name for name in (COMPILER, CXX_COMPILER, EMULATOR) if shutil.which(name) is None]
    return f"{' and '.join(missing)} not installed" if missing else ""


def write_program(folder: Path, problem: wb.planning.LinearMpc, low: Limit, high: Limit, penalty: float = 0.0) -> None:
    """The board, and the header of a problem, whose weights are less by the penalty that a solver adds to them.

    A cone of inputs is moved to its apex. TinyMPC subtracts the penalty of a cone from R once more.
    """
    nx, nu = problem.B.shape
    N, apex = problem.horizon, input_apex(problem)
    sizes = {"NX": nx, "NU": nu, "STAGES": N, "ROWS": (N + 1) * nx + N * nu, "PENALTY": repr(float(penalty))}
    R = np.diag(problem.R)
    for cone in problem.rows.cones:
        sizes |= {"CONE_START": cone.inputs[0], "CONE_SIZE": len(cone.inputs), "CONE_SLOPE": repr(cone.slope)}
    tables: Mapping[str, wb.Array] = {
        "A_columns": problem.A.ravel(order="F"),
        "B_columns": problem.B.ravel(order="F"),
        "Q_diagonal": np.diag(problem.Q) - penalty,
        "R_diagonal": R if problem.rows.cones else R - penalty,
        "lowest": np.broadcast_to(low, nu) - apex,
        "highest": np.broadcast_to(high, nu) - apex,
        "drift": problem.B @ apex,
        "wanted": -apex * R / (R + penalty),
    }
    lines = [f"#define {name} {value}" for name, value in sizes.items()]
    lines += [
        f"static const double {name}[] = {{{', '.join(map(repr, row.tolist()))}}};" for name, row in tables.items()
    ]
    files = {**wb.handover.CORTEX_M7.support_files, "problem.h": "\n".join(lines) + "\n"}
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")
    run([COMPILER, *wb.handover.CORTEX_M7.compiler_options, "-c", "platform.c"], folder)


def input_apex(problem: wb.planning.LinearMpc) -> wb.Array:
    """The apex (nu,) of the cone of inputs, which is at zero for TinyMPC; zeros without a cone."""
    apex = np.zeros(problem.B.shape[1])
    for cone in problem.rows.cones:
        apex[list(cone.inputs)] = [*cone.centre, -cone.offset / cone.slope]
    return apex


def solver_run(folder: Path, compiler: str, objects: Sequence[str], states: wb.Array, inputs: int) -> SolverRun:
    """Link a program of a folder, and run it over states (T, nx)."""
    board = wb.handover.CORTEX_M7
    run([compiler, *board.compiler_options, *BARE, *objects, "platform.o", "-o", PROGRAM], folder)
    with (folder / "inputs").open("wb") as file:
        file.write(np.array([len(states), 0], dtype="<u8").tobytes())
        np.ascontiguousarray(states, dtype="<f8").tofile(file)
    board.emulate(folder, SECONDS, "-icount", "shift=0")
    with (folder / "answers").open("rb") as file:  # which the program has just written
        rows = np.frombuffer(file.read(), np.dtype([("figures", "<u8", (4,)), ("u", "<f8", (inputs,))]))
    figures = rows["figures"].astype(float)
    return SolverRun(TICK * figures[:, 0], figures[:, 1], figures[:, 2], rows["u"])


def run(line: Sequence[str], folder: Path) -> None:
    """A program to its end in a folder."""
    subprocess.run(line, cwd=folder, check=True, stdout=subprocess.DEVNULL, timeout=SECONDS)
