"""What is said of an arm above its equations: its name and what its letters mean."""

from __future__ import annotations

from typing import NamedTuple

import casadi as ca
import numpy as np

from workbench.core import Dynamics

ROUNDING_OF_TWO_ROADS = 1e-9  # relative; a friction that is smaller would not be felt either


class Letter(NamedTuple):
    """A parameter: how it is printed, its path, its value and unit."""

    name: str
    path: str
    value: float
    unit: str


def harmless(text: str) -> str:
    """Text from outside as it may stand in any comment: one line of ASCII that ends no comment and no string."""
    printable = "".join(c if " " <= c <= "~" else "?" for c in text)
    return printable.replace("\\", "|").replace('"', "'").replace("*/", "*|").replace("/*", "|*")


def title(dynamics: Dynamics) -> str:
    """The equation of motion, of which arm, and which joints have no motor."""
    friction = " + F(qd)" if has_friction(dynamics) else ""
    idle = ", ".join(f"tau_{i + 1} = 0" for i in range(dynamics.dof) if i not in dynamics.motors)
    equation = f"M(q) qdd + C(q, qd) qd + G(q){friction} = tau, n = {dynamics.dof}"
    return f"{harmless(dynamics.name)}: {equation}{f', without a motor: {idle}' if idle else ''}"


def has_friction(dynamics: Dynamics) -> bool:
    """Whether it takes more than C qd + G to keep a velocity: the joints have friction."""
    bias = ca.substitute(dynamics.tau, dynamics.qdd, ca.SX.zeros(dynamics.dof))
    smooth = dynamics.C @ dynamics.qd
    unexplained, known = bias - smooth - dynamics.G, ca.fabs(smooth) + ca.fabs(dynamics.G)
    function = ca.Function("friction", [dynamics.q, dynamics.qd, dynamics.symbols], [unexplained, known])
    one = np.ones(dynamics.dof)
    gap, size = (np.array(part) for part in function(one, one, dynamics.p.default))
    return bool(np.any(np.abs(gap) > ROUNDING_OF_TWO_ROADS * np.max(size)))


def letters_of(dynamics: Dynamics) -> list[Letter]:
    """The parameters in their order."""
    names, p = dynamics.names(), dynamics.p
    units = [entry.unit for entry in p.entries for _ in entry.labels()]
    rows = zip(p.labels, p.default, units, strict=True)
    return [Letter(harmless(names[path]), harmless(path), float(value), harmless(unit)) for path, value, unit in rows]
