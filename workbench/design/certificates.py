"""What a solver says about its own answer: how far it can be trusted, or that it cannot."""

from __future__ import annotations

from dataclasses import dataclass

from workbench.validation.views import show


class Refused(ValueError):  # noqa: N818
    """No answer can be trusted here; the message says why, and what would help."""


@dataclass(frozen=True)
@show
class Certificate:
    """How far a solution can be trusted.

    Parameters
    ----------
    residual
        What is left of the equation over the size of its terms, summed in twice the working precision.
    error
        An estimate of the relative error of the solution, for the data exactly as given.
    condition
        A bound of the relative change of the solution over that of the data.
    margin
        How far the slowest pole lies from instability: -max Re in 1/s, or 1 - max |z| of a sampled loop.
    refined
        How many Newton steps were kept, each because it made the residual smaller.
    warnings
        What a reader should know before the numbers are used, a sentence each.
    """

    residual: float
    error: float
    condition: float
    margin: float
    refined: int = 0
    warnings: tuple[str, ...] = ()

    def __str__(self) -> str:
        figures = (
            f"residual {self.residual:.1e}, error {self.error:.1e}, condition {self.condition:.1e}, "
            f"margin {self.margin:.3g}, Newton steps {self.refined}"
        )
        return "; ".join([figures, *self.warnings])
