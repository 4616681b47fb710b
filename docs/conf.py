"""The site of the workbench: Sphinx reads the docstrings as numpydoc has them, and nothing comes from a network."""

import re
import sys
from pathlib import Path
from typing import Any

import workbench

DOCS = Path(__file__).parent
sys.path.insert(0, str(DOCS.parent))

from docs.gallery_entries import gallery  # noqa: E402
from docs.reference_page import reference  # noqa: E402

project = "control-workbench"
author = "The control-workbench authors"
release = workbench.__version__
extensions = ["myst_nb", "sphinx.ext.autodoc", "numpydoc"]
exclude_patterns = ["_site", "changes", "notebooks/downloads"]
html_theme = "furo"
html_title = project
html_static_path = ["_static"]
html_css_files = ["site.css"]
highlight_language = "none"  # an indented block is an equation; examples and files name their language
default_role = "code"
html_show_sphinx = False
html_show_copyright = False
autosummary_generate = False  # docs/reference_page.py writes the page of each name
autodoc_member_order = "bysource"
autodoc_typehints = "none"  # numpydoc's `Parameters` say shapes and units; the signature has the types
numpydoc_show_class_members = False
nb_execution_mode = "off"  # docs/notebook_outputs.py has run them
myst_heading_anchors = 2  # links between pages may name a heading


def as_literal(app: object, what: str, name: str, obj: object, options: object, lines: list[str]) -> None:
    """Equations, which docstrings indent as a book does, become literal blocks; |e| and d* are no markup."""
    text, literal = [], False
    for line in lines:
        indented = line.startswith("    ") and not line.lstrip().startswith((".. ", ":"))
        if indented and not literal and (not text or not text[-1].strip()):
            text += ["::", ""]
            literal = True
        elif line.strip() and not indented:
            literal = False
        text.append(line if literal else re.sub(r"(?<![`*])([|*])(?![*`])", r"\\\1", line))
    lines[:] = text


def setup(app: Any) -> None:
    """Called by Sphinx; before numpydoc reads the sections."""
    app.connect("autodoc-process-docstring", as_literal, priority=100)


(DOCS / "gallery.md").write_text(gallery(), encoding="utf-8")
(DOCS / "reference.md").write_text(reference(), encoding="utf-8")
