"""The page of a6, written of runs that nobody computed: values of RMSE that fall with the horizon."""

from types import SimpleNamespace

import numpy as np
import pytest

from studies.a6_unstated_choices.study import answer, sections, study
from studies.paper.card import LAWS
from tests.support.samples import made_sample
from workbench.study.document.document import Figure, Paragraph, ReportTable

POINTS = 48  # of each search
RMSE = (("sampled RMSE", 0, "rad"), ("sampled RMSE", 1, "rad"))
PEAK = (("peak torque", 0, "N m"), ("peak torque", 1, "N m"))


def numbers_of(factors, points):
    return np.column_stack([one.distribution.quantile(points[:, i]) for i, one in enumerate(factors)])


def runs_of(name, run, factors, points, halved, seed):
    """Runs whose error dies out after a time, one in eight of which diverges."""
    rng = np.random.default_rng(seed)
    t = np.arange(1, round(run.until / run.sampling_interval) + 1) * run.sampling_interval
    count = len(points)
    level = rng.uniform(0.3, 3.0, size=(count, 1, 2))
    values = level / np.sqrt(np.minimum(t, 20.0))[:, np.newaxis]
    lost = np.where(np.arange(count) % 8 == 7, 3.0, np.nan)
    values[np.isfinite(lost)] = np.nan
    again = np.arange(0, count, halved) if halved else np.empty(0, dtype=int)
    errors = 0.01 * values[again]
    limits = np.full(len(again), np.inf)
    columns = PEAK if name.startswith("peaks") else RMSE
    drawn = numbers_of(factors, points)
    return made_sample(name, (), columns, t, run.h, 0, "", drawn, values, again, errors, limits, lost)


def tuned_of(tuning, seed):
    points = np.random.default_rng(seed).random((POINTS, len(tuning.factors)))
    samples = {
        trial.name: runs_of(trial.name, trial.run, tuning.factors, points, None, seed + i)
        for i, trial in enumerate(tuning.trials)
    }
    numbers, objectives = numbers_of(tuning.factors, points), np.arange(POINTS, dtype=float)
    return SimpleNamespace(points=points, numbers=numbers, samples=samples, objectives=objectives)


@pytest.fixture(scope="module")
def page():
    tuned = {one.name: tuned_of(one, seed) for seed, one in enumerate(study.tunings)}
    samples = {
        one.name: runs_of(one.name, one.run, one.factors, one.design.points(), one.half_step_every, seed)
        for seed, one in enumerate(study.sweeps(tuned))
    }
    return sections(SimpleNamespace(tuning=tuned.__getitem__, sample=samples.__getitem__))


def test_the_page_has_five_findings_each_with_its_scope_and_variations(page):
    assert [one.name for one in page.findings] == [
        *("first", "below_rivals", "deciding", "row_of_fs", "printed_tables")
    ]
    for one in page.findings:
        assert one.statistic
        assert one.sample
        assert one.information
        assert one.variations
        assert one.limitations
    assert page.answer == answer(page.findings)


def test_the_answer_of_the_page_has_at_most_forty_words(page):
    assert len(page.answer.split()) <= 40


def test_sentences_of_the_findings_and_paragraphs_have_at_most_25_words(page):
    texts = [text for one in page.findings for text in (one.statement, one.statistic, one.information)]
    texts += [block.text for part in page.sections for block in part.blocks if isinstance(block, Paragraph)]
    long = [sentence for text in texts for sentence in text.split(". ") if len(sentence.split()) > 25]
    assert not long


def test_each_question_on_the_rankings_is_answered_by_column(page):
    blocks = [block for part in page.sections for block in part.blocks]
    below = next(one for one in blocks if isinstance(one, ReportTable) and one.name == "below")
    assert [row[:2] for row in below.rows] == [
        (question, limit)
        for limit in ("none", "100, 50 N m")
        for question in (*(f"below {law}" for law in LAWS[1:]), "first of six")
    ]
    assert all(shown.split(":")[0] in ("yes", "no", "mixed", "undecided") for row in below.rows for shown in row[2:])


def test_every_panel_has_a_title(page):
    figures = [block for part in page.sections for block in part.blocks if isinstance(block, Figure)]
    assert figures
    assert all(panel.title for figure in figures for panel in figure.panels)
