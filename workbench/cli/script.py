"""The script of a study: loaded as the user's own program, and named in its report."""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_file_location, spec_from_loader
from pathlib import Path
from shlex import join
from types import ModuleType
from typing import NoReturn

from workbench.core.validation.refusals import describe, nearest
from workbench.core.validation.signatures import check_arguments
from workbench.study.chosen_steps import ChosenSteps, kept_in
from workbench.study.compiled_study import compile_sweeps
from workbench.study.compiled_sweep import CompiledSweep
from workbench.study.executors import ClusterError, Pieces
from workbench.study.ledger.chunk import Chunk
from workbench.study.run_options import ArithmeticOf, Arithmetics, Record
from workbench.study.study import Study
from workbench.study.study_works import compile_works
from workbench.study.tuning import tune
from workbench.study.tuning.search import compile_tuning


def check_file(file: Path) -> None:
    """Refuse a path that is no file, before anything is imported."""
    if file.is_dir():
        raise LookupError(f"'{file}' is a folder without a `study.py`; a study is a Python file. Name the file in it.")
    if not file.is_file():
        beside = [str(other) for other in sorted(file.parent.glob("*.py"))] if file.parent.is_dir() else []
        raise LookupError(f"There is no study file '{file}'.{nearest(str(file), beside)}")


class _AsItStands(SourceFileLoader):
    """A loader that compiles a script each time: Python's cache misses a change of equal size within a second."""

    def path_stats(self, path: str | bytes | os.PathLike[str] | os.PathLike[bytes]) -> NoReturn:
        raise OSError(f"the time of {path!r} is not asked for")


def file_of(study: Path) -> Path:
    """The file of a study that is named by its folder, in which it is `study.py`, or by itself."""
    return study / "study.py" if (study / "study.py").is_file() else study


def module_of(file: Path) -> ModuleType:
    """A script that was run: in a package a module of it, else a program of its own with its folder on the path."""
    package = _package_of(file.resolve().parent)
    loader = _AsItStands(f"{package}.{file.stem}" if package else "__study__", str(file))
    spec = spec_from_loader(loader.name, loader)
    assert spec is not None
    module = module_from_spec(spec)
    beside = "" if package else str(file.parent.resolve())
    sys.path[:0] = [beside] if beside else []
    sys.modules[loader.name] = module
    try:
        loader.exec_module(module)
    except SystemExit as error:
        raise ValueError(f"'{file}' ended by itself, with status {error.code}, before its study was read.") from None
    finally:  # what the workbench imports later is not looked for beside the study
        if beside:
            with suppress(ValueError):
                sys.path.remove(beside)
            sys.path.append(beside)
    return module


@check_arguments
def load(file: Path | str) -> Study:
    r"""The `study` of a file, or of the `study.py` in a folder, which is run for it.

    Raises
    ------
    LookupError
        If there is no such file, or it defines no `study`.
    ValueError
        If that is no `Study`, or the path is none that a file can have.

    Examples
    --------
    >>> lines = 'import workbench as wb\nstudy = wb.Study("mine", "T", "Q?", "M.", sections=lambda results: [])'
    >>> with open("mine.py", "w") as file:
    ...     _ = file.write(lines)
    >>> wb.load("mine.py").name
    'mine'
    """
    file = file_of(Path(file))
    check_file(file)
    study = getattr(module_of(file), "study", None)
    if study is None:
        raise LookupError(f"'{file}' has no study: it must define `study = Study(...)` at its top level.")
    if not isinstance(study, Study):
        raise ValueError(f"`study` in '{file}' must be a `Study`; got {describe(study)}.")
    return study


def _package_of(folder: Path) -> str:
    """The dotted name of the package that a folder is, imported with those above it; '' if it has no `__init__.py`."""
    init = folder / "__init__.py"
    if not init.is_file():
        return ""
    name = f"{_package_of(folder.parent)}.{folder.name}".lstrip(".")
    there = sys.modules.get(name)
    if there is not None and Path(getattr(there, "__file__", None) or "").resolve() == init:
        return name
    if there is not None:
        raise ValueError(f"The package '{name}' in '{folder}' has the name of one that is loaded already; rename it.")
    spec = spec_from_file_location(name, init, submodule_search_locations=[str(folder)])
    assert spec is not None
    assert spec.loader is not None
    sys.modules[name] = package = module_from_spec(spec)
    spec.loader.exec_module(package)
    return name


def short_path(study: Path) -> str:
    """The path of a study with no more of this machine's folders than the user typed."""
    below = study.is_absolute() and study.is_relative_to(Path.cwd())
    return str(study.relative_to(Path.cwd()) if below else study)


def command(study: Path, out: Path | None, samples: int | None = None) -> str:
    """The command that makes this report, with no more of this machine's folders than the user typed."""
    words = ["workbench", "run", short_path(study)]
    words += [] if samples is None else ["--samples", str(samples)]
    return join(words if out is None else [*words, "--out", str(out)])


@dataclass(frozen=True)
class Script:
    """A study's file, at the same place on every worker, with its digest; called, it is loaded and its sweeps compiled.

    Sweeps have arithmetics by their names, and may follow from records of tunings and works: name, head and data of
    each. With `works` it gives those instead.
    """

    file: str
    digest: str
    samples: int | None
    arithmetics: Arithmetics = ()
    records: tuple[Record, ...] = ()
    works: bool = False

    @staticmethod
    def of(
        file: Path,
        samples: int | None = None,
        arithmetics: Arithmetics = (),
        records: tuple[Record, ...] = (),
        works: bool = False,
    ) -> Script:
        """The script as it stands in a file here."""
        return Script(str(file.resolve()), _digest_of(file), samples, arithmetics, records, works)

    def __call__(self) -> Pieces:
        """The sweeps, or the works, in the process of a worker."""
        file = Path(self.file)
        if not file.is_file() or _digest_of(file) != self.digest:
            raise ClusterError(f"A worker finds no '{self.file}', or another one: the study must be where it is here.")
        study, arithmetic_of = load(file), dict(self.arithmetics).get
        chunks = {name: Chunk(name, head, data) for name, head, data in self.records}
        with kept_in(ChosenSteps(chunks.values())):  # no worker chooses again
            return self._pieces(study, chunks, arithmetic_of)

    def _pieces(self, study: Study, chunks: dict[str, Chunk], arithmetic_of: ArithmeticOf) -> Pieces:
        works = compile_works(() if callable(study.works) else study.works)
        if self.works:
            return works
        sweeps = study.sweeps
        if callable(sweeps):

            def replay(sweeps: Sequence[CompiledSweep], first: int, last: int) -> list[Chunk]:
                return [chunks[one.name(first, last)] for one in sweeps]

            try:
                tuned = {one.name: tune(compile_tuning(one, arithmetic_of), replay) for one in study.tunings}
            except KeyError as error:
                raise ClusterError(f"A worker asks in a tuning for {error}, which is not here: it differs.") from None
            try:
                answers = {one.work.name: one.answers(chunks.__getitem__) for one in works}
            except KeyError as error:
                raise ClusterError(f"A worker asks in a work for {error}, which is not here: it differs.") from None
            sweeps = study.resolve({**tuned, **answers}).sweeps
            assert not callable(sweeps)
        return compile_sweeps(sweeps, self.samples, arithmetic_of)


def _digest_of(file: Path) -> str:
    return hashlib.sha256(file.read_bytes()).hexdigest()
