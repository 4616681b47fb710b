"""The room for editors and mypy: each of its names, and the file that it comes from."""

from workbench.identification.datasets import Dataset, Experiment
from workbench.identification.estimation import (
    Fit,
    FitCertificate,
    Identifiability,
    ResidualTest,
    fit,
    identifiability,
    simulate_log,
)

__all__ = [
    "Dataset",
    "Experiment",
    "Fit",
    "FitCertificate",
    "Identifiability",
    "ResidualTest",
    "fit",
    "identifiability",
    "simulate_log",
]
