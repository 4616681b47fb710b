"""Estimation: unknown numbers of a plant or a loop from a dataset, by exact sensitivities."""

from workbench.identification.estimation.experiment_check import identifiability as identifiability
from workbench.identification.estimation.fit import Fit as Fit
from workbench.identification.estimation.fit_bootstrap import Bootstrap as Bootstrap
from workbench.identification.estimation.fit_certificate import FitCertificate as FitCertificate
from workbench.identification.estimation.fit_system import fit as fit
from workbench.identification.estimation.fitted_parameters import FittedParameters as FittedParameters
from workbench.identification.estimation.identifiability import Identifiability as Identifiability
from workbench.identification.estimation.log_simulation import simulate_log as simulate_log
from workbench.identification.estimation.profile_likelihood import ProfileLikelihood as ProfileLikelihood
from workbench.identification.estimation.residual_tests import ResidualTest as ResidualTest
