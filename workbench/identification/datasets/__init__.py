"""Datasets: measured or simulated signals over time, read, checked and prepared for a fit."""

from workbench.identification.datasets.data_check import DataCheck as DataCheck
from workbench.identification.datasets.data_check import check_data as check_data
from workbench.identification.datasets.data_finding import DataFinding as DataFinding
from workbench.identification.datasets.dataset import Dataset as Dataset
from workbench.identification.datasets.delay import DelayEstimate as DelayEstimate
from workbench.identification.datasets.experiment import Experiment as Experiment
