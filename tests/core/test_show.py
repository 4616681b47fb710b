"""What a notebook shows of our objects."""

from xml.etree import ElementTree

from workbench.arms.dynamics import Dynamics
from workbench.arms.laws import SlidingMode
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.arms.mechanics.arm_catalogue import planar
from workbench.arms.observers import ArmFullState
from workbench.blocks.loop import ClosedLoop, open_loop
from workbench.blocks.signals import Sines
from workbench.core import block, parameter


def parsed(html: str) -> ElementTree.Element:
    """The markup as a tree: it must be well formed."""
    return ElementTree.fromstring(f"<div>{html}</div>")


def test_dynamics_show_their_three_matrices_in_mathml():
    tree = parsed(Dynamics.of(paper_arm())._repr_html_())
    assert len(tree.findall("math")) == 3
    assert {node.text for node in tree.iter("mi")} >= {"M", "C", "G", "m", "l", "q"}


def test_dynamics_with_long_entries_show_the_parts_that_these_share():
    tree = parsed(Dynamics.of(planar(5))._repr_html_())
    assert len(tree.findall("math")) == 4
    assert "w" in {node.text for node in tree.iter("mi")}


def test_a_block_shows_its_numbers_choices_and_parts():
    law = SlidingMode(paper_arm(), Lambda=[6.0, 6.0], K=[5.0, 5.0], phi=0.01)
    tree = parsed(law._repr_html_())
    shown = "".join(tree.itertext())
    for word in ("SlidingMode", "Lambda", "[6, 6]", "rad/s", "clip", "PlanarArm"):
        assert word in shown


def test_an_ode_shows_its_states_and_parameters():
    shown = "".join(parsed(open_loop(Manipulator(paper_arm(), q=[0.0, 0.0]))._repr_html_()).itertext())
    assert "qd" in shown
    assert "arm.links[1].mass" in shown


def test_a_whole_loop_shows_itself():
    loop = ClosedLoop(
        Manipulator(paper_arm(), q=[0.0, 0.0]),
        ArmFullState(2),
        SlidingMode(paper_arm(), Lambda=[6.0, 6.0], K=[5.0, 5.0], phi=0.01),
        Sines("q", "rad", [1.0, 0.5], [2.0, 3.0]),
    )
    shown = "".join(parsed(loop._repr_html_()).itertext())
    assert "Manipulator" in shown
    assert "amplitude" in shown


def test_a_hostile_unit_is_shown_as_text():
    @block
    class Odd:
        x: float = parameter(default=1.0, unit="<script>alert(1)</script>")

    html = Odd()._repr_html_()
    assert "<script>" not in html
    assert "&lt;script&gt;" in html
