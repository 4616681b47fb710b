"""M, C and G, inverse and forward dynamics as C99, without dependencies."""

from __future__ import annotations

from workbench.core import Dynamics
from workbench.handover.code import RESERVED, Routine, about, matrices_of, nominal, torque_of
from workbench.notation.program import Dialect
from workbench.validation.signatures import door

C99 = Dialect({}, RESERVED, width=70)

FORWARD = """
/* The accelerations qdd that the torques tau give; M is positive definite and needs no pivots. */
void workbench_forward_dynamics(const double *q, const double *qd, const double *tau, const double *p,
                                double *qdd)
{
    enum { n = WORKBENCH_JOINTS };
    double M[n * n], C[n * n], G[n];
    const double rest[n] = {0.0};
    workbench_dynamics(q, qd, p, M, C, G);
    workbench_inverse_dynamics(q, qd, rest, p, qdd);
    for (int i = 0; i < n; ++i)
        qdd[i] = tau[i] - qdd[i];
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


@door
def as_c(dynamics: Dynamics) -> str:
    """A C file with `workbench_dynamics`, `workbench_inverse_dynamics` and `workbench_forward_dynamics`."""
    said = [*about(dynamics), "", "Vectors have n numbers, matrices n * n, row by row. No memory is allocated."]
    lines = ["/*", *(f" * {line}".rstrip() for line in said), " */", "#include <math.h>", ""]
    lines += [f"#define WORKBENCH_JOINTS {dynamics.dof}", f"#define WORKBENCH_PARAMETERS {dynamics.p.size}", ""]
    if dynamics.p.size:
        rows = [f"    {value}, /* {what} */" for value, what in nominal(dynamics)]
        lines += ["const double workbench_nominal[WORKBENCH_PARAMETERS] = {", *rows, "};", ""]
    lines += _function("dynamics", ("q", "qd"), matrices_of(dynamics, C99))
    lines += ["", "/* The torques tau that give the accelerations qdd. */"]
    lines += _function("inverse_dynamics", ("q", "qd", "qdd"), torque_of(dynamics, C99))
    return "\n".join([*lines, FORWARD.rstrip("\n")])


def _function(name: str, state: tuple[str, ...], routine: Routine) -> list[str]:
    reads, program = routine
    given = ", ".join(f"const double *{x}" for x in (*state, "p"))
    made = ", ".join(f"double *{x}" for x in program.entries)
    lines = [f"const double {line};" for line in [*reads, *(" = ".join(line) for line in program.lines)]]
    unread = (x for x in (*state, "p") if not any(f" = {x}[" in line for line in reads))
    lines += [f"(void){x};" for x in unread]
    for letter, rows in program.entries.items():
        lines += [f"{letter}[{i}] = {entry};" for i, entry in enumerate(x for row in rows for x in row)]
    indent = " " * len(f"void workbench_{name}(")
    return [f"void workbench_{name}({given},", f"{indent}{made})", "{", *(f"    {line}" for line in lines), "}"]
