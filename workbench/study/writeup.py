"""From a study and its results to the document that the report renders."""

from __future__ import annotations

import platform
from collections.abc import Iterable
from contextlib import nullcontext
from dataclasses import replace
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from workbench import __version__
from workbench.core.equations import answer
from workbench.core.validation.permission import no_runs
from workbench.core.validation.refusals import several
from workbench.engine.arithmetic import signature
from workbench.study.document.document import Colophon, Document, Page, Section
from workbench.study.study import Results, Study

TIMED_PACKAGES = ("control-workbench", "casadi", "control", "jax", "llvmlite", "numba", "numpy", "scipy")
PACKAGES = ("casadi", "control", "numpy", "scipy", "matplotlib", "pandas", "typst")


def document(study: Study, results: Results, command: str) -> Document:
    """The document of a study, with command, versions and digests to make it again."""
    digests = {outcome.case.name: outcome.digest[:16] for outcome in results.outcomes}
    digests |= {sample.name: sample.digest[:16] for sample in results.all_samples}
    runs = (outcome.measurement.trajectories for outcome in results.outcomes)
    arithmetics = {signature(one.arithmetic) for one in runs} | {sample.arithmetic for sample in results.all_samples}
    colophon = Colophon(
        command=command,
        version=__version__,
        fingerprints=study.fingerprints,
        digests=digests,
        seed=_seed(study, results),
        packages={name: version(name) for name in PACKAGES},
        python=platform.python_version(),
        arithmetic=", ".join(sorted(arithmetics)),
    )
    if study.measures_time:
        colophon = replace(colophon, again="The same command measures again: times differ from run to run.")
    page = _page(study, results)
    return Document(
        title=study.title,
        question=" ".join(study.question.split()),
        method=" ".join(study.method.split()),
        sections=page.sections,
        colophon=colophon,
        answer=page.answer,
        findings=page.findings,
    )


def _seed(study: Study, results: Results) -> int | str | None:
    """The seed of the study, or those of its samples and tunings by their names."""
    if study.seed is not None:
        return study.seed
    seeds = {sample.name: str(sample.seeds) for sample in results.samples}
    seeds |= {found.tuning.name: ", ".join(map(str, found.tuning.seeds)) for found in results.tunings}
    if len(set(seeds.values())) < 2:
        return next(iter(seeds.values()), None)
    return "; ".join(f"{seed} of {name}" for name, seed in seeds.items())


def headlines(study: Study, results: Results) -> list[str]:
    """The findings of the study, each on one line."""
    call = "Study(headlines=...)(results)"
    return [" ".join(line.split()) for line in several(call, _called(study, "headlines", results), str)]


def _page(study: Study, results: Results) -> Page:
    """The page of a study, whose function may return its sections alone."""
    given = _called(study, "sections", results)
    if isinstance(given, Page):
        return given
    return Page("", (), several("Study(sections=...)(results)", given, Section))


def _called(study: Study, part: str, results: Results) -> object:
    """The return value of a function of the study for the results; an iterable other than text becomes a tuple.

    Nothing is simulated for it, unless the study measures time.
    """
    call = f"Study({part}=...)(results)"
    with nullcontext() if study.measures_time else no_runs(call):
        given = answer(call, getattr(study, part), results)
        return answer(call, tuple, given) if isinstance(given, Iterable) and not isinstance(given, str) else given


def testbed() -> str:
    """The processor and the versions with which times were measured, in words, and nothing else about the machine."""
    table = Path("/proc/cpuinfo")
    lines = table.read_text().splitlines() if table.exists() else []
    models = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    versions = [f"python {platform.python_version()}"]
    for package in TIMED_PACKAGES:
        try:
            versions.append(f"{package} {version(package)}")
        except PackageNotFoundError:
            continue
    return (
        f"Measured on {next(models, platform.processor() or platform.machine())} with {', '.join(versions)}. These are "
        "times: another run of this study gives other digits, and a machine that others use too gives longer ones."
    )
