"""The equations of an arm written out: what its letters mean, then M, C and G entry by entry."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import NamedTuple

from workbench.core import Dynamics
from workbench.core.show import formula_of
from workbench.notation import latex, python, text
from workbench.notation.formula import Matrix, Relation, Symbol, equations, symbol


class Letter(NamedTuple):
    """A parameter: how it is printed, its path, its value and unit."""

    name: str
    path: str
    value: float
    unit: str


def as_text(dynamics: Dynamics) -> str:
    """Plain text, for a terminal."""
    return "\n".join([*_head(dynamics), *_blocks(dynamics, text.emit)])


def as_latex(dynamics: Dynamics) -> str:
    """One display equation an entry; the letters as comments above."""
    head = (f"% {line}".rstrip() for line in _head(dynamics))
    return "\n".join([*head, *_blocks(dynamics, lambda relation: f"\\[\n{latex.emit(relation)}\n\\]")])


def as_python(dynamics: Dynamics) -> str:
    """Assignments over NumPy that end with M, C and G; q_1, qd_1 and their kin are left to be given."""
    lines = [f"# {_title(dynamics)}", "import numpy as np", ""]
    for letter in _letters(dynamics):
        variable = python.identifier(symbol(letter.name))
        lines.append(f"{variable} = {letter.value!r}  # {letter.unit}, {letter.path}")
    for name, relations in _entries(dynamics).items():
        variables = [python.identifier(relation.left) for relation in relations if isinstance(relation.left, Symbol)]
        shape = "" if name == "G" else f".reshape({dynamics.dof}, {dynamics.dof})"
        lines += ["", *map(python.emit, relations), f"{name} = np.array([{', '.join(variables)}]){shape}"]
    return "\n".join(lines)


FORMS: Mapping[str, Callable[[Dynamics], str]] = {"text": as_text, "latex": as_latex, "python": as_python}


def _title(dynamics: Dynamics) -> str:
    return f"{dynamics.name}: M(q) qdd + C(q, qd) qd + G(q) = tau, n = {dynamics.dof}"


def _head(dynamics: Dynamics) -> list[str]:
    lines = (f"{x.name:6} {x.path:20} {x.value:g} {x.unit}".rstrip() for x in _letters(dynamics))
    return [_title(dynamics), "", *lines]


def _letters(dynamics: Dynamics) -> list[Letter]:
    names, p = dynamics.names(), dynamics.p
    units = [entry.unit for entry in p.entries for _ in entry.labels()]
    rows = zip(p.labels, p.default, units, strict=True)
    return [Letter(names[path], path, float(value), unit) for path, value, unit in rows]


def _entries(dynamics: Dynamics) -> dict[str, list[Relation]]:
    entries = {}
    for letter, matrix in (("M", dynamics.M), ("C", dynamics.C), ("G", dynamics.G)):
        formula = formula_of(matrix, dynamics.names())
        entries[letter] = equations(symbol(letter), formula if isinstance(formula, Matrix) else Matrix(((formula,),)))
    return entries


def _blocks(dynamics: Dynamics, emit: Callable[[Relation], str]) -> Iterator[str]:
    for relations in _entries(dynamics).values():
        yield "\n".join(["", *map(emit, relations)])
