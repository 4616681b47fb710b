"""The study of the paper in small: derive its arm, check what it prints, run a scenario and compare four laws."""

import workbench as wb
from studies.paper.card import CARD
from studies.paper.laws import PRINTED_ARM, proposed_repaired, rival

derived = wb.arms.Dynamics.of(wb.paper_arm(), "derived from the energies")

printed = wb.arms.Dynamics.of(PRINTED_ARM, "as printed")
entries = wb.arms.paper_equations.compare(printed, derived)
verdicts = {entry.label: entry.kind for entry in entries}

wrong = next(entry for entry in entries if entry.kind == "differs")
values = {"printed": wrong.printed_value, "right": wrong.right_value, "state": str(wrong.witness)}

skew = {arm.name: wb.arms.properties.skew(arm).kind for arm in (printed, derived)}

loops = {law: rival("SS", law) for law in ("PID", "SMC", "super-twisting")}
loops["AOSMC-RGS, repaired"] = proposed_repaired("SS")

metrics = wb.rmse(), wb.metrics.peak_error(), wb.effort()
cases = tuple(
    wb.Case("SS", law, wb.Run(loop, metrics, CARD["SS: horizon"], every=0.01, h=1e-4)) for law, loop in loops.items()
)
study = wb.Study(
    name="paper_in_small",
    title="Four laws on the arm of the paper",
    question="How large are the errors and the torques of four laws in the second scenario?",
    method="RK4 at 0.1 ms; the errors of the values come from a second run at half of that.",
    cases=cases,
    sections=lambda results: [wb.Section("Laws", (wb.side_by_side("laws", "Four laws", results.outcomes),))],
)
results = wb.study.run(study)
table = results.to_frame()

runs = {law: results["SS", law].measurement.trajectories for law in ("PID", "AOSMC-RGS, repaired")}
figure = wb.plot(runs, "q", "tau")

citation = wb.cite(study)
