"""Experiments: inputs that tell most about a system within its limits, and what they tell, before they are run."""

from workbench.identification.experiments.design_experiment import design_experiment as design_experiment
from workbench.identification.experiments.experiment_design import DesignCertificate as DesignCertificate
from workbench.identification.experiments.experiment_design import ExperimentDesign as ExperimentDesign
