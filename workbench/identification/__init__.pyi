"""The room for editors and mypy: each of its names, and the file that it comes from."""

from workbench.identification.datasets import Dataset, Experiment
from workbench.identification.estimation import (
    Bootstrap,
    Fit,
    FitCertificate,
    Identifiability,
    ProfileLikelihood,
    ResidualTest,
    fit,
    identifiability,
    simulate_log,
)

__all__ = [
    "Bootstrap",
    "Dataset",
    "Experiment",
    "Fit",
    "FitCertificate",
    "Identifiability",
    "ProfileLikelihood",
    "ResidualTest",
    "fit",
    "identifiability",
    "simulate_log",
]
