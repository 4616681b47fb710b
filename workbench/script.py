"""The script that `workbench run` is given: found, loaded as the user's own program, and named in its report."""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path
from shlex import join
from typing import NoReturn

from workbench.core.layout import nearest
from workbench.study.study import Study


def check_file(file: Path) -> None:
    """Refuse what is no file, before anything is imported."""
    if file.is_dir():
        raise LookupError(f"'{file}' is a folder; a study is a Python file. Name the file in it.")
    if not file.is_file():
        beside = [str(other) for other in sorted(file.parent.glob("*.py"))] if file.parent.is_dir() else []
        raise LookupError(f"There is no study file '{file}'.{nearest(str(file), beside)}")


class _AsItStands(SourceFileLoader):
    """Compiles a script each time: what Python has kept is taken for it if it has the same second and size."""

    def path_stats(self, path: str | bytes | os.PathLike[str] | os.PathLike[bytes]) -> NoReturn:
        raise OSError(f"the time of {path!r} is not asked for")


def load(file: Path) -> Study:
    """The `study` of a script, which runs as the user's own program with its folder first on the path."""
    loader = _AsItStands("__study__", str(file))
    spec = spec_from_loader(loader.name, loader)
    assert spec is not None
    module = module_from_spec(spec)
    beside = str(file.parent.resolve())
    sys.path.insert(0, beside)
    sys.modules[loader.name] = module
    try:
        loader.exec_module(module)
    except SystemExit as error:
        raise ValueError(f"'{file}' ended by itself, with status {error.code}, before its study was read.") from None
    finally:  # what the workbench imports later is not looked for beside the study
        with suppress(ValueError):
            sys.path.remove(beside)
        sys.path.append(beside)
    study = getattr(module, "study", None)
    if study is None:
        raise LookupError(f"'{file}' has no study: it must define `study = Study(...)` at its top level.")
    if not isinstance(study, Study):
        raise ValueError(f"`study` in '{file}' must be a `Study`; got {type(study).__name__}.")
    return study


def command(study: Path, out: Path | None, samples: int | None = None) -> str:
    """The command that makes this report, with no more of this machine's folders than the user typed."""
    below = study.is_absolute() and study.is_relative_to(Path.cwd())
    words = ["workbench", "run", str(study.relative_to(Path.cwd()) if below else study)]
    words += [] if samples is None else ["--samples", str(samples)]
    return join(words if out is None else [*words, "--out", str(out)])
