"""M, C and G, inverse and forward dynamics as Python that builds CasADi functions."""

from __future__ import annotations

from workbench.core import Dynamics
from workbench.handover.code import RESERVED, Routine, about, matrices_of, nominal, torque_of
from workbench.notation.program import CALLED, Dialect
from workbench.validation.signatures import door

CASADI = Dialect({name: f"ca.{name}" for name in CALLED.split()} | {"pow": "ca.power"}, RESERVED, width=84)

FUNCTIONS = """q, qd, qdd, tau = (ca.SX.sym(name, {n}) for name in ("q", "qd", "qdd", "tau"))
p = ca.SX.sym("p", {parameters})

M, C, G = matrices(q, qd, p)
dynamics = ca.Function("dynamics", [q, qd, p], [M, C, G], ["q", "qd", "p"], ["M", "C", "G"])

inverse_dynamics = ca.Function(
    "inverse_dynamics", [q, qd, qdd, p], [torque(q, qd, qdd, p)], ["q", "qd", "qdd", "p"], ["tau"]
)

# by the factors M = L D L'
D, LT, order = ca.ldl(M, False)
forward_dynamics = ca.Function(
    "forward_dynamics",
    [q, qd, tau, p],
    [ca.ldl_solve(tau - torque(q, qd, ca.SX.zeros({n}), p), D, LT, order)],
    ["q", "qd", "tau", "p"],
    ["qdd"],
)"""


@door
def as_casadi(dynamics: Dynamics) -> str:
    """A module with the CasADi functions `dynamics`, `inverse_dynamics` and `forward_dynamics`."""
    matrices, torque = matrices_of(dynamics, CASADI), torque_of(dynamics, CASADI)
    lines = ['"""' + "\n".join(about(dynamics)), '"""', "", "import casadi as ca", ""]
    lines += ["NOMINAL = [", *(f"    {value},  # {what}" for value, what in nominal(dynamics)), "]"]
    lines += ["", "", "def matrices(q, qd, p):"]
    lines += ['    """M(q) (n, n), C(q, qd) (n, n) and G(q) (n, 1) as expressions."""', *_body(matrices)]
    lines += ["    return M, C, G", "", "", "def torque(q, qd, qdd, p):"]
    lines += ['    """The torques tau (n, 1) that give the accelerations qdd, as an expression."""', *_body(torque)]
    return "\n".join([*lines, "    return tau", "", "", FUNCTIONS.format(n=dynamics.dof, parameters=dynamics.p.size)])


def _body(routine: Routine) -> list[str]:
    lines = [*routine.reads, *(f"{variable} = {text}" for variable, text in routine.program.lines)]
    for letter, rows in routine.program.entries.items():
        joined = (f"ca.horzcat({', '.join(row)})" if letter in ("M", "C") else row[0] for row in rows)
        lines += [f"{letter} = ca.vertcat(", *(f"    {row}," for row in joined), ")"]
    return [f"    {line}" for line in lines]
