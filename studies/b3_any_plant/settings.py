"""The plants of b3, each off its operating point, and what is chosen about its two loops."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

import workbench as wb

INF = float("inf")
HAND, PUBLISHED, REGULATOR = "chosen by hand", "published", "those of LQG's regulator"  # origins of the gains of PID
SENSOR = 0.50  # V/cm: gains of the four tanks are published for the voltages of its sensors


@dataclass(frozen=True, eq=False)
class Setting:
    """A plant that starts off its operating point, and the choices about its two loops.

    The states of `plant` are those where a run starts; `at` names the operating point, `main` the output whose
    error counts. In LQG's cost `states` and `inputs` say by how much each may be off, infinite where a state costs
    nothing; its filter is made for white noise at the inputs of deviation `push` over a period, and for the `noise` of
    each reading. `limit` bounds the commands; the computer's `period` and the horizon `until` are in s. `pid` is the
    second law, `spread` the least and the largest share of each parameter that is varied.
    """

    name: str
    plant: wb.Plant
    at: Mapping[str, float]
    main: str
    states: tuple[float, ...]
    inputs: tuple[float, ...]
    push: float
    noise: Mapping[str, float]
    limit: tuple[float, float]
    period: float
    until: float
    pid: Pid
    spread: Mapping[str, tuple[float, float]]

    @cached_property
    def open(self) -> wb.Ode:
        """The plant alone."""
        return wb.open_loop(self.plant)

    @cached_property
    def point(self) -> wb.linear.TrimPoint:
        """The operating point."""
        return wb.linear.operating_point(self.open, self.at)

    @cached_property
    def model(self) -> Any:
        """The linear model there, a `StateSpace` of python-control."""
        return wb.linearize(self.open, 0.0, self.point.x, u=self.point.u, at_rest=True)

    @cached_property
    def design(self) -> wb.riccati.Lqg:
        """Regulator and Kalman filter, certified."""
        Q, R = (np.diag(1 / np.square(sizes)) for sizes in (self.states, self.inputs))
        driven = self.push**2 * self.period * np.eye(len(self.inputs))
        heard = np.diag([self.noise[name] ** 2 * self.period for name in self.plant.outputs.names])
        return wb.lqg(self.model, Q, R, driven, heard, G=self.model.B)

    @property
    def operating_outputs(self) -> dict[str, float]:
        """The outputs at the operating point, each of them a state."""
        x = self.open.states.unpack(self.point.x)
        return {name: float(np.squeeze(x[name])) for name in self.plant.outputs.names}

    @property
    def start(self) -> dict[str, float]:
        """The outputs where a run starts: the first reading, which either law takes as it is."""
        return {name: float(self.plant.states[name].default) for name in self.plant.outputs.names}


@dataclass(frozen=True, eq=False)
class Pid:
    """The second law of a plant: what it is in `words`, the `origin` of its gains, the law, and its gains in print."""

    words: str
    origin: str
    law: Callable[[Setting], wb.Controller]
    gains: Callable[[Setting], str]


def digits(values: Any) -> str:
    """Numbers with four digits; of a matrix its rows, where what rounding leaves of a zero is zero."""
    rows = np.atleast_2d(np.asarray(values, dtype=float))
    rows = np.where(np.abs(rows) > 1e-12 * np.abs(rows).max(), rows, 0.0)
    text = "; ".join(", ".join(f"{value:.4g}" for value in row) for row in rows)
    return (text if rows.size == 1 else f"[{text}]").replace("-", "\N{MINUS SIGN}")


def pid(words: str, Kp: float, Ki: float, Kd: float, N: float) -> Pid:
    """PID about the operating point, with no derivative of what is wanted."""

    def law(setting: Setting) -> wb.PID:
        plant, (y0,) = setting.plant, setting.start.values()
        return wb.PID(plant.outputs, plant.inputs, Kp, Ki, Kd, N, c=0.0, u0=setting.point.u, y0=y0)

    text = f"Kp = {Kp:g}, Ki = {Ki:g}" + (f", Kd = {Kd:g}, N = {N:g}" if Kd else "")
    return Pid(words, HAND, law, lambda setting: text)


def cascade(N: float) -> Pid:
    """Two PD about the operating point that together have the gains of the regulator, one for each state.

    The outer law reads the first output and drives what is wanted of the second; velocities are filtered derivatives.
    """

    def pairs(setting: Setting) -> tuple[tuple[float, float], tuple[float, float]]:
        """Kp and Kd of the outer law, then of the inner one."""
        gains = dict(zip(setting.plant.states.names, setting.design.regulator.K[0], strict=True))
        place, angle = setting.plant.outputs.names
        stiff = gains[angle]
        return (gains[place] / stiff, gains[f"{place}d"] / stiff), (stiff, gains[f"{angle}d"])

    def law(setting: Setting) -> wb.Cascade:
        plant, point, y0 = setting.plant, setting.point, setting.start
        slow, fast = (wb.Layout((entry,)) for entry in plant.outputs.entries)
        (above, above_d), (below, below_d) = pairs(setting)
        place, angle = slow.names[0], fast.names[0]
        outer = wb.PID(slow, fast, above, 0.0, above_d, N, c=0.0, u0=setting.operating_outputs[angle], y0=y0[place])
        inner = wb.PID(fast, plant.inputs, below, 0.0, below_d, N, c=0.0, u0=point.u, y0=y0[angle])
        return wb.Cascade(outer, inner)

    def text(setting: Setting) -> str:
        names = zip(("outer", "inner"), pairs(setting), strict=True)
        parts = (f"{name}: Kp = {digits(Kp)}, Kd = {digits(Kd)}" for name, (Kp, Kd) in names)
        return f"{'; '.join(parts)}; N = {N:g}"

    return Pid("a cascade of two PD controllers", REGULATOR, law, text)


def parallel(N: float) -> Pid:
    """A PD for each output, mixed over the inputs with the gains of the regulator; velocities are filtered."""

    def pair(setting: Setting) -> list[wb.Array]:
        """Kp and Kd, an input a row."""
        return list(np.split(setting.design.regulator.K, [len(setting.operating_outputs)], axis=1))

    def law(setting: Setting) -> wb.LinearLaw:
        ny = len(setting.operating_outputs)
        Kp, Kd = pair(setting)
        off = np.array([setting.operating_outputs[name] - y for name, y in setting.start.items()])
        return linear(setting, -N * np.eye(ny), N * np.eye(ny), -N * Kd, Kp + N * Kd, off)

    def text(setting: Setting) -> str:
        Kp, Kd = pair(setting)
        return f"Kp = {digits(Kp)}, Kd = {digits(Kd)}, N = {N:g}"

    return Pid("three PD controllers, mixed over the inputs", REGULATOR, law, text)


def two_pi(K: tuple[float, float], T: tuple[float, float]) -> Pid:
    """v_i = v_0i + K_i (e_i + integral of e_i / T_i), e_i in volts of the sensors."""

    def law(setting: Setting) -> wb.LinearLaw:
        gain, time = SENSOR * np.array(K), np.array(T)
        return linear(setting, np.zeros((2, 2)), np.eye(2), np.diag(gain / time), np.diag(gain), np.zeros(2))

    text = (
        f"Kp = {digits(K[0])}, {digits(K[1])} for errors in V of a sensor of {SENSOR:g} V/cm; Ti = {T[0]:g}, {T[1]:g} s"
    )
    return Pid("two PI controllers", PUBLISHED, law, lambda setting: text)


def second_order(n_1: float, n_0: float, d_1: float, d_0: float) -> Pid:
    """(n_1 s + n_0) / (s^2 + d_1 s + d_0): a PD behind a filter of second order."""

    def law(setting: Setting) -> wb.LinearLaw:
        A, B = np.array([[-d_1, -d_0], [1.0, 0.0]]), np.array([[1.0], [0.0]])
        return linear(setting, A, B, np.array([[n_1, n_0]]), np.zeros((1, 1)), np.zeros(2))

    text = f"({n_1:g} s + {n_0:g}) / (s\N{SUPERSCRIPT TWO} + {d_1:g} s + {d_0:g})"
    return Pid("a PD controller with a filter of second order", HAND, law, lambda setting: text)


def linear(setting: Setting, A: wb.Array, B: wb.Array, C: wb.Array, D: wb.Array, start: wb.Array) -> wb.LinearLaw:
    """A linear system as the law, from the errors of all outputs; where its states start."""
    states = wb.Layout((wb.core.Entry("z", start),))
    system = wb.core.LinearSystem(states, setting.plant.outputs, setting.plant.inputs, A, B, C, D)
    return wb.LinearLaw(system, error=True, u0=setting.point.u)


TENTH, FIFTH = (0.9, 1.1), (0.8, 1.2)
EASY, HARD = "quadruple tank P\N{MINUS SIGN}", "quadruple tank P+"
TANK = dict.fromkeys(("gamma_1", "gamma_2", "k_1", "k_2", "a_1"), TENTH)
HUNDREDTH = dict.fromkeys(("q", "k_0", "U_A", "T_f", "c_Af"), (0.99, 1.01))
SETTINGS = (
    Setting(
        "DC motor", wb.DCMotor(), {"omega": 1.0}, "omega", (0.05, INF), (1.0,), 1.0, {"omega": 0.01}, (0.0, 24.0),
        0.02, 4.0, pid("a PI controller", 15.0, 40.0, 0.0, 100.0), dict.fromkeys(("J", "b", "K", "R", "L"), FIFTH),
    ),
    Setting(
        "cart-pole", wb.CartPole(x=0.2, phi=0.1), {"x": 0.0, "phi": 0.0}, "x", (5000**-0.5, INF, 0.1, INF), (1.0,), 1.0,
        {"x": 1e-3, "phi": 1e-3}, (-20.0, 20.0), 0.01, 5.0, cascade(100.0),
        dict.fromkeys(("M", "m", "l", "I", "b"), FIFTH),
    ),
    Setting(
        "Furuta pendulum", wb.FurutaPendulum(theta_1=0.3, theta_2=np.pi + 0.05), {"theta_1": 0.0, "theta_2": np.pi},
        "theta_1", (0.1, INF, 0.1, INF), (0.1,), 0.1, {"theta_1": 1e-3, "theta_2": 1e-3}, (-1.0, 1.0), 0.005, 6.0,
        cascade(100.0), dict.fromkeys(("m_2", "L_1", "l_2", "J_1", "J_2"), TENTH),
    ),
    Setting(
        EASY, wb.QuadrupleTank(h_1=10.3, h_2=12.8, h_3=1.6, h_4=1.4), {"v_1": 3.0, "v_2": 3.0}, "h_1",
        (0.5, 0.5, INF, INF), (1.0, 1.0), 0.5, {"h_1": 0.02, "h_2": 0.02}, (0.0, 10.0), 2.0, 800.0,
        two_pi((3.0, 2.7), (30.0, 40.0)), TANK,
    ),
    Setting(
        HARD, replace(wb.QuadrupleTank.nonminimum_phase(), h_1=10.4), {"v_1": 3.15, "v_2": 3.15}, "h_1",
        (0.5, 0.5, INF, INF), (1.0, 1.0), 0.5, {"h_1": 0.02, "h_2": 0.02}, (0.0, 10.0), 2.0, 2400.0,
        two_pi((1.5, -0.12), (110.0, 220.0)), TANK,
    ),
    Setting(
        "two masses", wb.TwoMasses(x_1=1.0, x_2=1.0), {"x_2": 0.0}, "x_2", (INF, 1.0, INF, INF), (1.0,), 0.5,
        {"x_2": 0.01}, (-1.0, 1.0), 0.1, 60.0, second_order(0.7, 0.2, 1.4, 1.5),
        {"k": TENTH, "m_1": TENTH, "m_2": TENTH},
    ),
    Setting(
        "planar quadrotor", wb.PlanarQuadrotor(x=0.5, y=-0.3), {"x": 0.0, "y": 0.0, "theta": 0.0}, "x",
        (0.2, 0.2, 0.3, INF, INF, INF), (1.0, 1.0), 0.5, {"x": 5e-3, "y": 5e-3, "theta": 5e-3}, (0.0, 6.0), 0.005, 5.0,
        parallel(100.0), dict.fromkeys(("m", "I", "r"), TENTH),
    ),
    Setting(
        "buck converter", wb.BuckConverter(i=4.0, v=12.0), {"v": 15.0}, "v", (INF, 0.5), (0.2,), 0.05, {"v": 0.01},
        (0.0, 1.0), 1e-5, 4e-3, pid("a PID controller", 0.05, 200.0, 2e-5, 1e5),
        dict.fromkeys(("V_g", "L", "C", "R"), FIFTH),
    ),
    Setting(
        "stirred tank", wb.StirredTank(c_A=0.55, T=345.0), {"T": 350.0}, "T", (INF, 2.0), (8.0,), 5.0, {"T": 0.1},
        (270.0, 330.0), 1.0, 600.0, pid("a PI controller", 5.0, 0.03, 0.0, 1.0), HUNDREDTH,
    ),
)  # fmt: skip
