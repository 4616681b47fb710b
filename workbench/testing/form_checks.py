"""The forms of a law for other machines, each held against the bits of its loop."""

from __future__ import annotations

import shutil
from functools import lru_cache
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from tempfile import TemporaryDirectory
from types import ModuleType

import numpy as np

from workbench.core import Layout, SampledLaw, SampledSystem
from workbench.core.validation.refusals import Array
from workbench.engine import simulate
from workbench.engine.arithmetic import CASADI
from workbench.handover.c99.c_files import c_code
from workbench.handover.law_export import FORMS, export
from workbench.handover.memory_digest import Reals
from workbench.handover.programs.python_law import python_law
from workbench.handover.recording import Recording, record
from workbench.handover.targets import AbstractTarget
from workbench.handover.targets.external_programs import TargetError, missing_programs
from workbench.handover.targets.harness import TargetAnswers
from workbench.testing.failure_sentences import LONGEST, fail, no_refusal, skip

PERIODS = 40
INSTANTS = 20  # at which a function is held against another
LIMIT = 120.0  # s that a compiler or a program may take
NAME = "law"
LINEAR = ("control", "mat")  # forms of linear laws alone
TEXTS = ("c", "cortex-m4", "python", "casadi", "simulink", "ros2")
SPELL = "write it with operations that every machine has, or declare `exportable = False` in its class"


@lru_cache(maxsize=2)  # of a loop that several tests are given
def recording_of(name: str, system: SampledSystem, truths: tuple[str, ...]) -> Recording:
    """A short run of a loop in a computer, as its law sees it."""
    with no_refusal(name, "run in a computer", "return a loop that runs in `loop`"):
        return record(system, system.law(truths=truths), PERIODS, seed=1)


def demand_finite_run(name: str, system: SampledSystem) -> None:
    """Fail where a run in a computer is lost, in the arithmetic of CasADi."""
    with no_refusal(name, "run in a computer", "return a loop that runs in `loop`"):
        run = simulate(system.step(1), until=PERIODS * system.period, arithmetic=CASADI)
    if run.has_diverged.any():
        fail(name, "run in a computer", "a number of its loop is not finite", "return a loop that runs in `loop`")


def find_compiler() -> str:
    """The name of a C compiler of this machine; the test is skipped if there is none."""
    found = next((compiler for compiler in ("gcc", "clang") if shutil.which(compiler)), "")
    return found or skip("no C compiler is here: install gcc or clang")


def demand_target(name: str, target: AbstractTarget, recording: Recording) -> None:
    """Fail where a machine gives other commands, or leaves different states, than the loop did."""
    if lacks := missing_programs(target.programs):
        skip(lacks)
    with no_refusal(name, f"run on the target '{target.name}'", SPELL):
        code = c_code(recording.law, NAME)
    with TemporaryDirectory(prefix="workbench-") as folder:
        try:
            answers = target.answers(code, recording, Path(folder), LIMIT)
        except TargetError as error:
            fail(name, f"run on the target '{target.name}'", f"it said '{error}'", SPELL)
    if difference := first_difference(answers, recording):
        fail(
            name,
            f"give the bits of its loop on the target '{target.name}'",
            difference,
            "report it as a bug",
        )


def first_difference(answers: TargetAnswers, recording: Recording) -> str:
    """The first difference of a machine's answers in words, or an empty text if there is none."""
    if answers.flags.any():
        return f"at instant {int(np.argmax(answers.flags != 0))} it raises a flag"
    other = differing_bits(answers.u, recording.u)
    if other.any():
        k, i = np.argwhere(other)[0]
        label = recording.law.commands.labels[i]
        return f"at instant {k} '{label}' is {float(answers.u[k, i])!r} and not {float(recording.u[k, i])!r}"
    if answers.digests is not None and (answers.digests != recording.digests).any():
        return f"instant {int(np.argmax(answers.digests != recording.digests))} leaves different states"
    return ""


def differing_bits(one: Reals, other: Reals) -> Array:
    """True where two arrays differ in a bit; a NaN is like any other."""
    first, second = (np.ascontiguousarray(part, dtype=float).view(np.uint64) for part in (one, other))
    return np.asarray((first != second) & ~(np.isnan(one) & np.isnan(other)))


def demand_python(name: str, recording: Recording) -> None:
    """Fail where the module of Python gives other commands or another memory than the loop did."""
    law = recording.law
    with no_refusal(name, "be written as a module of Python", SPELL):
        text = python_law(law, NAME)
    commands, memory = run_module(text, law, recording)
    other = np.concatenate(
        [differing_bits(commands, recording.u), differing_bits(memory, recording.memory(0, recording.periods)[1:])],
        axis=1,
    )
    if other.any():
        came = f"its commands or its memory differ from instant {int(np.argwhere(other)[0][0])} on"
        fail(name, "give the bits of its loop in Python", came, SPELL)


def run_module(text: str, law: SampledLaw, recording: Recording) -> tuple[Array, Array]:
    """Commands and memory of an exported module of Python, handed what the law of the loop was."""
    machine, commands, memory = module_of_text(text).Law(), [], []
    for y, r in zip(recording.y, recording.r, strict=True):
        commands.append(_flat(law.commands, machine.step(_by_name(law.readings, y), _by_name(law.references, r))))
        memory.append(_flat(law.memory, machine.memory))
    return np.array(commands).reshape(len(commands), -1), np.array(memory).reshape(len(memory), -1)


def module_of_text(text: str) -> ModuleType:
    """The module of an exported text of Python."""
    with TemporaryDirectory(prefix="workbench-") as folder:
        file = Path(folder) / f"{NAME}.py"
        file.write_text(text, encoding="utf-8")
        spec = spec_from_file_location("exported_law", file)
        assert spec is not None
        assert spec.loader is not None
        module = module_from_spec(spec)
        spec.loader.exec_module(module)
    return module


def _by_name(port: Layout, row: Array) -> dict[str, float | list[float]]:
    parts = {entry: row[port.slice(entry.name)] for entry in port.entries}
    return {entry.name: part.tolist() if entry.shape else float(part[0]) for entry, part in parts.items()}


def _flat(port: Layout, values: dict[str, float | list[float]]) -> Array:
    return np.concatenate([np.zeros(0), *(np.atleast_1d(values[name]) for name in port.names)])


def demand_forms(name: str, law: SampledLaw) -> None:
    """Fail where a law is not written in a form of text; a form for linear laws may refuse it."""
    with TemporaryDirectory(prefix="workbench-") as folder:
        for form in (*TEXTS, *LINEAR):
            place = Path(folder) / form
            try:
                files = export(law, form, place, name=NAME)
            except (ValueError, LookupError) as error:
                if form in LINEAR:
                    continue
                fail(name, f"be exported in the form '{form}'", f"the export said '{error}'", SPELL)
            if not files or not all(file.stat().st_size for file in files):
                fail(name, f"be exported in the form '{form}'", "a file of it is empty", SPELL)
            if form == "casadi":
                _demand_function(name, law, files[0])


def _demand_function(name: str, law: SampledLaw, file: Path) -> None:
    """Fail where the exported function of CasADi gives other numbers than the law."""
    module, rng = module_of_text(file.read_text(encoding="utf-8")), np.random.default_rng(7)
    for k in range(INSTANTS):
        z, y, r = (rng.normal(size=port.size) for port in (law.memory, law.readings, law.references))
        ours, theirs = (function(k, z, y, r, law.parameters.default) for function in (law.F, module.law))
        for one, other in zip(ours, theirs, strict=True):
            if not np.allclose(np.array(one), np.array(other), rtol=1e-13, atol=1e-13, equal_nan=True):
                fail(name, "be the same function in CasADi", "the exported one gives other numbers", SPELL)


def demand_refused_forms(name: str, law: SampledLaw) -> None:
    """Fail where a law that is declared not to be exportable is exported, or refused in other words than a sentence."""
    remedy = "take `exportable = False` out of its class"
    with TemporaryDirectory(prefix="workbench-") as folder:
        for form in sorted(set(FORMS) - {*LINEAR, "casadi"}):  # CasADi has what calls CasADi
            try:
                export(law, form, Path(folder) / form, name=NAME)
            except ValueError as error:
                if not str(error).isprintable() or len(str(error)) > LONGEST:
                    fail(name, "be refused in one sentence", f"the export said '{error}'", remedy)
                continue
            fail(name, "be refused by each export, as `exportable = False` says", f"'{form}' was written", remedy)
