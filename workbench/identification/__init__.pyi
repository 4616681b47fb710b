"""The room for editors and mypy: each of its names, and the file that it comes from."""

from workbench.identification.datasets import Dataset, Experiment
from workbench.identification.estimation import (
    Bootstrap,
    Fit,
    FitCertificate,
    FittedParameters,
    Identifiability,
    ProfileLikelihood,
    ResidualTest,
    fit,
    identifiability,
    simulate_log,
)
from workbench.identification.experiments import DesignCertificate, ExperimentDesign, design_experiment
from workbench.identification.summaries import FitSummary

__all__ = [
    "Bootstrap",
    "Dataset",
    "DesignCertificate",
    "Experiment",
    "ExperimentDesign",
    "Fit",
    "FitCertificate",
    "FitSummary",
    "FittedParameters",
    "Identifiability",
    "ProfileLikelihood",
    "ResidualTest",
    "design_experiment",
    "fit",
    "identifiability",
    "simulate_log",
]
