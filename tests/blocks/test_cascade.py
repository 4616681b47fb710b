"""Cascades: the same as two nested loops done by hand, in continuous time and in a computer."""

import control
import numpy as np
import pytest
from scipy.linalg import expm

from tests.support.plain_plants import SPEED, VOLTAGE, Turntable
from workbench.blocks.laws import PID, Cascade
from workbench.blocks.loop import AbstractController, ClosedLoop
from workbench.blocks.signals import CombinedReference, Step
from workbench.core import block, layout, rk4
from workbench.engine import simulate

ANGLE = layout(theta="rad")
OUTER, INNER = PID(ANGLE, SPEED, Kp=3.0, Ki=0.5), PID(SPEED, VOLTAGE, Kp=5.0, Ki=2.0)
UP = Step("theta", "rad", 1.0)


def cascade_loop(ratio=1, outer=OUTER, inner=INNER):
    return ClosedLoop(Turntable(), controller=Cascade(outer, inner, ratio), reference=UP)


def test_in_continuous_time_it_is_one_loop_inside_another():
    s = control.tf("s")
    speed = control.feedback((5 + 2 / s) * 2 / (s + 1), 1)
    angle = control.feedback((3 + 0.5 / s) * speed / s, 1)
    _, y = control.step_response(control.minreal(angle, verbose=False), np.linspace(0, 3, 31))
    for ratio in (1, 4):  # a ratio of periods counts for nothing where there are none
        run = simulate(rk4(cascade_loop(ratio).ode(), 1e-3), until=3.0, every=0.1)
        # the fastest mode is 10 / s: (10 h)^4 / 120 a time constant
        np.testing.assert_allclose(run["theta"].ravel(), y, rtol=0, atol=1e-9)


def by_hand(h, steps, ratio):
    """Two loops of PI, the outer one at every so many instants; theta, omega, v at each."""
    F = expm(h * np.array([[0, 1, 0], [0, -1, 2], [0, 0, 0.0]]))
    x, far, near, wanted, seen = np.zeros(2), 0.0, 0.0, 0.0, []
    for k in range(steps):
        if k % ratio == 0:
            wanted = 3.0 * (1 - x[0]) + far
            far += ratio * h * 0.5 * (1 - x[0])
        v = 5.0 * (wanted - x[1]) + near
        near += h * 2.0 * (wanted - x[1])
        seen.append([*x, v])
        x = (F @ [*x, v])[:2]
    return np.array(seen)


@pytest.mark.parametrize("integrator", ["declared", "fine"])
@pytest.mark.parametrize("ratio", [1, 4])
def test_in_a_computer_the_outer_law_runs_once_in_so_many_periods(ratio, integrator):
    h = 0.02
    run = simulate(cascade_loop(ratio).digital(h, integrator=integrator).step(4), until=4.0)
    seen = np.stack([run[name].ravel() for name in ("theta", "omega", "v")], axis=1)
    # four Runge-Kutta steps of a mode of 1 / s leave (0.005)^5 / 120 each, in the command times 15
    np.testing.assert_allclose(seen[:-1], by_hand(h, 200, ratio), rtol=0, atol=1e-9)


def test_a_slower_computer_makes_periods_of_its_own_of_a_faster_one():
    law = Cascade(OUTER, INNER, 3).run_every(0.04)
    run = simulate(ClosedLoop(Turntable(), controller=law, reference=UP).digital(0.02).step(4), until=2.0)
    np.testing.assert_allclose(run["theta"].ravel()[:-1:2], by_hand(0.04, 50, 3)[:, 0], rtol=0, atol=1e-10)


def test_its_memory_and_its_parameters_lie_below_its_laws():
    ode = cascade_loop(4).ode()
    assert {"controller.outer.Kp", "controller.inner.Ki"} <= set(ode.parameters.names)
    memory = {"controller.outer.integral", "controller.inner.integral", "controller.held.omega"}
    assert memory <= set(ode.states.names)
    assert ode.states["controller.held.omega"].unit == "rad/s"
    assert "controller.held.omega" not in cascade_loop().ode().states


def test_it_says_what_it_reads_follows_and_drives():
    law = cascade_loop(4).controller
    assert (law.reads.names, law.follows.names, law.drives.names) == (("theta", "omega"), ("theta",), ("v",))
    assert cascade_loop().follows == ("theta",)
    assert cascade_loop(4).roles.readings == {"theta": ("read",), "omega": ("read",)}


def test_a_cascade_of_three_laws_is_made_of_two():
    inmost = PID(VOLTAGE, layout(w="V"), 1.0)
    law = Cascade(OUTER, Cascade(INNER, inmost, 2), 3)
    assert law.follows.names == ("theta",)
    assert law.memory.names[-1] == "held.omega"
    assert "inner.held.v" in law.memory


def test_each_law_can_be_left_parts_out_of():
    assert set(cascade_loop().controller.without()) == {"outer integral action", "inner integral action"}


@block
class Halving(AbstractController):
    """v+ = v / 2 + omega_ref: a recursion."""

    follows = SPEED
    reads = layout()
    drives = VOLTAGE
    memory = layout(v="V")

    def command(self, t, z, est, ref):
        return {"v": z.v}

    def update(self, t, z, est, ref):
        return {"v": z.v / 2 + ref.omega}


def test_a_cascade_with_a_recursion_is_one():
    loop = cascade_loop(inner=Halving())
    with pytest.raises(ValueError, match="`Cascade` is a recursion in discrete time"):
        loop.ode()
    run = simulate(loop.digital(0.1).step(), until=0.2)
    assert run["v"].ravel()[1] == 3.0  # Kp times the first error


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: Cascade(INNER, OUTER), "`PID` drives 'v', where `PID` follows 'theta'"),
        (lambda: Cascade(PID(ANGLE, layout(omega="1/s"), 1.0), INNER), r"'omega' in \[1/s\], where `PID` follows"),
        (lambda: Cascade(OUTER.run_every(0.1), INNER), r"`Cascade\(outer=...\)` must be a law without a period"),
        (lambda: Cascade(OUTER, INNER, 0), r"`Cascade\(ratio=...\)`"),
        (
            lambda: Cascade(PID(layout(omega="1/s"), SPEED, 1.0), INNER),
            r"`PID` takes 'omega' in \[1/s\].*both must take one",
        ),
    ],
)
def test_laws_that_do_not_fit_are_refused(make, says):
    with pytest.raises(ValueError, match=says):
        make()


def test_what_the_outer_law_leaves_is_followed_beside_it():
    @block
    class Both(AbstractController):
        follows = SPEED + layout(omegad="rad/s^2")
        reads = SPEED
        drives = VOLTAGE

        def command(self, t, z, est, ref):
            return {"v": ref.omega - est.omega + ref.omegad}

    law = Cascade(OUTER, Both())
    assert law.follows.names == ("theta", "omegad")
    wanted = CombinedReference((UP, Step("omegad", "rad/s^2", 7.0)))
    ode = ClosedLoop(Turntable(), controller=law, reference=wanted).ode()
    assert ode.outputs_at(0.0, np.zeros(ode.states.size))["v"] == 3.0 + 7.0
