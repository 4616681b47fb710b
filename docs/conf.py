"""The site of the workbench: Sphinx reads the docstrings as numpydoc has them, and nothing comes from a network."""

import html
import re
import shutil
import sys
from pathlib import Path
from typing import Any

import workbench

DOCS = Path(__file__).parent
ROOT = DOCS.parent
LIVE = DOCS / "_static" / "loops"  # the live pages, each with its first picture beside it

project = "control-workbench"
author = "The control-workbench authors"
release = workbench.__version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.autosummary", "numpydoc"]
exclude_patterns = ["_site", "_templates"]
templates_path = ["_templates"]
html_theme = "furo"
html_title = project
html_static_path = ["_static"]
html_css_files = ["site.css"]
highlight_language = "none"  # an indented block is an equation; examples and files name their language
default_role = "code"
html_show_sphinx = False
html_show_copyright = False
autosummary_generate = True
autodoc_member_order = "bysource"
autodoc_typehints = "none"  # numpydoc's `Parameters` say shapes and units; the signature has the types
numpydoc_show_class_members = False


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


def first_picture(report: Path) -> Path | None:
    """The figure that stands first on a report's page."""
    page = (report / "index.html").read_text(encoding="utf-8")
    for stem in re.findall(r'id="(?:fig-)?([\w-]+)"', page):
        if (picture := report / "figures" / f"{stem}.svg").is_file():
            return picture
    return min((report / "figures").glob("*.svg"), default=None)


def gallery() -> str:
    """A page of all studies: the title and the question of each, and its first picture."""
    parts = ["# Gallery\n", "Each picture is the first of its report; `make reports` makes all of them again.\n"]
    pictures = DOCS / "_pictures"
    shutil.rmtree(pictures, ignore_errors=True)
    pictures.mkdir()
    for report in sorted(path.parent for path in (ROOT / "reports").glob("*/index.html")):
        page = (report / "index.html").read_text(encoding="utf-8")
        title = html.unescape(re.search(r"<title>(.*?)</title>", page, re.S)[1]).strip()
        parts.append(f"## {title}\n\n`workbench run studies/{report.name.removeprefix('p0_')}`\n")
        if picture := first_picture(report):
            shutil.copy(picture, pictures / f"{report.name}.svg")
            parts.append(f"![{title}](_pictures/{report.name}.svg)\n")
    return "\n".join([*parts, live_loops()])


def live_loops() -> str:
    """The part of the gallery whose loops a reader turns: name, law, plant, horizon and picture, all with the page."""
    sys.path.insert(0, str(ROOT))
    from docs import loops

    shutil.rmtree(LIVE, ignore_errors=True)
    LIVE.mkdir(parents=True)
    parts = [
        "## Loops to be turned\n",
        "Each picture leads to a page of one file, 0.3 MB, that runs its loop in your browser at numbers you turn. "
        "[How to read such pages, and to make your own](howto/live_pages.md).\n",
    ]
    for title, shown in (
        ("Laws for the arm of the paper", loops.of_arms()),
        ("LQG and PID of each plant", loops.of_plants()),
    ):
        cards = "".join(card(name, one) for name, one in shown.items())
        parts.append(f'### {title}\n\n<div class="loops">{cards}</div>\n')
    return "\n".join(parts)


def card(name: str, shown: Any) -> str:
    """Write the live page of a loop and its picture; the two as a link."""
    page = workbench.live(shown.loop, shown.until, shown.h, title=name)
    stem = re.sub(r"\W+", "-", name.replace("−", " minus").replace("+", " plus ")).strip("-").lower()
    page.write(LIVE / f"{stem}.html")
    (LIVE / f"{stem}.svg").write_text(drawn(page.text), encoding="utf-8")
    words, place = html.escape(f"{name}, {shown.until:g} s"), f"_static/loops/{stem}"
    return f'<a href="{place}.html"><img src="{place}.svg" alt="" loading="lazy">{words}</a>'


def drawn(page: str) -> str:
    """The first figure of a page, as a file of its own."""
    found = re.search(r'<figure[^>]*class="drawing".*?(<svg.*?</svg>)', page, re.S)
    assert found, "a page of a loop draws its signals"
    return found[1]


def reference() -> str:
    """A page of all names of `wb`, room by room."""
    rooms: dict[str, list[str]] = {}
    for name, room in workbench._HOMES.items():
        rooms.setdefault(room, []).append(name)
    rooms["testing"] = [f"testing.{name}" for name in workbench.testing.__all__]
    parts = [
        "# Reference\n",
        "All names of `import workbench as wb`, each with its shapes, its units and an example that is run.\n",
    ]
    for room, names in rooms.items():
        lines = "\n".join(f"   workbench.{name}" for name in sorted(names, key=str.lower))
        parts.append(f"## {room}\n\n```{{eval-rst}}\n.. autosummary::\n   :toctree: _reference\n\n{lines}\n```\n")
    return "\n".join(parts)


(DOCS / "gallery.md").write_text(gallery(), encoding="utf-8")
(DOCS / "reference.md").write_text(reference(), encoding="utf-8")
