"""M, C and G, inverse and forward dynamics as Python over NumPy."""

from __future__ import annotations

from workbench.core import Dynamics
from workbench.derivation.code import RESERVED, about, nominal, program_of
from workbench.notation.program import Dialect

# The sines of `math` are those of the C library, as CasADi's are; NumPy's differ in the last bit on some machines.
PYTHON = Dialect({"fmin": "min", "fmax": "max"}, RESERVED, width=84)
BUILT_IN = {"min", "max"}

FUNCTIONS = '''

def inverse_dynamics(q, qd, qdd, p=NOMINAL):
    """The torques tau (n,) that give the accelerations qdd."""
    M, C, G = dynamics(q, qd, p)
    return M @ qdd + C @ qd + G


def forward_dynamics(q, qd, tau, p=NOMINAL):
    """The accelerations qdd (n,) that the torques tau give."""
    M, C, G = dynamics(q, qd, p)
    return np.linalg.solve(M, tau - C @ qd - G)
'''


def as_python(dynamics: Dynamics) -> str:
    """A module with the functions `dynamics`, `inverse_dynamics` and `forward_dynamics`."""
    reads, program = program_of(dynamics, PYTHON)
    called = [name for name in program.functions if name not in BUILT_IN]
    head = ['"""' + "\n".join(about(dynamics)), '"""', ""]
    head += [f"from math import {', '.join(called)}", ""] if called else []
    head += ["import numpy as np", "", "NOMINAL = (", *(f"    {x},  # {what}" for x, what in nominal(dynamics)), ")"]
    body = [*reads, *(f"{variable} = {text}" for variable, text in program.lines)]
    for letter, rows in program.entries.items():
        cells = [", ".join(row) for row in rows]
        body += [f"{letter} = np.array([{', '.join(cells)}])"] if letter == "G" else _array(letter, cells)
    function = [
        "def dynamics(q, qd, p=NOMINAL):",
        '    """M(q) (n, n), C(q, qd) (n, n) and G(q) (n,)."""',
        *(f"    {line}" for line in body),
        "    return M, C, G",
    ]
    return "\n".join([*head, "", "", *function, FUNCTIONS.rstrip("\n")])


def _array(letter: str, rows: list[str]) -> list[str]:
    return [f"{letter} = np.array(", "    [", *(f"        [{row}]," for row in rows), "    ]", ")"]
