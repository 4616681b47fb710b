"""M, C and G, inverse and forward dynamics as Python over NumPy."""

from __future__ import annotations

from workbench.core import Dynamics
from workbench.handover.code import RESERVED, Routine, about, matrices_of, nominal, torque_of
from workbench.notation.program import Dialect
from workbench.validation.signatures import door

# The sines of `math` are those of the C library, as CasADi's are; NumPy's differ in the last bit on some machines.
PYTHON = Dialect({"fmin": "min", "fmax": "max"}, RESERVED, width=84)
BUILT_IN = {"min", "max"}

FORWARD = '''def forward_dynamics(q, qd, tau, p=NOMINAL):
    """The accelerations qdd (n,) that the torques tau give."""
    M, _, _ = dynamics(q, qd, p)
    return np.linalg.solve(M, tau - inverse_dynamics(q, qd, np.zeros(len(q)), p))'''


@door
def as_python(dynamics: Dynamics) -> str:
    """A module with the functions `dynamics`, `inverse_dynamics` and `forward_dynamics`."""
    matrices, torque = matrices_of(dynamics, PYTHON), torque_of(dynamics, PYTHON)
    called = sorted({*matrices.program.functions, *torque.program.functions} - BUILT_IN)
    lines = ['"""' + "\n".join(about(dynamics)), '"""', ""]
    lines += [f"from math import {', '.join(called)}", ""] if called else []
    lines += ["import numpy as np", "", "NOMINAL = (", *(f"    {x},  # {what}" for x, what in nominal(dynamics)), ")"]
    lines += ["", "", "def dynamics(q, qd, p=NOMINAL):"]
    lines += ['    """M(q) (n, n), C(q, qd) (n, n) and G(q) (n,)."""', *_body(matrices), "    return M, C, G"]
    lines += ["", "", "def inverse_dynamics(q, qd, qdd, p=NOMINAL):"]
    lines += ['    """The torques tau (n,) that give the accelerations qdd."""', *_body(torque), "    return tau"]
    return "\n".join([*lines, "", "", FORWARD])


def _body(routine: Routine) -> list[str]:
    lines = [*routine.reads, *(f"{variable} = {text}" for variable, text in routine.program.lines)]
    for letter, rows in routine.program.entries.items():
        if letter in ("M", "C"):
            cells = (f"        [{', '.join(row)}]," for row in rows)
            lines += [f"{letter} = np.array(", "    [", *cells, "    ]", ")"]
        else:
            lines += [f"{letter} = np.array([{', '.join(row[0] for row in rows)}])"]
    return [f"    {line}" for line in lines]
