"""TinyMPC's own code on the Cortex-M7 of QEMU, where its sources are: none of them is in this project.

TINYMPC names the folder of the unpacked sources, as `pip download --no-binary :all: --no-deps tinympc` brings them.
"""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import workbench as wb

SOURCES = os.environ.get("TINYMPC", "")
SOLVER = "tinympc/TinyMPC"  # within the sources
UNITS = ("admm", "tiny_api", "rho_benchmark")
COMPILER, C_COMPILER = "arm-none-eabi-g++", "arm-none-eabi-gcc"
PROGRAM = "law.elf"  # which the board runs
TICK = 40  # instructions
SECONDS = 600.0  # of one run
OWN = Path(__file__).parent / "tinympc_program"


@dataclass(frozen=True, eq=False)
class TinyMpcRun:
    """Instructions, iterations and success (T,) of the solver from state to state, its inputs (T, nu), and its heap."""

    instructions: wb.Array
    iterations: wb.Array
    solved: wb.Array
    u: wb.Array
    heap: int


def lacking() -> str:
    """The reason why TinyMPC cannot be counted here; empty if it can."""
    missing = [name for name in (COMPILER, "qemu-system-arm") if shutil.which(name) is None]
    if missing:
        return f"{' and '.join(missing)} not installed"
    if not (Path(SOURCES) / SOLVER / "src/tinympc/admm.cpp").is_file():
        return "the sources of TinyMPC are not here: TINYMPC names their folder"
    return ""


def tinympc_run(
    problem: wb.planning.LinearMpc, low: float, high: float, penalty: float, states: wb.Array
) -> TinyMpcRun:
    """The solver at its default settings, warm started, from states (T, nx) one after the other.

    It adds the penalty to the weights that it is given, which here are less by it: so it solves the same problem.
    """
    nu, board = problem.B.shape[1], wb.handover.CORTEX_M7
    with TemporaryDirectory(prefix="tinympc-") as place:
        folder = Path(place)
        for name, text in {**board.support_files, "problem.h": _header(problem, low, high, penalty)}.items():
            (folder / name).write_text(text, encoding="utf-8")
        options = board.compiler_options
        for source in ("platform.c", str(OWN / "system.c")):
            _run([C_COMPILER, *options, "-c", source], folder)
        _run([COMPILER, *_own_options(options), f"-I{folder}", "-c", str(OWN / "main.cpp")], folder)
        bare = ["-nostartfiles", "-T", "board.ld", "-Wl,--no-warn-rwx-segments"]
        objects = ["main.o", "platform.o", "system.o", *map(str, _compiled_solver(options))]
        _run([COMPILER, *options, *bare, *objects, "-o", PROGRAM], folder)
        with (folder / "inputs").open("wb") as file:
            file.write(np.array([len(states), 0], dtype="<u8").tobytes())
            np.ascontiguousarray(states, dtype="<f8").tofile(file)
        board.emulate(folder, SECONDS, "-icount", "shift=0")
        record = np.dtype([("figures", "<u8", (4,)), ("u", "<f8", (nu,))])
        rows = np.fromfile(folder / "answers", record)
    figures = rows["figures"].astype(float)
    return TinyMpcRun(TICK * figures[:, 0], figures[:, 1], figures[:, 2], rows["u"], int(figures[-1, 3]))


def _own_options(options: Sequence[str]) -> list[str]:
    """The options for C++: the stream that prints nothing before all others, and no assertions."""
    solver = Path(SOURCES) / SOLVER
    folders = (OWN, solver / "src/tinympc", solver / "include", solver / "include/Eigen")
    return [*options, "-std=c++17", "-DNDEBUG", "-w", *(f"-I{folder}" for folder in folders)]


@cache
def _compiled_solver(options: tuple[str, ...]) -> tuple[Path, ...]:
    """The objects of TinyMPC, compiled once in a process, in a folder that the process leaves behind."""
    folder = Path(_keeper().name)
    for unit in UNITS:
        source = str(Path(SOURCES) / SOLVER / f"src/tinympc/{unit}.cpp")
        _run([COMPILER, *_own_options(options), "-c", source], folder)
    return tuple(folder / f"{unit}.o" for unit in UNITS)


@cache
def _keeper() -> TemporaryDirectory[str]:
    """A folder that is removed as the process ends."""
    return TemporaryDirectory(prefix="tinympc-solver-")


def _header(problem: wb.planning.LinearMpc, low: float, high: float, penalty: float) -> str:
    """The header of a problem."""
    nx, nu = problem.B.shape
    sizes = {"NX": nx, "NU": nu, "STAGES": problem.horizon, "PENALTY": repr(float(penalty))}
    tables: Mapping[str, wb.Array] = {
        "A_columns": problem.A.ravel(order="F"),
        "B_columns": problem.B.ravel(order="F"),
        "Q_diagonal": np.diag(problem.Q) - penalty,
        "R_diagonal": np.diag(problem.R) - penalty,
        "lowest": np.full(nu, low),
        "highest": np.full(nu, high),
    }
    lines = [f"#define {name} {value}" for name, value in sizes.items()]
    lines += [
        f"static const double {name}[] = {{{', '.join(map(repr, row.tolist()))}}};" for name, row in tables.items()
    ]
    return "\n".join(lines) + "\n"


def _run(line: Sequence[str], folder: Path) -> None:
    """A program to its end in a folder."""
    subprocess.run(line, cwd=folder, check=True, stdout=subprocess.DEVNULL, timeout=SECONDS)
