"""The room for editors and mypy: each of its names, and the file that it comes from."""

from workbench.study.case_runs import run
from workbench.study.citation import Citation, cite
from workbench.study.design_knob import DesignKnob
from workbench.study.document.document import (
    Figure,
    Finding,
    Itemize,
    Page,
    Panel,
    Paragraph,
    ReportTable,
    Section,
    TableColumn,
    Variation,
    Verdict,
)
from workbench.study.evidence.law_tables import side_by_side
from workbench.study.knob import Knob
from workbench.study.pid_specification import PidSpecification
from workbench.study.result_marks import bars, cell, points
from workbench.study.run_and_sweep import Run, Sweep
from workbench.study.sample import Sample
from workbench.study.single_core import one_core
from workbench.study.study import Case, Outcome, Results, Study
from workbench.study.study_works import Work
from workbench.study.tuning import Trial, Tuning
from workbench.study.uncertainty import (
    Factor,
    LatinHypercube,
    LogNormal,
    LogUniform,
    MonteCarlo,
    MorrisDesign,
    Normal,
    OneAtATime,
    SobolDesign,
    Triangular,
    Uniform,
    least_base,
    morris,
    quantiles,
    sobol,
    tornado,
)
from workbench.study.writeup import testbed

__all__ = [
    "Case",
    "Citation",
    "DesignKnob",
    "Factor",
    "Figure",
    "Finding",
    "Itemize",
    "Knob",
    "LatinHypercube",
    "LogNormal",
    "LogUniform",
    "MonteCarlo",
    "MorrisDesign",
    "Normal",
    "OneAtATime",
    "Outcome",
    "Page",
    "Panel",
    "Paragraph",
    "PidSpecification",
    "ReportTable",
    "Results",
    "Run",
    "Sample",
    "Section",
    "SobolDesign",
    "Study",
    "Sweep",
    "TableColumn",
    "Trial",
    "Triangular",
    "Tuning",
    "Uniform",
    "Variation",
    "Verdict",
    "Work",
    "bars",
    "cell",
    "cite",
    "least_base",
    "morris",
    "one_core",
    "points",
    "quantiles",
    "run",
    "side_by_side",
    "sobol",
    "testbed",
    "tornado",
]
