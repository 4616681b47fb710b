"""Identification: from measured signals to models with their uncertainty.

A `Dataset` holds a log, `fit` estimates parameters of any plant or loop from it, `identifiability` says before what
an experiment can tell, and `design_experiment` finds the one that tells most. Read `datasets/dataset.py` first, then
`estimation/fit_system.py` and `experiments/design_experiment.py`.

Examples
--------
>>> motor = wb.open_loop(wb.DCMotor())
>>> t = np.linspace(0.0, 2.0, 201)
>>> step = wb.Dataset.of(t, {"v": np.where(t < 1.0, 12.0, 0.0)}, {"v": "V"})
>>> wb.identifiability(motor, step, ["J", "b", "K", "R", "L"], ["omega"]).ambiguous_names
('J', 'b', 'K', 'R', 'L')
"""

from workbench.core.lazy_names import lazy_names

_FILES = {
    "datasets": "Dataset Experiment",
    "estimation": "Bootstrap Fit FitCertificate FittedParameters Identifiability ProfileLikelihood ResidualTest fit "
    "identifiability simulate_log",
    "experiments": "DesignCertificate ExperimentDesign design_experiment",
    "summaries": "FitSummary",
}
__all__, __getattr__, __dir__ = lazy_names(__name__, _FILES)
