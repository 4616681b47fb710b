"""Which of ten numbers decide the tracking error of workload W?

Runs in ten seconds on two cores.
"""

from collections.abc import Sequence

import numpy as np

import workbench as wb
from studies.paper.workload import HORIZON, PARAMETERS, VARIATION_RANGES, H, loop

BASE, SEED = 1024, 1
METRICS = (wb.rmse(), wb.metrics.TotalVariation("TV", "N m/s", "total variation of tau a second", "tau", H))


def factors() -> tuple[wb.Factor, ...]:
    """The ten numbers that the bench varies, each over its range: shares of their values."""
    return tuple(
        wb.Factor(label, (label,), wb.Uniform(*span), share=True)
        for name, span in VARIATION_RANGES.items()
        for label in PARAMETERS[name].labels()
    )


def sweep(base: int = BASE) -> wb.Sweep:
    """The runs behind the indices."""
    moved = factors()
    return wb.Sweep(
        "indices", wb.Run(loop(), METRICS, HORIZON, h=H), moved, wb.SobolDesign(len(moved), base, seed=SEED)
    )


def sections(results: wb.Results) -> Sequence[wb.Section]:
    """The indices."""
    sample = results.sample("indices")
    outputs = [(metric.name, joint) for metric in METRICS for joint in (0, 1)]
    scores = [sample.score(*output) for output in outputs]
    values, errors = (np.stack(parts, axis=1) for parts in ([s.value for s in scores], [s.error for s in scores]))
    names = [f"{metric}, q{joint + 1}" for metric, joint in outputs]
    found = wb.sobol(sample.design_of(wb.SobolDesign), values, names, factors=sample.factors, errors=errors)
    return (wb.Section("Which numbers decide", (wb.sobol_bars("indices", "Sobol indices.", found, sample.note),)),)


study = wb.Study(
    name="b2_workload",
    title="Sobol indices of workload W",
    question="The Sobol indices of AOSMC-RGS over its arm, its disturbance and two gains.",
    method="12,288 runs of 10 s at 1 ms: 1024 pairs of points and 10 factors. b2 measures what this study takes.",
    sections=sections,
    sweeps=(sweep(),),
    seed=SEED,
)
