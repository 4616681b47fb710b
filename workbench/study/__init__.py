"""The study: a question, the runs that answer it, and the report of their results, as data.

The room knows loops only as equations, and their authors not at all; it prints and draws nothing.
Read `study` first, then `execution`, where a study's sweeps become chunks, a ledger and samples.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

_FILES = {
    "contract": "Run Sweep",
    "document.document": "Column Figure Finding Itemize Page Panel Paragraph Section Table Variation Verdict",
    "evidence.law_tables": "side_by_side",
    "knob": "Knob",
    "marks": "bars cell points",
    "study": "Case Results Study",
    "tuning": "Trial Tuning",
    "uncertainty": "Factor LatinHypercube LogNormal LogUniform MonteCarlo MorrisDesign Normal OneAtATime SobolDesign "
    "Triangular Uniform least_base morris quantiles sobol tornado",
    "work": "Work",
}
_HOMES = {name: file for file, names in _FILES.items() for name in names.split()}
__all__ = sorted(_HOMES)


def __getattr__(name: str) -> Any:
    """A name of the room, loaded from its file when it is first asked for."""
    if name not in _HOMES:
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
