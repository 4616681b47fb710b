"""Tokens, the lexer of plain text, and the names for which tokens stand.

The text is `m_2*l_1*cos(q_2)**2` as one types it and computer algebra prints it; however a name is written, `l_c1`,
`lc1`, `l_{c1}` and `l_{c,1}` are one.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction

from workbench.core.notation.formula import GREEK, Symbol, name_of, symbol

# Beyond these a text is no equation of a paper; it is refused before any work is done on it.
MOST_CHARACTERS, MOST_TOKENS, DEEPEST, LONGEST_WORD = 50_000, 20_000, 50, 80
LARGEST_EXPONENT_OF_TEN = 99
LONGEST_QUOTE = 40  # of what a message quotes

BRACKETS = {"(": ")", "[": "]", "{": "}", "begin": "end"}
FUNCTIONS = ("sin", "cos", "tan", "sqrt")


class FormulaError(ValueError):
    """The error of a text that is no formula; the message begins with its line and column."""


@dataclass(frozen=True)
class Token:
    """A piece of a formula, and where it begins, counted from 1.

    `kind` is "number", "name", "function", "frac", "begin" or "end" (of a matrix), "row", "break" or
    "transpose", or the character itself. A name also has its `index` and the `dots` over it. `within` has the kinds of
    the brackets round it.
    """

    kind: str
    text: str
    line: int
    column: int
    index: str = ""
    dots: int = 0
    within: tuple[str, ...] = ()

    @property
    def quotation(self) -> str:
        """The token as a message quotes it."""
        return shorten(self.text if not self.index else f"{self.text}_{self.index}")


def refusal(place: Token | tuple[int, int], message: str) -> FormulaError:
    """The error that refuses the text at a place, to be raised."""
    line, column = (place.line, place.column) if isinstance(place, Token) else place
    return FormulaError(f"line {line}, column {column}: {message}")


def shorten(text: str) -> str:
    """A piece of the text as a message quotes it, shortened."""
    return text if len(text) <= LONGEST_QUOTE else f"{text[:LONGEST_QUOTE]}..."


def refuse_size(text: str) -> None:
    """Refuse a text that is too long, before it is read."""
    if len(text) > MOST_CHARACTERS:
        advice = "keep only those to be checked"
        raise FormulaError(f"equations take at most {MOST_CHARACTERS} characters; got {len(text)}: {advice}.")


def checked_tokens(tokens: Iterable[Token]) -> tuple[Token, ...]:
    """The tokens, if they are not too many and their brackets match, not too deep."""
    kept: list[Token] = []
    opened: list[Token] = []
    for token in tokens:
        outside = opened[:-1] if token.kind in BRACKETS.values() else opened
        kept.append(replace(token, within=tuple(bracket.kind for bracket in outside)))
        if len(kept) > MOST_TOKENS:
            raise refusal(token, f"equations of at most {MOST_TOKENS} signs are read; keep only those to be checked.")
        length = len(token.text) + len(token.index)
        if length > LONGEST_WORD and token.kind in ("number", "name"):
            raise refusal(token, f"a {token.kind} has at most {LONGEST_WORD} characters; got {length}.")
        if token.kind in BRACKETS:
            opened.append(token)
            if len(opened) > DEEPEST:
                raise refusal(token, f"brackets are nested more than {DEEPEST} deep; write the formula in parts.")
        elif token.kind in BRACKETS.values():
            if not opened or BRACKETS[opened[-1].kind] != token.kind:
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
_TYPED_LETTERS = str.maketrans("−·×²³₀₁₂₃₄₅₆₇₈₉", "-**230123456789") | {ord(sign): name for name, sign in GREEK.items()}


def tokens_of_text(text: str) -> tuple[Token, ...]:
    """The tokens of a text; a new line is a "break" unless a bracket is open."""
    refuse_size(text)
    return checked_tokens(_scan(text))


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
            depth += (said in BRACKETS) - (said in BRACKETS.values())
            if kind == "raised":
                yield Token("^", said, *place)
            said = said.translate(_TYPED_LETTERS)
            kind = {"sign": "^" if said == "**" else said, "raised": "number", "path": "name"}.get(kind, kind)
            yield Token("function" if said in FUNCTIONS else kind, said, *place)


def exact_number(token: Token) -> Fraction:
    """The exact value of a number as it is written."""
    mantissa, _, exponent = token.text.lower().partition("e")
    if exponent and abs(int(exponent)) > LARGEST_EXPONENT_OF_TEN:
        raise refusal(token, f"a number lies between 1e-{LARGEST_EXPONENT_OF_TEN} and 1e{LARGEST_EXPONENT_OF_TEN}.")
    return Fraction(mantissa) * Fraction(10) ** int(exponent or 0)


# Letters with their index, without what sets the two apart; dots; accent and mark.
Key = tuple[str, int, str]
PI = Symbol("pi")  # the number, unless pi is a name that is known
SHORTHAND = re.compile(r"([sc])_?([0-9]+)")


def key_of(symbol: Symbol) -> Key:
    """The key that all spellings of one symbol have in common."""
    return symbol.letter + re.sub(r"[,_ ]", "", symbol.index), symbol.dots, symbol.accent + symbol.mark


def spelled_symbol(letters: str, index: str = "", dots: int = 0) -> Symbol:
    """The symbol of letters as a lexer found them, with index and dots: `qd` with index 1 is q dot 1."""
    read = symbol("_".join(filter(None, [letters, index.replace(",", "_")])))
    return Symbol(read.letter, read.index, min(read.dots + dots, 2), read.accent, read.mark)


@dataclass(frozen=True)
class Names:
    """The symbols that are known, by their keys, and those known by a path such as `links[0].mass`."""

    keys: Mapping[Key, Symbol]
    paths: Mapping[str, Symbol]

    @staticmethod
    def of(symbols: Iterable[Symbol], paths: Mapping[str, Symbol] | None = None) -> Names:
        """The table of these symbols."""
        return Names({key_of(symbol): symbol for symbol in symbols}, paths or {})

    def find(self, letters: str, index: str = "", dots: int = 0) -> Symbol | None:
        """The known symbol of that spelling, if there is one."""
        if not index and not dots and letters in self.paths:
            return self.paths[letters]
        return self.keys.get(key_of(spelled_symbol(letters, index, dots)))

    def split(self, token: Token) -> list[Symbol]:
        """The symbols that a name stands for: letters side by side in LaTeX may be several."""
        if (whole := self.find(token.text, token.index, token.dots)) is not None:
            return [whole]
        if token.text.isalpha() and not token.dots and (several := self._side_by_side(token)) is not None:
            return several
        raise refusal(token, self._refusal_text(token))

    def _side_by_side(self, token: Token) -> list[Symbol] | None:
        letters = token.text
        rest: dict[int, list[Symbol]] = {}  # from each letter on
        for start in range(len(letters) - 1, -1, -1):
            if (last := self.find(letters[start:], token.index)) is not None:
                rest[start] = [last]
                continue
            for end in range(len(letters) - 1, start, -1):
                if end in rest and (first := self.find(letters[start:end])) is not None:
                    rest[start] = [first, *rest[end]]
                    break
        return rest.get(0)

    def _refusal_text(self, token: Token) -> str:
        said = name_of(spelled_symbol(token.text, token.index, token.dots)) if token.index or token.dots else token.text
        letters = (symbol for symbol in self.keys.values() if not (symbol.bold and symbol.dots))
        known = sorted({name_of(symbol) for symbol in letters if "," not in symbol.index})
        near = difflib.get_close_matches(said[:60], [*known, *self.paths], n=1, cutoff=0.6)
        if short := SHORTHAND.fullmatch(said):
            angles = " + ".join(f"q_{digit}" for digit in short[2])
            function = "sin" if short[1] == "s" else "cos"
            advice = f" If it is short for {function}({angles}), declare it: `{said} = {function}({angles})`."
        elif "." in said:
            advice = (
                " A formula is no program: a path names a number of the robot, as links[0].length, and nothing else."
            )
        elif near:
            advice = f" Did you mean '{near[0]}'?"
        else:
            advice = f" Known are {', '.join(known[:20])}{', ...' if len(known) > 20 else ''}."
        return f"there is no '{shorten(said)}' among the names of this robot, nor is it declared here.{advice}"
