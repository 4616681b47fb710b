"""M, C and G, inverse and forward dynamics as C99, without dependencies."""

from __future__ import annotations

from workbench.core import Dynamics
from workbench.derivation.code import RESERVED, about, nominal, program_of
from workbench.notation.program import Dialect

C99 = Dialect({}, RESERVED, width=70)

FUNCTIONS = """
/* The torques tau that give the accelerations qdd. */
void workbench_inverse_dynamics(const double *q, const double *qd, const double *qdd, const double *p,
                                double *tau)
{
    enum { n = WORKBENCH_JOINTS };
    double M[n * n], C[n * n], G[n];
    workbench_dynamics(q, qd, p, M, C, G);
    for (int i = 0; i < n; ++i) {
        tau[i] = G[i];
        for (int j = 0; j < n; ++j)
            tau[i] += M[n * i + j] * qdd[j] + C[n * i + j] * qd[j];
    }
}

/* The accelerations qdd that the torques tau give; M is positive definite and needs no pivots. */
void workbench_forward_dynamics(const double *q, const double *qd, const double *tau, const double *p,
                                double *qdd)
{
    enum { n = WORKBENCH_JOINTS };
    double M[n * n], C[n * n], G[n];
    workbench_dynamics(q, qd, p, M, C, G);
    for (int i = 0; i < n; ++i) {
        qdd[i] = tau[i] - G[i];
        for (int j = 0; j < n; ++j)
            qdd[i] -= C[n * i + j] * qd[j];
    }
    for (int j = 0; j < n; ++j)
        for (int i = j + 1; i < n; ++i) {
            const double l = M[n * i + j] / M[n * j + j];
            for (int k = j; k < n; ++k)
                M[n * i + k] -= l * M[n * j + k];
            qdd[i] -= l * qdd[j];
        }
    for (int i = n - 1; i >= 0; --i) {
        for (int j = i + 1; j < n; ++j)
            qdd[i] -= M[n * i + j] * qdd[j];
        qdd[i] /= M[n * i + i];
    }
}
"""


def as_c(dynamics: Dynamics) -> str:
    """A C file with `workbench_dynamics`, `workbench_inverse_dynamics` and `workbench_forward_dynamics`."""
    reads, program = program_of(dynamics, C99)
    said = [*about(dynamics), "", "Vectors have n numbers, matrices n * n, row by row. No memory is allocated."]
    lines = ["/*", *(f" * {line}".rstrip() for line in said), " */", "#include <math.h>", ""]
    lines += [f"#define WORKBENCH_JOINTS {dynamics.dof}", f"#define WORKBENCH_PARAMETERS {dynamics.p.size}", ""]
    if dynamics.p.size:
        rows = [f"    {value}, /* {what} */" for value, what in nominal(dynamics)]
        lines += ["const double workbench_nominal[WORKBENCH_PARAMETERS] = {", *rows, "};", ""]
    arguments = "const double *q, const double *qd, const double *p, double *M, double *C, double *G"
    lines += [f"void workbench_dynamics({arguments})", "{"]
    lines += [f"    const double {line};" for line in [*reads, *(" = ".join(line) for line in program.lines)]]
    sources = [line.partition(" = ")[2] for line in reads]
    lines += [
        f"    (void){array};" for array in ("q", "qd", "p") if not any(x.startswith(f"{array}[") for x in sources)
    ]
    for letter, entries in program.entries.items():
        lines += [f"    {letter}[{i}] = {entry};" for i, entry in enumerate(x for row in entries for x in row)]
    return "\n".join([*lines, "}", FUNCTIONS.rstrip("\n")])
