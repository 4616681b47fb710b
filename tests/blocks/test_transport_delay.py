"""Commands that wait some periods of their computer before they act."""

import numpy as np
import pytest
from scipy.linalg import expm

from tests.support.compilers import needs_llvmlite
from workbench.blocks.loop import AbstractController, AbstractPlant, ClosedLoop
from workbench.core import block, initial, layout, parameter
from workbench.engine import simulate

PERIOD = 0.1


@block
class Tanks(AbstractPlant):
    """Two tanks without a connection: x' = u - x, y' = v - 2 y."""

    x: float = initial(1.0, unit="m")
    y: float = initial(-0.5, unit="m")
    inputs = layout(u="m/s", v="m/s")
    outputs = layout(x="m", y="m")

    def rate(self, t, x, u):
        return {"x": u.u - x.x, "y": u.v - 2 * x.y}


@block
class Gains(AbstractController):
    """u = -k x, v = 1 - y."""

    k: float = parameter(0.7, unit="1/s")
    reads = layout(x="m", y="m")
    drives = layout(u="m/s", v="m/s")

    def command(self, t, z, est, ref):
        return {"u": -self.k * est.x, "v": 1 - est.y}


def by_hand(u_waits, v_waits, n, every=1):
    """The states at the instants, with queues that are plain lists; each state is an exact exponential."""
    z, rows, ways = np.array([1.0, -0.5]), [], ([0.0] * u_waits, [0.0] * v_waits)
    for k in range(n):
        if k % every == 0:
            command = (-0.7 * z[0], 1 - z[1])
        for way, number in zip(ways, command, strict=True):
            way.append(number)
        acts = [way.pop(0) for way in ways]
        rows.append([*z, *acts])
        for i, pole in enumerate((1.0, 2.0)):
            decay = float(expm([[-pole * PERIOD]])[0, 0])
            z[i] = decay * z[i] + (1 - decay) / pole * acts[i]
    return np.array(rows)


@block
class Cooled(AbstractPlant):
    """A body that a jacket at 300 K cools: T' = (T_c - T) / 10 s."""

    T: float = initial(350.0, unit="K")
    inputs = layout(T_c=("K", 300.0), fan="K/s")
    outputs = layout(T="K")

    def rate(self, t, x, u):
        return {"T": (u.T_c - x.T) / 10 - u.fan}


@block
class Cold(AbstractController):
    """A jacket of 280 K and a fan."""

    reads = layout(T="K")
    drives = layout(T_c="K", fan="K/s")

    def command(self, t, z, est, ref):
        return {"T_c": 280.0, "fan": 2.0}


def test_what_acts_before_the_first_command_is_what_the_plant_declares_of_its_inputs():
    made = simulate(ClosedLoop(Cooled(), controller=Cold()).digital(PERIOD, delay=2).step(1), until=0.4)
    assert made["T_c_applied"].ravel()[:4].tolist() == [300.0, 300.0, 280.0, 280.0]
    assert made["fan_applied"].ravel()[:4].tolist() == [0.0, 0.0, 2.0, 2.0]


def run(delay, law=None, **how):
    step = ClosedLoop(Tanks(), controller=law or Gains()).digital(PERIOD, delay=delay).step(20)
    made = simulate(step, until=3.0, **how)
    return np.column_stack([made[name][0] for name in ("x", "y", "u_applied", "v_applied")]), step


@pytest.mark.parametrize(
    ("delay", "waits"),
    [
        (False, (0, 0)),
        (True, (1, 1)),
        (1, (1, 1)),
        (2, (2, 2)),
        (7, (7, 7)),
        ({"u": 3}, (3, 0)),
        ({"u": 1, "v": 4}, (1, 4)),
        ({}, (0, 0)),
    ],
)
def test_a_command_acts_so_many_periods_after_it_was_computed(delay, waits):
    made, _ = run(delay)
    # Runge-Kutta with lambda h = 0.01 leaves 1e-12 a period
    np.testing.assert_allclose(made, by_hand(*waits, len(made)), atol=1e-10)


@pytest.mark.parametrize(("delay", "waits"), [(2, (2, 2)), ({"v": 2}, (0, 2))])
def test_a_law_of_a_longer_period_is_late_by_periods_of_the_computer(delay, waits):
    made, _ = run(delay, Gains().run_every(3 * PERIOD))
    np.testing.assert_allclose(made, by_hand(*waits, len(made), every=3), atol=1e-10)


def test_each_period_is_a_state_with_a_start_that_one_may_set():
    _, step = run({"u": 1, "v": 3})
    assert {e.name: (e.size, e.unit) for e in step.states.entries if "next" in e.name} == {
        "hold.next": (2, "m/s"),
        "hold.next.2": (1, "m/s"),
        "hold.next.3": (1, "m/s"),
    }
    x0 = step.states.pack({"hold.next": [5.0, 6.0], "hold.next.2": [7.0]})
    made = simulate(step, x0=x0, until=0.4)
    np.testing.assert_array_equal(made["v_applied"][0, :3].ravel(), [6.0, 7.0, 0.0])
    assert made["u_applied"][0, 0] == 5.0


def test_one_period_is_the_same_loop_by_whatever_word():
    loop = ClosedLoop(Tanks(), controller=Gains())
    prints = {loop.digital(PERIOD, delay=delay).fingerprint for delay in (True, 1, {"u": 1, "v": 1})}
    assert len(prints) == 1
    assert loop.digital(PERIOD, delay=0).fingerprint == loop.digital(PERIOD).fingerprint


@needs_llvmlite
def test_a_queue_has_the_same_bits_in_the_compiled_march_and_in_numpy():
    native, numpy = (run({"u": 3, "v": 1}, engine=engine, arithmetic="fused")[0] for engine in ("native", "numpy"))
    np.testing.assert_array_equal(native, numpy)


@pytest.mark.parametrize(
    ("delay", "kind", "says"),
    [
        (1.5, ValueError, r"whole number of periods from 0 to 1000.*got 1.5: take a period that divides the delay, or"),
        (-1, ValueError, r"`ClosedLoop.digital\(delay=...\)` must be a whole number of periods"),
        (2000, ValueError, r"whole number of periods from 0 to 1000"),
        (np.nan, ValueError, r"whole number of periods"),
        ({"u": 0.5}, ValueError, r"whole number of periods.*; got 0.5: take"),
        ({"uu": 1}, LookupError, r"no 'uu' among the 2 inputs of the plant"),
        (
            "no",
            ValueError,
            r"`ClosedLoop.digital\(delay=...\)` must be True or False or a number or a mapping.*got 'no'",
        ),
        (
            None,
            ValueError,
            r"`ClosedLoop.digital\(delay=...\)` must be True or False or a number or a mapping.*got None",
        ),
    ],
)
def test_a_delay_of_no_whole_number_of_periods_is_refused(delay, kind, says):
    with pytest.raises(kind, match=says):
        ClosedLoop(Tanks(), controller=Gains()).digital(PERIOD, delay=delay)
