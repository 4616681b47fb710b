"""A report as a folder whose page and PDF are replaced in one move, so that neither is ever half written."""

from __future__ import annotations

import os
import re
import secrets
import shutil
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path

from workbench.report import pdf
from workbench.report.figures import numbers_of, sheets
from workbench.report.findings_json import findings_json
from workbench.report.html_page import GENERATOR, html
from workbench.report.live.page_data import LiveData
from workbench.report.table_text import to_csv, to_latex
from workbench.study.document.document import Document
from workbench.study.ledger.durability import sync, sync_folder
from workbench.study.ledger.ownership import FOLDER, stranger_in

PARTS = ("figures", "runs", "tables")
_OURS = re.compile(
    r"index\.html|report\.pdf|findings\.json|tables/[a-z0-9_]+\.(csv|tex)|figures/[a-z0-9_]+\.(svg|csv)|"
    rf"runs/[a-z0-9_]+\.(csv|parquet|mat|json)(\.part)?|{'|'.join(PARTS)}|{FOLDER}|\.partial-[0-9a-f]{{8}}"
)


class ReportError(ValueError):
    """The error of a report that could not be written; an earlier report is left unchanged."""


def write(
    document: Document,
    folder: Path | str,
    beside: Mapping[str, bytes] | None = None,
    live: LiveData | None = None,
) -> Path:
    """Write `index.html`, `report.pdf`, `findings.json`, and the files of tables and figures; return the folder.

    These are `tables/*.csv`, `tables/*.tex` and `figures/*.svg`.

    A figure that has its `numbers`, or curves, bars or points, gets a `figures/*.csv` too; `beside` are further files
    by their paths, and `live` are the data with which the page is live.

    All is written to a hidden folder within the target, from where each file takes the place of the earlier one by a
    rename, `index.html` last; so at every moment each file is whole. If a step fails, all earlier files come back. If
    the process is killed among the renames, files of both reports stand side by side until the next report. A ledger
    there is not touched.

    Raises
    ------
    ReportError
        If the target holds anything but an earlier report, or cannot be written; nothing half-written is left behind.
    """
    target = Path(os.path.realpath(folder))
    try:
        _earlier(target)
        contents = _contents(document, live) | dict(beside or {})
        _replace(target, contents)
    except OSError as error:
        raise ReportError(
            f"`write(document, '{folder}')` could not write the report: {error.strerror or error}"
            f"{f' ({error.filename})' if error.filename else ''}. Nothing was changed there. Make room, or "
            "name a folder that you may write."
        ) from error
    return target


def _contents(document: Document, live: LiveData | None) -> dict[str, bytes]:
    """Every file of a report by its path below the folder."""
    drawn = sheets(document)
    pictures = {name: sheet.svg for name, sheet in drawn.items()}
    with ThreadPoolExecutor(1) as beside:  # typst lets go of the interpreter's lock; what it reads is made before
        printed = beside.submit(pdf.compile_pdf, pdf.data(document, pictures))
        texts = {"index.html": html(document, drawn, live)}
        texts |= {f"figures/{name}.svg": drawing for name, drawing in pictures.items()}
        texts |= {f"figures/{name}.csv": numbers for name, numbers in numbers_of(document).items()}
        for table in document.tables:
            texts[f"tables/{table.name}.csv"] = to_csv(table)
            texts[f"tables/{table.name}.tex"] = to_latex(table)
        if document.answer or document.findings:
            texts["findings.json"] = findings_json(document)
        return {path: text.encode("utf-8") for path, text in texts.items()} | {"report.pdf": printed.result()}


def check_place(folder: Path) -> None:
    """Refuse a place that `write` would refuse, or where no folder can be made, by making one for a moment.

    Raises
    ------
    ReportError
        As `write`.
    """
    target = Path(os.path.realpath(folder))
    made: list[Path] = []
    try:
        _earlier(target)
        for path in (*reversed(target.parents), target, target / f".partial-{secrets.token_hex(4)}"):
            if not path.exists():
                path.mkdir()
                made.append(path)
    except OSError as error:
        raise ReportError(
            f"The report cannot go to '{folder}': {error.strerror or error}. Name a folder that you may write."
        ) from error
    finally:
        for path in reversed(made):
            with suppress(OSError):  # another run may have begun to write there
                path.rmdir()


def _earlier(target: Path) -> list[str]:
    """The files of the report in a folder; a file that `write` did not put there is refused."""
    if target.exists() and not target.is_dir():
        raise ReportError(f"`write(document, '{target}')` needs a folder; there is a file of that name.")
    held: list[str] = []
    runs_here = (target / FOLDER).is_dir() and stranger_in(target / FOLDER) is None
    for folder in (target, *(target / name for name in PARTS)):
        for path in folder.iterdir() if folder.is_dir() else ():
            name = path.relative_to(target).as_posix()
            damaged = name == "index.html" and not (_is_report(path) or runs_here)
            if path.is_symlink() or damaged or not _OURS.fullmatch(name):
                raise _foreign(target, name)
            held.append(name)
    # without a page it is ours if a run is on its way there, or was killed
    others = [name for name in held if name != FOLDER]
    if others and not (runs_here or any(name == "index.html" or name.startswith(".") for name in others)):
        raise _foreign(target, others[0])
    return [name for name in held if (target / name).is_file()]


def _foreign(target: Path, name: str) -> ReportError:
    return ReportError(
        f"`write(document, '{target}')` replaces only a report that it wrote itself; that folder holds '{name}' "
        "from elsewhere, which would be lost. Name a new folder, or move what is there."
    )


def _is_report(page: Path) -> bool:
    if not page.is_file():
        return False
    with page.open("rb") as file:
        return f'<meta name="generator" content="{GENERATOR} '.encode() in file.read(2000)


def _replace(target: Path, contents: Mapping[str, bytes]) -> None:
    """Write all files to hidden names within the target, and rename them over the earlier ones."""
    partial = target / f".partial-{secrets.token_hex(4)}"
    before, after = _earlier(target), sorted(contents, key=lambda name: ("/" not in name, name == "index.html"))
    was_there = target.exists()
    try:
        for name in after:
            _write_through(partial / "new" / name, contents[name])
        for name in before:
            _spare(target / name, partial / "old" / name)
        _switch(target, partial, before, after)
    finally:
        for folder in PARTS:
            with suppress(OSError):  # it is not empty, or not there
                (target / folder).rmdir()
        for left in target.glob(".partial-*"):
            shutil.rmtree(left, ignore_errors=True)
        if not was_there:
            with suppress(OSError):  # the report stands there
                target.rmdir()


def _switch(target: Path, partial: Path, before: Sequence[str], after: Sequence[str]) -> None:
    """Rename the new files into their places one by one, and remove the others; if a step fails, put all back."""
    try:
        for name in after:
            (target / name).parent.mkdir(exist_ok=True)
            os.replace(partial / "new" / name, target / name)
        for name in set(before).difference(after):
            (target / name).unlink()
        for folder in {(target / name).parent for name in after}:
            sync_folder(folder)
    except BaseException:
        for name in {*before, *after}:
            with suppress(OSError):  # the step that failed, and those behind it, have changed nothing
                os.replace(partial / "old" / name, target / name) if name in before else (target / name).unlink()
        raise


def _write_through(file: Path, content: bytes) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    with file.open("wb") as out:
        out.write(content)
        out.flush()
        sync(out.fileno())


def _spare(file: Path, place: Path) -> None:
    """Give a file a second name, or a copy where the disk has no such names."""
    place.parent.mkdir(parents=True, exist_ok=True)
    try:
        os.link(file, place)
    except OSError:
        shutil.copyfile(file, place)
