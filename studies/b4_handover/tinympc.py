"""TinyMPC's own code on the Cortex-M7 of QEMU, where its sources are: none of them is in this project.

TINYMPC names the folder of the unpacked sources, as `pip download --no-binary :all: --no-deps tinympc` brings them.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import workbench as wb
from studies.b4_handover.solver_program import (
    COMPILER,
    CXX_COMPILER,
    OWN,
    Limit,
    SolverRun,
    input_apex,
    missing_programs,
    run,
    solver_run,
    write_program,
)

SOURCES = os.environ.get("TINYMPC", "")
SOLVER = "tinympc/TinyMPC"  # within the sources
UNITS = ("admm", "tiny_api", "rho_benchmark")


def tinympc_lacks() -> str:
    """The reason why TinyMPC cannot be counted here; empty if it can."""
    if reason := missing_programs():
        return reason
    if not (Path(SOURCES) / SOLVER / "src/tinympc/admm.cpp").is_file():
        return "the sources of TinyMPC are not here: TINYMPC names their folder"
    return ""


def tinympc_run(problem: wb.planning.LinearMpc, low: Limit, high: Limit, penalty: float, states: wb.Array) -> SolverRun:
    """The solver at its default settings, warm started, from states (T, nx) one after the other.

    It adds the penalty to the weights that it is given, which here are less by it: so it solves the same problem.
    """
    options = wb.handover.CORTEX_M7.compiler_options
    with TemporaryDirectory(prefix="tinympc-") as place:
        folder = Path(place)
        write_program(folder, problem, low, high, penalty)
        run([COMPILER, *options, "-c", str(OWN / "system.c")], folder)
        run([CXX_COMPILER, *_own_options(options), f"-I{folder}", "-c", str(OWN / "tinympc_main.cpp")], folder)
        objects = ["tinympc_main.o", "system.o", *map(str, _compiled_solver(options))]
        answer = solver_run(folder, CXX_COMPILER, objects, states, problem.B.shape[1])
        return replace(answer, u=answer.u + input_apex(problem))


def _own_options(options: Sequence[str]) -> list[str]:
    """The options for C++: the stream that prints nothing before all others, and no assertions."""
    solver = Path(SOURCES) / SOLVER
    folders = (OWN / "silent", solver / "src/tinympc", solver / "include", solver / "include/Eigen")
    return [*options, "-std=c++17", "-DNDEBUG", "-w", *(f"-I{folder}" for folder in folders)]


@cache
def _compiled_solver(options: tuple[str, ...]) -> tuple[Path, ...]:
    """The objects of TinyMPC, compiled once in a process."""
    folder = Path(_keeper().name)
    for unit in UNITS:
        source = str(Path(SOURCES) / SOLVER / f"src/tinympc/{unit}.cpp")
        run([CXX_COMPILER, *_own_options(options), "-c", source], folder)
    return tuple(folder / f"{unit}.o" for unit in UNITS)


@cache
def _keeper() -> TemporaryDirectory[str]:
    """A folder that is removed as the process ends."""
    return TemporaryDirectory(prefix="tinympc-solver-")
