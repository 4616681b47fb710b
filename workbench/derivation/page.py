"""The equations of an arm for reading: what its letters mean, then M, C and G entry by entry.

Where the entries are short they stand in the form of a textbook. Elsewhere the parts that occur more than
once are given names, in order, each before it is used.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from html import escape

from workbench.core import Dynamics
from workbench.core.show import letters, table_to_html, written
from workbench.derivation.letters import harmless, letters_of, title
from workbench.notation import latex, mathml, text, typst_math
from workbench.notation.formula import Matrix, Relation, Symbol, equations


def as_text(dynamics: Dynamics) -> str:
    """Plain text, for a terminal."""
    return "\n".join([*_head(dynamics), *_blocks(dynamics, text.emit)])


def as_latex(dynamics: Dynamics) -> str:
    """One display equation an entry; the letters as comments above."""
    head = (f"% {line}".rstrip() for line in _head(dynamics))
    return "\n".join([*head, *_blocks(dynamics, lambda relation: f"\\[\n{latex.emit(relation)}\n\\]")])


def as_typst(dynamics: Dynamics) -> str:
    """One block equation an entry; the letters as comments above."""
    head = (f"// {line}".rstrip() for line in _head(dynamics))
    return "\n".join([*head, *_blocks(dynamics, lambda relation: f"$ {typst_math.emit(relation)} $")])


def as_mathml(dynamics: Dynamics) -> str:
    """A page for a browser."""
    rows = [(letters(letter.name), letter.path, f"{letter.value:g}", letter.unit) for letter in letters_of(dynamics)]
    table = table_to_html("The letters", ("letter", "parameter", "value", "unit"), rows)
    head = f'<!doctype html>\n<meta charset="utf-8">\n<title>{escape(harmless(dynamics.name))}</title>'
    return "\n".join([head, f"<h1>{escape(title(dynamics))}</h1>", table, *_blocks(dynamics, mathml.emit)])


def _head(dynamics: Dynamics) -> list[str]:
    lines = (f"{x.name:6} {x.path:20} {x.value:g} {x.unit}".rstrip() for x in letters_of(dynamics))
    return [title(dynamics), "", *lines]


def _blocks(dynamics: Dynamics, emit: Callable[[Relation], str]) -> Iterator[str]:
    definitions, matrices = written({"M": dynamics.M, "C": dynamics.C, "G": dynamics.G}, dynamics.names())
    if definitions:
        yield "\n".join(["", *map(emit, definitions)])
    for relation in matrices:
        name, right = relation.left, relation.right
        assert isinstance(name, Symbol)
        entries = equations(name, right if isinstance(right, Matrix) else Matrix(((right,),)))
        yield "\n".join(["", *map(emit, entries)])
