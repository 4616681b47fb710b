"""M, C and G, inverse and forward dynamics of an arm as laws without memory, which other machines compute."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

import casadi as ca
import numpy as np

from workbench.arms.code.arm_equations import letters_of, title
from workbench.arms.dynamics import Dynamics, solve_definite
from workbench.core.layout import Entry, Layout
from workbench.core.sampled_law import SampledLaw
from workbench.core.validation.signatures import check_arguments

ALWAYS = 1.0  # s, the period of a law that knows no time


class ArmFunctions(NamedTuple):
    """The functions of an arm, the lines about them, a line about each of their parameters, and their sizes by name."""

    laws: tuple[SampledLaw, ...]
    about: tuple[str, ...]
    parameters: tuple[str, ...]
    sizes: Mapping[str, int]

    def __repr__(self) -> str:
        return f"<ArmFunctions {', '.join(law.name for law in self.laws)}>"


@check_arguments
def functions_of(dynamics: Dynamics) -> ArmFunctions:
    """The functions `dynamics`, `inverse_dynamics` and `forward_dynamics` of an arm, each a law without memory.

    `forward_dynamics` solves M qdd = tau - C qd - G, less the friction if there is any, by the factors M = L D L'.

    Examples
    --------
    >>> from workbench.arms.code import functions_of
    >>> arm = wb.arms.Dynamics.of(wb.robot("planar-1r"), "planar-1r")
    >>> [law.name for law in functions_of(arm).laws]
    ['dynamics', 'inverse_dynamics', 'forward_dynamics']
    """
    n = dynamics.dof
    tau = _vector("tau", n).symbols()
    bias = ca.substitute(dynamics.tau, dynamics.qdd, ca.SX.zeros(n))
    state = {"q": dynamics.q, "qd": dynamics.qd}
    matrices = {"M": dynamics.M, "C": dynamics.C, "G": dynamics.G}
    laws = (
        _law(dynamics, "dynamics", "M(q) (n, n), C(q, qd) (n, n) and G(q) (n,).", state, matrices),
        _law(
            dynamics,
            "inverse_dynamics",
            "The torques tau (n,) that give the accelerations qdd.",
            {**state, "qdd": dynamics.qdd},
            {"tau": dynamics.tau},
        ),
        _law(
            dynamics,
            "forward_dynamics",
            "The accelerations qdd (n,) that the torques tau give.",
            {**state, "tau": tau},
            {"qdd": solve_definite(dynamics.M, tau - bias)},
        ),
    )
    notes = tuple(f"{x.name}, {x.path}{f' [{x.unit}]' if x.unit else ''}" for x in letters_of(dynamics))
    return ArmFunctions(laws, tuple(_about(dynamics)), notes, {"JOINTS": n})


def _law(
    dynamics: Dynamics, name: str, about: str, inputs: Mapping[str, ca.SX], outputs: Mapping[str, ca.SX]
) -> SampledLaw:
    """The law that gives the outputs from the inputs at once."""
    readings = Layout(tuple(Entry(letter, np.zeros(dynamics.dof)) for letter in inputs))
    shapes = {letter: part.shape if letter in "MC" else (dynamics.dof,) for letter, part in outputs.items()}
    commands = Layout(tuple(Entry(letter, np.zeros(shape)) for letter, shape in shapes.items()))
    return SampledLaw(
        name=name,
        period=ALWAYS,
        memory=Layout(),
        readings=readings,
        references=Layout(),
        commands=commands,
        parameters=dynamics.p,
        k=ca.SX.sym("k"),
        z=ca.SX(0, 1),
        y=ca.vertcat(*inputs.values()),
        r=ca.SX(0, 1),
        p=dynamics.symbols,
        command=ca.densify(ca.vertcat(*map(ca.vec, outputs.values()))),
        update=ca.SX(0, 1),
        notes=(about,),
    )


def _vector(name: str, n: int) -> Layout:
    return Layout((Entry(name, np.zeros(n)),))


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
