"""The samples that the tables of a study need are asked for before anything is computed."""

import re
from pathlib import Path

import pytest

import workbench as wb
from workbench.study.evidence import Mean, Median, Quantile, Success, Tail, compare, least_draws, pair_samples
from workbench.study.uncertainty import MonteCarlo, SobolDesign, least_base, sobol

ROOT = Path(__file__).parents[2]
DRAWN = """
import workbench as wb
from workbench.study.uncertainty import MonteCarlo, SobolDesign, least_base

motor = wb.open_loop(wb.DCMotor(omega=1.0))
run = wb.Run(motor, (wb.effort("omega"),), until=0.1, h=0.01)
factors = tuple(wb.Factor(name, (name,), wb.Uniform(0.1, 0.2)) for name in ("b", "J", "R"))
print("started", flush=True)

def sections(results):
    sample = results.sample("indices")
    found = wb.sobol(sample.design, sample.score("effort of omega").value, factors=sample.factors, control_variate=True)
    return [wb.Section("Indices", (wb.Paragraph(str(found.S1.value)),))]

study = wb.Study("drawn", "T", "Q?", "M.", sections, sweeps=(
    wb.Sweep("indices", run, factors, SobolDesign(3, 64), least_samples=least_base(3)),))
"""


@pytest.mark.parametrize("dimensions", [1, 3, 7, 20])
@pytest.mark.parametrize("second_order", [False, True])
def test_the_least_base_is_what_the_control_variate_asks_for(dimensions, second_order):
    least = least_base(dimensions, second_order)
    design = SobolDesign(dimensions, least, second_order)
    sobol(design, design.points().sum(axis=1), control_variate=True)
    if least > 8:
        fewer = SobolDesign(dimensions, least // 2, second_order)
        with pytest.raises(ValueError, match="needs at least 4 runs for each"):
            sobol(fewer, fewer.points().sum(axis=1), control_variate=True)


@pytest.mark.parametrize("estimand", [Mean(), Median(), Success(1.0), Quantile(0.9), Quantile(0.02), Tail(0.75)])
def test_the_least_draws_are_what_a_comparison_asks_for(estimand):
    least = least_draws((estimand,))
    values = MonteCarlo(2, least).points()
    compare(pair_samples({"a": values[:, 0], "b": values[:, 1]}, metric="e"), estimand, resamples=100)
    with pytest.raises(ValueError, match="needs at least"):
        compare(pair_samples({"a": values[1:, 0], "b": values[1:, 1]}, metric="e"), estimand, resamples=100)


def test_a_sweep_with_too_few_samples_is_refused_by_name_before_anything_is_computed(command, tmp_path):
    (tmp_path / "drawn.py").write_text(DRAWN, encoding="utf-8")
    done = command("run", "drawn.py", "--out", "out", "--samples", 4 * 2)
    assert done.exit_code == 0, done.output
    worse = DRAWN.replace("least_base(3)", "16")
    (tmp_path / "drawn.py").write_text(worse, encoding="utf-8")
    done = command("run", "drawn.py", "--out", "new", "--samples", 8)
    assert done.exit_code == 2
    said = r"`Sweep\('indices', design=...\)` needs at least 16 samples, the `base` of its design, .* got 8: take more"
    assert re.search(said, done.stderr)
    assert not (tmp_path / "new").exists()


def test_a_design_with_fewer_samples_than_its_tables_need_is_refused():
    run = wb.Run(wb.open_loop(wb.DCMotor()), (wb.effort("omega"),), until=0.1, h=0.01)
    factors = (wb.Factor("b", ("b",), wb.Uniform(0.1, 0.2)),)
    with pytest.raises(ValueError, match=r"Sweep\('few', design=...\)` needs at least 100 samples.*got 20"):
        wb.Sweep("few", run, factors, MonteCarlo(1, 20), least_samples=100)


def test_a_study_whose_sweeps_follow_from_tunings_says_what_they_need(command, tmp_path):
    lines = DRAWN.replace("sweeps=(", "least_samples=32, sweeps=(")
    (tmp_path / "drawn.py").write_text(lines, encoding="utf-8")
    done = command("run", "drawn.py", "--out", "out", "--samples", 16)
    assert done.exit_code == 2
    assert "`--samples` must be at least 32 for the study 'drawn', as its tables need them; got 16." in done.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("study", ["a7_sensitivity", "a8_fair_comparison"])
def test_the_paper_s_studies_refuse_too_few_samples_at_once(command, study, tmp_path):
    folder = ROOT / "studies" / study
    done = command("run", folder, "--out", "out", "--samples", 16)
    assert done.exit_code == 2
    assert "got 16" in done.stderr
    assert not (tmp_path / "out").exists()
