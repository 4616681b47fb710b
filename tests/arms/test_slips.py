"""The likely slip behind an entry that differs."""

import pytest

from workbench.arms.dynamics import Dynamics
from workbench.arms.mechanics import paper_arm, robot
from workbench.arms.paper_equations.arm_letters import fix_parameters
from workbench.arms.paper_equations.entry_comparison import compare_sheet
from workbench.arms.paper_equations.entry_diagnosis import diagnose, first_wrong, in_common
from workbench.arms.paper_equations.printed_equations import read_sheet

PAPER = Dynamics.of(paper_arm())
PELICAN = Dynamics.of(robot("pelican"))
RODS = Dynamics.of(robot("planar-3r"))


def diagnoses(said: str, arm=PAPER):
    sheet = read_sheet(said, arm, "text")
    derived = fix_parameters(arm, sheet.fixed_values)
    verdicts = compare_sheet(sheet, derived)
    found = diagnose(sheet, verdicts, derived)
    return found, in_common(verdicts, found)


SLIPS = {
    "M_12 = m_2*(l_2^2 - l_1*l_2*cos(q_2))": ("sign", "-l_1*l_2*cos(q_2) has the wrong sign"),
    "G_2 = -m_2*g*l_2*sin(q_1 + q_2)": ("sign", "the whole entry has the wrong sign"),
    "C_21 = m_2*l_1*l_2*sin(q_2)*q_1": ("velocity", "q_1 stands where qd_1 is right"),
    "G_2 = m_2*g*l_2*cos(q_1 + q_2)": ("function", "cos(q_1 + q_2) stands where sin(q_1 + q_2) is right"),
    "G_2 = m_2*g*l_2*sin(q_2)": ("angle", "sin(q_2) stands where sin(q_1 + q_2) is right"),
    "G_2 = m_2*g*l_2*sin(q_1 - q_2)": ("angle", "sin(q_1 - q_2) stands where sin(q_1 + q_2) is right"),
    "C_21 = m_2*l_1*l_2*sin(qd_2)*qd_1": ("angle", "sin(qd_2) stands where sin(q_2) is right"),
    "M_22 = m_1*l_2^2": ("symbol", "m_1 stands where m_2 is right"),
    "M_22 = m_2*l_1^2": ("symbol", "l_1 stands where l_2 is right"),
    "C_21 = m_2*l_1*l_2*sin(q_2)*qd_2": ("symbol", "qd_2 stands where qd_1 is right"),
    "M_12 = m_2*l_2*(l_1 + l_1*cos(q_2))": ("symbol", "l_1 stands where l_2 is right"),
    "C_21 = m_2*l_1^2*sin(q_2)*qd_1": ("symbol", "l_1 stands where l_2 is right"),
    "M_22 = m_2*l_2": ("power", "l_2 stands where l_2^2 is right"),
    "G_2 = m_2*g*l_2^2*sin(q_1 + q_2)": ("power", "l_2^2 stands where l_2 is right"),
    "M_11 = m_1*l_1^2 + m_2*(l_1^2 + l_2^2 + l_1*l_2*cos(q_2))": ("factor", "l_1*l_2*cos(q_2) lacks the factor 2"),
    "M_22 = m_2*l_2^2/3": ("factor", "the whole entry lacks the factor 3"),
    "M_22 = 4*m_2*l_2^2": ("factor", "the whole entry has a factor 4 too many"),
    "C_21 = m_2*l_1*l_2*g*sin(q_2)*qd_1": ("extra", "the whole entry has a factor g too many"),
    "M_12 = m_2*(l_2^2 + l_1*l_2*cos(q_2)) + m_1*l_1": ("extra", "the term m_1*l_1 does not belong here"),
    "C_21 = m_2*l_1*l_2*sin(q_2)": ("missing", "the whole entry lacks the factor qd_1"),
    "C_21 = m_2*l_1*l_2*qd_1": ("missing", "the whole entry lacks the factor sin(q_2)"),
    "G_2 = 1.0005*m_2*g*l_2*sin(q_1 + q_2)": ("scale", "the whole entry is 1.0005 times what is right"),
    "M_12 = m_2*(l_2^2 + 1.0005*l_1*l_2*cos(q_2))": (
        "scale",
        "2001/2000*l_1*l_2*cos(q_2) is 1.0005 times what is right",
    ),
    "C_22 = 1e-8*qd_2": ("extra", "it does not belong here: 0 is right"),
    "M_22 = m_2*l_2^2 + 1e-7*m_1": ("extra", "the term 1/10000000*m_1 does not belong here"),
    "M_12 = m_2*l_1*l_2*cos(q_2)": ("term", "the term m_2*l_2^2 is missing"),
    "C_12 = m_2*(l_2^2 + l_1*l_2*cos(q_2))": ("term", "this is M[1,2], printed in another place"),
}


@pytest.mark.parametrize("said", SLIPS)
def test_each_kind_of_slip_is_named(said):
    ((_, diagnosis),) = diagnoses(said)[0].items()
    assert (diagnosis.slip.kind, diagnosis.slip.description) == SLIPS[said]


def test_a_letter_that_is_wrong_throughout_is_named_once():
    (found,) = diagnoses("M_12 = m_1*l_2^2 + m_1*l_1*l_2*cos(q_2)")[0].values()
    assert found.slip.description == "m_1 stands throughout where m_2 is right"


def test_two_terms_that_became_one_doubled_are_told_apart_again():
    (found,) = diagnoses("G_1 = 2*m_2*g*l_1*sin(q_1) + m_2*g*l_2*sin(q_1 + q_2)")[0].values()
    assert found.slip.description == "m_2 stands where m_1 is right"


def test_a_slip_within_a_long_entry_is_found_in_its_term():
    said = (
        "M_11 = I_1 + I_2 + I_3 + m_1*c_1^2 + m_2*(l_1^2 + c_2^2 + 2*l_1*c_2*cos(q_2)) + m_3*(l_1^2 + l_2^2 + c_3^2"
        " + 2*l_1*l_2*cos(q_2) + 2*l_2*c_3*cos(q_3) + 2*l_1*c_3*cos(q_3))"
    )
    (found,) = diagnoses(said, RODS)[0].values()
    assert found.slip.description == "cos(q_3) stands where cos(q_2 + q_3) is right"


def test_a_sign_that_a_whole_matrix_has_is_said_once_for_all():
    said = "G = [-(m_1 + m_2)*g*l_1*sin(q_1) - m_2*g*l_2*sin(q_1 + q_2), -m_2*g*l_2*sin(q_1 + q_2)]"
    assert diagnoses(said)[1] == ["G as a whole has the wrong sign."]
    half = said.replace("-(m_1", "(m_1").replace("- m_2*g*l_2", "+ m_2*g*l_2")
    assert diagnoses(half)[1] == []


def test_what_no_single_edit_repairs_has_no_slip():
    (found,) = diagnoses("M_11 = m_1*l_2*cos(q_1)")[0].values()
    assert found.slip is None


ROUNDED = "agrees with the right value to the digits printed, at the nominal parameters"


@pytest.mark.parametrize("said", ["M_22 = 0.0127", "M_12 = 0.01267 + 0.01218*cos(q_2)", "G_2 = 0.4596*sin(q_1 + q_2)"])
def test_numbers_that_were_rounded_for_print_are_no_missing_terms(said):
    (found,) = diagnoses(said, PELICAN)[0].values()
    assert found.slip.description == ROUNDED


@pytest.mark.parametrize("said", ["M_22 = 0.0128", "M_22 = 0.01", "M_12 = 0.01267 + 0.01228*cos(q_2)"])
def test_a_number_that_is_wrong_in_a_digit_or_has_only_one_is_not_called_rounded(said):
    (found,) = diagnoses(said, PELICAN)[0].values()
    assert found.slip is None or found.slip.description != ROUNDED


def test_a_letter_that_is_given_as_zero_is_never_meant():
    (found,) = diagnoses("G_1 = 0", PELICAN)[0].values()
    assert found.slip.description == "the whole entry is missing"


H = "h = m_2*l_1*l_2*sin(q_2)"


def test_the_misprint_in_another_factorisation_is_told_from_the_entries_that_are_right_beside_it():
    said = f"C = [[-2*h*qd_2, -h*qd_1], [h*qd_1, 0]]\n{H}"  # h qd_2 in the second place would be right
    found, _ = diagnoses(said)
    assert {label: one.instead for label, one in found.items()} == {"C[1,1]": "C[1,2]", "C[1,2]": ""}
    assert (found["C[1,1]"].slip, found["C[1,2]"].slip.description) == (None, "qd_1 stands where qd_2 is right")
    sheet = read_sheet(said, PAPER, "text")
    assert first_wrong(sheet, compare_sheet(sheet, PAPER), PAPER).label == "C[1,2]"
    repaired = read_sheet(said.replace("-h*qd_1]", "-h*qd_2]"), PAPER, "text")
    assert first_wrong(repaired, compare_sheet(repaired, PAPER), PAPER) is None


def test_two_misprints_in_a_row_stay_two():
    found, _ = diagnoses(f"C = [[-h*q_2, -h*(qd_1 + qd_1)], [h*qd_1, 0]]\n{H}")
    assert [one.slip.kind for one in found.values()] == ["velocity", "symbol"]


def test_right_entries_have_no_diagnosis():
    assert diagnoses("M_22 = m_2*l_2^2") == ({}, [])
