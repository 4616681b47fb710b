"""Text from outside, as it may stand in a comment of any language."""

from __future__ import annotations


def harmless(text: str) -> str:
    """Text from outside as it may stand in any comment: one line of ASCII that ends no comment and no string."""
    printable = "".join(c if " " <= c <= "~" else "?" for c in text)
    printable = printable.replace("??", "? ?").replace("??", "? ?")  # which begins a trigraph in C
    return printable.replace("\\", "|").replace('"', "'").replace("*/", "*|").replace("/*", "|*")
