"""C's spelling: an operation as a formula of its operands; all others are calls of primitives and functions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import NamedTuple

from workbench.engine.machines.c_real import Real
from workbench.engine.machines.operations import OPERATIONS, Tightness

CHOICE, LOGIC, ORDER, SUM, PRODUCT, UNARY, ATOM = Tightness


class Form(NamedTuple):
    """A formula with places for its operands, and how tightly each of them must hold together."""

    text: str
    operands: tuple[Tightness, ...] = (ATOM, ATOM, ATOM)


# {real} and {integer} stand for the type of a number and of a signed word as wide, {one} for the number 1.
SPELLING: Mapping[str, Form] = {
    "add": Form("{} + {}", (SUM, UNARY)),
    "sub": Form("{} - {}", (SUM, UNARY)),
    "mul": Form("{} * {}", (PRODUCT, UNARY)),
    "fma": Form("({} * {}) + {}", (PRODUCT, UNARY, UNARY)),
    "fms": Form("({} * {}) - {}", (PRODUCT, UNARY, UNARY)),
    "fnma": Form("{2} - ({0} * {1})", (PRODUCT, UNARY, SUM)),
    "div": Form("{} / {}", (PRODUCT, UNARY)),
    "inv": Form("{one} / {}", (UNARY,)),
    "neg": Form("-{}"),
    "lt": Form("{} < {}", (SUM, SUM)),
    "le": Form("{} <= {}", (SUM, SUM)),
    "gt": Form("{} > {}", (SUM, SUM)),
    "ge": Form("{} >= {}", (SUM, SUM)),
    "eq": Form("{} == {}", (SUM, SUM)),
    "ne": Form("{} != {}", (SUM, SUM)),
    "and": Form("{} && {}"),
    "or": Form("{} || {}"),
    "not": Form("!{}"),
    "select": Form("{} ? {} : {}"),
    "if_else": Form("{} ? {} : {}"),
    "barrier": Form("{}"),
    "word_add": Form("{} + {}"),
    "word_mul": Form("{} * {}"),
    "word_and": Form("{} & {}"),
    "word_or": Form("{} | {}"),
    "word_xor": Form("{} ^ {}"),
    "shl": Form("{} << {}"),
    "lshr": Form("{} >> {}"),
    "nonzero": Form("{} != 0u"),
    "signed": Form("({real})({integer}){}"),
}
FUSED_ARGUMENTS = {"fma": "{0}, {1}, {2}", "fms": "{0}, {1}, -{2}", "fnma": "-{0}, {1}, {2}"}  # as arguments of fma


class Text(NamedTuple):
    """An expression in C, and how tightly it holds together; `plain` if it is a variable or a number as it stands."""

    text: str
    tightness: Tightness
    plain: bool = False

    def within(self, least: Tightness) -> str:
        """The text where it must hold together so tightly; a product in a sum has parentheses of its own."""
        bare = self.tightness >= least and not (least == SUM and self.tightness == PRODUCT)
        return self.text if bare else f"({self.text})"


def formula(operation: str, operands: Sequence[Text], real: Real) -> Text:
    """The formula of an operation on expressions of a format."""
    form = SPELLING[operation]
    parts = [text.within(least) for text, least in zip(operands, form.operands, strict=False)]
    return Text(format_operation(operation, parts, real), OPERATIONS[operation].tightness)


def format_operation(operation: str, parts: Sequence[str], real: Real) -> str:
    """The text of an operation on operands that need no parentheses any more."""
    return SPELLING[operation].text.format(*parts, **_words(real))


@lru_cache
def _words(real: Real) -> Mapping[str, str]:
    return {"real": real.type, "integer": real.signed_word, "one": real.literal(1.0)}


def fused_arguments(operation: str, operands: Sequence[Text]) -> str:
    """The arguments of a function for a b + c, for a product that is rounded together with a sum."""
    parts = [text.within(UNARY) for text in operands]
    return FUSED_ARGUMENTS[operation].format(*(part if part[0] != "-" else f"({part})" for part in parts))


def number_of_truth(truth: Text, real: Real) -> Text:
    """The number of a truth: 1 or 0."""
    return Text(f"{truth.within(ATOM)} ? {real.literal(1)} : {real.literal(0)}", CHOICE)


def truth_of_number(number: Text, real: Real) -> Text:
    """The truth of a number: nonzero is true."""
    return Text(f"{number.within(SUM)} != {real.literal(0)}", ORDER)
