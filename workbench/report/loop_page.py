"""The page of a single loop, live: the bench on which one tries a law before there is a study."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from markupsafe import Markup, escape

from workbench.core import Ode, SampledSystem
from workbench.core.equations import Loop
from workbench.core.validation.places import other_kind
from workbench.core.validation.signatures import check_arguments
from workbench.engine.metrics import AbstractMetric
from workbench.report.html_page import html
from workbench.report.live.live_data import live_data
from workbench.report.live.loop_study import loop_study
from workbench.study import case_runs, writeup
from workbench.study.design_knob import DesignKnob
from workbench.study.knob import Knob
from workbench.study.ledger.durability import write_durably
from workbench.study.pid_specification import PidSpecification

HEIGHT = 900  # pixels of the frame in a notebook
COMMAND = "workbench.live(...)"


@dataclass(frozen=True)
class LoopPage:
    """A page that a notebook shows and `write` puts into a file; `no_live_reason` says why it has no knobs there."""

    text: str
    no_live_reason: str = ""

    def __repr__(self) -> str:
        kind = "printed" if self.no_live_reason else "live"
        return f"<{kind} page of {len(self.text) // 1000} kB: `write(path)` puts it into a file>"

    def _repr_html_(self) -> str:
        frame = '<iframe srcdoc="{}" width="100%" height="{}" style="border: 0" sandbox="allow-scripts"></iframe>'
        return Markup(frame).format(escape(self.text), HEIGHT)

    @check_arguments
    def write(self, path: str | Path) -> Path:
        """Write the page to a file, and give its path.

        Raises
        ------
        LookupError
            If there is no folder for it.
        """
        place = Path(path)
        if not place.parent.is_dir():
            raise LookupError(f"`write({str(place)!r})` must be in a folder that is there; '{place.parent}' is none.")
        if kind := other_kind(place):
            raise LookupError(f"`write({str(place)!r})` must be the path of a file; {kind} has this name.")
        write_durably(place, self.text.encode())
        return place


@check_arguments
def live(
    loop: Loop | Ode | SampledSystem,
    until: float,
    h: float = 1e-3,
    metrics: Sequence[AbstractMetric] = (),
    knobs: Sequence[Knob | DesignKnob | PidSpecification] = (),
    title: str = "",
) -> LoopPage:
    """An HTML page of a loop with knobs, whose reader changes numbers and sees the responses at once.

    A loop that no browser can run has a page without knobs, which says why.

    Parameters
    ----------
    until, h
        The horizon and the step in s; for a sampled loop, h is the substep. Errors come from h / 2.
    metrics
        The metrics to show; by default those of tracking errors and inputs.
    knobs
        The numbers that can be turned; by default all numbers of the loop that move what the page shows. A
        `PidSpecification` may stand among them, and a loop whose law is a `PID` of one signal has one by default.
    title
        The title of the page.

    Examples
    --------
    >>> wb.live(wb.open_loop(wb.DCMotor()), until=2.0).text[:15]
    '<!DOCTYPE html>'
    """
    study = loop_study(loop, until, h, metrics, knobs, title)
    results = case_runs.run(study)
    document = writeup.document(study, results, COMMAND)
    data = live_data(study, results, document)
    if data and data["loops"]:
        return LoopPage(html(document, live=data, bench=True))
    if data:
        why = "; ".join(data["refused"].values()).rstrip(".")
    elif study.live:
        why = "llvmlite, which compiles it for a browser, is not installed"
    else:
        why = "no number moves what is shown"
    printed = f"Nothing can be turned in this loop: {why}."
    told = replace(study, method=f"{study.method} {printed}")
    return LoopPage(html(writeup.document(told, results, COMMAND), bench=True), printed)
