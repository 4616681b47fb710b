"""Orders by comparison: many structures on the same data, by AIC, BIC, a hold-out and the tests of residuals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import one_of
from workbench.core.validation.signatures import check_arguments
from workbench.identification.datasets import Dataset
from workbench.identification.linear_models.polynomial_estimates import Names, polynomial_model
from workbench.identification.linear_models.polynomial_model import PolynomialModel
from workbench.identification.linear_models.polynomial_structure import PolynomialStructure

if TYPE_CHECKING:
    import pandas as pd

CRITERIA = ("hold-out", "AIC", "BIC")


@dataclass(frozen=True, eq=False)
@show
class OrderSelection:
    """Models of several structures on the same data; `refusals` has a sentence for each structure without a model."""

    models: tuple[PolynomialModel, ...]
    refusals: tuple[str, ...] = ()

    @check_arguments
    def best(self, criterion: str = "hold-out") -> PolynomialModel:
        """The model with the least prediction error on the hold-out, or the least "AIC" or "BIC".

        Raises
        ------
        ValueError
            If the criterion is none of these, or outputs are missing and the errors of the models are not of the same
            samples, which AIC and BIC need.
        """
        one_of("best(criterion=...)", criterion, CRITERIA)
        counts = {one.samples for one in self.models}
        if criterion != "hold-out" and len(counts) > 1:
            raise ValueError(
                f"`best(criterion={criterion!r})` needs models of the same errors; with the missing outputs of this "
                f"log {min(counts):,} to {max(counts):,} count: use the hold-out."
            )
        if criterion == "hold-out":
            return min(self.models, key=lambda one: one.holdout.prediction_rmse if one.holdout else np.inf)
        return min(self.models, key=lambda one: one.AIC if criterion == "AIC" else one.BIC)

    def to_frame(self) -> pd.DataFrame:
        """A table with a row for each model: orders, parameters, criteria, fits in percent, and whether tests pass."""
        import pandas as pd

        rows = []
        for model in self.models:
            held, other = model.structure, model.holdout
            tests = model.residual_tests()
            rows.append(
                {
                    "kind": model.kind,
                    **{name: getattr(held, name) for name in ("na", "nb", "nc", "nd", "nf", "nk")},
                    "parameters": held.size,
                    "AIC": model.AIC,
                    "BIC": model.BIC,
                    "hold-out predicted [%]": other.prediction if other else np.nan,
                    "hold-out simulated [%]": other.simulation if other else np.nan,
                    "white": tests[0].is_passed,
                    "input explained": all(test.is_passed for test in tests[1:]),
                }
            )
        return pd.DataFrame(rows)


@check_arguments
def select_orders(
    data: Dataset,
    inputs: Names,
    output: str,
    structures: Sequence[PolynomialStructure],
    holdout: Dataset,
    *,
    offsets: str = "estimate",
    initial: str = "estimate",
    starts: int = 8,
    seed: int = 0,
) -> OrderSelection:
    """Models of several structures on the same data, judged on the same hold-out; arguments as of `polynomial_model`.

    Raises
    ------
    ValueError
        If no structure has a model; the sentence is that of the last refusal.
    LookupError
        If there is no such signal.

    References
    ----------
    Ljung (1999), System Identification, sections 16.4 and 16.6.

    Examples
    --------
    >>> u = np.random.default_rng(1).standard_normal(400)
    >>> y = np.convolve(u, [0.0, 1.0, 0.5])[:400] + 0.1 * np.random.default_rng(2).standard_normal(400)
    >>> log = wb.Dataset.of(0.1 * np.arange(400), {"u": u, "y": y}, {"u": "V", "y": "V"})
    >>> structures = [wb.linear_models.PolynomialStructure(nb=(count,)) for count in (1, 2, 3)]
    >>> selection = wb.linear_models.select_orders(log.split(0.3)[0], "u", "y", structures, log.split(0.3)[1])
    >>> selection.best("BIC").structure.nb
    (2,)
    """
    models, refusals = [], list[str]()
    for structure in structures:
        try:
            models.append(
                polynomial_model(
                    data,
                    inputs,
                    output,
                    structure,
                    holdout=holdout,
                    offsets=offsets,
                    initial=initial,
                    starts=starts,
                    seed=seed,
                )
            )
        except ValueError as error:
            refusals.append(str(error))
    if not models:
        raise ValueError(
            refusals[-1] if refusals else "`select_orders(structures=...)` must have a structure; got none."
        )
    return OrderSelection(tuple(models), tuple(refusals))
