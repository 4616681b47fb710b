"""`fit_page`: a fit as a page of its own, to be read in a notebook and written into a folder with its PDF."""

from __future__ import annotations

import platform
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

from markupsafe import Markup, escape

from workbench import __version__
from workbench.core.validation.signatures import check_arguments
from workbench.identification.estimation.fit import Fit
from workbench.identification.summaries.fit_summary import FitSummary
from workbench.report import folder as report_folder
from workbench.report.fit_section import fit_parts, verdict
from workbench.report.html_page import html
from workbench.report.live.fit_data import LiveFit, live_fit
from workbench.report.live.page_data import LiveData
from workbench.study.document.document import Colophon, Document, Section
from workbench.study.document.phrases_and_tables import Phrase
from workbench.study.document.words import join_names
from workbench.study.writeup import PACKAGES

HEIGHT = 900  # pixels of the frame in a notebook
COMMAND = "workbench.fit_page(...)"
NAME = "fit"  # the first part of the names of its figures and tables
MOST_NAMES = 6  # in a sentence


@dataclass(frozen=True, eq=False)
class FitPage:
    """A page on a fit, which a notebook shows, and which `write` puts into a folder.

    `no_live_reason` says why it has no knobs, if it has none.
    """

    document: Document
    live: LiveData | None = None
    no_live_reason: str = ""

    @property
    def text(self) -> str:
        """The HTML of the page, one file without any other."""
        return html(self.document, live=self.live)

    def __repr__(self) -> str:
        kind = "printed" if self.live is None else "live"
        return f"<{kind} page of a fit, '{self.document.title}': `write(folder)` makes its HTML, PDF and tables>"

    def _repr_html_(self) -> str:
        frame = '<iframe srcdoc="{}" width="100%" height="{}" style="border: 0" sandbox="allow-scripts"></iframe>'
        return Markup(frame).format(escape(self.text), HEIGHT)

    @check_arguments
    def write(self, folder: str | Path) -> Path:
        """Write `index.html`, `report.pdf`, tables and figures into a folder, new or with an earlier page; its path.

        Raises
        ------
        ValueError
            If the folder holds anything else, or cannot be written.
        """
        return report_folder.write(self.document, folder, live=self.live)


@check_arguments
def fit_page(fit: Fit | FitSummary, title: str = "", *, summary: FitSummary | None = None) -> FitPage:
    """The page of a fit, as HTML and PDF, with the parts of `wb.fit_section`.

    A fit with its equations has a live page: the curve of the model moves under the samples when a reader turns a
    number, and the root mean square of the errors follows, with the bits of the engine's portable arithmetic.

    Parameters
    ----------
    fit
        The result of `wb.fit`; or a summary of it, which has no equations, so that nothing can be turned.
    title
        The title of the page.
    summary
        A summary of the same fit, `wb.identification.FitSummary.of(fit, ...)`, which can hold profiles, draws and a
        designed experiment.

    Raises
    ------
    ValueError
        If the summary is of another fit, or there are two.

    Examples
    --------
    >>> motor = wb.open_loop(wb.DCMotor())
    >>> t = np.linspace(0.0, 2.0, 101)
    >>> v = 12.0 * np.sign(np.sin(5.0 * t) + 0.1)
    >>> log = wb.Dataset.of(t, {"v": v, "omega": np.cumsum(v) / 400}, {"v": "V", "omega": "rad/s"})
    >>> wb.fit_page(wb.fit(motor, log, ["J", "R"]), "The motor")
    <live page of a fit, 'The motor': `write(folder)` makes its HTML, PDF and tables>
    """
    summary = _summary(fit, summary)
    live, reason = _live(fit, summary) if isinstance(fit, Fit) else (None, "a summary has no equations to run")
    names = summary.names
    few = join_names(names) if len(names) <= MOST_NAMES else f"{len(names)} numbers"
    samples = sum(one.count for one in summary.sensors)
    count = len(summary.experiments)
    method = (
        f"Output errors of least weighted squares, from {samples} samples of {len(summary.sensors)} "
        f"sensor{'s' * (len(summary.sensors) > 1)} in {count} experiment{'s' * (count > 1)}. Standard errors and "
        "intervals are those of linear outputs unless a column says otherwise."
    )
    colophon = Colophon(
        command=COMMAND,
        version=__version__,
        packages={name: version(name) for name in PACKAGES},
        python=platform.python_version(),
        again="The same log with the same versions gives this page again.",
    )
    first, *others = fit_parts(summary, NAME)
    if not summary.warnings:  # the answer of the page is the first paragraph
        first = first._replace(blocks=first.blocks[1:])
    if live is not None:
        first = first._replace(blocks=(*first.blocks, live.table))
    else:
        method += f" Nothing can be turned on this page: {reason.rstrip('.')}."
    sections = tuple(Section(part.heading, part.blocks) for part in (first, *others))
    question = f"What does the log say of {few}, and how surely?"
    document = Document(title or f"Fit of {few}", question, method, sections, colophon, answer=_answer(summary))
    return FitPage(document, None if live is None else live.data, reason)


def _summary(fit: Fit | FitSummary, summary: FitSummary | None) -> FitSummary:
    """The summary to be shown; one of another fit is refused."""
    if isinstance(fit, FitSummary):
        if summary is not None:
            raise ValueError("`fit_page(fit, summary=...)` must have one summary; `fit` is one already: give the fit.")
        return fit
    if summary is None:
        return FitSummary.of(fit)
    if [(one.name, one.estimate) for one in summary.numbers] != [*fit.values.items()]:
        raise ValueError("`fit_page(fit, summary=...)` must be a summary of this fit: `FitSummary.of(fit, ...)`.")
    return summary


def _live(fit: Fit, summary: FitSummary) -> tuple[LiveFit | None, str]:
    """The live part of the page, or the reason why it has none."""
    try:
        return live_fit(fit, summary, NAME), ""
    except ImportError:
        return None, "llvmlite, which compiles it for a browser, is not installed"
    except ValueError as error:
        return None, str(error)


def _answer(summary: FitSummary) -> Phrase:
    """The first line of the page: the worst that speaks against the fit, or else its misfit."""
    said = verdict(summary)
    return (said[0], f" {summary.warnings[0]}") if isinstance(said, tuple) else said
