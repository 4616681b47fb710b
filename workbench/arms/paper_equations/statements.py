r"""The statements of a file, `name = formula`, taken apart before any name is looked up.

In text a statement ends with its line, in LaTeX with `\\` outside of a matrix, a blank line, the end of a
display, or a line behind which another `name =` begins; unless a bracket is open, or a sign such as + leads on.
`a = b = formula` are two statements.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

from workbench.arms.paper_equations.tex import tokens_of_latex
from workbench.arms.paper_equations.tokens import Token, refusal, tokens_of_text

Language = Literal["text", "latex"]
SEPARATORS = {",", ";"}
SIGNS = {"+", "-", "*", "/"}
AHEAD = 40  # tokens in which an equals sign makes a statement of what comes


@dataclass(frozen=True)
class Statement:
    """The name left of an equals sign, with its place in a matrix if it has one, and the tokens right."""

    name: Token
    place: tuple[int, ...]
    right: tuple[Token, ...]


def statements(text: str, language: Language) -> tuple[Statement, ...]:
    """The statements of a text in the order in which they stand."""
    found = tokens_of_latex(text) if language == "latex" else tokens_of_text(text)
    return tuple(statement for part in _parts(found) for statement in _split_statements(part))


def _parts(tokens: Sequence[Token]) -> Iterator[list[Token]]:
    """The tokens of each statement; a piece without an equals sign beside a sign belongs to the one before."""
    parts: list[list[Token]] = []
    for piece in _pieces(tokens):
        goes_on = parts and (piece[0].kind in SIGNS or parts[-1][-1].kind in SIGNS | {"="})
        if goes_on and not _equals(piece):
            parts[-1].extend(piece)
        else:
            parts.append(piece)
    for part in parts:
        while part and part[-1].kind in (",", ".", ";"):
            part.pop()
        if part and not _equals(part):
            raise refusal(part[0], "here stands no statement of the form `name = formula`, as M[1,1] = m_1*l_1^2.")
        if part:
            yield part


def _pieces(tokens: Sequence[Token]) -> Iterator[list[Token]]:
    piece: list[Token] = []
    for i, token in enumerate(tokens):
        ends = token.kind in SEPARATORS and _begins_statement(tokens[i + 1 : i + 1 + AHEAD], token.within)
        next_line = piece and token.line > piece[-1].line and token.kind == "name" and not token.within
        # the signs of a long piece are sought only where it may end
        complete = next_line and piece[-1].kind not in SIGNS | {"="} and _equals(piece)
        if complete and _begins_statement(tokens[i : i + AHEAD], ()):
            yield piece
            piece = []
        if not token.within and (token.kind == "break" or ends):
            if piece:
                yield piece
            piece = []
        elif token.kind not in ("break", "&") or token.within[-1:] == ("begin",):
            piece.append(token)
    if piece:
        yield piece


def _begins_statement(rest: Sequence[Token], within: tuple[str, ...]) -> bool:
    """True if an equals sign comes before the next break or separator."""
    signs = (token for token in rest if token.kind in SEPARATORS | {"=", "break"})
    return next((sign.kind == "=" for sign in signs if len(sign.within) <= len(within)), False)


def _equals(part: Sequence[Token]) -> list[int]:
    """The places of the equals signs outside of brackets."""
    return [i for i, token in enumerate(part) if token.kind == "=" and not token.within]


def _split_statements(part: list[Token]) -> Iterator[Statement]:
    signs = _equals(part)
    right = tuple(part[signs[-1] + 1 :])
    if not right:
        raise refusal(part[-1], "behind this equals sign stands nothing.")
    for start, end in zip([0, *(sign + 1 for sign in signs)], signs, strict=False):
        yield _statement(part[start:end], right, part[end])


def _statement(left: list[Token], right: tuple[Token, ...], equals: Token) -> Statement:
    """A name, a place in brackets or none, arguments or none; braces around the name change nothing."""
    left = [token for token in left if token.kind not in ("{", "}")]
    if not left or left[0].kind != "name":
        raise refusal(left[0] if left else equals, "left of '=' stands one name, as in M[1,1] = ... or h = ....")
    name, rest = left[0], left[1:]
    place: tuple[int, ...] = ()
    if rest and rest[0].kind == "[":
        end = next(i for i, token in enumerate(rest) if token.kind == "]")
        inner = rest[1:end]
        if [token.kind for token in inner] not in (["number"], ["number", ",", "number"]) or not all(
            token.text.isdecimal() for token in inner[::2]
        ):
            raise refusal(rest[0], f"the place of an entry is one or two whole numbers, as in {name.text}[1,2].")
        place, rest = tuple(int(token.text) for token in inner[::2]), rest[end + 1 :]
    if [token.kind for token in rest] in (["(", "number", ")"], ["(", "number", ",", "number", ")"]):
        numbers = ",".join(token.text for token in rest if token.kind == "number")
        raise refusal(rest[0], f"in round brackets stand arguments; for an entry write {name.text}[{numbers}].")
    if rest and not (rest[0].kind == "(" and rest[-1].kind == ")"):
        raise refusal(rest[0], "left of '=' stands one name, as in M[1,1] = ... or h = ....")
    return Statement(name, place, right)
