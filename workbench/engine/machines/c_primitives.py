"""Primitives in C: square root, floor and the like, without C's library or by it, from two files of C."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Mapping
from functools import lru_cache
from pathlib import Path

from workbench.engine.machines.c_real import Real, word_text

FOLDER = Path(__file__).parent
HEAD = re.compile(r"^static \w+ NAME_(\w+?)_MARK\(", re.MULTILINE)
PLACEHOLDER = re.compile(r"\bNAME_(?P<own>\w+?)_MARK\b|\b(?P<library>sqrt|fma)_MARK\b|\b(?P<word>[A-Z_]{2,})\b")
NEEDS = {
    "finite": ("bits",),
    "defined": ("bits",),
    "fabs": ("bits", "number"),
    "copysign": ("bits", "number"),
    "trunc": ("fabs", "copysign"),
    "floor": ("trunc",),
    "sqrt": ("bits", "number", "finite"),
}


def _templates(file: str) -> Mapping[str, str]:
    """The functions of a file by name, each a paragraph of it."""
    paragraphs = (FOLDER / file).read_text(encoding="utf-8").strip().split("\n\n")
    return {head[1]: text for text in paragraphs if (head := HEAD.search(text))}


PRIMITIVES = _templates("c_primitives.c")
HARDWARE = _templates("c_library.c")


def primitive(prefix: str, real: Real, name: str, hardware: Collection[str] = ()) -> str:
    """The definition of a primitive of a format, of the processor's own where that is asked for."""
    words = numbers_of(real)

    def replacement(match: re.Match[str]) -> str:
        if match["own"]:
            return f"{prefix}_{match['own']}{real.mark}"
        return f"{match['library']}{real.mark}" if match["library"] else words[match["word"]]

    return PLACEHOLDER.sub(replacement, HARDWARE[name] if name in hardware else PRIMITIVES[name])


@lru_cache
def numbers_of(real: Real) -> Mapping[str, str]:
    """The types and numbers of a format by the words that stand for them in the files of C."""
    bias = (1 << (real.bits - real.digits - 2)) - 1
    up = real.digits + 2 - real.digits % 2  # an even power of two, which leaves no subnormal number
    return {
        "REAL": real.type,
        "WORD": real.word,
        "INTEGER": real.signed_word,
        "BIAS": str(bias),
        "DIGITS": f"{real.digits}u",
        "STEPS": str(real.digits + 2),
        "OFFSET": word_text((bias - 1) << real.digits),
        "ZERO": real.literal(0.0),
        "ONE": real.literal(1.0),
        "WHOLE": real.literal(2.0**real.digits),
        "SMALLEST": real.literal(2.0 ** (1 - bias)),
        "UP": real.literal(2.0**up),
        "DOWN": real.literal(2.0 ** -(up // 2)),
        "SIGN": word_text(1 << (real.bits - 1)),
        "HIDDEN": word_text(1 << real.digits),
        "MANTISSA": word_text((1 << real.digits) - 1),
        "INFINITE": word_text(real.pattern(math.inf)),
        "NOT_A_NUMBER": word_text(real.pattern(math.nan)),
    }
