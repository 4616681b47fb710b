"""Studies: a question, the runs that answer it, and the document of their results.

A study is data: this package executes it and keeps its results, but draws no figure and writes no page. It knows a loop
by its equations alone. Read `study` first, then `execution`, where the sweeps of a study become chunks in a ledger, and
these become samples.

Examples
--------
>>> motor = wb.Run(wb.open_loop(wb.DCMotor(), "motor"), (wb.effort("omega"),), until=1.0, h=1e-2)
>>> study = wb.Study("s", "T", "Q?", "M.", lambda results: [], cases=(wb.Case("speed", "no law", motor),))
>>> wb.study.run(study).outcomes[0].case.law
'no law'
"""

from workbench.core.lazy_names import lazy_names

_FILES = {
    "case_runs": "run",
    "citation": "Citation cite",
    "run_and_sweep": "Run Sweep",
    "document.document": "TableColumn Figure Finding Itemize Page Panel Paragraph Section ReportTable Variation "
    "Verdict",
    "evidence.law_tables": "side_by_side",
    "design_knob": "DesignKnob",
    "knob": "Knob",
    "pid_specification": "PidSpecification",
    "result_marks": "bars cell points",
    "single_core": "one_core",
    "sample": "Sample",
    "study": "Case Outcome Results Study",
    "tuning": "Trial Tuning",
    "uncertainty": "Factor LatinHypercube LogNormal LogUniform MonteCarlo MorrisDesign Normal OneAtATime SobolDesign "
    "Triangular Uniform least_base morris quantiles sobol tornado",
    "study_works": "Work",
    "writeup": "testbed",
}
__all__, __getattr__, __dir__ = lazy_names(__name__, _FILES)
