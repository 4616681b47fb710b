"""Numbers that a sheet gives to parameters of the robot, and declarations that are none."""

from fractions import Fraction

import numpy as np
import pytest

from workbench.arms.dynamics import Dynamics
from workbench.arms.mechanics import paper_arm, robot
from workbench.arms.paper_equations.arm_letters import fix_parameters
from workbench.arms.paper_equations.entry_comparison import compare_sheet
from workbench.arms.paper_equations.printed_equations import read_sheet
from workbench.arms.paper_equations.tokens import FormulaError

PAPER = Dynamics.of(paper_arm())
RODS = Dynamics.of(robot("planar-2r"))

NUMBERS = {
    "1 + 1": 2,
    "sqrt(4)": 2,
    "0.1 + 0.2": Fraction(3, 10),
    "2^-2": Fraction(1, 4),
    "sqrt(9/4)/3": Fraction(1, 2),
}


@pytest.mark.parametrize("said", NUMBERS)
def test_a_number_may_be_given_as_a_formula_of_numbers(said):
    assert read_sheet(f"m_2 = {said}\nM_22 = m_2*l_2^2", PAPER, "text").numbers == {"links[1].mass": NUMBERS[said]}


REFUSED = [
    ("links[0].ofset = 0", "there is no 'links[0].ofset' among the numbers of this robot. Did you mean 'links[0]."),
    ("links[7].mass = 3", "there is no 'links[7].mass' among the numbers of this robot. Did you mean 'links["),
    ("links[7].mass = m_1", "there is no 'links[7].mass' among the numbers of this robot."),
    ("k = h*zzz", "line 1, column 5: there is no 'h'"),
    ("k = 1 +", "breaks off after '+'"),
    ("m_2 = m_1", "'m_2' is this robot's letter for links[1].mass, to which a sheet gives a number"),
    ("m_2 = 2*k\nk = 1/2", "'m_2' is this robot's letter for links[1].mass"),
    ("m_2 = pi", "'m_2' is this robot's letter for links[1].mass"),
    ("m_2 = sqrt(2)", "'m_2' of this robot takes one rational number"),
    ("m_2 = [1, 2]", "'m_2' of this robot takes one rational number"),
    ("m_2 = sin(1)", "'m_2' of this robot takes one rational number"),
    ("m_2 = 1 - 1", "'links[1].mass' must be finite, with 0 < value; got 0"),
    ("m_2 = 1e99*1e99", "'links[1].mass' must be zero, or of a size between 1e-99 and 1e99"),
    ("g = 1e-99*1e-99*1e-99*1e-99", "'gravity' must be zero, or of a size between 1e-99 and 1e99"),
]


@pytest.mark.parametrize(("said", "why"), REFUSED)
def test_a_declaration_that_would_say_nothing_or_hold_on_one_side_only_is_refused(said, why):
    with pytest.raises(FormulaError) as refusal:
        read_sheet(f"{said}\nM_22 = 1", PAPER, "text")
    assert why in str(refusal.value)


SHORTHANDS = [
    "c_2 = cos(q_2)\nM_12 = m_2*links[0].length*c_2",
    "c_1 = c_2\nc_2 = cos(theta_2)\nM_12 = m_2*l_1*c_1",
    "l_2 = links[0].length\nM_12 = m_2*l_2*cos(q_2)",
]


@pytest.mark.parametrize("said", SHORTHANDS)
def test_a_letter_of_the_robot_may_be_short_for_a_function_of_the_joints_or_for_another_path(said):
    own = read_sheet(said, RODS, "text").entries
    assert own == read_sheet("M_12 = m_2*l_1*cos(q_2)", RODS, "text").entries


def test_the_line_of_a_witness_replays_on_the_robot_at_the_numbers_that_a_sheet_gives():
    sheet = read_sheet("m_2 = 0.7\nl_2 = 3\nM_22 = m_2*l_2", PAPER, "text")
    (verdict,) = compare_sheet(sheet, fix_parameters(PAPER, sheet.fixed_values))
    assert verdict.witness is not None
    assert "links[1].mass = 0.7, links[1].length = 3" in verdict.evidence
    M, _, _ = PAPER.matrices(verdict.witness.q, verdict.witness.qd, PAPER.p.pack(verdict.witness.changed_parameters)[0])
    assert str({"links[1].mass": 0.7, "links[1].length": 3.0}) in verdict.witness.replay
    np.testing.assert_allclose(M[1, 1], verdict.right_value, rtol=1e-14)  # a few roundings
    np.testing.assert_allclose([verdict.printed_value, verdict.right_value], [2.1, 6.3], rtol=1e-14)


def test_a_witness_leaves_out_what_is_zero_in_the_robot_too():
    sheet = read_sheet("M_22 = m_2*c_2^2 + 2*I_2", RODS, "text")
    assert sheet.zeros == {"links[0].offset", "links[1].offset"}
    (verdict,) = compare_sheet(sheet, fix_parameters(RODS, sheet.fixed_values))
    assert verdict.witness is not None
    assert verdict.witness.changed_parameters == {}
    sheet = read_sheet("links[1].offset = 0.5\nM_22 = m_2*c_2^2 + 2*I_2", RODS, "text")
    (verdict,) = compare_sheet(sheet, fix_parameters(RODS, sheet.fixed_values))
    assert verdict.witness is not None
    assert verdict.witness.changed_parameters == {"links[1].offset": 0.5}
