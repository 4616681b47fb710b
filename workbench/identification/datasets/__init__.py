"""Datasets: measured or simulated signals over time, read, checked and prepared for a fit."""

from workbench.identification.datasets.dataset import Dataset as Dataset
from workbench.identification.datasets.experiment import Experiment as Experiment
