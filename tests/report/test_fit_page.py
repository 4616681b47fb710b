"""The page of a fit: what speaks against it first, then numbers, the log beside the model, residuals, and what next."""

import re
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest

import workbench as wb
from tests.support.fitted_motor import motor_fit
from workbench.identification.summaries.summary_parts import PlanSummary
from workbench.study.document.document import Figure, Itemize, Paragraph, ReportTable
from workbench.study.document.figure import Area

FitSummary = wb.identification.FitSummary


@pytest.fixture(scope="module")
def fit():
    return motor_fit()


@pytest.fixture(scope="module")
def summary(fit):
    return FitSummary.of(fit, profiles=[fit.profile("R")], bootstrap=fit.bootstrap(40, seed=2))


def blocks_of(fit, kind):
    return [block for block in wb.fit_section(fit).blocks if isinstance(block, kind)]


def words_of(fit):
    paragraphs = [block.text for block in blocks_of(fit, Paragraph)]
    items = [item for block in blocks_of(fit, Itemize) for item in block.items]
    return " ".join("".join(getattr(part, "text", part) for part in text) for text in (*paragraphs, *items))


def test_the_misfit_stands_first_and_warnings_follow_it(fit):
    warned = FitSummary.of(replace(fit, remarks=("The clock of the log drifts.",)))
    first, second, *_ = wb.fit_section(warned).blocks
    assert first.text[0].text == "1 point speaks against this fit."
    assert "of its spread" in first.text[1]
    assert second.items == ("The clock of the log drifts.",)
    assert "The clock of the log drifts." in wb.fit_page(warned).document.answer[1]


def test_a_fit_without_a_fault_says_so_and_has_no_list_of_faults(fit):
    first, second, *_ = wb.fit_section(fit).blocks
    assert first.text.startswith("Nothing was found against this fit.")
    assert isinstance(second, ReportTable)


def test_every_estimate_has_its_error_and_lies_in_its_interval(fit):
    table = next(one for one in blocks_of(fit, ReportTable) if one.name == "fit_estimates")
    assert [row[0] for row in table.rows] == ["J", "b", "R"]
    assert all(row[5] < row[3] < row[6] and row[4] > 0 for row in table.rows)


def test_the_hold_out_is_shaded_from_its_first_sample_to_its_last(fit):
    outputs, residuals = blocks_of(fit, Figure)[:2]
    for panel in (*outputs.panels, *residuals.panels):
        shade = next(mark for mark in panel.series if isinstance(mark, Area))
        assert {*shade.x} == {fit.model.dataset.experiments[0].t[97], 3.0}  # of 121 samples the last fifth
        low, high = panel.ylim or (panel.series[0].y.min(), panel.series[0].y.max())
        assert shade.y.min() <= low < high <= shade.y.max()
    model, samples = outputs.panels[0].series[:2]
    assert np.allclose(model.y - samples.y, fit.errors[0][:, 0], rtol=0, atol=1e-12)  # rounding of a sum
    assert np.allclose(residuals.panels[0].series[0].y, fit.errors[0][:, 0] / fit.noise["omega"], rtol=1e-9)


def test_intervals_by_profile_and_bootstrap_stand_beside_the_linear_ones(summary):
    table = next(one for one in blocks_of(summary, ReportTable) if one.name == "fit_intervals")
    rows = {row[0]: row[2:] for row in table.rows}
    assert rows["R"][2:4] == summary.profiles[0].interval
    assert rows["J"][2:4] == (None, None)
    assert rows["b"][4:] == summary.bootstrap.intervals()["b"]
    figure = next(one for one in blocks_of(summary, Figure) if one.name == "fit_profiles")
    assert figure.panels[0].hlines == (summary.profiles[0].limit,)
    assert figure.panels[0].vlines == summary.profiles[0].interval


def test_an_open_end_of_a_profile_is_open_in_its_table(summary):
    from workbench.identification.estimation.profile_likelihood import ProfileEnd

    profile = replace(summary.profiles[0], high_end=ProfileEnd(np.inf, "open"), low_end=ProfileEnd(np.nan, "bound"))
    table = next(
        one for one in blocks_of(replace(summary, profiles=(profile,)), ReportTable) if one.name == "fit_intervals"
    )
    assert [end.words for end in next(row for row in table.rows if row[0] == "R")[4:6]] == ["not known", "open"]


def test_null_directions_of_a_larger_set_are_said_in_words(fit):
    log = fit.model.dataset
    larger = wb.identifiability(fit.model.ode, log.select(["v"]), ["J", "b", "K", "R", "L"], ["omega"])
    said = words_of(FitSummary.of(fit, larger_set=larger))
    assert "K and L must come from elsewhere" in said
    assert all(sentence in said for sentence in larger.sentences)
    assert "No output changes" not in words_of(fit)


def test_the_change_that_is_told_least_is_one_standard_error_of_the_covariance(fit):
    relative = fit.covariance / np.outer(fit.theta, fit.theta)
    largest = np.sqrt(np.linalg.eigvalsh(relative)[-1])
    said = words_of(fit).split("one standard error: ")[1].split(" The same")[0]
    moves = [float(part) / 100 for part in re.findall(r" by (\S+) %", said)]
    assert np.isclose(np.linalg.norm(moves), largest, rtol=0.05)  # two digits, and parts below a tenth left out


def test_a_plan_has_its_expected_errors_beside_the_present_ones(fit):
    plan = PlanSummary(4.0, "D", {"J": fit.standard_errors["J"] / 3, "R": 0.5}, ("v",), ("A limit is broken.",))
    planned = replace(FitSummary.of(fit), plan=plan)
    table = next(one for one in blocks_of(planned, ReportTable) if one.name == "fit_next")
    rows = {row[0]: row[4:] for row in table.rows}
    assert np.isclose(rows["J"][1], 1 / 3, rtol=1e-12)
    assert rows["b"] == (None, None)
    said = words_of(planned)
    assert "0.33 times the present error of J" in said
    assert "the limits of v" in said
    assert "A limit is broken." in said


def test_a_log_without_noise_promises_no_errors(fit):
    exact = replace(FitSummary.of(fit), is_exact=True)
    assert "to rounding" in words_of(exact)
    assert all(block.name != "fit_next" for block in blocks_of(exact, ReportTable))


def test_of_too_many_records_those_with_the_largest_residuals_are_drawn(fit):
    one = FitSummary.of(fit).experiments[0]
    sizes = np.linspace(0.1, 2.0, 8)
    many = tuple(
        replace(one, name=f"log {k}", outputs=one.samples + size * (one.outputs - one.samples))
        for k, size in enumerate(sizes)
    )
    figure = blocks_of(replace(FitSummary.of(fit), experiments=many), Figure)[0]
    assert len(figure.panels) == 12
    assert {panel.title for panel in figure.panels} == {f"log {k}" for k in range(2, 8)}
    assert "12 of 16 records" in figure.caption


def test_names_of_a_log_are_text_on_the_page_and_in_its_drawings(fit):
    evil = "<b>$x_1$ & y"
    summary = FitSummary.of(fit)
    sensors = (replace(summary.sensors[0], name=evil), *summary.sensors[1:])
    numbers = (replace(summary.numbers[0], name=evil), *summary.numbers[1:])
    page = wb.fit_page(replace(summary, sensors=sensors, numbers=numbers), f"Fit of {evil}")
    assert "<b>$" not in page.text
    assert "&lt;b&gt;$x_1$ &amp; y" in page.text
    from workbench.report.picture import Picture

    for figure in page.document.figures:
        assert ElementTree.fromstring(Picture(figure).svg).tag.endswith("svg")


def test_a_page_is_written_with_its_pdf_and_its_tables_and_looked_at_in_a_notebook(fit, tmp_path):
    page = wb.fit_page(fit, "A motor")
    folder = page.write(tmp_path / "motor")
    assert (folder / "index.html").read_text(encoding="utf-8") == page.text
    assert (folder / "report.pdf").read_bytes().startswith(b"%PDF")
    assert (folder / "tables" / "fit_estimates.csv").is_file()
    assert 'sandbox="allow-scripts"></iframe>' in page._repr_html_()
    assert "A motor" in repr(page)
    (tmp_path / "else").mkdir()
    (tmp_path / "else" / "notes.txt").write_text("mine")
    with pytest.raises(ValueError, match=r"notes\.txt"):
        page.write(tmp_path / "else")


def test_two_fits_of_one_report_have_names_of_their_own(fit):
    names = [block.name for block in wb.fit_section(fit, "Another", name="second").blocks if hasattr(block, "name")]
    assert names
    assert all(name.startswith("second_") for name in names)
    with pytest.raises(ValueError, match="a-z, 0-9"):
        wb.fit_section(fit, name="../up")


def test_each_kind_is_a_picture_of_its_own_and_another_is_refused(fit):
    for kind in ("outputs", "residuals", "correlations"):
        assert fit.plot(kind).svg.startswith("<svg")
    with pytest.raises(LookupError, match="pictures of a fit"):
        fit.plot("bode")
