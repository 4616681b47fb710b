"""M, C and G, inverse and forward dynamics as Python that builds CasADi functions."""

from __future__ import annotations

from workbench.core import Dynamics
from workbench.derivation.code import RESERVED, about, nominal, program_of
from workbench.notation.program import CALLED, Dialect

CASADI = Dialect({name: f"ca.{name}" for name in CALLED.split()} | {"pow": "ca.power"}, RESERVED, width=88)

ENDING = """
dynamics = ca.Function("dynamics", [q, qd, p], [M, C, G], ["q", "qd", "p"], ["M", "C", "G"])

inverse_dynamics = ca.Function(
    "inverse_dynamics", [q, qd, qdd, p], [M @ qdd + C @ qd + G], ["q", "qd", "qdd", "p"], ["tau"]
)

# by the factors M = L D L'
D, LT, order = ca.ldl(M, False)
forward_dynamics = ca.Function(
    "forward_dynamics",
    [q, qd, tau, p],
    [ca.ldl_solve(tau - C @ qd - G, D, LT, order)],
    ["q", "qd", "tau", "p"],
    ["qdd"],
)
"""


def as_casadi(dynamics: Dynamics) -> str:
    """A module with the CasADi functions `dynamics`, `inverse_dynamics` and `forward_dynamics`."""
    reads, program = program_of(dynamics, CASADI)
    n = dynamics.dof
    lines = ['"""' + "\n".join(about(dynamics)), '"""', "", "import casadi as ca", ""]
    lines += ["NOMINAL = [", *(f"    {value},  # {what}" for value, what in nominal(dynamics)), "]", ""]
    lines += [f'{name} = ca.SX.sym("{name}", {n})' for name in ("q", "qd", "qdd", "tau")]
    lines += [f'p = ca.SX.sym("p", {dynamics.p.size})', "", *reads, ""]
    lines += [f"{variable} = {text}" for variable, text in program.lines]
    for letter, rows in program.entries.items():
        joined = [f"ca.horzcat({', '.join(row)})" for row in rows] if letter != "G" else [row[0] for row in rows]
        lines += ["", f"{letter} = ca.vertcat(", *(f"    {row}," for row in joined), ")"]
    return "\n".join([*lines, ENDING.rstrip("\n")])
