"""Drawings of plants: their places are those of the mechanism, in the symbols of the loop, as plain data."""

import json
import math

import casadi as ca
import control
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from workbench.arms.laws import ArmPID
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import CATALOGUE, robot
from workbench.blocks.loop import AbstractController, AbstractPlant, ClosedLoop, LinearPlant, open_loop
from workbench.blocks.plants import (
    BuckConverter,
    CartPole,
    DCMotor,
    DisturbedPlant,
    EquippedPlant,
    FirstOrder,
    FurutaPendulum,
    PlanarQuadrotor,
    Quadrotor,
    QuadrupleTank,
    SingleTrackVehicle,
    StirredTank,
    TwoMasses,
)
from workbench.blocks.signals import Step
from workbench.core import Circle, Line, Word, block, initial, layout, parameter, with_quadrature
from workbench.core.shapes import project

ARMS = [Manipulator(robot(name), q=np.zeros(robot(name).dof)) for name in sorted(CATALOGUE)]
SEEN = [
    *(CartPole(), FurutaPendulum(), TwoMasses(), DCMotor.position(), PlanarQuadrotor(), Quadrotor()),
    *(QuadrupleTank(), StirredTank(), SingleTrackVehicle(), *ARMS),
]
RANDOM = np.random.default_rng(7)


@block
class Still(AbstractController):
    """The inputs at their defaults, whatever happens."""

    inputs: object
    reads = layout()

    @property
    def drives(self):
        return self.inputs

    def command(self, t, z, est, ref):
        return {entry.name: entry.default for entry in self.inputs.entries}


def title(plant):
    of = f" {plant.arm.links[0]}" if isinstance(plant, Manipulator) else ""
    return type(plant).__name__ + of[:12]


def places(ode, x=None, p=None, t=0.0):
    """The moving coordinates at a state, at defaults unless given."""
    function = ca.Function("places", [ode.t, ode.x, ode.p], [ode.drawing.coordinates])
    x, p = (ode.states.default if x is None else x), (ode.parameters.default if p is None else p)
    return np.array(function(t, x, p)).ravel()


def numbers(shape, values):
    """The coordinates of one shape, moving or not."""
    return np.array(shape["fixed"]) if "fixed" in shape else values[shape["points"]]


def shapes(ode, kind, tone, *point):
    """The coordinates of all shapes of a kind and a tone."""
    values = places(ode, *point)
    held = [shape for shape in ode.drawing.shapes if (shape["kind"], shape["tone"]) == (kind, tone)]
    width = 3 if kind == "circle" else 2
    return [numbers(shape, values).reshape(-1, width) for shape in held]


@pytest.mark.parametrize("plant", SEEN, ids=title)
def test_a_plant_has_a_drawing_of_finite_places_and_plain_data(plant):
    drawing = open_loop(plant).drawing
    values = places(open_loop(plant))
    assert np.isfinite(values).all()
    assert 0 < len(values) <= 150  # of each kept row of a live page
    data = json.loads(json.dumps(drawing.data, allow_nan=False))
    assert (data["view"], data["follow"]) == (None, False)
    for shape in data["shapes"]:
        assert ("fixed" in shape) != ("points" in shape)
        held = shape.get("fixed", shape.get("points"))
        counts = {"circle": {3}, "word": {2}}.get(shape["kind"], range(4, 100, 2))
        assert len(held) in counts
        assert all(0 <= place < len(values) for place in shape.get("points", ()))
        assert shape["tone"] in ("body", "link", "ground", "liquid", "path")
        assert shape.get("width", 0.0) >= 0.0
    assert any("points" in shape for shape in data["shapes"])


@pytest.mark.parametrize(
    "plant",
    [BuckConverter(), DCMotor(), LinearPlant(control.ss(-1.0, 1.0, 1.0, 0.0, inputs=["u"], outputs=["y"]))],
    ids=title,
)
def test_a_plant_without_a_picture_has_no_drawing(plant):
    assert open_loop(plant).drawing is None
    assert ClosedLoop(plant, controller=Still(plant.inputs)).digital(0.1).drawing is None


def test_the_links_of_a_planar_arm_lie_where_its_forward_kinematics_has_them():
    for name, zero in (
        ("paper-arm", -np.pi / 2),
        ("pelican", -np.pi / 2),
        ("slotine-li", 0.0),
        ("planar-4r", -np.pi / 2),
    ):
        arm = robot(name)
        ode = open_loop(Manipulator(arm, q=np.zeros(arm.dof)))
        lengths = np.array([link.length for link in arm.links])
        for q in RANDOM.uniform(-4, 4, (5, arm.dof)):
            angles = zero + np.cumsum(q)
            ends = np.cumsum(np.stack([lengths * np.cos(angles), lengths * np.sin(angles)], axis=1), axis=0)
            rods = shapes(ode, "line", "link", np.concatenate([q, 0 * q]))
            np.testing.assert_allclose([rod[1] for rod in rods], ends, atol=1e-13)
            np.testing.assert_allclose([np.linalg.norm(rod[1] - rod[0]) for rod in rods], lengths, rtol=1e-13)
            (tip,) = shapes(ode, "circle", "path", np.concatenate([q, 0 * q]))
            np.testing.assert_allclose(tip[0, :2], ends[-1], atol=1e-13)


def test_a_turned_length_moves_the_picture_in_any_loop():
    arm = robot("paper-arm")
    plant = Manipulator(arm, q=[0.3, 0.2])
    law = ArmPID([1.0, 1.0], [1.0, 1.0], [1.0, 1.0], model=arm)
    loop = ClosedLoop(plant, controller=law, reference=Step("q", "rad", [1.0, 1.0]))
    for ode in (loop.ode(), loop.digital(0.01).flow, loop.ode(inputs=True), loop.cut()):
        turned = {"plant.arm.links[1].length": 1.5, "controller.model.links[0].length": 3.0}
        rods = shapes(ode, "line", "link", None, ode.parameters.pack(turned)[0])
        np.testing.assert_allclose([np.linalg.norm(rod[1] - rod[0]) for rod in rods], [1.0, 1.5], rtol=1e-13)


def test_wrapped_plants_and_longer_equations_keep_the_drawing():
    cart = CartPole(x=0.2, phi=0.1)
    plain = places(open_loop(cart))
    around = DisturbedPlant(EquippedPlant(cart, (FirstOrder("F", 0.1),)), by=Step("F", "N", 1.0))
    loop = ClosedLoop(around, controller=Still(around.inputs))
    np.testing.assert_array_equal(places(loop.ode()), plain)
    assert loop.digital(0.1).drawing.data == loop.ode().drawing.data
    ode = loop.ode()
    np.testing.assert_array_equal(places(with_quadrature(ode, {"z": ode.x[0]})), plain)
    assert ode.fingerprint == ClosedLoop(around, controller=Still(around.inputs)).ode().fingerprint


def test_a_pole_and_a_furuta_pendulum_keep_their_lengths_and_turn_as_their_equations_say():
    (rod,) = shapes(open_loop(CartPole()), "line", "link", [0.4, 0.0, 0.5, 0.0])
    np.testing.assert_allclose(rod, [(0.4, 0.0), (0.4 - 0.6 * np.sin(0.5), 0.6 * np.cos(0.5))])  # away from +x
    plant = FurutaPendulum()
    turned, raised = np.radians(20.0), np.radians(18.0)
    sight = np.array([-np.sin(turned) * np.cos(raised), np.cos(turned) * np.cos(raised), -np.sin(raised)])
    for theta_1, theta_2 in RANDOM.uniform(-4, 4, (5, 2)):
        arm, pendulum = shapes(open_loop(plant), "line", "link", [theta_1, theta_2, 0.0, 0.0])
        along = np.array([np.cos(theta_1), np.sin(theta_1), 0.0])
        across = np.array([-np.sin(theta_1), np.cos(theta_1), 0.0])
        hang = 2 * plant.l_2 * (np.sin(theta_2) * across - np.cos(theta_2) * np.array([0, 0, 1.0]))
        for line, part in ((arm, plant.L_1 * along), (pendulum, hang)):
            # of a length in space the picture has what lies across the line of sight
            seen = np.linalg.norm(part - sight * (sight @ part))
            np.testing.assert_allclose(np.linalg.norm(line[1] - line[0]), seen, rtol=1e-12)
    # the arm and the pendulum move the way in which the kinetic energy of the equations couples them
    M_12 = plant.m_2 * plant.L_1 * plant.l_2
    assert M_12 * (plant.L_1 * across) @ (2 * plant.l_2 * across) > 0


def test_the_view_of_space_is_that_of_parallel_rays():
    axes = np.hstack([np.array(ca.DM(project(ca.SX(axis)))) for axis in np.eye(3)])
    np.testing.assert_allclose(axes @ axes.T, np.eye(2), atol=1e-15)  # orthonormal rows: a true view
    assert axes[1, 2] > 0.9 < axes[0, 0]  # z is upward and x to the right


def test_the_hinges_of_a_spatial_arm_lie_where_rotations_put_them():
    arm = robot("scara")
    ode = open_loop(Manipulator(arm, q=np.zeros(4)))
    q = [0.4, -0.7, -0.1, 0.2]
    elbow = np.array([0.4 * np.cos(0.4), 0.4 * np.sin(0.4), 0.35])
    seat = elbow + 0.3 * np.array([np.cos(-0.3), np.sin(-0.3), 0.0])
    wanted = [[0, 0, 0.35], elbow, seat + [0, 0, -0.1], seat + [0, 0, -0.25]]
    wanted = [np.array(ca.DM(project(ca.SX(place)))).ravel() for place in wanted]
    rods = shapes(ode, "line", "link", [*q, 0, 0, 0, 0])
    np.testing.assert_allclose([rod[1] for rod in rods[:4]], wanted, atol=1e-14)


def test_quadrotors_tilt_about_their_centres_and_keep_their_beams():
    beam = shapes(open_loop(PlanarQuadrotor()), "line", "link", [1.0, 2.0, 0.3, 0, 0, 0])[0]
    ends = np.array([1.0, 2.0]) + 0.25 * np.outer([-1, 1], [np.cos(0.3), np.sin(0.3)])
    np.testing.assert_allclose(beam, ends)
    state = np.concatenate([[1.0, 2.0, 3.0], [0.2, -0.3, 0.7], np.zeros(6)])
    R = Rotation.from_euler("ZYX", [0.7, -0.3, 0.2]).as_matrix()
    first, second = shapes(open_loop(Quadrotor()), "line", "link", state)[:2]
    for line, axis in ((first, R[:, 0]), (second, R[:, 1])):
        ends = [np.array(ca.DM(project(ca.SX(state[:3] + side * 0.225 * axis)))).ravel() for side in (-1, 1)]
        np.testing.assert_allclose(line, ends, atol=1e-14)


def test_levels_stand_as_high_as_the_water_and_the_car_is_as_long_as_its_axles():
    water = [line for line in shapes(open_loop(QuadrupleTank()), "line", "liquid") if len(line) == 4]
    heights = [np.ptp(line[:, 1]) for line in water]
    np.testing.assert_allclose(heights, [0.124, 0.127, 0.018, 0.014])
    np.testing.assert_allclose(np.pi * (np.ptp(water[0][:, 0]) / 2) ** 2, 28e-4)  # its area in m^2
    car = SingleTrackVehicle(Y=1.0, psi=0.2)
    wheels = [line.mean(axis=0) for line in shapes(open_loop(car), "line", "link")]
    axles = np.mean(wheels[:2], axis=0), np.mean(wheels[2:], axis=0)
    np.testing.assert_allclose(axles[0], [1.1 * np.cos(0.2), 1.0 + 1.1 * np.sin(0.2)])
    np.testing.assert_allclose(np.linalg.norm(axles[0] - axles[1]), 2.68)


class AbstractPendulum(AbstractPlant):
    """A plant to draw."""

    inputs, outputs = layout(tau="N m"), layout(theta="rad")

    def rate(self, t, x, u):
        return {"theta": u.tau / self.l}


def plant_that_draws(answer):
    """A plant of one angle, of which a test says the drawing."""

    @block
    class Pendulum(AbstractPendulum):
        l: float = parameter(default=0.5, unit="m", low=0, strict=True)
        theta: float = initial(default=0.0, unit="rad")

        def drawing(self, t, x):
            return answer(self, x)

    return Pendulum()


def test_a_plant_of_ones_own_draws_itself():
    def answer(own, x):
        tip = (own.l * ca.sin(x.theta), -own.l * ca.cos(x.theta))
        return Line([(0.0, 0.0), tip], width=own.l / 10), Circle(tip, 0.1), Word((0, 1), "A")

    drawing = open_loop(plant_that_draws(answer)).drawing
    line, circle, word = drawing.data["shapes"]
    assert drawing.coordinates.shape == (4, 1)  # a place that two shapes share is there once; and a 0, a radius
    assert line["points"][2:] == circle["points"][:2]
    assert line["width"] == pytest.approx(0.05)
    assert word == {"kind": "word", "tone": "body", "letters": "A", "fixed": [0.0, 1.0]}
    assert open_loop(plant_that_draws(lambda own, x: ())).drawing is None
    assert open_loop(plant_that_draws(lambda own, x: None)).drawing is None


STRANGER = ca.SX.sym("stranger")
BAD = {
    "text": (lambda own, x: "a line", "must return shapes, each a `Line`, a `Circle` or a `Word`"),
    "one alone": (lambda own, x: Line([(0, 0), (1, 1)]), "must return shapes, each"),
    "a number among them": (lambda own, x: (Line([(0, 0), (1, 1)]), 3), r"it returned 3 at \[1\]"),
    "one point": (lambda own, x: (Line([(0, 0)]),), "must be two or more points; got 1"),
    "points in space": (lambda own, x: (Line([(0, 0, 0), (1, 1, 1)]),), "two numbers or expressions"),
    "no points": (lambda own, x: (Line(3.0),), "two or more points"),
    "a word as radius": (lambda own, x: (Circle((0, 0), "big"),), "a number or an expression"),
    "an unknown tone": (lambda own, x: (Circle((0, 0), 1.0, "red"),), "'red'"),
    "no number": (lambda own, x: (Circle((0, math.nan), 1.0),), "finite coordinates"),
    "a width that moves": (lambda own, x: (Line([(0, 0), (1, 1)], width=x.theta),), "widths of parameters alone"),
    "a negative width": (lambda own, x: (Line([(0, 0), (1, 1)], width=-own.l),), "not negative; got -0.5 m"),
    "a stranger": (lambda own, x: (Circle((STRANGER, 0), 1.0),), "the symbol 'stranger'"),
    "sines of numbers": (lambda own, x: (Circle((math.sin(x.theta), 0), 1.0),), "symbols in place of numbers"),
}


@pytest.mark.parametrize(("answer", "told"), BAD.values(), ids=BAD)
def test_a_bad_drawing_is_refused_in_one_sentence(answer, told):
    with pytest.raises(ValueError, match=told) as error:
        open_loop(plant_that_draws(answer))
    assert "\n" not in str(error.value)


def test_a_drawing_that_asks_for_a_signal_that_is_not_there_is_refused():
    with pytest.raises(LookupError, match=r"`Pendulum.drawing\(...\)` asks for a signal"):
        open_loop(plant_that_draws(lambda own, x: (Circle((x.omega, 0), 1.0),)))
