"""OSQP's generated C on the Cortex-M7 of QEMU, where its package is: none of it is in this project."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from scipy import sparse

import workbench as wb
from studies.b4_handover.solver_program import (
    COMPILER,
    OWN,
    Limit,
    SolverRun,
    missing_programs,
    run,
    solver_run,
    write_program,
)

CODE = "generated"
HAS_OSQP = find_spec("osqp") is not None
if HAS_OSQP:
    import osqp


def osqp_lacks() -> str:
    """The reason why OSQP cannot be counted here; empty if it can."""
    return missing_programs() or ("" if HAS_OSQP else "the package osqp is not installed")


def osqp_run(problem: wb.planning.LinearMpc, low: Limit, high: Limit, states: wb.Array) -> SolverRun:
    """The generated code at its default settings, warm started, from states (T, nx) one after the other."""
    options = wb.handover.CORTEX_M7.compiler_options
    with TemporaryDirectory(prefix="osqp-") as place:
        folder = Path(place)
        _generate(problem, low, high, folder / CODE)
        write_program(folder, problem, low, high)
        code = folder / CODE
        folders = [f"-I{part}" for part in (folder, code, code / "inc/public", code / "inc/private")]
        sources = [*sorted(code.glob("src/*.c")), code / "mpc_workspace.c", OWN / "osqp_main.c"]
        run([COMPILER, *options, "-w", *folders, "-c", *map(str, sources)], folder)
        objects = [f"{source.stem}.o" for source in sources]
        run([COMPILER, *options, "-c", str(OWN / "system.c")], folder)
        return solver_run(folder, COMPILER, [*objects, "system.o"], states, problem.B.shape[1])


def _generate(problem: wb.planning.LinearMpc, low: Limit, high: Limit, folder: Path) -> None:
    """The code for the states x_0, ..., x_N and inputs of all stages, whose first rows are the state that is given."""
    (nx, nu), N = problem.B.shape, problem.horizon
    size = (N + 1) * nx
    cost = np.zeros((size + N * nu, size + N * nu))
    cost[: N * nx, : N * nx] = np.kron(np.eye(N), problem.Q)
    cost[N * nx : size, N * nx : size] = problem.P
    cost[size:, size:] = np.kron(np.eye(N), problem.R)
    states = np.kron(np.eye(N + 1, k=-1), problem.A) - np.eye(size)
    inputs = np.kron(np.eye(N + 1, N, k=-1), problem.B)
    rows = np.block([[states, inputs], [np.zeros((N * nu, size)), np.eye(N * nu)]])
    none = np.zeros(size)
    solver = osqp.OSQP()
    solver.setup(
        sparse.csc_matrix(np.triu(cost)),
        np.zeros(rows.shape[1]),
        sparse.csc_matrix(rows),
        np.r_[none, np.tile(np.broadcast_to(low, nu), N)],
        np.r_[none, np.tile(np.broadcast_to(high, nu), N)],
        verbose=False,
    )
    solver.codegen(
        str(folder),
        parameters="vectors",
        extension_name=None,
        prefix="mpc_",
        force_rewrite=True,
        use_float=False,
        printing_enable=False,
        profiling_enable=False,
        interrupt_enable=False,
        include_codegen_src=True,
        compile=False,
    )
