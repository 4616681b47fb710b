"""The pictures of a fit: what speaks against it first, then the numbers, the log beside the model, and residuals."""

import numpy as np
import pytest

import workbench as wb
from workbench.report.pictures.fit_pictures import fit_pictures
from workbench.study.document.document import Figure, Itemize, Paragraph, ReportTable

MOTOR = wb.open_loop(wb.DCMotor())
T = np.linspace(0.0, 3.0, 121)
V = 12.0 * np.sign(np.sin(5.0 * T) + 0.1)


@pytest.fixture(scope="module")
def found():
    e = 0.05 * np.random.default_rng(0).standard_normal((121, 2))
    p = np.array(MOTOR.parameters.default)
    steps = wb.simulate(MOTOR, p, until=0.025, every=0.025)
    assert len(steps.t) == 2
    x = [np.zeros(2)]
    for v in V[:-1]:
        p[-1] = v
        x.append(wb.simulate(wb.rk4(MOTOR, 1e-3), p, x[-1], until=0.025, every=0.025).x[0, -1])
    x = np.array(x) + e
    log = wb.Dataset.of(T, {"v": V, "omega": x[:, 0], "i": x[:, 1]}, {"v": "V", "omega": "rad/s", "i": "A"})
    return wb.fit(MOTOR, log, ["J", "b", "R"])


def test_the_misfit_stands_first_and_every_estimate_has_its_interval(found):
    first, *_, table, outputs, residuals, correlations = fit_pictures(found)
    assert isinstance(first, Paragraph)
    assert isinstance(table, ReportTable)
    assert [row[0] for row in table.rows] == ["J", "b", "R"]
    assert all(row[5] < row[3] < row[6] for row in table.rows)
    assert [len(figure.panels) for figure in (outputs, residuals, correlations)] == [2, 2, 1]
    assert all(isinstance(figure, Figure) for figure in (outputs, residuals, correlations))


def test_warnings_stand_behind_the_misfit(found):
    from dataclasses import replace

    warned = replace(found, remarks=("The clock of the log drifts.",))
    blocks = fit_pictures(warned)
    assert isinstance(blocks[1], Itemize)


def test_the_samples_held_out_are_drawn_apart_and_begin_at_the_line(found):
    outputs = fit_pictures(found)[-3]
    model, fitted, kept = outputs.panels[0].series
    assert (len(model.x), len(fitted.x), len(kept.x)) == (121, 97, 24)
    assert outputs.panels[0].vlines == (kept.x[0],)


def test_each_kind_is_a_picture_of_its_own_and_another_is_refused(found):
    for kind in ("outputs", "residuals", "correlations"):
        assert found.plot(kind).svg.startswith("<svg")
    with pytest.raises(LookupError, match="pictures of a fit"):
        found.plot("bode")
