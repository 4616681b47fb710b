"""The equations of an arm for reading: what its letters mean, then M, C and G entry by entry.

Where the entries are short they stand in the form of a textbook. Elsewhere the parts that occur more than
once are given names, in order, each before it is used.
"""

from __future__ import annotations

from collections.abc import Iterator
from html import escape

from workbench.core import Dynamics
from workbench.core.layout import letters
from workbench.handover.letters import harmless, has_friction, letters_of, title
from workbench.notation import latex, mathml, text, typst_math
from workbench.notation.formula import Matrix, Symbol, System, equations
from workbench.notation.reader import equations_of
from workbench.validation.signatures import door
from workbench.validation.views import table_to_html


@door
def as_text(dynamics: Dynamics) -> str:
    """Plain text, for a terminal; the letters as comments above, so that `workbench verify` reads it."""
    head = (f"# {line}" if line else "" for line in _head(dynamics))
    return "\n".join([*head, *("\n" + text.emit(block) for block in _blocks(dynamics))])


@door
def as_latex(dynamics: Dynamics) -> str:
    """Displays for a document with amsmath; the letters as comments above."""
    head = (f"% {line}".rstrip() for line in _head(dynamics))
    displays = ("\n" + latex.display(block.relations) for block in _blocks(dynamics))
    return "\n".join([*head, "", r"\allowdisplaybreaks", *displays])


@door
def as_typst(dynamics: Dynamics) -> str:
    """A Typst document; the letters as comments above."""
    head = (f"// {line}".rstrip() for line in _head(dynamics))
    displays = (f"\n$ {typst_math.emit(block)} $" for block in _blocks(dynamics))
    return "\n".join([*head, "", "#set text(11pt)", "#show math.equation: set block(breakable: true)", *displays])


@door
def as_mathml(dynamics: Dynamics) -> str:
    """A page for a browser."""
    rows = [(letters(letter.name), letter.path, f"{letter.value:g}", letter.unit) for letter in letters_of(dynamics)]
    table = table_to_html("", ("letter", "parameter", "value", "unit"), rows)
    named = f"<title>{escape(harmless(dynamics.name))}</title>"
    head = ["<!doctype html>", '<meta charset="utf-8"/>', named, STYLE, f"<h1>{escape(title(dynamics))}</h1>", table]
    return "\n".join([*head, *(f"\n{mathml.emit(block)}" for block in _blocks(dynamics))])


STYLE = "<style>body { margin: 2em } h1 { font-size: 1.2em } td, th { padding-right: 1em; text-align: left }</style>"


def _head(dynamics: Dynamics) -> list[str]:
    lines = (f"{x.name:6} {x.path:20} {x.value:g} {x.unit}".rstrip() for x in letters_of(dynamics))
    friction = ["The friction F(qd) is left out here; the programs of this arm have it in tau."]
    return [title(dynamics), *(friction if has_friction(dynamics) else []), *(["", *lines] if dynamics.p.size else [])]


def _blocks(dynamics: Dynamics) -> Iterator[System]:
    """The definitions, if there are any, then M, C and G entry by entry."""
    definitions, matrices = equations_of({"M": dynamics.M, "C": dynamics.C, "G": dynamics.G}, dynamics.names())
    if definitions:
        yield System(definitions)
    for relation in matrices:
        name, right = relation.left, relation.right
        assert isinstance(name, Symbol)
        yield System(tuple(equations(name, right if isinstance(right, Matrix) else Matrix(((right,),)))))
