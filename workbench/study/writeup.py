"""From a study and its results to the document that the report renders."""

from __future__ import annotations

import platform
from importlib.metadata import version

from workbench import __version__
from workbench.study.document import Colophon, Document
from workbench.study.study import Results, Study

PACKAGES = ("casadi", "control", "numpy", "scipy", "matplotlib", "pandas", "typst")


def document(study: Study, results: Results, command: str) -> Document:
    """What the study says, with all that is needed to get it again: command, versions, fingerprints."""
    prints = {outcome.case.name: outcome.ode.fingerprint[:16] for outcome in results.outcomes}
    colophon = Colophon(
        command=command,
        version=__version__,
        fingerprints={**study.fingerprints, **prints},
        packages={name: version(name) for name in PACKAGES},
        python=platform.python_version(),
    )
    return Document(
        title=study.title,
        question=" ".join(study.question.split()),
        method=" ".join(study.method.split()),
        sections=tuple(study.sections(results)),
        colophon=colophon,
    )
