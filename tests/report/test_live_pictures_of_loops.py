"""The pictures on live pages of several kinds of loops: of channels, in a computer, not stable, and without rest."""

import numpy as np
import pytest

import workbench as wb
from studies.paper.laws import rival
from studies.performance.chromium import open_browser, open_page
from tests.support.browsers import needs_chromium
from tests.support.compilers import needs_llvmlite
from tests.support.linear_answers import answer_of, received
from tests.support.live_pictures import IDLE, blocks_of, data_of, drawn, loop, turn
from workbench.study import case_runs
from workbench.study.document.document import Figure, MissingCell, Paragraph, ReportTable, ValueWithError
from workbench.study.document.frequency_curves import decibels


def margins_of(closed):
    return next(
        block for block in blocks_of(closed) if isinstance(block, ReportTable) and block.name == "linear_margins"
    )


@pytest.fixture(scope="module")
def browser():
    with open_browser() as browser:
        yield browser


@pytest.mark.heavy
def test_margins_of_one_channel_stand_beside_the_disk_margin_of_all():
    table = margins_of(rival("FS", "PID"))
    assert [column.header for column in table.columns] == ["quantity", "unit", "tau[0]", "tau[1]", "all at once"]
    rows = {row[0]: row[2:] for row in table.rows}
    linear = wb.linear_loop(rival("FS", "PID"), at_rest=False)
    assert [cell.value for cell in rows["Ms"][:2]] == [one.margins.Ms.gain.value for one in linear.margins().values()]
    assert rows["disk margin"][:2] == ("", "")
    assert rows["disk margin"][2].value == linear.disk_margin.alpha
    assert "all at once" in str(table.notes)


def test_a_loop_that_is_not_stable_has_words_in_the_place_of_margins():
    table = margins_of(loop(Kp=-100.0))
    rows = {row[0]: row[2] for row in table.rows}
    assert isinstance(rows["phase margin"], MissingCell)
    assert rows["phase margin"].words == rows["disk margin"].words == "unstable"
    assert isinstance(rows["largest real part of a pole"], ValueWithError)
    assert rows["largest real part of a pole"].value > 0


def test_a_loop_without_linear_answers_has_the_sentence_and_no_empty_plot():
    blocks = blocks_of(loop(low=0.0, high=24.0))  # it rests where the limit begins
    said = [block.text for block in blocks if isinstance(block, Paragraph)]
    assert [text for text in said if "no linear answers" in text]
    assert not [block for block in blocks if isinstance(block, Figure) and block.name.startswith("linear")]


def test_equations_alone_have_no_linear_pictures():
    names = [block.name for block in blocks_of(loop().ode()) if isinstance(block, Figure)]
    assert names
    assert not [name for name in names if name.startswith("linear")]


def test_a_study_places_the_pictures_with_one_call(tmp_path):
    case = wb.Case("speed", "PI", wb.Run(loop(), (wb.rmse(),), until=0.2, every=0.01, h=1e-2))

    def sections(results):
        return [wb.Section("Margins", wb.loop_gain_pictures(results["speed", "PI"], "speed"))]

    (section,) = sections(case_runs.run(wb.Study("s", "T", "Q?", "M.", sections, cases=(case,))))
    names = [block.name for block in section.blocks if isinstance(block, Figure | ReportTable)]
    assert names == ["speed_margins", "speed_bode", "speed_nyquist", "speed_sensitivity", "speed_poles"]


@pytest.mark.heavy
@needs_chromium
@needs_llvmlite
def test_a_loop_of_two_channels_in_a_computer_draws_each_with_the_other_closed(tmp_path, browser):
    closed = wb.DigitalLoop(rival("FS", "PID"), 0.01)
    shown = wb.live(closed, until=0.1, h=5e-3)
    about = data_of(shown)["loops"][0]["linear"]
    linear = wb.linear_loop(closed, at_rest=False, substeps=2)
    with open_page(shown.write(tmp_path / "arm.html"), browser=browser) as page:
        page.until("Boolean(livePage.data && livePage.motion)")
        page.value("livePage.bench.knobs[0].turn(1.1)")
        page.until(IDLE)
        page.value(received(answer_of(linear, np.array(about["omega"]))))
        page.until("!livePage.late.size && !livePage.away.size && livePage.figures.has('linear_bode')")
        for i in range(2):
            L = 1 / linear.response(about["omega"], "S").values[:, i, i] - 1
            np.testing.assert_allclose(drawn(page, "linear_bode", 0, i)[1], decibels(L), atol=1e-5)
        assert page.complaints == []


@pytest.mark.heavy
@needs_chromium
@needs_llvmlite
def test_a_switch_that_does_not_act_at_rest_leaves_the_loop_its_answer(tmp_path, browser):
    limits = {"low": -24.0, "high": 24.0}  # beyond which alone the integral, which is zero at rest, is clamped
    path = wb.live(loop(**limits), until=0.5).write(tmp_path / "limits.html")
    with open_page(path, browser=browser) as page:
        page.until("Boolean(livePage.data && livePage.motion)")
        turn(page, 350)
        margins = wb.linear_loop(loop(Kp=350.0, **limits)).margins()["v"].margins
        found = page.value("livePage.answers.get(0).answer.margins?.[0].phaseMargin")
        assert found == pytest.approx(margins.phase_margin.value, rel=1e-9)
