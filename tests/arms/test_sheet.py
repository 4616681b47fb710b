"""The equations of a paper as one types them, read as entries of an arm."""

import casadi as ca
import numpy as np
import pytest

import workbench as wb
from tests.support.cases import heavy_but
from workbench.arms.code.arm_equations import as_latex
from workbench.arms.dynamics import Dynamics
from workbench.arms.identity_proofs import candidates
from workbench.arms.mechanics import paper_arm, robot, urdf
from workbench.arms.paper_equations.arm_letters import fix_parameters, symbols_of
from workbench.arms.paper_equations.entry_comparison import compare_sheet
from workbench.arms.paper_equations.formula_values import CASADI, evaluate
from workbench.arms.paper_equations.printed_equations import read_sheet
from workbench.arms.paper_equations.tokens import FormulaError
from workbench.core.notation import latex, text
from workbench.core.notation.formula import Matrix, Relation, equations, symbol
from workbench.core.notation.normal_form import NormalForm, to_formula

PAPER = Dynamics.of(paper_arm())
RODS = Dynamics.of(robot("planar-2r"))
CART_POLE = Dynamics.of(robot("cart-pole"))
LINK = """<link name="{0}"><inertial><origin xyz="{1} 0 0"/><mass value="2"/>
<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.2" iyz="0" izz="0.2"/></inertial></link>"""
JOINT = """<joint name="{0}" type="continuous"><parent link="{1}"/><child link="{2}"/>
<origin xyz="{3} 0 0"/><axis xyz="0 0 1"/></joint>"""
PLANAR_URDF = "".join(
    [
        '<robot name="planar"><link name="base"/>',
        LINK.format("upper", 0.4) + LINK.format("lower", 0.3),
        JOINT.format("shoulder", "base", "upper", 0) + JOINT.format("elbow", "upper", "lower", 0.8),
        "</robot>",
    ]
)


def printed(said: str, language="text", arm=PAPER) -> dict[str, str]:
    return {f"{m}{i}{j}": text.emit(f) for (m, i, j), f in read_sheet(said, arm, language).entries.items()}


WAYS = [
    ("M[1,2] = m_2*l_2^2", "text"),
    ("M_12 = m2*l2**2", "text"),
    ("M12 = a; a = m_2*l_2^2", "text"),
    ("M_1_2(q) = m_2*l_2^2.", "text"),
    ("M[1,2] = m_2*\n  (l_2^2)", "text"),
    ("M[1,2] = m_2\n    *l_2^2", "text"),
    ("h = m_2*l_2  # declared before or after\nM[1,2] = h*l_2", "text"),
    ("M[1,2] = h*l_2\nh = m_2*l_2", "text"),
    ("a_2 = links[1].length\nM[1,2] = m_2*a_2^2", "text"),
    ("M[1,2] = links[1].mass*l_2^2", "text"),
    (r"\[ M_{12} = m_2 l_2^2 \]", "latex"),
    (r"$$ M_{1,2} = m_2 l_2^2. $$", "latex"),
    (r"\begin{align} \mathbf{M}_{12}(q) &= m_2 \label{x} \\ & \quad {} \cdot l_2^2 \nonumber \end{align}", "latex"),
    (r"\begin{equation*} h = m_2 l_2, \quad M_{12} = h l_2, \end{equation*}", "latex"),
]


@pytest.mark.parametrize(("said", "language"), WAYS)
def test_an_entry_may_be_written_in_many_ways(said, language):
    assert printed(said, language) == {"M12": "m_2*l_2^2"}


def test_a_matrix_is_all_its_entries_and_a_letter_in_it_may_be_declared_below():
    said = "M = [[M_11, M_12], [M_12, m_2*l_2^2]]\nM_11 = m_1*l_1^2\nM_12 = 0"
    assert printed(said) == {"M11": "m_1*l_1^2", "M12": "0", "M21": "0", "M22": "m_2*l_2^2"}


def test_a_vector_may_stand_upright_or_lie():
    upright = r"G(q) = \begin{bmatrix} m_1 g \\ 0 \end{bmatrix}"
    assert printed("G = [m_1*g, 0]") == printed(upright, "latex") == {"G11": "m_1*g", "G21": "0"}


def test_a_chain_of_equals_signs_is_several_statements():
    assert printed("M_12 = M_21 = m_2") == {"M12": "m_2", "M21": "m_2"}


def test_each_line_of_latex_may_begin_an_equation():
    said = "M_{11} = m_1\n  + m_2\nM_{12}\n = M_{21} =\nm_2\nM_{22} = m_2"
    assert printed(said, "latex") == {"M11": "m_1 + m_2", "M12": "m_2", "M21": "m_2", "M22": "m_2"}


JOINTS = ["qd_1", "qd1", "q_1'", "dq_1", "qdot1", "q1dot", "dtheta_1", "thetad_1"]


@pytest.mark.parametrize("name", JOINTS)
def test_a_velocity_may_be_written_in_many_ways(name):
    assert printed(f"C[2,1] = {name}") == {"C21": "qd_1"}


def test_an_angle_under_another_name_has_a_rate_under_that_name():
    assert printed("phi_1 = q_1\nC[2,1] = phid_1*sin(phi_1)") == {"C21": "qd_1*sin(q_1)"}
    said = r"\[ \varphi_1 = q_1 \] \[ C_{21} = \dot{\varphi}_1 \cos\varphi_1 \]"
    assert printed(said, "latex") == {"C21": "qd_1*cos(q_1)"}


RATES = [
    ("theta_2 = q_1 + q_2", "thetad_2", "qd_1 + qd_2"),
    ("theta_2 = q_1 + q_2", "theta_2'", "qd_1 + qd_2"),
    ("theta_2 = q_1 + q_2", "dtheta_2 + thetadot_2 + theta2dot", "qd_1 + qd_2 + qd_1 + qd_2 + qd_1 + qd_2"),
    ("theta_2 = -q_2", "theta_2'", "-qd_2"),
    ("theta_1 = q_2\ntheta_2 = q_1", "dtheta_1*thetadot_1*thetad_1*theta_1'", "qd_2^4"),
    ("theta_1 = q_2\ntheta_2 = q_1", "q_1'*q_2'", "qd_1*qd_2"),
    ("q_1 = theta_1 - pi/2", "q_1'*theta_1'*thetad_1*qd_1", "qd_1^4"),
    ("theta_2 = (2*phi - q_1)/3\nphi = theta_1 + l_1*q_2", "theta_2'", "(2*(qd_1 + l_1*qd_2) - qd_1)/3"),
    ("theta_2 = l_1 + 1/2", "theta_2'", "0"),
    ("theta_2 = q_1*q_2\nthetad_2 = qd_1*q_2 + q_1*qd_2", "theta_2'", "qd_1*q_2 + q_1*qd_2"),
]


@pytest.mark.parametrize(("declared", "said", "meant"), RATES)
def test_a_declared_angle_has_the_rate_that_follows_from_it(declared, said, meant):
    own = read_sheet(f"{declared}\nM[1,2] = {said}", PAPER, "text").entries["M", 1, 2]
    by_hand = read_sheet(f"M[1,2] = {meant}", PAPER, "text").entries["M", 1, 2]
    values = {letter: ca.SX.sym(name) for letter, name in symbols_of(PAPER).items()}
    assert NormalForm.of(evaluate(own, values, CASADI)) == NormalForm.of(ca.SX(evaluate(by_hand, values, CASADI)))


def test_a_rate_under_a_dot_of_latex_is_that_of_the_declared_angle():
    said = r"\theta_2 = q_1 + q_2 \\ C_{11} = -m_2 l_1 l_2 \dot\theta_2 \sin q_2"
    (verdict,) = compare_sheet(read_sheet(said, PAPER, "latex"), PAPER)
    assert (verdict.kind, verdict.same_torque) == ("differs", "refuted")


@pytest.mark.parametrize("angle", ["q_1*q_2", "sin(q_1)", "q_1/q_2", "q_1^2", "qd_1"])
def test_the_rate_of_what_is_not_linear_in_the_angles_is_refused_by_name(angle):
    with pytest.raises(FormulaError, match="takes the rate of 'theta_2'.*declare it: `thetad_2 = ...`"):
        read_sheet(f"theta_2 = {angle}\nC_11 = dtheta_2", PAPER, "text")


def test_a_declaration_comes_before_the_robots_own_letter():
    assert printed("l_2 = links[0].length\nl_1 = links[1].length\nM_22 = l_1 + 2*l_2") == {"M22": "l_2 + 2*l_1"}


def test_a_number_given_to_a_parameter_holds_for_the_robot_too():
    sheet = read_sheet("m_1 = 2.5\nlinks[1].length = 1/4\nM_22 = m_1*l_2", PAPER, "text")
    assert sheet.fixed_values == {"links[0].mass": 2.5, "links[1].length": 0.25}
    arm = fix_parameters(PAPER, sheet.fixed_values)
    wanted = PAPER.p.pack(sheet.fixed_values)[0]
    np.testing.assert_array_equal(arm.p.default, wanted)
    for one, other in zip(arm.matrices([0.3, 1], [1, 2]), PAPER.matrices([0.3, 1], [1, 2], wanted), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-14)
    assert all(
        (s.p[0], s.p[3]) == (2.5, 0.25) and s.changed_parameters.items() >= sheet.fixed_values.items()
        for s in candidates(arm)
    )


def test_whole_numbers_are_put_into_the_matrices_and_others_keep_their_letter():
    arm = fix_parameters(PAPER, {"links[0].mass": 2.0, "links[1].length": 0.1})
    assert {"links[0].mass", "links[1].length"} & {s.name() for s in ca.symvar(arm.M)} == {"links[1].length"}


def test_what_is_zero_in_the_robot_and_not_on_the_sheet_is_zero():
    said = "M_22 = m_2*c_2^2 + I_2"
    assert set(read_sheet(said, RODS, "text").fixed_values) == {"links[0].offset", "links[1].offset"}
    assert set(read_sheet(f"{said} + m_2*d_2^2", RODS, "text").fixed_values) == {"links[0].offset"}


@pytest.mark.parametrize(
    "robot", heavy_but(["paper-arm", "planar-1r", "planar-2r", "planar-3r"], "paper-arm", "planar-1r")
)
def test_what_is_derived_and_printed_is_proved_right_when_read_again(robot):
    arm = Dynamics.of(wb.robot(robot), robot)
    letters = {name: symbol(said) for name, said in arm.names().items()}
    rows = []
    for matrix in "MCG":
        formula = to_formula(getattr(arm, matrix), letters)
        rows += equations(symbol(matrix), formula if isinstance(formula, Matrix) else Matrix(((formula,),)))
    in_text = "\n".join(text.emit(row) for row in rows)
    for said, language in ((in_text, "text"), (as_latex(arm), "latex")):
        verdicts = compare_sheet(read_sheet(said, arm, language), arm)
        assert {verdict.kind for verdict in verdicts} == {"same"}
        assert len(verdicts) == arm.dof * (2 * arm.dof + 1)


def test_a_matrix_that_is_broken_over_lines_is_read_as_one():
    letters = {name: symbol(said) for name, said in PAPER.names().items()}
    relation = Relation(symbol("M"), "=", to_formula(PAPER.M, letters))
    (said,) = {latex.emit(relation, width=60)} - {latex.emit(relation, width=1000)}
    assert len(read_sheet(said, PAPER, "latex").entries) == 4


def kinds(said: str, arm=PAPER, language="text") -> list[str]:
    """The verdict on each entry, as the command gives it."""
    sheet = read_sheet(said, arm, language)
    return [verdict.kind for verdict in compare_sheet(sheet, fix_parameters(arm, sheet.fixed_values))]


CART = "l = links[1].com[2]\nI = links[1].inertia[3]\n"
CART += "M_12 = m_2*l*cos(q_2)\nM_22 = I + m_2*l^2\nC_12 = -m_2*l*qd_2*sin(q_2)\nG_2 = -m_2*g*l*sin(q_2)"


def test_what_is_zero_in_a_vector_of_a_spatial_arm_and_not_on_the_sheet_is_zero():
    assert read_sheet(CART, CART_POLE, "text").fixed_values == {"links[1].com[0]": 0}
    assert kinds(CART, CART_POLE) == ["same"] * 4
    assert kinds(CART.replace("-m_2*l*qd_2", "m_2*l*qd_2"), CART_POLE) == ["same", "same", "differs", "same"]


@pytest.mark.parametrize("said", ["c_21 = 0", "links[1].com[0] = 0", "c_21 = 0.25 - 1/4"])
def test_a_number_may_be_given_to_a_component_of_a_vector(said):
    sheet = read_sheet(f"{said}\nM_12 = m_2*c_23*cos(q_2)", CART_POLE, "text")
    assert sheet.fixed_values == {"links[1].com[0]": 0}
    arm = fix_parameters(CART_POLE, {"links[1].com[0]": 0.25, "links[1].com[2]": 2.0})
    assert arm.p.labels == CART_POLE.p.labels
    assert arm.names() == CART_POLE.names()
    wanted = CART_POLE.p.pack({"links[1].com[0]": 0.25, "links[1].com[2]": 2.0})[0]
    np.testing.assert_array_equal(arm.p.default, wanted)


def test_a_planar_arm_out_of_urdf_is_held_against_a_textbook():
    arm = Dynamics.of(urdf.parse(PLANAR_URDF))
    said = """a = links[1].position[0]
        b = links[1].com[0]
        I = links[1].inertia[5]
        M_22 = I + m_2*b^2
        M_12 = I + m_2*(b^2 + a*b*cos(q_2))
        C_21 = m_2*a*b*qd_1*sin(q_2)"""
    assert kinds(said, arm) == ["same"] * 3
    assert kinds(said.replace("b^2 + a*b", "b^2 - a*b"), arm) == ["differs", "same", "same"]


DECIMALS = "m_1 = 0.1\nm_2 = 0.1\nl_1 = 0.3\nl_2 = 0.3\n"
FACTORED = "C = [[-0.018*qd_2*sin(q_2), -0.009*qd_2*sin(q_2)], [0.009*qd_1*sin(q_2), 0]]"


def test_decimals_are_the_fractions_that_they_are_printed_as():
    sheet = read_sheet(DECIMALS + FACTORED, PAPER, "text")
    verdicts = compare_sheet(sheet, fix_parameters(PAPER, sheet.fixed_values))
    assert [v.kind for v in verdicts] == ["differs", "differs", "same", "same"]
    assert [v.same_torque for v in verdicts[:2]] == ["proved", "proved"]
    assert kinds("g = 9.81\nm_1 = m_2 = l_1 = l_2 = 1\nG_1 = 9.81*(2*sin(q_1) + sin(q_1 + q_2))") == ["same"]
    assert kinds("m_2 = 0.1\nl_2 = 0.1\nM_22 = 0.001") == ["same"]
    assert kinds("m_2 = 0.1\nl_2 = 0.1\nM_22 = 0.0010001") == ["differs"]


@pytest.mark.parametrize("factor", ["(1 + 1e-17)", "1.0000000000000000001", "(1 - 1e-30)"])
def test_a_factor_that_a_double_takes_for_one_is_never_proved_to_be_one(factor):
    assert kinds(f"M_22 = m_2*l_2^2*{factor}") == ["not refuted"]
    assert kinds("M_22 = m_2*l_2^2*(1 + 1e-17 - 1e-17)") == ["same"]


TURNED = ["cos(q_1 + q_2 - pi/2)", "(-cos(q_1 + 5*pi/2 + q_2))", "(-sin(q_1 + q_2 - 3*pi))", "sin(pi - q_1 - q_2)"]


@pytest.mark.parametrize("sine", TURNED)
def test_quarter_turns_are_taken_off_an_angle(sine):
    assert kinds(f"G_2 = m_2*g*l_2*{sine}") == ["same"]
    assert kinds(f"G_2 = -m_2*g*l_2*{sine}") == ["differs"]
    declared = f"phi = q_1 + q_2 - pi/2\nG_2 = m_2*g*l_2*{sine.replace('q_1 + q_2', 'phi + pi/2')}"
    assert kinds(declared) == ["same"]
