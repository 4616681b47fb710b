"""Sentences on a fit that explains its log, or the part that it did not see, badly."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

MISFIT = 1.5  # root mean square of the residuals in standard deviations of a known noise that a model does not explain
TOO_GOOD = 0.3  # of the same: noise so large is not in the log
UNEXPLAINED = 0.5  # of a signal's spread
WORSE = 1.5  # ratio of the hold-out's residuals to those of the fit


def misfit_sentences(misfit: Mapping[str, float], is_noise_known: bool) -> list[str]:
    """A sentence for each sensor whose residuals are too large, or too small, beside its noise or its spread."""
    said = []
    for name, size in misfit.items():
        if is_noise_known and size > MISFIT:
            said.append(
                f"The model does not explain '{name}': its residuals are {size:.3g} times the noise that was given."
            )
        elif is_noise_known and size < TOO_GOOD:
            said.append(
                f"The noise that was given does not explain '{name}': the residuals are {size:.3g} times as large. "
                "Look at the units of both."
            )
        elif not is_noise_known and size > UNEXPLAINED:
            said.append(f"The model explains little of '{name}': {100 * size:.2g} % of its spread is left.")
    return said


def hold_out_sentences(ratios: Mapping[str, float]) -> list[str]:
    """A sentence for each sensor that is worse on the hold-out, or one if there is no hold-out."""
    said = []
    if all(np.isnan(ratio) for ratio in ratios.values()):
        said.append("No sample was held out: the fit was not tried on data that it did not see.")
    said += [
        f"The residuals of '{name}' are {ratio:.3g} times as large on the hold-out as on the fit."
        for name, ratio in ratios.items()
        if ratio > WORSE
    ]
    return said
