"""The equations that a paper prints: read from text or LaTeX, and held against the derived ones entry by entry.

The room knows formulas as they stand on a page and the `Dynamics` of an arm; nothing that it reads is run as code. Read
`entry_comparison` first, then `printed_equations` and `grammar`.
"""

from workbench.arms.printed.entry_comparison import EntryVerdict, compare

__all__ = [
    "EntryVerdict",
    "compare",
]
