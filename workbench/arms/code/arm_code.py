"""M, C and G, inverse and forward dynamics of an arm as programs: Python over NumPy, CasADi functions, and C99."""

from __future__ import annotations

import keyword
from collections.abc import Iterable, Mapping
from typing import NamedTuple

import casadi as ca

from workbench.arms.code.arm_equations import letters_of, title
from workbench.arms.dynamics import Dynamics
from workbench.core.notation.program import CALLED, Dialect, Program, straight_line
from workbench.core.validation.signatures import door

# Names that the written functions use themselves.
OWN = (
    "q qd qdd tau p M C G n i j k l D LT order rest matrices torque ca np NOMINAL "
    "dynamics inverse_dynamics forward_dynamics"
)
C_WORDS = (
    "auto break case char const continue default do double else enum extern float for goto if inline int long "
    "register restrict return short signed sizeof static struct switch typedef union unsigned void volatile while "
    "j0 j1 jn y0 y1 yn gamma exp2 div abs main signgam"
)
RESERVED = frozenset([*OWN.split(), *C_WORDS.split(), *CALLED.split(), "min", "max", *keyword.kwlist])


class Routine(NamedTuple):
    """The lines that read each variable, as `m_1 = p[0]`, and the program over these."""

    reads: list[str]
    program: Program


def _routines(dynamics: Dynamics, dialect: Dialect) -> tuple[Routine, Routine]:
    """The routines of M, C and G, and of the torque."""
    matrices = {"M": dynamics.M, "C": dynamics.C, "G": dynamics.G}
    return _routine(dynamics, matrices, dialect), _routine(dynamics, {"tau": dynamics.tau}, dialect)


def _routine(dynamics: Dynamics, results: Mapping[str, ca.SX], dialect: Dialect) -> Routine:
    joints = [(letter, i) for letter in ("q", "qd", "qdd") for i in range(dynamics.dof)]
    letters = {f"{letter}[{i}]": f"{letter}_{i + 1}" for letter, i in joints}
    program = straight_line(results, letters | dynamics.names(), dialect)
    variables = {name: variable for variable, name in program.inputs}
    places = {name: name for name in letters} | {path: f"p[{k}]" for k, path in enumerate(dynamics.p.labels)}
    return Routine([f"{variables[name]} = {place}" for name, place in places.items() if name in variables], program)


def _about(dynamics: Dynamics) -> list[str]:
    lengths, forces = _units(dynamics.units), _units("N" if unit == "m" else "N m" for unit in dynamics.units)
    meanings = {
        "q, qd, qdd": f"positions, velocities and accelerations of the joints, in {lengths}, per s and s^2",
        "tau": f"what drives the joints, in {forces}",
        "p": "parameters, in the order of the nominal values below" if dynamics.p.size else "",
        "M, C, G": "C of the Christoffel symbols: M' - 2 C is skew",
    }
    return [title(dynamics), "", *(f"{name:<12}{meaning}" for name, meaning in meanings.items() if meaning)]


def _units(each: Iterable[str]) -> str:
    units = list(each)
    return units[0] if len(set(units)) == 1 else f"({', '.join(units)})"


def _nominal(dynamics: Dynamics) -> list[tuple[str, str]]:
    return [(repr(x.value), f"{x.name}, {x.path}{f' [{x.unit}]' if x.unit else ''}") for x in letters_of(dynamics)]


# The sines of `math` are those of the C library, as CasADi's are; NumPy's differ in the last bit on some machines.
PYTHON = Dialect({"fmin": "min", "fmax": "max"}, RESERVED, width=84)
BUILT_IN = {"min", "max"}

FORWARD_IN_PYTHON = '''def forward_dynamics(q, qd, tau, p=NOMINAL):
    """The accelerations qdd (n,) that the torques tau give."""
    M, _, _ = dynamics(q, qd, p)
    return np.linalg.solve(M, tau - inverse_dynamics(q, qd, np.zeros(len(q)), p))'''


@door
def as_python(dynamics: Dynamics) -> str:
    """A module with the functions `dynamics`, `inverse_dynamics` and `forward_dynamics`.

    Examples
    --------
    >>> from workbench.arms.code import as_c, as_casadi, as_python, in_numbers
    >>> arm = in_numbers(wb.named("planar-1r"), "planar-1r")
    >>> as_python(arm).count("def ")
    3
    >>> "workbench_dynamics" in as_c(arm), "import casadi" in as_casadi(arm)
    (True, True)
    """
    matrices, torque = _routines(dynamics, PYTHON)
    called = sorted({*matrices.program.functions, *torque.program.functions} - BUILT_IN)
    lines = ['"""' + "\n".join(_about(dynamics)), '"""', ""]
    lines += [f"from math import {', '.join(called)}", ""] if called else []
    lines += ["import numpy as np", "", "NOMINAL = (", *(f"    {x},  # {what}" for x, what in _nominal(dynamics)), ")"]
    lines += ["", "", "def dynamics(q, qd, p=NOMINAL):"]
    lines += ['    """M(q) (n, n), C(q, qd) (n, n) and G(q) (n,)."""', *_in_python(matrices), "    return M, C, G"]
    lines += ["", "", "def inverse_dynamics(q, qd, qdd, p=NOMINAL):"]
    lines += ['    """The torques tau (n,) that give the accelerations qdd."""', *_in_python(torque), "    return tau"]
    return "\n".join([*lines, "", "", FORWARD_IN_PYTHON])


def _in_python(routine: Routine) -> list[str]:
    lines = [*routine.reads, *(f"{variable} = {text}" for variable, text in routine.program.lines)]
    for letter, rows in routine.program.entries.items():
        if letter in ("M", "C"):
            cells = (f"        [{', '.join(row)}]," for row in rows)
            lines += [f"{letter} = np.array(", "    [", *cells, "    ]", ")"]
        else:
            lines += [f"{letter} = np.array([{', '.join(row[0] for row in rows)}])"]
    return [f"    {line}" for line in lines]


CASADI = Dialect({name: f"ca.{name}" for name in CALLED.split()} | {"pow": "ca.power"}, RESERVED, width=84)

CASADI_FUNCTIONS = """q, qd, qdd, tau = (ca.SX.sym(name, {n}) for name in ("q", "qd", "qdd", "tau"))
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
    matrices, torque = _routines(dynamics, CASADI)
    lines = ['"""' + "\n".join(_about(dynamics)), '"""', "", "import casadi as ca", ""]
    lines += ["NOMINAL = [", *(f"    {value},  # {what}" for value, what in _nominal(dynamics)), "]"]
    lines += ["", "", "def matrices(q, qd, p):"]
    lines += ['    """M(q) (n, n), C(q, qd) (n, n) and G(q) (n, 1) as expressions."""', *_in_casadi(matrices)]
    lines += ["    return M, C, G", "", "", "def torque(q, qd, qdd, p):"]
    lines += [
        '    """The torques tau (n, 1) that give the accelerations qdd, as an expression."""',
        *_in_casadi(torque),
    ]
    return "\n".join(
        [*lines, "    return tau", "", "", CASADI_FUNCTIONS.format(n=dynamics.dof, parameters=dynamics.p.size)]
    )


def _in_casadi(routine: Routine) -> list[str]:
    lines = [*routine.reads, *(f"{variable} = {text}" for variable, text in routine.program.lines)]
    for letter, rows in routine.program.entries.items():
        joined = (f"ca.horzcat({', '.join(row)})" if letter in ("M", "C") else row[0] for row in rows)
        lines += [f"{letter} = ca.vertcat(", *(f"    {row}," for row in joined), ")"]
    return [f"    {line}" for line in lines]


C99 = Dialect({}, RESERVED, width=70)

FORWARD_IN_C = """
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
    said = [*_about(dynamics), "", "Vectors have n numbers, matrices n * n, row by row. No memory is allocated."]
    lines = ["/*", *(f" * {line}".rstrip() for line in said), " */", "#include <math.h>", ""]
    lines += [f"#define WORKBENCH_JOINTS {dynamics.dof}", f"#define WORKBENCH_PARAMETERS {dynamics.p.size}", ""]
    if dynamics.p.size:
        rows = [f"    {value}, /* {what} */" for value, what in _nominal(dynamics)]
        lines += ["const double workbench_nominal[WORKBENCH_PARAMETERS] = {", *rows, "};", ""]
    matrices, torque = _routines(dynamics, C99)
    lines += _c_function("dynamics", ("q", "qd"), matrices)
    lines += ["", "/* The torques tau that give the accelerations qdd. */"]
    lines += _c_function("inverse_dynamics", ("q", "qd", "qdd"), torque)
    return "\n".join([*lines, FORWARD_IN_C.rstrip("\n")])


def _c_function(name: str, state: tuple[str, ...], routine: Routine) -> list[str]:
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
