"""Summaries of fits without the log itself, which the reports do not copy."""

from __future__ import annotations

from dataclasses import replace

import workbench as wb


def thin_out(fit: wb.identification.Fit, every: int) -> wb.identification.FitSummary:
    """A summary with one in `every` samples, which is enough for a picture.

    Another log was held out, so that no warning says that none was.
    """
    summary = wb.identification.FitSummary.of(fit)
    parts = [
        replace(
            one,
            t=one.t[::every],
            samples=one.samples[::every],
            outputs=one.outputs[::every],
            weighs=one.weighs[::every],
            held_out=one.held_out[::every],
        )
        for one in summary.experiments
    ]
    warnings = tuple(text for text in fit.warnings if not text.startswith("No sample was held out"))
    return replace(summary, experiments=tuple(parts), warnings=warnings)
