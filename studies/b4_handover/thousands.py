"""Counts of instructions in thousands, as the tables of the study print them."""

from __future__ import annotations


def in_thousands(count: float) -> float | int:
    """A count in thousands to three digits, whole from a hundred thousand on."""
    value = float(f"{count / 1000:.3g}")
    return value if value < 100 else round(value)
