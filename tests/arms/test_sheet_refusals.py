"""A sheet that is none is refused in a sentence, and what stands on it oddly is read for what it is."""

import pytest

from tests.support.cases import heavy_but
from workbench.arms.dynamics import Dynamics
from workbench.arms.mechanics import paper_arm
from workbench.arms.paper_equations.arm_letters import symbols_of
from workbench.arms.paper_equations.entry_comparison import compare_sheet
from workbench.arms.paper_equations.formula_values import normal_form
from workbench.arms.paper_equations.printed_equations import read_sheet
from workbench.arms.paper_equations.tokens import FormulaError

PAPER = Dynamics.of(paper_arm())


def chain(step, start="q_1"):
    """A thousand names, each made from the one before by a step, and an entry that is the last."""
    declared = "".join(f"a_{i} = {step.format(f'a_{i - 1}')}\n" for i in range(1, 1000))
    return f"a_0 = {start}\n{declared}M_11 = a_999"


REFUSED = [
    ("M = [[1, 2, 3], [4, 5, 6], [7, 8, 9]]", "line 1, column 1: M of this robot is 2 by 2; got 3 by 3"),
    ("M[3,1] = 1", "this robot has 2 joints: there is no M[3,1]"),
    ("M[1,1] = [m_1, m_2]", "M[1,1] is one number; got a matrix"),
    ("M[1] = 1", "a row and a column"),
    ("G[1,2] = 1", "G is a vector"),
    ("M[1,1] = m_1\nM_11 = m_2", "line 2, column 1: M[1,1] is printed twice"),
    ("h = m_1\nh = m_2\nM[1,1] = h", "line 2, column 1: 'h' is declared twice"),
    ("a = b\nb = c\nc = a + 1\nM[1,1] = a", "line 1, column 1: 'a' is declared by itself: a needs b needs c needs a."),
    ("a = 2*a\nM[1,1] = a", "'a' is declared by itself: a needs a."),
    ("M_11 = M_12\nM_12 = M_11", "is declared by itself: M_"),
    ("theta_1 = theta_1'\nM_11 = theta_1", "is declared by itself: "),
    (chain("{}", "a_999"), "is declared by itself: "),
    pytest.param(chain("{}", "a_999"), " needs ... needs ", marks=pytest.mark.heavy),
    pytest.param(chain("sin({})"), "more than 100 operations are nested", marks=pytest.mark.heavy),
    pytest.param(chain("{}^16*2"), "powers of powers, go up to 16", marks=pytest.mark.heavy),
    pytest.param(chain("{}*1e99"), "numbers between", marks=pytest.mark.heavy),
    ("m_1 = " + "(" * 12 + "2*3" + ")^16*3" * 12 + "\nM_11 = m_1", "powers of powers, go up to 16"),
    ("M_11 = sqrt(" + "(" * 9 + "2" + "+1)^16" * 9 + ")", "powers of powers, go up to 16"),
    ("M_11 = sin((m_1 + m_2 + l_1 + l_2 + g)^16)", "more than 1000 terms"),
    ("M_11 = 1/(m_1 + m_2 + l_1 + l_2 + g)^16", "more than 1000 terms"),
    ("M_11 = " + "*".join(f"cos({k}*q_1)" for k in range(1, 1100)), "more than 1000 terms"),
    ("h = m_1", "no entry of M, C or G is printed here"),
    ("", "no entry of M, C or G is printed here"),
    ("hello", "line 1, column 1: here stands no statement"),
    ("M[1,1] = m_1\nl_1^2", "line 2, column 1: here stands no statement"),
    ("M[1,1] =", "behind this equals sign stands nothing"),
    ("m_1*l_1 = M[1,1]", "left of '=' stands one name"),
    ("M[x,1] = 1", "one or two whole numbers"),
    ("D = [[m_1, 0], [0, 1]]\nM[1,1] = 2*D", "a matrix under another name"),
    ("links[0].mass = m_2\nM[1,1] = 1", "can be given a number"),
    ("m_1 = -1\nM[1,1] = m_1", "'links[0].mass' must be finite, with 0 < value; got -1"),
    ("M[1,1] = links[0].mas", "there is no 'links[0].mas'"),
    ("M[1,1] = " + "+".join(["m_1"] * 6000), "more than 5000 symbols"),
    ("M[1,1] = " + "*".join(["m_1"] * 6000), "go up to 16"),
    ("M[1,1] = " + "*".join(["1e99"] * 50) + "*m_1", "numbers between"),
    ("M[1,1] = " + "*".join(f"(m_1+{k}*m_2+l_1+l_2+g+q_1+qd_1)" for k in range(9)), "more than 1000 terms"),
    (
        "a_0 = m_1 + l_1\n" + "".join(f"a_{i} = a_{i - 1}*(a_{i - 1} + 1)\n" for i in range(1, 25)) + "M_11 = a_24",
        "5000",
    ),
    ("M[1,1] = " + "m_1" * 20_000, "at most 50000 characters"),
]


@pytest.mark.parametrize(("said", "why"), REFUSED)
def test_what_is_no_sheet_is_refused_in_a_sentence(said, why):
    with pytest.raises(FormulaError) as refusal:
        read_sheet(said, PAPER, "text")
    assert why in str(refusal.value)


@pytest.mark.parametrize(
    ("step", "last"), heavy_but([("{}", "q_1"), ("{} + l_1", "q_1 + 999*l_1"), ("-{}", "-q_1")], ("{}", "q_1"))
)
def test_a_thousand_declarations_of_one_another_are_one_formula(step, last):
    own, by_hand = (read_sheet(said, PAPER, "text").entries["M", 1, 1] for said in (chain(step), f"M_11 = {last}"))
    assert normal_form(own, symbols_of(PAPER)) == normal_form(by_hand, symbols_of(PAPER))


@pytest.mark.parametrize("entry", ["m_1/(l_1 - l_1)", "1/(2 - 2)", "(1 - 3)^(1/2)", "sqrt(0 - 2)", "m_1/(q_1*(1 - 1))"])
def test_an_entry_that_is_a_number_nowhere_is_refused_and_never_taken_for_the_same(entry):
    sheet = read_sheet(f"M[1,1] = {entry}", PAPER, "text")
    with pytest.raises(ValueError, match=r"M\[1,1\] is a number at none of the states"):
        compare_sheet(sheet, PAPER)


def test_a_row_of_c_that_is_printed_in_part_is_judged_beside_the_derived_entries():
    (verdict,) = compare_sheet(read_sheet("C_12 = 0", PAPER, "text"), PAPER)
    assert (verdict.kind, verdict.same_torque) == ("differs", "refuted")
