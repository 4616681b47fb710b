"""Linear systems of python-control in the sockets of a loop, as they stand."""

import control
import numpy as np
import pytest

from workbench.blocks.loop import AbstractReference, ClosedLoop, LinearFilter, LinearLaw, LinearPlant, open_loop
from workbench.core import LinearSystem, block, layout, parameter, rk4
from workbench.engine import simulate

PERIOD = 0.1
PLANT = control.tf([1, 2], [1, 1, 3], inputs="v", outputs="omega", name="motor")
PI = control.tf([2.0, 3.0], [1.0, 0.0], inputs="omega", outputs="v", name="pi")
TUSTIN = control.c2d(PI, PERIOD, "tustin")
ROUNDING = 1e-12  # some hundred operations on numbers of order one


@block
class Level(AbstractReference):
    """A speed that is wanted from the start."""

    level: float = parameter(1.0, unit="rad/s")
    gives = layout(omega="rad/s")

    def at(self, t):
        return {"omega": self.level}


def their_samples(until):
    """python-control's own discrete closed loop, at its instants."""
    loop = control.feedback(control.c2d(PLANT, PERIOD, "zoh") * TUSTIN, 1)
    return control.step_response(loop, np.arange(0, until + PERIOD / 2, PERIOD)).outputs


def our_samples(plant, substeps):
    loop = ClosedLoop(plant, controller=LinearLaw(TUSTIN, error=True), reference=Level())
    return simulate(loop.digital(PERIOD).step(substeps), until=5.0, every=PERIOD)["omega"][0, :, 0]


def test_a_discrete_law_gives_the_samples_of_python_controls_discrete_loop():
    plant = control.c2d(PLANT, PERIOD, "zoh")
    np.testing.assert_allclose(our_samples(plant, 1), their_samples(5.0), rtol=0, atol=ROUNDING)


def test_a_continuous_plant_gives_the_same_samples_by_enough_runge_kutta_steps():
    # of order four: 64 steps of 1.6 ms at modes of 1.7 rad/s leave (1.7 * 1.6e-3)^4 / 120, below 1e-12
    np.testing.assert_allclose(our_samples(PLANT, 64), their_samples(5.0), rtol=0, atol=ROUNDING)


def test_a_continuous_loop_is_python_controls_feedback():
    ode = ClosedLoop(PLANT, controller=LinearLaw(PI, error=True), reference=Level()).ode()
    times = np.linspace(0, 5, 51)
    theirs = control.step_response(control.feedback(PLANT * PI, 1), times).outputs
    ours = simulate(rk4(ode, 1e-3), until=5.0, every=0.1)["omega"][0, :, 0]
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-11)  # of order four at 1 ms


def test_an_input_called_by_what_is_wanted_follows_it():
    law = LinearLaw(control.ss([], [], [], [[2.0, -3.0]], inputs=["omega_ref", "omega"], outputs="v"))
    ode = ClosedLoop(PLANT, controller=law, reference=Level(4.0)).ode()
    assert (law.follows.names, law.reads.names) == (("omega",), ("omega",))
    out = ode.outputs_at(0.0, [0.5, 0.25])
    np.testing.assert_allclose(out["v"], 2 * 4.0 - 3 * (1 * 0.5 + 2 * 0.25))


def test_a_law_acts_about_its_operating_point():
    gain = control.ss([], [], [], [[-2.0]], inputs="omega", outputs="v")
    ode = ClosedLoop(PLANT, controller=LinearLaw(gain, u0=[7.0], v0=[1.0])).ode()
    assert ode.outputs_at(0.0, [1.0, 0.0])["v"] == 7.0
    assert ode.outputs_at(0.0, [2.0, 0.0])["v"] == 5.0


def test_the_numbers_of_a_system_are_parameters_of_the_loop():
    ode = ClosedLoop(PLANT, controller=LinearLaw(PI, error=True), reference=Level()).ode()
    twice = ode.parameters.pack({"plant.system.C": 2 * np.array([[1.0, 2.0]])})[0]
    assert ode.outputs_at(0.0, [1, 0, 0], twice)["omega"] == 2.0
    assert "plant.system.D" not in ode.parameters


def test_names_are_kept_and_units_may_be_given():
    plant = control.ss(-np.eye(2), np.eye(2), np.eye(2), 0, inputs=["F[0]", "F[1]"], outputs=["p", "v"])
    system = LinearSystem.of(plant, units={"F": "N", "v": "m/s"})
    assert [(e.name, e.size, e.unit) for e in system.inputs.entries] == [("F", 2, "N")]
    assert [(e.name, e.unit) for e in system.outputs.entries] == [("p", "?"), ("v", "m/s")]
    with pytest.raises(LookupError, match="There is no 'w' among the 4 states, inputs and outputs"):
        LinearSystem.of(plant, units={"w": "N"})


def test_a_plant_in_the_wrong_unit_is_refused():
    plant = LinearPlant(LinearSystem.of(PLANT, units={"omega": "m/s"}))
    law = LinearLaw(LinearSystem.of(PI, units={"omega": "rad/s"}), error=True)
    with pytest.raises(ValueError, match=r"`LinearLaw` reads 'omega' in \[rad/s\], where .* gives it in \[m/s\]"):
        ClosedLoop(plant, controller=law, reference=Level())


def test_a_plant_starts_where_it_is_told():
    ode = open_loop(LinearPlant(PLANT, start=[1.0, -1.0]))
    np.testing.assert_array_equal(ode.states.default, [1.0, -1.0])
    with pytest.raises(ValueError, match=r"`LinearPlant\(start=...\)` must have shape \(2,\)"):
        LinearPlant(PLANT, start=[1.0])


@pytest.mark.parametrize("period", [None, PERIOD])
def test_an_observer_of_python_control_estimates_as_its_matrices_say(period):
    space = control.ss(control.ss(PLANT) if period is None else control.c2d(control.ss(PLANT), PERIOD))
    A, B, C = space.A, space.B, space.C
    L = np.array([[0.3], [0.2]])
    names = {"inputs": ["omega", "v"], "outputs": ["x1", "x2"]}
    observer = control.ss(A - L @ C, np.hstack([L, B]), np.eye(2), 0, space.dt, **names)
    law = LinearLaw(control.ss([], [], [], [[-1.0, -0.5]], inputs=["x1", "x2"], outputs="v"))
    loop = ClosedLoop(LinearPlant(space, start=[1, 0]), observer, law)
    assert (loop.observer.reads.names, loop.observer.inputs.names) == (("omega",), ("v",))
    whole = control.ss(np.block([[A, B @ [[-1, -0.5]]], [L @ C, A - L @ C + B @ [[-1, -0.5]]]]), np.zeros((4, 1)),
                       np.hstack([C, 0 * C]), 0, space.dt)  # fmt: skip
    times = np.arange(0, 3.05, 0.1)
    theirs = control.initial_response(whole, times, [1, 0, 0, 0]).outputs
    step = rk4(loop.ode(), 1e-3) if period is None else loop.digital(PERIOD).step()
    ours = simulate(step, until=3.0, every=0.1)["omega"][0, :, 0]
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-11)  # of order four at 1 ms


def test_a_lqg_controller_closes_the_loop_as_it_stands():
    from workbench.design.riccati import lqg

    space = control.ss(PLANT)
    space.update_names(inputs="v", outputs="omega")
    ours = lqg(space, np.eye(2), [[1.0]], np.eye(2), [[1.0]])
    ode = ClosedLoop(space, controller=ours.controller).ode()
    poles = np.linalg.eigvals(np.array(ode.A(0, ode.states.default, ode.parameters.default)))
    np.testing.assert_allclose(np.sort_complex(poles), np.sort_complex(ours.poles), atol=1e-9)  # four simple poles


def one(D=0.0, dt=0, **names):
    return control.ss(-1.0, 1.0, 1.0, D, dt, name="one", **({"inputs": "v", "outputs": "omega"} | names))


NAMELESS = {"inputs": None, "outputs": None}
REFUSED = [
    (lambda: LinearPlant(one(D=2.0)), "algebraic one: its output 'omega' follows its input 'v' by D = 2"),
    (lambda: LinearPlant(one(D=2.0, dt=0.1)), "algebraic one: its output 'omega' follows its input 'v' by D = 2"),
    (lambda: ClosedLoop(one(D=2.0), controller=TUSTIN), "its output 'omega' follows its input 'v' by D = 2"),
    (lambda: LinearPlant(one(inputs=None)), r"'u\[0\]' of 'one' is python-control's own. Give inputs=\[...\]"),
    (lambda: LinearPlant(one(outputs=None)), r"'y\[0\]' of 'one' is python-control's own. Give outputs=\[...\]"),
    (lambda: LinearSystem.of(one(), inputs=["a", "b"]), r"of\(inputs=...\)` must be 1 names.*got \('a', 'b'\)"),
    (lambda: LinearLaw(one(dt=True)), r"must be the period in s of 'one', a discrete system that says none"),
    (lambda: LinearSystem.of(one(), dt=0.1), r"'one' is continuous: sample it by `wb.c2d\(system, dt\)`; got 0.1"),
    (lambda: LinearSystem.of(one(dt=0.2), dt=0.1), "'one' has 0.2 s"),
    (
        lambda: LinearPlant(control.ss(np.inf, 1, 1, 0, name="odd", inputs="v", outputs="w")),
        "`LinearSystem\\(A=...\\)` must be finite",
    ),
    (lambda: LinearPlant(control.tf([np.nan], [1, 1], name="odd", inputs="v", outputs="w")), "finite coefficients"),
    (
        lambda: LinearLaw(control.tf([1, 0], [2], inputs="omega", outputs="v", name="D")),
        "'D' from 'omega' to 'v' has a numerator of degree 1 over a denominator of degree 0",
    ),
    (
        lambda: LinearLaw(control.tf([[[1], [1]]], [[[1, 1], [1, 2]]], inputs=["a", "b"], outputs="v", name="G")),
        "the transfer function 'G' has 2 inputs and 1 outputs",
    ),
    (lambda: LinearPlant(3.0), "must be a `StateSpace` or a `TransferFunction` of python-control; got 3.0"),
    (lambda: LinearLaw(TUSTIN).run_every(0.2), "must be the period of a discrete law, 0.1 s.*got 0.2 s"),
    (
        lambda: LinearLaw(TUSTIN, u0=[1.0, 2.0]),
        r"`LinearLaw\(u0=...\)` must have shape \(1,\), one number for each of the signals v; got \(2,\)",
    ),
    (lambda: LinearFilter(one(D=1.0), ("v",)), "follows its input 'v' by D = 1"),
    (lambda: ClosedLoop(PLANT, controller=TUSTIN).ode(), "only a computer runs"),
    (lambda: ClosedLoop(PLANT, controller=TUSTIN).digital(0.03), "no whole multiple of 0.03 s"),
]


@pytest.mark.parametrize(("make", "message"), REFUSED)
def test_what_is_no_block_of_a_loop_is_refused_by_name(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def test_a_discrete_system_without_a_period_takes_one():
    law = LinearLaw(LinearSystem.of(one(dt=True, inputs="omega", outputs="v"), dt=0.05))
    assert law.period == 0.05


def test_made_up_names_are_replaced_by_those_that_are_given():
    system = LinearSystem.of(control.ss(-1.0, 1.0, 1.0, 0.0), inputs="v", outputs=["omega"])
    assert (system.inputs.names, system.outputs.names) == (("v",), ("omega",))
