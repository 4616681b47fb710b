"""The citation of a study, a loop or a block: the publications that the docstrings of its blocks name."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

from workbench import __version__
from workbench.core import Ode, SampledSystem
from workbench.core.block import is_block
from workbench.core.equations import is_loop
from workbench.core.publications import Origin, Publication, origins, publications_in, references_section
from workbench.core.validation.notebook_display import HtmlText, table_to_html
from workbench.core.validation.refusals import refusal
from workbench.core.validation.signatures import check_arguments
from workbench.study.bibtex import bibtex_entry, bibtex_keys
from workbench.study.run_and_sweep import Run
from workbench.study.study import Study
from workbench.study.tuning import Tuning

# As CITATION.cff has them; a test holds the two equal.
WORKBENCH = Publication("The control-workbench authors", "", "control-workbench")


class Mention(NamedTuple):
    """A block that names a publication, and the place in it: a chapter, an equation; empty if it names none."""

    block: str
    place: str


@dataclass(frozen=True, eq=False)
@check_arguments
class Citation:
    """The publications behind a study, a loop or a block, as `cite` finds them.

    Attributes
    ----------
    subject
        The thing that is cited, in words.
    publications
        Each publication with the blocks that name it, in the order of authors and years.
    without_reference
        The blocks, metrics and designs whose docstrings have no `References` section.
    remarks
        Sentences on what could not be found out.

    Examples
    --------
    >>> print(wb.cite(wb.CartPole()).bibtex().splitlines()[-2])
      note = {Messner and Tilbury, Control Tutorials for Matlab and Simulink, "Inverted Pendulum: System Modeling"},
    """

    subject: str
    publications: tuple[tuple[Publication, tuple[Mention, ...]], ...]
    without_reference: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()

    def __repr__(self) -> str:
        lines = [f"To cite with {self.subject}:", f"  {_workbench()}"]
        for publication, uses in self.publications:
            lines += [f"  {publication.text}.", *(f"      {_words(use)}" for use in uses)]
        if self.without_reference:
            lines.append(f"Without a reference: {', '.join(self.without_reference)}.")
        return "\n".join([*lines, *self.remarks])

    def _repr_html_(self) -> HtmlText:
        rows = [(_workbench(), "")]
        rows += [(f"{publication.text}.", "; ".join(map(_words, uses))) for publication, uses in self.publications]
        if self.without_reference:
            rows.append(("Without a reference", ", ".join(self.without_reference)))
        rows += [(remark, "") for remark in self.remarks]
        return table_to_html(f"To cite with {self.subject}", ("publication", "named by"), rows)

    def bibtex(self) -> str:
        """The publications as BibTeX, the workbench first, each a `@misc` with the fields that are known.

        Authors and year are fields where the reference has them. Title, journal and volume stand in `note` as the
        docstring has them, since no rule tells where a title ends.
        """
        works = [WORKBENCH, *(publication for publication, _ in self.publications)]
        notes = [f"Version {__version__}", *(work.work for work in works[1:])]
        entries = zip(bibtex_keys(works), works, notes, strict=True)
        return "\n\n".join(bibtex_entry(key, work, note) for key, work, note in entries) + "\n"


@check_arguments
def cite(subject: object) -> Citation:
    """The publications that a study, a loop or a block is built on, to be cited beside the workbench.

    They are named in the `References` sections of docstrings: of the laws, observers, plants and signals in its loops,
    of its metrics, designs and tunings. A study names its own references in the docstring of its module, and a work in
    the docstring of its function. A block without a reference is listed by its name.

    Parameters
    ----------
    subject
        A `Study`, a loop such as a `ClosedLoop`, an `Ode` or a `SampledSystem`, or a block.

    Raises
    ------
    ValueError
        If `subject` is something else.

    Examples
    --------
    >>> motor = wb.DCMotor()
    >>> law = wb.PID(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0)
    >>> citation = wb.cite(wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0)))
    >>> citation.publications[0][0].text, citation.publications[0][1][0].block
    ('Astrom and Hagglund (2006), Advanced PID Control', 'PID')
    >>> citation.without_reference
    ('Step',)
    """
    if isinstance(subject, Study):
        remarks = list(_remarks(subject))
        return _citation(f"the study '{subject.name}'", (*_of_study(subject, remarks),), remarks)
    if is_block(subject) or is_loop(subject):
        remarks = []
        words = (
            f"the loop '{subject.name}'" if isinstance(subject, Ode | SampledSystem) else f"`{type(subject).__name__}`"
        )
        return _citation(words, (*_of_loop(subject, "The loop", remarks),), remarks)
    raise refusal("cite(subject)", "a `Study`, a loop such as a `ClosedLoop`, or a block", subject)


def _citation(subject: str, found: Iterable[Origin], remarks: list[str]) -> Citation:
    """The citation of these origins, in which each publication stands once."""
    merged: dict[tuple[str, str, str], tuple[Publication, dict[Mention, None]]] = {}
    without: dict[str, None] = {}
    for origin in found:
        entries = publications_in(origin.references)
        if not entries:
            without[origin.block] = None
        for publication, place in entries:
            known, uses = merged.get(publication.identity, (publication, {}))
            fullest = max(known, publication, key=lambda one: len(one.authors))
            merged[publication.identity] = fullest, uses | {Mention(origin.block, place): None}
    ordered = sorted(merged.values(), key=lambda entry: (entry[0].text.lower(), entry[0].year))
    publications = tuple((publication, tuple(uses)) for publication, uses in ordered)
    return Citation(subject, publications, tuple(without), tuple(dict.fromkeys(remarks)))


def _of_study(study: Study, remarks: list[str]) -> Iterator[Origin]:
    cases = () if callable(study.cases) else study.cases
    sweeps = () if callable(study.sweeps) else study.sweeps
    works = () if callable(study.works) else study.works
    own = references_section(_module_docstring(study.sections))
    yield from [Origin(f"the study '{study.name}'", own)] if own else []
    for case in cases:
        yield from _of_run(case.run, f"The loop of '{case.name}'", remarks)
    for sweep in sweeps:
        yield from _of_run(sweep.run, f"The loop of '{sweep.name}'", remarks)
        yield _of_class(type(sweep.design))
    for tuning in study.tunings:
        yield _of_class(Tuning)
        for trial in tuning.trials:
            yield from _of_run(trial.run, f"The loop of '{tuning.name}'", remarks)
    for work in works:
        if section := references_section(getattr(work.function, "__doc__", "")):
            yield Origin(f"the work '{work.name}'", section)
        for item in work.over:
            if is_block(item) or is_loop(item):
                yield from _of_loop(item, f"A loop of '{work.name}'", remarks)


def _of_run(run: Run, words: str, remarks: list[str]) -> Iterator[Origin]:
    yield from _of_loop(run.loop, words, remarks)
    for metric in run.metrics:
        yield Origin(metric.name, references_section(type(metric).__doc__))


def _of_loop(loop: object, words: str, remarks: list[str]) -> Iterator[Origin]:
    found = origins(loop.flow if isinstance(loop, SampledSystem) else loop)
    yield from found
    if not found:
        remarks.append(f"{words} is given by its equations, so its blocks are not known.")


def _of_class(kind: type) -> Origin:
    return Origin(kind.__name__, references_section(kind.__doc__))


def _remarks(study: Study) -> Iterator[str]:
    """The parts of a study that follow from its results, so that their blocks are not known."""
    for part in ("cases", "sweeps", "works"):
        if callable(getattr(study, part)):
            yield f"The {part} of the study follow from its results, so what they use is not listed."


def _module_docstring(function: Callable[..., object]) -> str:
    """The docstring of the module in which a function is written; empty if it is not known."""
    module = sys.modules.get(getattr(function, "__module__", None) or "")
    return getattr(function, "__globals__", {}).get("__doc__") or getattr(module, "__doc__", None) or ""


def _workbench() -> str:
    return f"{WORKBENCH.authors}, {WORKBENCH.work}, version {__version__}."


def _words(use: Mention) -> str:
    return f"{use.block}: {use.place}" if use.place else use.block
