"""Designs: which points of the unit cube are run, each made from the seed and its own number alone."""

from workbench.study.sampling.contract import AbstractDesign
from workbench.study.sampling.listed import Listed
from workbench.study.sampling.morris import MorrisDesign
from workbench.study.sampling.one_at_a_time import OneAtATime
from workbench.study.sampling.plain import LatinHypercube, MonteCarlo
from workbench.study.sampling.sobol import SobolDesign

__all__ = ["AbstractDesign", "LatinHypercube", "Listed", "MonteCarlo", "MorrisDesign", "OneAtATime", "SobolDesign"]
