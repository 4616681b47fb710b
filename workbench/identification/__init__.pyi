"""The room for editors and mypy: each of its names, and the file that it comes from."""

from workbench.identification.datasets import Dataset, Experiment
from workbench.identification.estimation import (
    Fit,
    FitCertificate,
    Identifiability,
    ResidualTest,
    fit,
    identifiability,
)
from workbench.identification.experiments import DesignCertificate, ExperimentDesign, design_experiment

__all__ = [
    "Dataset",
    "DesignCertificate",
    "Experiment",
    "ExperimentDesign",
    "Fit",
    "FitCertificate",
    "Identifiability",
    "ResidualTest",
    "design_experiment",
    "fit",
    "identifiability",
]
