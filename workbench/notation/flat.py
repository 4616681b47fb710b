"""What languages of one line have in common: fractions by a slash, functions by their names."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import ClassVar

from workbench.notation.markup import AbstractMarkup, Space


class AbstractFlat(AbstractMarkup):
    """A markup of plain characters, in which operators do all the work."""

    flat = True
    # What stands between a base and its exponent.
    power_sign: ClassVar[str]

    def number(self, value: Fraction | float) -> str:
        """A fraction as 1/2, a double by its shortest digits."""
        return str(value) if isinstance(value, Fraction) else repr(value)

    def times(self, space: Space) -> str:
        """A star."""
        return "*"

    def row(self, parts: Sequence[str]) -> str:
        """Parts side by side."""
        return "".join(parts)

    def quotient(self, numerator: str, denominator: str) -> str:
        """A slash."""
        return f"{numerator}/{denominator}"

    def power(self, base: str, exponent: str) -> str:
        """The sign of a power."""
        return f"{base}{self.power_sign}{exponent}"

    def call(self, function: str, arguments: Sequence[str], *, exponent: str = "", bare: bool = False) -> str:
        """The function's name, and its arguments in parentheses."""
        return f"{self.opening(function)}{', '.join(arguments)})"

    def group(self, inner: str) -> str:
        """Parentheses."""
        return f"({inner})"

    def closing(self, exponent: str = "") -> str:
        """A closed parenthesis."""
        return self.power(")", exponent) if exponent else ")"
