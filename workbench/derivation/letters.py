"""What is said of an arm above its equations: its name and what its letters mean."""

from __future__ import annotations

from typing import NamedTuple

from workbench.core import Dynamics


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
    """The equation of motion, and of which arm."""
    return f"{harmless(dynamics.name)}: M(q) qdd + C(q, qd) qd + G(q) = tau, n = {dynamics.dof}"


def letters_of(dynamics: Dynamics) -> list[Letter]:
    """The parameters in their order."""
    names, p = dynamics.names(), dynamics.p
    units = [entry.unit for entry in p.entries for _ in entry.labels()]
    rows = zip(p.labels, p.default, units, strict=True)
    return [Letter(harmless(names[path]), harmless(path), float(value), harmless(unit)) for path, value, unit in rows]
