"""Linear models from logs: ARX, ARMAX, output error, Box-Jenkins, subspaces, and responses over frequency.

This package takes a `Dataset` at one constant period and gives models with their covariance, which become systems of
python-control about an operating point. Read `prediction_errors.py` first, then `gauss_newton.py`, `search_starts.py`
and `polynomial_model.py`.

Examples
--------
>>> wb.linear_models.PolynomialStructure(na=2, nb=(2,), nc=1).names
('a1', 'a2', 'b1', 'b2', 'c1')
"""

from workbench.identification.linear_models.frequency_estimate import FrequencyEstimate
from workbench.identification.linear_models.frequency_estimators import (
    local_polynomial_response,
    periodic_response,
    spectral_response,
)
from workbench.identification.linear_models.gauss_newton import LocalMinimum
from workbench.identification.linear_models.model_residuals import CorrelationTest
from workbench.identification.linear_models.model_structures import armax, arx, box_jenkins, output_error
from workbench.identification.linear_models.order_selection import OrderSelection, select_orders
from workbench.identification.linear_models.polynomial_estimates import polynomial_model
from workbench.identification.linear_models.polynomial_model import ModelFit, PolynomialModel
from workbench.identification.linear_models.polynomial_structure import Polynomials, PolynomialStructure
from workbench.identification.linear_models.subspace_estimates import subspace_model
from workbench.identification.linear_models.subspace_model import SubspaceModel

__all__ = [
    "CorrelationTest",
    "FrequencyEstimate",
    "LocalMinimum",
    "ModelFit",
    "OrderSelection",
    "PolynomialModel",
    "PolynomialStructure",
    "Polynomials",
    "SubspaceModel",
    "armax",
    "arx",
    "box_jenkins",
    "local_polynomial_response",
    "output_error",
    "periodic_response",
    "polynomial_model",
    "select_orders",
    "spectral_response",
    "subspace_model",
]
