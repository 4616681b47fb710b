"""Tokens, and the lexer of plain text, `m_2*l_1*cos(q_2)**2` as one types it and computer algebra prints it."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from fractions import Fraction

from workbench.notation.formula import GREEK

# Beyond these a text is no equation of a paper; it is refused before any work is done on it.
MOST_CHARACTERS, MOST_TOKENS, DEEPEST, LONGEST_WORD = 50_000, 20_000, 50, 80
LARGEST_EXPONENT_OF_TEN = 99
LONGEST_QUOTE = 40  # of what a message quotes

OPENING = {"(": ")", "[": "]", "{": "}", "begin": "end"}
FUNCTIONS = ("sin", "cos", "tan", "sqrt")


class FormulaError(ValueError):
    """The error of a text that is no formula; the message begins with its line and column."""


@dataclass(frozen=True)
class Token:
    """A piece of a formula, and where it begins, counted from 1.

    `kind` is "number", "name", "function", "frac", "begin" or "end" (of a matrix), "row", "break" or
    "transpose", or the character itself. A name also has its `index` and the `dots` over it.
    """

    kind: str
    text: str
    line: int
    column: int
    index: str = ""
    dots: int = 0

    @property
    def shown(self) -> str:
        """The token as a message quotes it."""
        return cut(self.text if not self.index else f"{self.text}_{self.index}")


def refusal(place: Token | tuple[int, int], said: str) -> FormulaError:
    """The error that refuses the text at a place, to be raised."""
    line, column = (place.line, place.column) if isinstance(place, Token) else place
    return FormulaError(f"line {line}, column {column}: {said}")


def cut(said: str) -> str:
    """A piece of the text as a message quotes it, shortened."""
    return said if len(said) <= LONGEST_QUOTE else f"{said[:LONGEST_QUOTE]}..."


def refuse_size(text: str) -> None:
    """Refuse a text that is too long, before it is read."""
    if len(text) > MOST_CHARACTERS:
        raise FormulaError(
            f"the equations of a paper take at most {MOST_CHARACTERS} characters; got {len(text)}: keep only those to "
            "be checked."
        )


def checked(tokens: Iterable[Token]) -> tuple[Token, ...]:
    """The tokens, if they are not too many and their brackets match, not too deep."""
    kept: list[Token] = []
    opened: list[Token] = []
    for token in tokens:
        kept.append(token)
        if len(kept) > MOST_TOKENS:
            raise refusal(token, f"equations of at most {MOST_TOKENS} signs are read; keep only those to be checked.")
        length = len(token.text) + len(token.index)
        if length > LONGEST_WORD and token.kind in ("number", "name"):
            raise refusal(token, f"a {token.kind} has at most {LONGEST_WORD} characters; got {length}.")
        if token.kind in OPENING:
            opened.append(token)
            if len(opened) > DEEPEST:
                raise refusal(token, f"brackets are nested more than {DEEPEST} deep; write the formula in parts.")
        elif token.kind in OPENING.values():
            if not opened or OPENING[opened[-1].kind] != token.kind:
                raise refusal(token, f"'{token.text}' closes nothing that is open; check the brackets.")
            opened.pop()
    if opened:
        raise refusal(opened[-1], f"'{opened[-1].text}' is never closed; check the brackets.")
    return tuple(kept)


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


def tokens_of_text(text: str) -> tuple[Token, ...]:
    """The tokens of a text; a new line is a "break" unless a bracket is open."""
    refuse_size(text)
    return checked(_scan(text))


def _scan(text: str) -> Iterator[Token]:
    line, start, depth, at = 1, 0, 0, 0
    while at < len(text):
        found = _PATTERN.match(text, at)
        place = (line, at - start + 1)
        if found is None:
            latex = "LaTeX is read from a file that ends in .tex"
            why = latex if text[at] == "\\" else "it is no sign of a formula"
            known = "formulas are made of names, numbers and + - * / ^ ( ) [ ]"
            raise refusal(place, f"{text[at]!r} cannot be read: {why}; {known}.")
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
            said = said.translate(_TYPED)
            kind = {"sign": "^" if said == "**" else said, "raised": "number", "path": "name"}.get(kind, kind)
            yield Token("function" if said in FUNCTIONS else kind, said, *place)


def exact_number(token: Token) -> Fraction:
    """The exact value of a number as it is written."""
    mantissa, _, exponent = token.text.lower().partition("e")
    if exponent and abs(int(exponent)) > LARGEST_EXPONENT_OF_TEN:
        raise refusal(token, f"a number lies between 1e-{LARGEST_EXPONENT_OF_TEN} and 1e{LARGEST_EXPONENT_OF_TEN}.")
    return Fraction(mantissa) * Fraction(10) ** int(exponent or 0)
