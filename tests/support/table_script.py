"""The script of a page that writes the numbers of its tables."""

from __future__ import annotations

from importlib.resources import files

LIVE = files("workbench.report") / "templates" / "live"
SCRIPT = (LIVE / "tables.js").read_text("utf-8")
