"""The predictive law of d2 in both settings: derived sweeps, sweeps that a tolerance needs, proofs, a published law."""

import numpy as np
import pytest

import workbench as wb
from studies.d2_planning import settings_section
from studies.d2_planning.certificates import PIECES, Conflict, Piece, prove_conflict, published_piece
from studies.d2_planning.designs import BY_KEY, TUNED
from studies.d2_planning.posed_problems import INFEASIBLE, MIDDLE, POSED, PUBLISHED
from studies.d2_planning.predictive import LEVEL, MANY_SWEEPS, design_of, design_record, predictive_law
from studies.d2_planning.problems import PROBLEMS
from studies.d2_planning.settings import COUNTS, TOLERANCE, Errors, Settings, compare_settings
from workbench.study import Results

PRINTED = 6e-5  # half of the last printed digit of the published gains, and some rounding
CERTIFIED = 1e-8  # what a certificate of the exact solver promises


@pytest.mark.heavy
def test_the_judged_law_has_the_sweeps_of_its_design_and_candidates_have_many():
    problem = PROBLEMS["quadrotor"]
    design = design_of(problem, MIDDLE)
    judged, tuned = (law.block(problem, {**MIDDLE, "load": 1.0}).law for law in (BY_KEY["mpc"], TUNED["mpc"]))
    assert judged.sweeps == design.numbers.sweeps < MANY_SWEEPS == tuned.sweeps
    assert judged.residual_bounds.high == pytest.approx(2 * design.evidence.largest_residual, abs=1e-5)
    record = design_record(problem, MIDDLE, 1.0, 0.9)
    assert (record.sweeps, record.largest_error) == (design.numbers.sweeps, design.evidence.largest_error)


@pytest.mark.heavy
def test_a_design_for_tight_limits_has_its_sample_there_and_the_law_the_limits_of_its_loop():
    problem = PROBLEMS["quadrotor"]
    tight = MIDDLE | {LEVEL: problem.levels[0]}
    highest = design_of(problem, tight).problem.rows.high + problem.u0
    np.testing.assert_allclose(highest, problem.levels[0] * np.array(problem.high))
    np.testing.assert_array_equal(predictive_law(problem, tight).target.high, problem.high)


def test_both_settings_of_a_published_law_agree_with_what_is_promised():
    one = compare_settings(PUBLISHED)
    assert one.few.sweeps < one.many.sweeps
    assert one.few.largest_move > TOLERANCE >= one.many.largest_move
    assert one.late == 0.0
    assert one.few.median_move <= one.few.largest_move
    assert max(one.violation, one.sign, one.gap) <= CERTIFIED
    assert one.moves > one.loops  # limits matter in more than a period of a loop


@pytest.mark.parametrize("name", PIECES)
def test_a_piece_of_the_published_law_has_its_printed_numbers_in_both_settings(name):
    piece = published_piece(name)
    assert max(piece.exact, piece.few) < PRINTED


@pytest.mark.heavy
@pytest.mark.parametrize("name", INFEASIBLE)
def test_an_infeasible_state_is_proved_so_and_each_named_limit_is_needed(name):
    conflict = prove_conflict(name)
    assert conflict.is_proved
    assert conflict.needed_count == len(conflict.limits) > 1


def test_a_conflict_names_the_limits_of_inputs_rather_than_those_of_other_states():
    tanks = next(name for name in INFEASIBLE if name.startswith("four tanks"))
    assert prove_conflict(tanks).limits == ("v_1", "v_2", "h_1")  # 'v_1', 'h_1' and 'h_2' conflict, too


def test_the_section_says_where_no_number_of_sweeps_is_enough():
    few, many = Errors(3, 1e-16, 0.5, 0.1, 1e-7, 0.01), Errors(COUNTS[-1], 0.0, 1e-3, 0.0, 0.0, 1e-5)
    one = Settings("ADMM", 300, 40, few, many, 0.01, 1e-15, 0.0, 2e-15, 4)
    works = {
        "settings": (one,) * len(POSED),
        "conflicts": (Conflict(("F", "x"), 0.1, True, 2),) * len(INFEASIBLE),
        "published": (Piece(1e-5, 1e-5),) * len(PIECES),
    }
    _, _, settings, conflicts, law = settings_section.section(Results(works=works)).blocks
    assert settings.rows[0][1:8] == ("design", "3", "0", "5e-01", "10 %", "1e-07", "1e-02")
    assert settings.rows[1][:3] == ("ADMM, 300 moves", "1e-8", f"> {COUNTS[-1]}")
    assert settings.rows[2][:3] == ("4 changes of the active set", "exact", "25")
    assert settings.rows[2][-1] == "2e-15"
    assert conflicts.rows[0][1:] == ("F and x", 0.1, "exact arithmetic", "2 of 2")
    assert isinstance(law, wb.document.ReportTable)
