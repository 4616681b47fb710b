"""The reference: a page of all names of `wb` by what a reader wants to do, and a page for each name."""

import html
import inspect
import re
import shutil
from pathlib import Path
from types import ModuleType

from pygments import highlight
from pygments.formatters import HtmlFormatter
from pygments.lexers import PythonConsoleLexer

import workbench as wb
from docs.reference_groups import GROUPS, Group
from docs.reference_pictures import drawings

DOCS = Path(__file__).parent
PAGES, PICTURES = DOCS / "_reference", DOCS / "_static" / "names"
HEADING = re.compile(r"\n\w[\w ]*\n-{3,}\n")  # of a section of a docstring
NOT_DOCUMENTED = {"Array": "`numpy.typing.NDArray[numpy.float64]`: an array of doubles of any shape."}


def reference() -> str:
    """Write the page of each name, and the pictures; the text of the page of all names."""
    for folder in (PAGES, PICTURES):
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
    pictures = {}
    for name, drawn in drawings().items():
        pictures[name] = f"{name}.svg" if isinstance(drawn, str) else f"{name}.png"
        (PICTURES / pictures[name]).write_bytes(drawn.encode() if isinstance(drawn, str) else drawn)
    ways = " · ".join(f'<a href="#{anchor(group)}">{html.escape(group.title)}</a>' for group in GROUPS)
    parts = [
        "# Reference\n",
        "All names of `import workbench as wb`, by what you want to do. "
        "Each leads to its page, with shapes, units and errors.\n",
        f'<p class="ways">{ways}</p>\n',
    ]
    for group in GROUPS:
        entries = "".join(entry(name, line, pictures.get(name)) for name, line in group.names.items())
        parts += [f"## {group.title}\n", f"{group.line}\n", f'<div class="names">{entries}</div>\n']
        for name in group.names:
            write_page(name, group, pictures.get(name))
    return "\n".join(parts)


def anchor(group: Group) -> str:
    """The id that Sphinx gives to the heading of a group."""
    return re.sub(r"[^a-z0-9]+", "-", group.title.lower()).strip("-")


def entry(name: str, line: str, picture: str | None) -> str:
    """A name with its purpose, what it draws, and its example to unfold."""
    page = f"_reference/workbench.{name}.html"
    code = example(name)
    shown = f'<a href="{page}"><img src="_static/names/{picture}" alt="" loading="lazy"></a>' if picture else ""
    unfolded = f"<details><summary>Example</summary>{code}</details>" if code else ""
    return (
        f'<div class="name"><a class="of" href="{page}"><code>{html.escape(name)}</code></a>'
        f"<div><p>{in_html(line)}</p>{unfolded}</div>{shown}</div>"
    )


def example(name: str) -> str:
    """The example of a name's docstring, coloured; nothing for a room."""
    held = getattr(wb, name)
    text = "" if isinstance(held, ModuleType) or name in NOT_DOCUMENTED else inspect.getdoc(held) or ""
    _, _, after = text.partition("\nExamples\n--------\n")
    lines = HEADING.split(after)[0].strip()
    if not lines:
        return ""
    formatted = highlight(lines, PythonConsoleLexer(), HtmlFormatter(nowrap=True))
    unbroken = formatted.replace("\n\n", "\n<span></span>\n")  # a blank line would end the block of HTML
    return f'<div class="highlight"><pre>{unbroken}</pre></div>'


def in_html(line: str) -> str:
    """A line with its code marked."""
    return re.sub("`(.*?)`", r"<code>\1</code>", html.escape(line))


def write_page(name: str, group: Group, picture: str | None) -> None:
    """The page of a name: its docstring, or the names of a room, and the way to its neighbours."""
    held = getattr(wb, name)
    title, line = f"wb.{name}", group.names[name]
    links = " · ".join(
        f'<a href="workbench.{other}.html">{other}</a>' if other != name else f"<b>{other}</b>" for other in group.names
    )
    above = f'<a href="../reference.html">Reference</a> › <a href="../reference.html#{anchor(group)}">{group.title}</a>'
    ways = f'<p class="ways">{above}</p>', f'<p class="ways">{links}</p>'
    if name in NOT_DOCUMENTED or isinstance(held, ModuleType):
        text = NOT_DOCUMENTED.get(name) or room_text(held)
        page = f"---\norphan: true\n---\n# {title}\n\n{ways[0]}\n\n{line}\n\n{text}\n\n{ways[1]}\n"
        (PAGES / f"workbench.{name}.md").write_text(page, encoding="utf-8")
        return
    kind = "class" if inspect.isclass(held) else "function"
    shown = f".. image:: ../_static/names/{picture}\n   :alt:\n   :class: drawing\n\n" if picture else ""
    raw = [f".. raw:: html\n\n   {way}\n\n" for way in ways]
    page = (
        f":orphan:\n\n{title}\n{'=' * len(title)}\n\n{raw[0]}{line}\n\n{shown}"
        f".. currentmodule:: workbench\n\n.. auto{kind}:: {name}\n\n{raw[1]}"
    )
    (PAGES / f"workbench.{name}.rst").write_text(page, encoding="utf-8")


def room_text(room: ModuleType) -> str:
    """The names of a room, each with the first sentence of its docstring."""
    rows = []
    for name in sorted(getattr(room, "__all__", ()), key=str.lower):
        held = getattr(room, name)
        ours = getattr(held, "__module__", "").startswith("workbench")
        if callable(held) and ours and (text := inspect.getdoc(held)):
            first = " ".join(text.split("\n\n")[0].split()).rstrip(":,")
            rows.append(f"<tr><td><code>{name}</code></td><td>{in_html(first)}</td></tr>")
    return f'`{room.__name__}`\n\n<table class="room">{"".join(rows)}</table>'
