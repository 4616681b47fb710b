"""The outputs of the notebooks: each is run once when the site is built, and its first picture is its thumbnail."""

from __future__ import annotations

import base64
import json
import os
import re
import tempfile
from collections.abc import Iterator
from typing import Any, NamedTuple
from unittest.mock import patch

from docs.walk_notebooks import DOWNLOADS, FOLDER, NOTEBOOKS, ROOT

LONGEST = 300  # s of a cell
THUMBNAILS = "thumbnails"


class Entry(NamedTuple):
    """A notebook of the gallery: its title, a line, a picture, its page on the site, and its file; paths below ROOT."""

    title: str
    line: str
    thumbnail: str
    page: str
    file: str


def write() -> list[Entry]:
    """Run all notebooks and write them: the pages, the files for those who download them, and the thumbnails."""
    for folder in (FOLDER, FOLDER / DOWNLOADS, FOLDER / THUMBNAILS):
        folder.mkdir(parents=True, exist_ok=True)
    entries = []
    for notebook in NOTEBOOKS:
        document = run(notebook.document())
        page = notebook.document(download=True)
        page["cells"] = [*page["cells"][:1], *document["cells"][1:]]  # the first has the link to the file
        places = [FOLDER / f"{notebook.name}.ipynb", FOLDER / DOWNLOADS / f"{notebook.name}.ipynb"]
        for place, content in zip(places, (page, document), strict=True):
            place.write_text(f"{json.dumps(content, indent=1, ensure_ascii=False)}\n", encoding="utf-8")
        ending, picture = next(pictures(document))
        thumbnail = FOLDER / THUMBNAILS / f"{notebook.name}.{ending}"
        thumbnail.write_bytes(picture)
        paths = [path.relative_to(ROOT).as_posix() for path in (thumbnail, places[1])]
        line = notebook.about.replace("`", "")  # a card has plain text
        entries.append(Entry(notebook.title, line, paths[0], f"notebooks/{notebook.name}", paths[1]))
    return entries


def run(document: dict[str, Any]) -> dict[str, Any]:
    """The notebook with the outputs of its cells, run in an empty folder; an error in a cell is raised."""
    import nbformat  # both come with myst-nb, in the extra `docs`
    from nbclient import NotebookClient

    notebook = nbformat.from_dict(document)
    paths = filter(None, (str(ROOT), os.environ.get("PYTHONPATH")))  # a cell imports this workbench
    with tempfile.TemporaryDirectory() as folder, patch.dict(os.environ, PYTHONPATH=os.pathsep.join(paths)):
        resources = {"metadata": {"path": folder}}
        NotebookClient(notebook, timeout=LONGEST, record_timing=False, resources=resources).execute()
    return dict(json.loads(nbformat.writes(notebook)))


def pictures(document: dict[str, Any]) -> Iterator[tuple[str, bytes]]:
    """The ending and the content of each picture among the outputs."""
    for cell in document["cells"]:
        for output in cell.get("outputs", ()):
            data = {kind: "".join(text) for kind, text in output.get("data", {}).items() if kind != "application/json"}
            if "image/png" in data:
                yield "png", base64.b64decode(data["image/png"])
            elif found := re.search(r"<svg.*?</svg>", data.get("text/html", ""), re.S):
                yield "svg", found[0].encode()
