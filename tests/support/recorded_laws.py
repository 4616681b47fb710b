"""Laws of the catalogue in the computer of their loops, with the rows of a run; and laws written by hand."""

from collections.abc import Callable, Mapping
from functools import cache
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

import workbench as wb
from studies.paper.laws import RIVALS, proposed_repaired, rival
from workbench.core import Entry, Layout, SampledLaw


class Recorded(NamedTuple):
    """A law, and the instants, memory, readings and references of a run."""

    law: SampledLaw
    k: np.ndarray
    z: np.ndarray
    y: np.ndarray
    r: np.ndarray


def arm(loop) -> tuple[Any, tuple[str, ...], float]:
    """A loop of the paper with noise, a quantum, limits and a delay."""
    instruments = wb.Instruments.of(loop.plant, noise={"q": 1e-4}, quantum={"q": 1e-4}, limit={"tau": (-80.0, 80.0)})
    truths = tuple(name for name in loop.plant.truths.names if name in loop.observer.reads)
    return loop.digital(1e-3, instruments, delay=True), truths, 0.3


def motor() -> tuple[Any, tuple[str, ...], float]:
    """The first loop of the README."""
    plant = wb.DCMotor()
    law = wb.PID(plant.outputs, plant.inputs, Kp=100.0, Ki=200.0, Kd=10.0, low=-24.0, high=24.0)
    loop = wb.ClosedLoop(plant, controller=law, reference=wb.Step("omega", "rad/s", 1.0, time=0.1))
    return loop.digital(1e-3), (), 0.3


def cart(law: str) -> tuple[Any, tuple[str, ...], float]:
    """The balanced cart of the README: extended Kalman filter and regulator, or LQG."""
    plant, period = wb.CartPole(phi=0.1), 0.01
    upright = wb.linearize(wb.open_loop(plant), t=0.0, x=np.zeros(4), at_rest=True)
    Q, W, V = np.diag([5000.0, 0.0, 100.0, 0.0]), np.diag([0.0, 1e-2, 0.0, 1e-2]), 1e-6 * np.eye(2)
    instruments = wb.Instruments.of(plant, noise={"x": 1e-3, "phi": 1e-3}, limit={"F": (-10.0, 10.0)})
    if law == "LQG":
        loop = wb.ClosedLoop(plant, controller=wb.lqg(upright, Q, [[1.0]], W, V).controller)
        return loop.digital(period, instruments), (), 3.0
    kalman = wb.ExtendedKalmanFilter(plant, W, V, P=1e-2 * np.eye(4), period=period)
    regulator = wb.StateFeedback.of(plant, wb.lqr(upright, Q=Q, R=[[1.0]]).K, follow=("x",))
    loop = wb.ClosedLoop(plant, kalman, regulator, wb.Step("x", "m", 0.2, time=2.0))
    return loop.digital(period, instruments, delay=True), (), 3.0


MAKERS: Mapping[str, Callable[[], tuple[Any, tuple[str, ...], float]]] = {
    "AOSMC-RGS": lambda: arm(proposed_repaired("FS")),
    **{name: lambda name=name: arm(rival("FS", name)) for name in RIVALS},
    "motor PID": motor,
    "EKF": lambda: cart("EKF"),
    "LQG": lambda: cart("LQG"),
}
LOOPS = {name: cache(make) for name, make in MAKERS.items()}


@cache
def recorded(name: str) -> Recorded:
    """A law of the catalogue with the rows of a short run of its loop."""
    sampled, truths, until = LOOPS[name]()
    law = sampled.law(truths=truths)
    entries = tuple(Entry(key, np.zeros(value.numel())) for key, value in sampled.computer_input_values.items())
    taken, values = Layout(entries), ca.vertcat(*map(ca.vec, sampled.computer_input_values.values()))
    step = sampled.step(1).with_memory(taken, ca.SX.sym("taken", taken.size), values)
    x, states = wb.simulate(step, until=until, arithmetic="portable", seed=1).x[0], step.states

    def held(prefix: str, layout: Layout) -> np.ndarray:
        return np.concatenate([x[:, states.slice(prefix + name)] for name in layout.names] + [x[:, :0]], axis=1)

    z, y, r = held("", law.memory), held("y.", law.readings), held("r.", law.references)
    return Recorded(law, np.arange(len(x) - 1), z[:-1], y[1:], r[1:])


def by_hand(
    command: Callable[..., ca.SX], readings: int = 1, p: tuple[float, ...] = (), **stages: Callable
) -> SampledLaw:
    """The law u = command(y, k, p) with so many readings; further values of y have names."""
    sizes = {"z": 0, "y": readings, "r": 0, "p": len(p)}
    symbols = {name: ca.SX.sym(name, size) for name, size in sizes.items()}
    k, y = ca.SX.sym("k"), symbols["y"]
    own = Layout((Entry("gain", np.array(p)),)) if p else Layout()
    ports = [Layout(), Layout((Entry("y", np.zeros(readings), "m"),)), Layout()]
    u = ca.SX(command(y, k, symbols["p"]))
    commands = Layout((Entry("u", np.zeros(u.numel()), "N"),))
    stage = wb.core.Stage("Law", {name: value(y) for name, value in stages.items()})
    return SampledLaw("by hand", 0.1, *ports, commands, own, k, *symbols.values(), u, ca.SX(0, 1), (stage,))
