"""Graders as modules: found by their functions without being run, loaded under names of their own, left clean."""

from __future__ import annotations

import ast
import contextlib
import importlib.util
import io
import sys
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

FILES = ("grade.py", "harness.py")


@dataclass(frozen=True)
class Grader:
    """A file that grades, by its place below the folder of exams: what functions it defines, or why it is none."""

    file: Path
    name: str
    functions: frozenset[str]
    broken: str = ""


@dataclass(frozen=True)
class Loaded:
    """A grader as a module, the modules of its folder that it imported, and what it has printed so far."""

    module: ModuleType
    modules: tuple[ModuleType, ...]
    printed: io.StringIO


def find(folder: Path) -> list[Grader]:
    """The graders below a folder, in the order of their names."""
    files = sorted(file for name in FILES for file in folder.rglob(name) if file.is_file())
    return [_read(file, folder) for file in files]


def _name(file: Path, folder: Path) -> str:
    place = file.parent.relative_to(folder).as_posix()
    return place if place != "." else folder.resolve().name


def _read(file: Path, folder: Path) -> Grader:
    try:
        tree = ast.parse(file.read_text(encoding="utf-8"))
    except (SyntaxError, ValueError, OSError) as error:  # text that is none, or no Python
        return Grader(file, _name(file, folder), frozenset(), f"{type(error).__name__}: {error}")
    defined = frozenset(node.name for node in tree.body if isinstance(node, ast.FunctionDef))
    return Grader(file, _name(file, folder), defined)


@contextlib.contextmanager
def loaded(grader: Grader) -> Iterator[Loaded]:
    """The grader's module, while its folder is on the path and what it prints is kept; warnings there are no errors."""
    folder, known, path = str(grader.file.parent.resolve()), set(sys.modules), list(sys.path)
    bytecode, sys.dont_write_bytecode = sys.dont_write_bytecode, True
    # a module of the same name from another folder would be taken for the grader's own
    own = {file.stem for file in grader.file.parent.glob("*.py")}
    hidden = {name: sys.modules.pop(name) for name in own & known}
    sys.path.insert(0, folder)
    printed = io.StringIO()
    try:
        with warnings.catch_warnings(), contextlib.redirect_stdout(printed):
            warnings.simplefilter("ignore")
            spec = importlib.util.spec_from_file_location(f"exam:{grader.file}", grader.file)
            assert spec is not None
            assert spec.loader is not None
            module = importlib.util.module_from_spec(spec)
            spec.loader.exec_module(module)
            new = [m for name, m in list(sys.modules.items()) if name in own or name not in known]
            beside = tuple(m for m in new if _below(m, folder))
            yield Loaded(module, (module, *beside), printed)
    finally:
        for name in [name for name, m in sys.modules.items() if name not in known and _below(m, folder)]:
            del sys.modules[name]
        for name in own & set(sys.modules):
            del sys.modules[name]
        sys.modules.update(hidden)
        sys.path[:] = path
        sys.dont_write_bytecode = bytecode


def _below(module: ModuleType | None, folder: str) -> bool:
    file = getattr(module, "__file__", None)
    return isinstance(file, str) and Path(folder) in Path(file).resolve().parents
