"""The equations that a paper prints: read from text or LaTeX, and compared with the derived ones entry by entry.

It uses printed formulas and the `Dynamics` of an arm. Nothing that it reads is run as code. Read
`entry_comparison` first, then `printed_equations` and `grammar`.
"""

from workbench.arms.paper_equations.entry_comparison import EntryVerdict, compare

__all__ = [
    "EntryVerdict",
    "compare",
]
