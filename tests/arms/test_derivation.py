"""The equations of an arm on paper: every form says the same, in order, and within the page."""

import dataclasses
import json
import re
from functools import cache
from xml.etree import ElementTree

import numpy as np
import pytest
import typst

import workbench as wb
from tests.support.arms import random_arm
from tests.support.cases import heavy_but
from workbench.arms.code.arm_equations import in_numbers
from workbench.arms.dynamics import Dynamics
from workbench.arms.mechanics import SpatialArm, SpatialLink, robot, urdf
from workbench.arms.mechanics.arm_catalogue import planar
from workbench.cli.derive import FORMS, text_of

PAGE = 80 * 5.5  # pt: 80 widths of a digit at 11 pt
INDENT = 11.0  # pt: lines after the first stand by one quad to the right


@pytest.fixture(scope="module")
def long_arm():
    """An arm whose entries are too long for a textbook's form."""
    return Dynamics.of(planar(6), "planar-6r")


@cache
def printed(dynamics, form):
    return text_of(dynamics, form)


def names_in(text):
    return set(re.findall(r"\bw_\d+\b", text))


def test_short_entries_have_the_form_of_a_textbook_and_long_ones_common_parts(long_arm):
    assert not names_in(text_of(Dynamics.of(robot("planar-4r")), "text"))
    assert len(names_in(printed(long_arm, "text"))) > 100


def test_a_common_part_is_defined_once_before_it_is_used_and_in_order(long_arm):
    text = re.sub(r"\n    ", " ", printed(long_arm, "text")).split("\n\n", 2)[2]
    known = []
    for line in filter(None, text.splitlines()):
        left, right = line.split(" = ", 1)
        assert names_in(right) <= set(known)
        known += names_in(left)
    assert known == [f"w_{k}" for k in range(1, len(known) + 1)]


def test_what_common_parts_say_has_the_values_of_the_model(long_arm):
    """The printed text, read by Python's own grammar, against the model."""
    values = {"sin": np.sin, "cos": np.cos}
    q, qd = np.random.default_rng(5).uniform(-2, 2, (2, long_arm.dof))
    values |= {f"q_{i + 1}": x for i, x in enumerate(q)} | {f"qd_{i + 1}": x for i, x in enumerate(qd)}
    names = long_arm.names()
    values |= {names[path]: x for path, x in zip(long_arm.p.labels, long_arm.p.default, strict=True)}
    text = re.sub(r"\n    ", " ", printed(long_arm, "text")).split("\n\n", 2)[2].replace("^", "**")
    for line in filter(None, text.splitlines()):
        left, right = line.split(" = ", 1)
        values[left] = eval(right, {"__builtins__": {}}, values)
    for letter, ours in zip("MCG", long_arm.matrices(q, qd), strict=True):
        places = np.ndindex(ours.shape)
        theirs = [values[f"{letter}_{''.join(str(i + 1) for i in place)}"] for place in places]
        # sums of up to a hundred rounded terms of that size
        np.testing.assert_allclose(np.reshape(theirs, ours.shape), ours, rtol=0, atol=1e-13 * np.abs(ours).max())


@cache
def derived_twice(robot):
    return tuple(Dynamics.of(wb.robot(robot), robot) for _ in range(2))


@pytest.mark.parametrize("robot", heavy_but(["paper-arm", "planar-3r"], "paper-arm"))
@pytest.mark.parametrize("form", FORMS)
def test_every_form_is_printed_in_ascii_and_the_same_again(robot, form):
    said, again = (text_of(model, form) for model in derived_twice(robot))
    assert said.isascii() or form == "mathml"
    assert said == again


@pytest.mark.parametrize("form", ["text", "python", "casadi", "c"])
def test_no_line_of_characters_leaves_the_page(long_arm, form):
    assert max(map(len, printed(long_arm, form).splitlines())) <= {"text": 100}.get(form, 110)


def measured(folder, equations):
    """The widths in pt of equations in Typst, in the fonts of LaTeX."""
    lines = [f"#context [#metadata(measure({equation}).width.pt()) <width>]" for equation in equations]
    page = folder / "page.typ"
    page.write_text("#set text(11pt)\n" + "\n".join(lines), encoding="utf-8")
    return json.loads(typst.query(str(page), "<width>", field="value"))


@pytest.mark.parametrize(
    "robot", heavy_but(["paper-arm", "planar-4r", "planar-6r", "scara", "ur5"], "paper-arm", "scara")
)
def test_no_equation_of_typst_leaves_the_page(tmp_path, robot):
    model = Dynamics.of(wb.robot(robot))
    equations = re.findall(r"^\$ .*? \$$", text_of(model, "typst"), re.DOTALL | re.MULTILINE)
    assert "".join(equations).count(" & = ") >= 2 * model.dof**2 + model.dof
    assert max(measured(tmp_path, equations)) <= PAGE + INDENT


def test_the_typst_file_compiles(long_arm):
    assert typst.compile(printed(long_arm, "typst").encode()).startswith(b"%PDF")


@pytest.mark.heavy
def test_latex_breaks_its_lines_where_typst_does(long_arm):
    """So what was measured in one, which has the other's fonts, holds in the other."""
    latex, other = printed(long_arm, "latex"), printed(long_arm, "typst")
    assert latex.count(r"\begin{align*}") == latex.count(r"\end{align*}") == 4
    assert latex.count("\\\\\n") == other.count("\\\n")


def test_the_page_for_browsers_is_well_formed(long_arm):
    head, page = printed(long_arm, "mathml").split("\n", 1)
    assert head == "<!doctype html>"
    tree = ElementTree.fromstring(f"<html>{page}</html>")
    assert len(tree.findall("math")) == 4
    assert len(tree.findall("table/tr")) == 1 + long_arm.p.size


def test_friction_is_named_where_there_is_any_and_nowhere_else():
    smooth, rough = (link("hinge", viscous=viscous) for viscous in (None, 0.2))
    assert " + F(qd) = tau" not in text_of(Dynamics.of(smooth), "text")
    assert "= tau, n = 1\n# The friction" in text_of(Dynamics.of(rough), "text")
    assert " + F(qd) = tau" in text_of(Dynamics.of(rough), "c")


def link(name, **drive):
    return SpatialArm((SpatialLink(name, 1.0, (0.1, 0.2, 0.3), (0.1, 0.0, 0.0, 0.1, 0.0, 0.1), **drive),))


def test_the_numbers_of_an_arm_may_stand_in_place_of_its_letters():
    printed = text_of(in_numbers(robot("scara"), "scara"), "text")
    assert "M_33 = 3/2" in printed
    assert "m_1" not in printed


HOSTILE = 'x */ """ \\ \n#include <x> ${}\u202e<script>'


@pytest.mark.parametrize("form", FORMS)
def test_a_hostile_name_ends_no_comment_and_begins_no_line(form):
    arm = random_arm(1, np.random.default_rng(0))
    plain, odd = (dataclasses.replace(Dynamics.of(arm), name=name) for name in ("x", HOSTILE))
    plain, odd = text_of(plain, form), text_of(odd, form)
    assert len(odd.splitlines()) == len(plain.splitlines())
    assert "\u202e" not in odd
    assert "<script>" not in odd or form != "mathml"
    assert odd.count("*/") == plain.count("*/")
    assert odd.count('"""') == plain.count('"""')


TILTED = """<robot name="r"><link name="base"/>
<link name="near"><inertial><mass value="1"/><origin xyz="0.1 0 0"/>{inertia}</inertial></link>
<link name="far"><inertial><mass value="{mass}"/><origin xyz="0 0.2 0"/>{inertia}</inertial></link>
<joint name="first" type="revolute"><parent link="base"/><child link="near"/><axis xyz="0 0 1"/></joint>
<joint name="second" type="revolute"><parent link="near"/><child link="far"/>
<origin xyz="0.3 0 0" rpy="0.7 0.2 0.4"/><axis xyz="0 0 1"/></joint></robot>"""


def tilted(mass):
    inertia = '<inertia ixx="0.02" ixy="0" ixz="0" iyy="0.03" iyz="0" izz="0.01"/>'
    return urdf.parse(TILTED.format(mass=mass, inertia=inertia))


def smallest(dynamics):
    """The least number of size that stands in the entries, by the printed digits."""
    body = text_of(dynamics, "text").split("\n\n", 1)[1]
    printed = (float(number) for number in re.findall(r"(?<![_\w.])\d+\.\d+(?:e-\d+)?", body))
    return min(number for number in printed if number)


def test_numbers_bring_no_rounding_dust_with_them():
    assert smallest(Dynamics.of(tilted(0.7), symbolic=False)) < 1e-15  # what doubles leave of a rotation
    assert smallest(in_numbers(tilted(0.7))) > 1e-4


def test_a_true_term_stays_however_small():
    tiny = in_numbers(tilted(1e-19))
    assert 1e-22 < smallest(tiny) < 1e-19
    # G_2 = m g (0.27 cos q_2 - 0.87 sin q_2) / 0.7 of the arm above, whose m is 0.7
    heavy, light = (in_numbers(tilted(mass)).matrices([0.1, 0.5], [0.0, 0.0])[2][1] for mass in (0.7, 1e-19))
    assert light / 1e-19 == pytest.approx(heavy / 0.7, rel=1e-13)


def test_a_sum_of_decimals_is_printed_as_the_decimal_that_it_is():
    assert "M_22 = 0.012672837978\n" in text_of(in_numbers(robot("pelican")), "text")
    assert "M_22 = 4 + " in text_of(in_numbers(robot("planar-4r")), "text")


@pytest.mark.parametrize("robot", ["paper-arm", "pelican", "slotine-li", "cart-pole", "scara", "planar-6r"])
def test_numbers_put_in_exactly_give_what_doubles_give(robot):
    arm = wb.robot(robot)
    q, qd = np.random.default_rng(3).uniform(-2, 2, (2, arm.dof))
    for exact, rounded in zip(in_numbers(arm).matrices(q, qd), Dynamics.of(arm).matrices(q, qd), strict=True):
        np.testing.assert_allclose(exact, rounded, rtol=0, atol=1e-14 * max(1.0, np.abs(rounded).max()))


def test_a_joint_without_a_motor_and_the_units_of_a_slide_are_said():
    model = Dynamics.of(robot("cart-pole"), "cart-pole")
    for form in ("text", "latex", "typst", "c", "python", "casadi"):
        assert "= tau, n = 2, without a motor: tau_2 = 0\n" in text_of(model, form)
    assert "accelerations of the joints, in (m, rad), per s and s^2" in text_of(model, "c")
    assert "what drives the joints, in (N, N m)" in text_of(model, "c")
    assert "without a motor" not in text_of(Dynamics.of(robot("planar-2r")), "text")
