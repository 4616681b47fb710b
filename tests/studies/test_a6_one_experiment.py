"""The findings of a6 on the printed rows: one experiment for all laws, and what identifies a law."""

from dataclasses import replace

import numpy as np

from studies.a6_unstated_choices import experiments, findings, fits, loops, rows
from studies.paper.card import LAWS
from tests.support.drawn_errors import common_searches, fitted, row, sampled


def test_the_nearest_choice_to_a_row_is_the_one_that_has_it_at_one_horizon():
    t = np.arange(1.0, 31.0)
    ends = np.array([[0.3538, 0.3542], [0.3538, 0.40], [np.nan, np.nan]])  # at 20 s
    values = ends[:, np.newaxis] * np.sqrt((20 + fits.SAMPLE) / (t + fits.SAMPLE))[:, np.newaxis]
    samples = {"FS": sampled(t, values)}
    row = fits.nearest("AOSMC-RGS", "FS", samples)
    assert row[0] < 1e-9
    assert 0.05 < row[1] < 0.07  # between its joints, 12 % apart
    assert np.isinf(row[2])
    assert fits.nearest("AOSMC-RGS", "FS q2", samples)[1] < fits.CLOSE
    np.testing.assert_array_equal(
        experiments.OneRow("AOSMC-RGS", "FS", 20.0)({"fs": samples["FS"]}) < 1e-9, [True, False, False]
    )


def test_the_one_experiment_is_the_same_for_all_laws_and_leaves_open_only_what_is_their_own():
    for law in LAWS:
        loop = experiments.shared_loop(law)
        square = loop.reference.square
        assert (tuple(square.amplitude), square.frequency) == (experiments.AMPLITUDES, experiments.FREQUENCY)
        names = {factor.name for factor in experiments.own(law)}
        assert not names & {"a1", "a2", "f", "rivals' measurements"}
        if law not in (loops.PROPOSED_LAW, loops.PID):
            assert loop.observer.inside == 1.0


def test_the_finding_on_one_experiment_is_met_only_if_all_rows_of_both_scenarios_are():
    near, numbers = dict.fromkeys(LAWS, 0.004), dict.fromkeys(LAWS, "")
    one = experiments.Experiment(9.0, near, numbers)
    good = findings.tables_finding(common_searches(), fitted(0.002), one, one)
    assert good.answer == "met"
    assert good.statement.startswith("One experiment for each scenario gives 12 of the 12")
    # what the page of a2 rests on
    assert all(f"6 of 6 rows of the {scenario} scenario come" in good.evidence for scenario in ("first", "second"))
    assert "+0.5 % and -0.3 %" in good.assumptions  # by how much the amplitudes were moved by hand
    bad = findings.tables_finding(common_searches(), fitted(0.002), one, replace(one, miss=near | {"PID": 0.02}))
    assert not bad.is_decided
    assert "11 of the 12" in bad.statement


def test_a_law_whose_four_cells_are_not_met_by_one_choice_reverses_the_finding_on_the_tables():
    one = experiments.Experiment(9.0, dict.fromkeys(LAWS, 0.004), dict.fromkeys(LAWS, ""))
    met = fitted(0.002)
    met["ASMC", "both"] = replace(met["ASMC", "both"], miss=0.035)
    finding = findings.tables_finding(common_searches(0.0), met, one, one)
    assert [(each.words, each.detail) for each in finding.reversals] == [
        ("all cells, same gains, a separate horizon for each law", "ASMC is the farthest, 3.5 %")
    ]


def test_the_row_identifies_the_law_only_if_one_sign_alone_meets_it():
    def finding(**near):
        every = [row(*case, near.get(case[0].replace(", two repairs", "_two"), 0.2)) for case in rows.CASES]
        return findings.row_finding(common_searches(), every)

    assert "does not identify the law" in finding(plus=0.002, minus=0.2, minus_two=0.001).statement
    assert "only the plus meets" in finding(plus=0.002).statement
    assert "No choice" in finding().statement
    assert not finding().is_decided
    words = [one.words for one in finding().variations]
    assert words[: len(rows.CASES)] == [f"{sign}, {shape}" for sign, shape in rows.CASES]
