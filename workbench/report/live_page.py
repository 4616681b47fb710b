"""The live part of a page: its scripts, its data and its style, all inside it, and the policy that allows them."""

from __future__ import annotations

import json
from base64 import b64encode
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from hashlib import sha256

from markupsafe import Markup

from workbench.core.templates import template_text
from workbench.report.figures.dark_colors import variable
from workbench.report.figures.plates import Plate
from workbench.report.live.page_data import LiveData

# in the order in which they need each other
SCRIPTS = (
    *("curves", "rulers", "marks", "planes", "figures", "tables", "animation", "address", "knobs", "answers", "holds"),
    *("pictures", "pool", "motion", "handles", "crossover_handle", "pole_handles", "specification", "page"),
)
WORKER = (
    *("linear_matrices", "linear_eigenvalues", "linear_roots", "linear_response", "linear_model", "linear_rest"),
    *("linear_corners", "linear_poles", "linear_margins", "linear_disk", "linear_answer"),
    *("linear_seek", "linear_place", "linear_descent", "linear_gain_plane", "linear_gain_search"),
    *("linear_program", "linear_law", "linear_specification", "worker"),
)
PAINTS = {"color", "fill", "ink"}  # the colours of a series in a plate
STYLES = ("live", "figures", "tables", "animation")
PRINT_POLICY = Markup("default-src 'none'; style-src 'unsafe-inline'; font-src data:")  # of a page without scripts


@dataclass(frozen=True)
class LivePage:
    """The parts of a page beside its print, each as it stands between its tags."""

    script: Markup
    worker: Markup
    data: Markup
    style: Markup
    policy: Markup


def live_page(live: LiveData, plates: Mapping[str, Plate]) -> LivePage:
    """The live part of a page from the data of its study and the plates of its figures."""
    shown = {link["figure"] for link in (*live["curves"], *live["marks"], *live["linear_marks"])}
    data = json.dumps(
        {**live, "plates": {name: _painted(plate) for name, plate in plates.items() if name in shown}},
        allow_nan=False,
        separators=(",", ":"),
    )
    digest = b64encode(sha256(_script().encode()).digest()).decode("ascii")
    policy = f"{PRINT_POLICY!s}; script-src 'sha256-{digest}' 'wasm-unsafe-eval' blob:; worker-src blob:"
    # no text can end the element that holds it
    safe = data.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")
    return LivePage(Markup(_script()), Markup(_worker()), Markup(safe), Markup(_styles()), Markup(policy))


def _painted(plate: Plate) -> dict[str, object]:
    """A plate whose colours are the variables of the page."""
    panels = [
        {**panel, "series": [{key: _paint(key, held) for key, held in one.items()} for one in panel["series"]]}
        for panel in plate["panels"]
    ]
    return {**plate, "panels": panels}


def _paint(key: str, held: object) -> object:
    return variable(held) if key in PAINTS and isinstance(held, str) else held


@cache
def _script() -> str:
    return "\n".join(_text(f"{name}.js") for name in SCRIPTS)


@cache
def _worker() -> str:
    return "\n".join(_text(f"{name}.js") for name in WORKER)


@cache
def _styles() -> str:
    return "\n".join(_text(f"{name}.css") for name in STYLES)


def _text(name: str) -> str:
    return template_text("workbench.report", f"live/{name}")
