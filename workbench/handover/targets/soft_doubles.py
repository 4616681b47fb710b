"""Sums of doubles on Cortex-M3 and M4, which have no instructions for them: one case that GCC's routine rounds wrongly.

`__aeabi_dadd` of libgcc for these processors (seen in 12.2.1; it is written in assembly) shifts the smaller number by
the difference of the exponents. Where that is 33, and the numbers have opposite signs, it keeps one bit behind the last
one of the larger number and a mark for all others. If the result lies below a power of two it is shifted back by that
one bit, and is rounded by the mark alone: 1 - 0x1.72e0936935f7p-33 gives 0x1.fffffffe8d1f6p-1, and ...7 is next to it.
Products and quotients are not concerned, nor is a Cortex-M0, whose routine is another one.

The file takes that case from the library; the linker hands it all sums if it is told so by `WRAPS`.
"""

from workbench.core.templates import template_text

SOFT_DOUBLES_FILE = "soft_doubles.c"
WRAPS = tuple(f"-Wl,--wrap=__aeabi_{name}" for name in ("dadd", "dsub", "drsub"))


def soft_doubles() -> str:
    """The file in C."""
    return template_text("workbench.handover", f"targets/{SOFT_DOUBLES_FILE}")
