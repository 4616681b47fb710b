"""The study of what a Sobol study costs: its workload, and verdicts that turn with the times."""

from dataclasses import replace

import numpy as np

from studies.b2_sobol_cost import study as study
from studies.b2_sobol_cost.workload import sweep
from workbench.study.compiled_sweep import compile_sweep

FAST = study.Cost(12288, 768, (study.Command(9.0, 14.0, 0.3),) * 3, ((9.8, 10.0),) * 3)


def test_the_workload_is_twelve_thousand_runs_of_ten_factors():
    asked = sweep()
    assert (asked.design.size, asked.design.dimensions) == (12288, 10)
    assert (asked.run.h, asked.run.until) == (1e-3, 10.0)


def test_what_is_marched_alone_are_the_rows_that_the_ledger_keeps():
    one = compile_sweep(sweep(8))
    sample = study.record(one)
    assert len(sample) == one.sweep.design.size
    assert sample.diverged_count == 0
    study.march(one)  # the same rows and steps: it would refuse others
    assert np.isfinite(sample.score("RMSE").value).all()


def test_bars_are_reached_or_missed_as_the_figures_say():
    assert [one.answer for one in study.findings(FAST)] == ["reached"] * 3
    long = (study.Command(11.0, 20.0, 0.9), study.Command(12.0, 20.0, 1.2), study.Command(9.5, 18.0, 0.9))
    slow = replace(FAST, commands=long, turns=((9.4, 10), (9.3, 10), (9.2, 10)))
    assert [one.answer for one in study.findings(slow)] == ["missed"] * 3
    assert [one.kind for one in study.findings(slow)] == ["depends", "depends", "found"]  # other runs reach two bars
    (run,) = study.findings(slow)[0].reversals
    assert (run.words, run.answer, run.detail) == ("run 3 of the command", "reached", "9.5 s")
    assert "11.0 s from command to report, and 1.20 GB of memory" in study.answer(slow)
    # where others use the machine too, the clock decides nothing
    assert study.findings(replace(slow, others=3.0))[0].kind == "open"


def test_turns_on_both_sides_of_the_bar_leave_it_open():
    noisy = replace(FAST, turns=((9.9, 10), (9.8, 10), (9.4, 10)))
    finding = study.findings(noisy)[2]
    assert (finding.kind, [one.words for one in finding.reversals]) == ("open", ["turn 3"])
    assert study.answer(noisy).endswith("is 1.0 % to 6.0 %, which decides nothing.")
    assert study.answer(FAST).endswith("in the processor time is 2.0 % to 2.0 %.")
