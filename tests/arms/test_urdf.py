"""URDF from friends and from strangers."""

import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from workbench.arms.dynamics import Dynamics
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import urdf
from workbench.arms.mechanics.spatial_vectors import from_angles
from workbench.blocks.loop import open_loop
from workbench.design.linear import linearize

ROOT = Path(__file__).parents[2]
LINK = (
    '<link name="{}"><inertial><mass value="{}"/>'
    '<inertia ixx="{}" ixy="0" ixz="0" iyy="{}" iyz="0" izz="{}"/></inertial></link>'
)
JOINT = (
    '<joint name="{}" type="{}"><parent link="{}"/><child link="{}"/>'
    '<origin xyz="0.1 0.2 0.3"/><axis xyz="0 0 1"/></joint>'
)


def link(name="arm", mass="1", x="1", y="1", z="1"):
    return LINK.format(name, mass, x, y, z)


def joint(name="turn", kind="revolute", parent="base", child="arm"):
    return JOINT.format(name, kind, parent, child)


def robot(*parts):
    return f'<?xml version="1.0"?><robot name="r">{"".join(parts)}</robot>'


BASE = '<link name="base"/>'
GOOD = robot(BASE, link(), joint())
ATTRIBUTES = " ".join(f"a{i}='1'" for i in range(150_000))
LAUGHS = "".join(f'<!ENTITY l{i + 1} "{f"&l{i};" * 10}">' for i in range(9))

STRANGE = {
    "empty": ("", "no element found: line 1"),
    "truncated": (GOOD[:200], "is no plain, well-formed XML: unclosed token: line 1"),
    "no XML": ("solid ascii", "syntax error: line 1, column 0"),
    "binary": ("\x00\x01\x02", "is no plain, well-formed XML"),
    "a billion laughs": (f'<!DOCTYPE r [<!ENTITY l0 "ha">{LAUGHS}]><robot>&l9;</robot>', "has a DOCTYPE"),
    "a file as an entity": ('<!DOCTYPE r [<!ENTITY f SYSTEM "file:///etc/passwd">]><robot>&f;</robot>', "DOCTYPE"),
    "an external subset": ('<!DOCTYPE robot SYSTEM "http://localhost/r.dtd"><robot/>', "has a DOCTYPE"),
    "an entity of nobody": (robot("&nbsp;"), "undefined entity"),
    "five thousand deep": ("<a>" * 5000 + "</a>" * 5000, "its root is <a>, and must be <robot>"),
    "deep and never closed": ("<robot>" * 200_000, "no element found"),
    "very long": (robot(" " * 5_000_000), "has more than 2000000 bytes"),
    "very many links": (robot('<link name="x"/>' * 100_000), "has more than 2000 links"),
    "many links": (robot('<link name="x"/>' * 3_000), "has more than 2000 links or 64 moving joints"),
    "many joints": (robot(joint() * 65), "has more than 2000 links or 64 moving joints"),
    "an unknown encoding": ('<?xml version="1.0" encoding="klingon"?><robot/>', "in an encoding that is not known"),
    "another root": ("<sdf/>", "its root is <sdf>, and must be <robot>"),
    "xacro": (
        robot('<x:include xmlns:x="http://ros.org/wiki/xacro" filename="/etc/passwd"/>'),
        "expand it with the program xacro first",
    ),
    "no links": (robot(), "stands on one base, a link that no joint carries; such are none"),
    "no name": (robot("<link/>"), "A <link> needs the attribute 'name'"),
    "a very long name": (robot(link("x" * 1000)), "an attribute 'name' of 1000 characters"),
    "a name of two lines": (robot(link("a&#10;b")), "an attribute 'name' of 3 characters, some not printable"),
    "very many attributes": (f"<robot {ATTRIBUTES}/>", "stands on one base"),
    "one name twice": (robot(link(), link()), "names of links must be unique; 'arm' came more than once"),
    "one joint twice": (robot(BASE, link(), joint(), joint()), "names of joints must be unique; 'turn'"),
    "a loop": (
        robot(link("a"), link("b"), joint("i", child="a", parent="b"), joint("j", child="b", parent="a")),
        "such are none",
    ),
    "a loop aside": (
        robot(BASE, link("a"), link("b"), joint("i", child="a", parent="b"), joint("j", child="b", parent="a")),
        "'a', 'b' carry each other in a loop",
    ),
    "a link on itself": (robot(BASE, link(), joint(parent="arm")), "'arm' carry each other in a loop"),
    "a closed chain": (
        robot(
            BASE, link("a"), link("b"), joint("i", child="a"), joint("j", child="b"), joint("k", child="b", parent="a")
        ),
        "'b' is carried by more than one joint: closed chains",
    ),
    "two bases": (robot(BASE, link()), "stands on one base, a link that no joint carries; such are 'base', 'arm'"),
    "a child of nobody": (robot(BASE, link(), joint(child="arn")), "'arn', which is no link. Did you mean 'arm'?"),
    "nothing that moves": (robot(BASE, link(), joint(kind="fixed")), "needs a joint that moves"),
    "a floating joint": (robot(BASE, link(), joint(kind="floating")), "of type 'floating'; an arm has revolute"),
    "a mimic": (
        GOOD.replace("<axis", '<mimic joint="x"/><axis'),
        "mimics another one; coupled joints are not modelled",
    ),
    "no parent": (GOOD.replace('<parent link="base"/>', ""), "needs a <parent link=...> and a <child link=...>"),
    "two origins": (GOOD.replace("<axis", "<origin/><axis"), "has more than one <origin>"),
    "numbers of two lines": (GOOD.replace("0.1 0.2 0.3", "0.1&#10;x"), "must be 3 numbers with spaces between"),
    "a comma": (
        GOOD.replace('mass value="1"', 'mass value="1,5"'),
        "must be a number, as in '0.5' or '1e-3'; got '1,5'",
    ),
    "not a number": (GOOD.replace('mass value="1"', 'mass value="nan"'), "got 'nan'"),
    "an infinite number": (GOOD.replace('mass value="1"', 'mass value="1e999"'), "mass of link 'arm' must be finite"),
    "a hexadecimal": (GOOD.replace('mass value="1"', 'mass value="0x10"'), "got '0x10'"),
    "an underscore": (GOOD.replace('mass value="1"', 'mass value="1_0"'), "got '1_0'"),
    "code": (GOOD.replace('mass value="1"', 'mass value="__import__(1)"'), "must be a number"),
    "two numbers": (GOOD.replace("0.1 0.2 0.3", "0.1 0.2"), "must be 3 numbers with spaces between"),
    "a negative mass": (
        GOOD.replace('mass value="1"', 'mass value="-1"'),
        "finite and not negative; got -1 kg",
    ),
    "an inertia of no mass": (GOOD.replace('mass value="1"', 'mass value="0"'), "belongs to no mass"),
    "no mass that moves": (
        robot(BASE, '<link name="arm"/>', joint()),
        "'arm' is moved by joint 'turn' and has no mass",
    ),
    "a negative moment": (robot(BASE, link(x="-1"), joint()), "must be positive definite"),
    "an impossible moment": (robot(BASE, link(z="3"), joint()), "belongs to no body"),
    "an impossible moment of the base": (robot(link("base", z="3"), link(), joint()), "inertia of link 'base' belongs"),
    "half an inertial": (
        robot(BASE, '<link name="arm"><inertial/></link>', joint()),
        "needs a <mass> and an <inertia>",
    ),
    "no axis": (GOOD.replace("0 0 1", "0 0 0"), "must be a unit vector, as q counts along it; its length is 0"),
    "a long axis": (GOOD.replace("0 0 1", "0 0 2"), "its length is 2"),
    "an axis beyond squares": (GOOD.replace("0 0 1", "0 1e300 1e300"), "its length is 1.41421e+300"),
    "a point on its axis": (robot(BASE, link(x="0", y="0", z="0"), joint()), "M must be positive definite"),
}


@pytest.mark.parametrize("case", STRANGE)
def test_a_strange_file_is_refused_in_one_sentence_and_at_once(tmp_path, case):
    text, says = STRANGE[case]
    file = tmp_path / "r.urdf"
    file.write_text(text, encoding="utf-8")
    began = time.process_time()
    with pytest.raises(ValueError) as refusal:
        urdf.read_urdf(file)
    assert time.process_time() - began < 2
    assert says in str(refusal.value)
    assert str(refusal.value).startswith(f"'{file}'")
    assert len(str(refusal.value)) < 500
    assert "\n" not in str(refusal.value)


def test_a_file_that_is_none_and_a_text_that_is_none_are_refused(tmp_path):
    os.mkfifo(tmp_path / "pipe")  # which would wait for a writer
    for file in (tmp_path / "nowhere.urdf", tmp_path, tmp_path / "pipe", "/dev/zero"):
        with pytest.raises(LookupError, match="There is no file"):
            urdf.read_urdf(file)
    with pytest.raises(ValueError, match="must be a path that a file can have"):
        urdf.read_urdf("nul\0")
    with pytest.raises(ValueError, match=r"`read_urdf\(file=...\)` must be text or a `Path`; got None"):
        urdf.read_urdf(None)
    with pytest.raises(ValueError, match=r"`parse\(text=...\)` must be text; got 3"):
        urdf.parse(3)


HOSTILE = """
import codecs, sys
from tests.arms.test_urdf import GOOD, STRANGE
from studies.performance.processes import most_memory
from workbench.arms.mechanics import urdf
mesh = '<visual><geometry><mesh filename="file:///etc/passwd"/></geometry></visual>'
urdf.parse(GOOD)
try:
    codecs.lookup('klingon')
except LookupError:
    opened = []
sys.addaudithook(lambda event, args: opened.append(args[0]) if event == 'open' else None)
assert urdf.parse(GOOD.replace('<inertial>', mesh + '<inertial>')).dof == 1
for text, _ in STRANGE.values():
    try:
        urdf.parse(text)
    except ValueError:
        continue
    raise SystemExit('read')
found = list(opened)
print(len(found), most_memory(), found)
"""


def test_neither_a_mesh_nor_strange_text_opens_a_file_or_takes_much_memory():
    done = subprocess.run([sys.executable, "-c", HOSTILE], cwd=ROOT, capture_output=True, text=True, check=True)
    opened, most, _ = done.stdout.split(maxsplit=2)
    assert int(opened) == 0, done.stdout
    assert float(most) < 500e6


def test_what_is_fixed_to_a_link_weighs_as_a_part_of_it():
    tool = link("tool", "2", "0.1", "0.2", "0.25").replace("<mass", '<origin xyz="0.1 0 0"/><mass')
    place = f'<origin xyz="0 0.5 0" rpy="0 0 {np.pi / 2}"/>'
    fixed = f'<joint name="f" type="fixed"><parent link="arm"/><child link="tool"/>{place}</joint>'
    arm = urdf.parse(robot(BASE, link(), tool, joint(), fixed))
    assert arm.links[0].mass == 3
    np.testing.assert_allclose(arm.links[0].com, [0, 2 * 0.6 / 3, 0], atol=1e-16)
    # about z: 1 + 0.25, and Steiner's terms of the tool at y = 0.6 and of the arm at 0, about the common centre at 0.4
    np.testing.assert_allclose(arm.links[0].inertia[5], 1.25 + 2 * 0.2**2 + 1 * 0.4**2, rtol=1e-15)
    # the tool's own x and y have changed places
    np.testing.assert_allclose(arm.links[0].inertia[0], 1 + 0.2 + 2 * 0.2**2 + 1 * 0.4**2, rtol=1e-15)


def test_a_chain_of_fixed_joints_moves_the_joints_after_it():
    place = '<origin xyz="0 0 1" rpy="0.3 -0.2 0.7"/>'
    fixed = f'<joint name="f" type="fixed"><parent link="base"/><child link="flange"/>{place}</joint>'
    flange = f'<link name="flange"/>{fixed}'
    arm = urdf.parse(robot(BASE, link(), flange, joint(parent="flange")))
    R = from_angles(0.3, -0.2, 0.7)
    np.testing.assert_allclose(arm.links[0].position, [0, 0, 1] + R @ [0.1, 0.2, 0.3], rtol=1e-15)
    np.testing.assert_allclose(arm.links[0].rotation, R, rtol=1e-15)


def test_branches_are_numbered_along_the_tree_whatever_the_order_of_the_file():
    links = [link(name) for name in ("a", "b", "c")]
    joints = [joint("third", child="c"), joint("second", child="b", parent="a"), joint("first", child="a")]
    arm = urdf.parse(robot(*joints, *links, BASE))
    assert [(one.name, one.parent) for one in arm.links] == [("third", -1), ("first", -1), ("second", 1)]


def test_friction_is_read_where_there_is_any():
    text = robot(BASE, link(), joint().replace("<axis", '<dynamics damping="0.5" friction="0"/><axis'))
    (only,) = urdf.parse(text).links
    assert (only.viscous, only.coulomb) == (0.5, None)


def test_an_axis_of_printed_digits_is_made_a_unit_vector_and_x_is_the_default():
    (only,) = urdf.parse(GOOD.replace("0 0 1", "0.57735 0.57735 0.57735")).links
    np.testing.assert_allclose(only.axis, np.full(3, 1 / np.sqrt(3)), rtol=1e-15)
    (only,) = urdf.parse(GOOD.replace('<axis xyz="0 0 1"/>', "")).links
    np.testing.assert_array_equal(only.axis, [1, 0, 0])


def test_gravity_pulls_along_minus_z_of_the_root_link():
    text = robot(BASE, link(), joint(kind="prismatic"))
    _, _, G = Dynamics.of(urdf.parse(text, gravity=3.0)).matrices([0.4], [0.0])
    np.testing.assert_allclose(G, [3.0], rtol=1e-15)


def test_a_byte_order_mark_and_comments_are_no_trouble(tmp_path):
    file = tmp_path / "r.urdf"
    file.write_bytes(b"\xef\xbb\xbf" + GOOD.replace("<robot", "<!-- head --><robot").encode())
    assert urdf.read_urdf(str(file)).dof == 1


def test_a_joint_can_be_named_passive():
    second = joint("hinge", parent="arm", child="load")
    text = robot(BASE, link(), joint(), link("load"), second)
    assert urdf.parse(text).motors == (0, 1)
    assert urdf.parse(text, passive=("turn",)).motors == (1,)
    with pytest.raises(LookupError, match=r"no 'tun' among the 2 joints of this arm. Did you mean 'turn'\?"):
        urdf.parse(text, passive=("tun",))


def test_what_the_base_weighs_moves_nothing():
    heavy, plain = (urdf.parse(robot(base, link(), joint())) for base in (link("base", "9"), BASE))
    states = ([0.3], [0.4])
    for a, b in zip(Dynamics.of(heavy).matrices(*states), Dynamics.of(plain).matrices(*states), strict=True):
        np.testing.assert_array_equal(a, b)


RUBBING = robot(BASE, link(), joint().replace("<axis", '<dynamics damping="0.5" friction="2"/><axis'))


def test_coulomb_friction_is_smoothed_by_the_argument_that_the_refusal_names():
    x = np.zeros(2)
    with pytest.raises(ValueError, match=r"jumps by 4 .* \(of friction from a file: `friction_speed=...`\)"):
        linearize(open_loop(Manipulator(urdf.parse(RUBBING), [0.0])), 0.0, x)
    smooth = urdf.parse(RUBBING, friction_speed=0.1)
    # M = 1 about the axis z: damping 0.5, and the slope 2 / 0.1 of the friction
    assert linearize(open_loop(Manipulator(smooth, [0.0])), 0.0, x).A[1, 1] == pytest.approx(-20.5, rel=1e-14)
    fast = Dynamics.of(smooth).torque([0.0], [5.0], [0.0])  # tanh(50) is 1
    np.testing.assert_allclose(fast, Dynamics.of(urdf.parse(RUBBING)).torque([0.0], [5.0], [0.0]), rtol=1e-15)


def test_a_friction_speed_must_be_positive():
    with pytest.raises(ValueError, match=r"`read_urdf\(friction_speed=...\)` must be a positive"):
        urdf.parse(RUBBING, friction_speed=0.0)
