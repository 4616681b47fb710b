"""A report as a folder that is there whole or not at all; beside a ledger, as files that are replaced one by one."""

from __future__ import annotations

import os
import re
import secrets
import shutil
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from workbench.report import pdf
from workbench.report.figures import drawn
from workbench.report.page import GENERATOR, html
from workbench.report.tables import to_csv, to_latex
from workbench.study.document import Document
from workbench.study.durable import sync_folder
from workbench.study.store import FOLDER

_OURS = re.compile(
    r"index\.html|report\.pdf|tables|figures|runs|tables/[a-z0-9_]+\.(csv|tex)|figures/[a-z0-9_]+\.(svg|csv)|"
    rf"runs/[a-z0-9_]+\.(csv|parquet|mat)(\.part)?|({FOLDER}|\.partial-[0-9a-f]{{8}})(/.*)?"
)


class ReportError(ValueError):
    """A report that could not be written; what stood in its place still stands there."""


def write(document: Document, folder: Path | str, beside: Mapping[str, bytes] | None = None) -> Path:
    """Write `index.html`, `report.pdf`, `tables/*.csv`, `tables/*.tex`, `figures/*.svg`; return the folder.

    A figure that has its `numbers` gets a `figures/*.csv` too.

    Everything is made first, in memory, then written to a hidden folder beside the target, and put
    in its place by a rename. An earlier report there is replaced whole. A ledger there is not moved: the
    hidden folder is then within the target, and its files and folders replace those of the earlier report
    one by one, `index.html` last.

    Parameters
    ----------
    beside
        Further files of the report, by their paths below the folder.

    Raises
    ------
    ReportError
        If the target holds anything but an earlier report, or if it cannot be written: the disk is
        full, or the place is not ours to write. Nothing half-written is left behind.
    """
    target = Path(folder).resolve()
    try:
        check_free(target)
        contents = _contents(document) | dict(beside or {})
        target.parent.mkdir(parents=True, exist_ok=True)
        (_replace_within if (target / FOLDER).is_dir() else _replace)(target, contents)
    except OSError as error:
        raise ReportError(
            f"`write(document, '{folder}')` could not write the report: {error.strerror or error}"
            f"{f' ({error.filename})' if error.filename else ''}. Nothing was changed there. Make room, or "
            "name a folder that you may write."
        ) from error
    return target


def _contents(document: Document) -> dict[str, bytes]:
    """Every file of a report by its path below the folder."""
    drawings = drawn(document)
    with ThreadPoolExecutor(1) as beside:  # typst lets go of the interpreter's lock; what it reads is made before
        printed = beside.submit(pdf.printed, pdf.data(document, drawings))
        texts = {"index.html": html(document, drawings)}
        texts |= {f"figures/{name}.svg": drawing for name, drawing in drawings.items()}
        for figure in document.figures:
            if figure.numbers is not None:
                texts[f"figures/{figure.name}.csv"] = to_csv(figure.numbers)
        for table in document.tables:
            texts[f"tables/{table.name}.csv"] = to_csv(table)
            texts[f"tables/{table.name}.tex"] = to_latex(table)
        return {path: text.encode("utf-8") for path, text in texts.items()} | {"report.pdf": printed.result()}


def check_free(target: Path) -> None:
    """Refuse, before anything long is begun, a target that holds what `write` did not put there."""
    if not target.exists():
        return
    if not target.is_dir():
        raise ReportError(f"`write(document, '{target}')` needs a folder; there is a file of that name.")
    found = sorted(path.relative_to(target).as_posix() for path in target.rglob("*"))
    foreign = [path for path in found if not _OURS.fullmatch(path)]
    if found and (foreign or not (_is_report(target) or (target / FOLDER).is_dir())):
        held = f"'{foreign[0]}'" if foreign else "files"
        raise ReportError(
            f"`write(document, '{target}')` replaces only a report that it wrote itself; that folder holds {held} "
            "from elsewhere, which would be lost. Name a new folder, or move what is there."
        )


def check_place(target: Path) -> None:
    """Refuse a place where no folder can be made, by making one beside the target, and taking it away at once."""
    probe = target.with_name(f".{target.name}.partial-{secrets.token_hex(4)}")
    made: list[Path] = []
    try:
        for folder in [path for path in (*reversed(probe.parents), probe) if not path.exists()]:
            folder.mkdir()
            made.append(folder)
    except OSError as error:
        raise ReportError(
            f"The report cannot go to '{target}': {error.strerror or error}. Name a folder that you may write."
        ) from error
    finally:
        for folder in reversed(made):
            folder.rmdir()


def _is_report(target: Path) -> bool:
    page = target / "index.html"
    if not page.is_file():
        return False
    with page.open("rb") as file:
        return f'<meta name="generator" content="{GENERATOR} '.encode() in file.read(2000)


def _replace(target: Path, contents: Mapping[str, bytes]) -> None:
    """Write all files beside the target, then let two renames put them in its place."""
    mark = secrets.token_hex(4)
    partial = target.with_name(f".{target.name}.partial-{mark}")
    former = target.with_name(f".{target.name}.former-{mark}")
    try:
        _write_all(partial, contents)
        if target.exists():
            target.rename(former)
        partial.rename(target)
    except BaseException:
        if former.exists() and not target.exists():
            former.rename(target)
        shutil.rmtree(partial, ignore_errors=True)
        raise
    shutil.rmtree(former, ignore_errors=True)
    sync_folder(target.parent)


def _replace_within(target: Path, contents: Mapping[str, bytes]) -> None:
    """Write all files to a hidden folder within the target, then put each part of the report in the place of the old.

    What a run that was killed has left hidden goes too: whoever writes beside a ledger holds its lock.
    """
    for left in target.glob(".partial-*"):
        shutil.rmtree(left, ignore_errors=True)
    partial = target / f".partial-{secrets.token_hex(4)}"
    try:
        _write_all(partial / "new", contents)
        (partial / "old").mkdir()
        for part in ("figures", "runs", "tables", "report.pdf", "index.html"):
            if (target / part).is_dir():
                (target / part).rename(partial / "old" / part)
            if (partial / "new" / part).exists():
                (partial / "new" / part).replace(target / part)
        sync_folder(target)
    finally:
        shutil.rmtree(partial, ignore_errors=True)


def _write_all(folder: Path, contents: Mapping[str, bytes]) -> None:
    for path, content in contents.items():
        file = folder / path
        file.parent.mkdir(parents=True, exist_ok=True)
        with file.open("wb") as out:
            out.write(content)
            out.flush()
            os.fsync(out.fileno())
    for inner in [path for path in folder.rglob("*") if path.is_dir()]:
        sync_folder(inner)
    sync_folder(folder)
