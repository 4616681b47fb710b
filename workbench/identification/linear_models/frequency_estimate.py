"""A frequency response that was estimated: values over frequency with their covariance."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array, finite, refusal
from workbench.core.validation.signatures import check_arguments

Complex = NDArray[np.complex128]
if TYPE_CHECKING:
    Complexes: TypeAlias = Complex | Array
else:
    Complexes = object  # any numbers; `contains` refuses the rest
EMPTY = np.zeros(0)


@dataclass(frozen=True, eq=False)
@show
class FrequencyEstimate:
    """An estimate G (m,) of a response at `frequencies` (m,) in rad/s, from a signal to another one, at a period in s.

    `covariance` (m, 2, 2) is that of real and imaginary part, NaN where the method has none. `coherence` (m,) is the
    fraction of the output that the input explains, empty if the method has none. `wb.bode` and `wb.nyquist` draw it
    beside models, with its region of 95 %.
    """

    method: str
    frequencies: Array
    values: Complex
    covariance: Array
    period: float
    source: str
    output: str
    coherence: Array = field(default_factory=lambda: EMPTY)
    remarks: tuple[str, ...] = ()

    @property
    def gain_errors(self) -> Array:
        """The standard errors (m,) of the gain |G|."""
        return self._along(self.values)

    @property
    def phase_errors(self) -> Array:
        """The standard errors (m,) of the phase in rad, to first order."""
        sizes = np.abs(self.values)
        turns = np.divide(self._along(1j * self.values), sizes, out=np.full(len(sizes), np.inf), where=sizes > 0)
        return np.asarray(turns)

    def _along(self, directions: Complex) -> Array:
        """The standard errors (m,) along directions in the complex plane."""
        sizes = np.abs(directions)
        unit = np.where(sizes > 0, directions / np.where(sizes > 0, sizes, 1), 1)
        axes = np.stack([unit.real, unit.imag], axis=1)
        return np.asarray(np.sqrt(np.maximum(np.einsum("mi,mij,mj->m", axes, self.covariance, axes), 0.0)))

    @check_arguments
    def contains(self, values: Complexes, level: float = 0.95) -> NDArray[np.bool_]:
        """True (m,) where the ellipse of confidence at a level holds the `values` (m,) of another response.

        Raises
        ------
        ValueError
            If the level is not between 0 and 1, or there is not one value for each frequency.
        """
        level = finite("contains(level=...)", level)
        if not 0 < level < 1:
            raise ValueError(f"`contains(level=...)` must lie between 0 and 1; got {level:g}.")
        try:
            others = np.array(values, dtype=complex)
        except Exception:  # an object of the user's may raise anything when it is asked for its numbers
            raise refusal("contains(values=...)", "complex numbers, one for each frequency", values) from None
        if others.shape != self.values.shape:
            raise ValueError(
                f"`contains(values=...)` must have one value for each of {len(self.values)} frequencies; got shape "
                f"{others.shape}."
            )
        away = others - self.values
        parts = np.stack([away.real, away.imag], axis=1)
        with np.errstate(all="ignore"):
            solved = np.linalg.solve(self.covariance, parts[..., np.newaxis])[..., 0]
        return np.asarray(np.einsum("mi,mi->m", parts, solved) <= chi2.ppf(level, 2))

    @check_arguments
    def between(self, low: float, high: float) -> FrequencyEstimate:
        """The estimate at frequencies from `low` to `high` in rad/s."""
        inside = (self.frequencies >= low) & (self.frequencies <= high)
        coherence = self.coherence[inside] if len(self.coherence) else self.coherence
        return FrequencyEstimate(
            self.method,
            self.frequencies[inside],
            self.values[inside],
            self.covariance[inside],
            self.period,
            self.source,
            self.output,
            coherence,
            self.remarks,
        )
