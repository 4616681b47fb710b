"""tmp"""
from sensitivity_sweeps import LAWS, sweeps
from workbench.study.study import Study
study = Study("a7_sensitivity", "t", "q", "m", lambda r: (), sweeps=tuple(s for law in LAWS for s in sweeps(law)))
