"""Plain text to tokens: `m_2*l_1*cos(q_2)**2`, as one types it and as computer algebra prints it."""

from __future__ import annotations

import re
from collections.abc import Iterator

from workbench.notation.formula import GREEK
from workbench.printed.tokens import FUNCTIONS, OPENING, FormulaError, Token, checked, refusal, refuse_size
from workbench.validation.signatures import door

_LETTERS = "A-Za-z_Α-Ωα-ωϕ"
_PATTERN = re.compile(
    r"(?P<space>[ \t\r\f]+)|(?P<comment>[#%][^\n]*)|(?P<break>\n)"
    r"|(?P<number>([0-9]+(\.[0-9]*)?|\.[0-9]+)([eE][+-]?[0-9]+)?)"
    r"|(?P<path>[A-Za-z]\w*(\[[0-9]+\])*(\.[A-Za-z_]\w*(\[[0-9]+\])*)+)"
    rf"|(?P<name>[{_LETTERS}][{_LETTERS}0-9₀-₉]*)"
    r"|(?P<raised>[²³])|(?P<sign>\*\*|[-+*/^()\[\],;='.−·×])"
)
# Signs that a keyboard lacks and a copied formula has.
_TYPED = str.maketrans("−·×²³₀₁₂₃₄₅₆₇₈₉", "-**230123456789") | {ord(sign): name for name, sign in GREEK.items()}


@door
def tokens(text: str) -> tuple[Token, ...]:
    """The tokens of a text; a new line is a "break" unless a bracket is open.

    Raises
    ------
    FormulaError
        If a character belongs to no formula, a bracket has no partner, or the text is too long or too
        deeply nested; with its place.
    """
    refuse_size(text)
    return checked(_scan(text))


def _scan(text: str) -> Iterator[Token]:
    line, start, depth, at = 1, 0, 0, 0
    while at < len(text):
        found = _PATTERN.match(text, at)
        place = (line, at - start + 1)
        if found is None:
            raise _unknown(text[at], place)
        at = found.end()
        kind, said = found.lastgroup or "", found.group()
        if kind == "break":
            line, start = line + 1, at
            if depth == 0:
                yield Token("break", "the end of the line", *place)
        elif kind not in ("space", "comment"):
            depth += (said in OPENING) - (said in OPENING.values())
            if kind == "raised":
                yield Token("^", said, *place)
            yield _token(kind, said.translate(_TYPED), place)


def _token(kind: str, said: str, place: tuple[int, int]) -> Token:
    match kind:
        case "sign":
            return Token("^" if said == "**" else said, said, *place)
        case "raised":
            return Token("number", said, *place)
        case _ if said in FUNCTIONS:
            return Token("function", said, *place)
    return Token("name" if kind == "path" else kind, said, *place)


def _unknown(character: str, place: tuple[int, int]) -> FormulaError:
    why = "LaTeX is read from a file that ends in .tex" if character == "\\" else "it is no sign of a formula"
    return refusal(
        place, f"{character!r} cannot be read: {why}; formulas are made of names, numbers and + - * / ^ ( ) [ ]."
    )
