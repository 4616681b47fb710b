"""Published problems of robust and structured design, with the figures that are printed for them."""

from __future__ import annotations

import itertools
import json
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

import numpy as np

import workbench as wb
from studies.d1_benchmarks.linear_systems import System, distillation_column, state_space
from studies.d1_benchmarks.two_masses import two_mass_figure

SPIN = 10.0  # rad/s, of the satellite
STARTS, SEED = 6, 0  # of each search for a controller of given structure
COMPLEIB = json.loads((Path(__file__).parent / "structured_benchmarks.json").read_text(encoding="utf-8"))["problems"]
Pair: TypeAlias = tuple[float, float]
Levels: TypeAlias = tuple[float, float, float, float]
OUTLETS = (0.071, 0.057)  # cm^2, of its lower and upper tanks on either side
# The quadruple tank of Johansson (2000) in its two settings: valves, pumps in cm^3/(V s), levels in cm.
TANKS: dict[str, tuple[Pair, Pair, Levels]] = {
    "minimum phase": ((0.70, 0.60), (3.33, 3.35), (12.4, 12.7, 1.8, 1.4)),
    "nonminimum phase": ((0.43, 0.34), (3.14, 3.29), (12.6, 13.0, 4.8, 4.9)),
}


@dataclass(frozen=True)
class Bounds:
    """A figure between its bounds; both are the same where it is known to all digits."""

    low: float
    high: float


def satellite() -> tuple[wb.Array, wb.Array, wb.Array]:
    """A, B and C of T = 1 / (s + 1) [1, a; -a, 1], the loop of a spinning satellite under the gain one."""
    A, C = np.array([[0.0, SPIN], [-SPIN, 0.0]]), np.array([[1.0, SPIN], [-SPIN, 1.0]])
    return A - C, np.eye(2), C


def satellite_loop() -> Bounds:
    """Ms of each channel of the satellite while the other one is closed: the larger one."""
    A, B, C = np.array([[0.0, SPIN], [-SPIN, 0.0]]), np.eye(2), np.array([[1.0, SPIN], [-SPIN, 1.0]])
    found = []
    for channel in range(2):
        other = 1 - channel
        one = state_space(A - np.outer(B[:, other], C[other]), B[:, [channel]], C[[channel]], np.zeros((1, 1)))
        found.append(wb.stability_margins(one).Ms.gain)
    return Bounds(max(one.low for one in found), max(one.high for one in found))


def satellite_norm() -> Bounds:
    """The H-infinity norm of T of the satellite."""
    gain = wb.hinf_norm(state_space(*satellite(), np.zeros((2, 2)))).gain
    return Bounds(gain.low, gain.high)


def satellite_mu() -> Bounds:
    """The structured singular value of T for independent changes of both gains."""
    blocks = [wb.structured_uncertainty.FullBlock(1)] * 2
    return peak(state_space(*satellite(), np.zeros((2, 2))), blocks)


def peak(system: System, blocks: list[wb.structured_uncertainty.FullBlock]) -> Bounds:
    found = wb.structured_uncertainty.robustness_over_frequency(system, blocks)
    return Bounds(found.lower, found.upper)


def column(part: str) -> Bounds:
    """The peaks of the distillation column: of its performance, its stability, and both at once."""
    full = wb.structured_uncertainty.FullBlock
    N = distillation_column()
    if part == "performance":
        gain = wb.hinf_norm(N[2:, 2:]).gain
        return Bounds(gain.low, gain.high)
    if part == "stability":
        return peak(N[:2, :2], [full(1), full(1)])
    return peak(N, [full(1), full(1), full(2)])


def tank(valves: Pair, pumps: Pair, levels: Levels, outlets: Pair = OUTLETS) -> System:
    """The linear model of the quadruple tank, from the pumps in V to the sensors in V."""
    areas = np.array([28.0, 32.0, 28.0, 32.0])
    T = areas / np.tile(outlets, 2) * np.sqrt(2 * np.array(levels) / 981.0)
    A = np.diag(-1 / T)
    A[0, 2], A[1, 3] = areas[2] / (areas[0] * T[2]), areas[3] / (areas[1] * T[3])
    (g1, g2), (k1, k2) = valves, pumps
    B = np.array([[g1 * k1 / 28, 0], [0, g2 * k2 / 32], [0, (1 - g2) * k2 / 28], [(1 - g1) * k1 / 32, 0]])
    return state_space(A, B, 0.5 * np.eye(2, 4), np.zeros((2, 2)))


def tank_zero(setting: str) -> Bounds:
    """The slower transmission zero of the quadruple tank in 1/s, for all numbers that round to the printed ones.

    It is monotone in each valve, level and outlet, so the corners of half a unit in the last digit are its ends.
    """
    (g1, g2), pumps, (h1, h2, h3, h4) = TANKS[setting]
    zeros = []
    for sign in itertools.product((-1, 1), repeat=6):
        valves = g1 + 0.005 * sign[0], g2 + 0.005 * sign[1]
        levels = h1, h2, h3 + 0.05 * sign[2], h4 + 0.05 * sign[3]
        outlets = OUTLETS[0] + 0.0005 * sign[4], OUTLETS[1] + 0.0005 * sign[5]
        both = wb.pole_zero_structure(tank(valves, pumps, levels, outlets)).transmission_zeros.values.real
        zeros.append(float(both[np.abs(both).argmin()]))
    return Bounds(min(zeros), max(zeros))


def benner() -> Bounds:
    """The least H-infinity norm of an example whose optimum is printed in many digits."""
    plant = wb.synthesis.GeneralizedPlant(
        A=[[-1, 0, 1, -2, 1], [0, -100, 0, 0, 0], [0, 0, 0, -2, 1], [0, 0, 0, 0, 1], [0, 0, 0, 3, 2]],
        B1=[[1], [0], [1], [0], [0]], B2=[[0], [-90], [0], [0], [1]],
        C1=[[1, 0, 0, 0, 0], [0, 1, 0, 0, 0]], C2=[[0, 0, 1, -2, 1]],
        D11=np.zeros((2, 1)), D12=[[0], [1]], D21=[[1]], D22=[[0]],
    )  # fmt: skip
    gamma = wb.hinf_controller(plant).gamma
    return Bounds(gamma.low, gamma.high)


def compleib_plant(name: str) -> tuple[wb.Array, wb.Array, wb.Array, wb.Array]:
    """The matrices A, [B1 B], [C1; C] and [0 D12; D21 0] of a problem of COMPleib."""
    p = {key: np.array(COMPLEIB[name][key], dtype=float) for key in ("A", "B", "C", "B1", "C1", "D12", "D21")}
    (nz, nw), (ny, nu) = (len(p["C1"]), p["B1"].shape[1]), (len(p["C"]), p["B"].shape[1])
    direct = np.block([[np.zeros((nz, nw)), p["D12"]], [p["D21"], np.zeros((ny, nu))]])
    return p["A"], np.hstack([p["B1"], p["B"]]), np.vstack([p["C1"], p["C"]]), direct


@dataclass(frozen=True)
class StaticDesign:
    """A static controller of a problem of COMPleib: its norm, that of each start, and the full-order optimum.

    `full` is NaN if the full-order problem is refused, and `why` is then the reason.
    """

    gamma: Bounds
    starts: tuple[float, ...]
    stationarity: float
    full: float
    why: str


def static_design(name: str) -> StaticDesign:
    """The static output feedback of a problem of COMPleib, from several starts."""
    matrices = compleib_plant(name)
    ny, nu = len(COMPLEIB[name]["C"]), len(COMPLEIB[name]["B"][0])
    answer = wb.structured_tuning.structured_controller(state_space(*matrices), ny, nu, starts=STARTS, seed=SEED)
    gain = next(one.value for one in answer.goals if one.goal.figure == "hinf")
    ends = tuple(float(np.exp(one.objective)) if one.stable else np.nan for one in answer.starts)
    try:
        plant = wb.synthesis.GeneralizedPlant.of(state_space(*matrices), ny, nu)
        full, why = wb.hinf_controller(plant).gamma.value, ""
    except wb.linear.DesignError as refused:
        full, why = np.nan, str(refused)
    return StaticDesign(Bounds(gain.low, gain.high), ends, answer.stationarity, full, why)


@dataclass(frozen=True)
class Problem:
    """A figure of a problem by its key, what is printed for it with so many digits after the point, and where.

    `relation` is "=" for a figure, and "\N{LESS-THAN OR EQUAL TO}" or "\N{GREATER-THAN OR EQUAL TO}" for a requirement
    that its source states for the controller. `was_read` is false for a figure that is quoted from memory.
    """

    key: str
    name: str
    figure: str
    printed_figure: float
    digits: int
    source: str
    relation: str = "="
    was_read: bool = True


BOOK, JOHANSSON, BENNER = "[1]", "[2]", "[3]"  # as the note of the table names them
CHAIT, CHIANG, STENGEL = "[4]", "[5]", "[6]"
MOST, LEAST = "\N{LESS-THAN OR EQUAL TO}", "\N{GREATER-THAN OR EQUAL TO}"
MASSES_QFT, MASSES_HINF = "two masses, QFT", "two masses, H-infinity"
PUBLISHED = (
    Problem("satellite loop", "spinning satellite", "Ms of each channel", 1.0, 2, f"{BOOK}, 3.7.1", "=", False),
    Problem("satellite norm", "spinning satellite", "norm of T", 10.05, 2, f"{BOOK}, 3.7.1", "=", False),
    Problem("satellite mu", "spinning satellite", "mu of both gains", 10.05, 2, f"{BOOK}, 3.7.1", "=", False),
    Problem("column performance", "distillation column", "norm of w_P S", 0.5, 2, f"{BOOK}, 8.11.3"),
    Problem("column stability", "distillation column", "mu, robust stability", 0.53, 2, f"{BOOK}, 8.11.3"),
    Problem("column both", "distillation column", "mu, robust performance", 5.8, 1, f"{BOOK}, 8.11.3"),
    Problem("benner", "example 6.1 with a = 1", "least norm", 7.853923684, 9, BENNER),
    Problem("tank minimum phase", "quadruple tank, P-", "slower zero [1/s]", -0.018, 3, JOHANSSON),
    Problem("tank nonminimum phase", "quadruple tank, P+", "slower zero [1/s]", 0.013, 3, JOHANSSON),
    Problem("masses qft peak", MASSES_QFT, "peak of T, k from 0.5 to 2 N/m", 2.25, 2, CHAIT, MOST),
    Problem("masses qft softest", MASSES_QFT, "softest stable spring [N/m]", 0.5, 1, CHAIT, MOST),
    Problem("masses hinf softest", MASSES_HINF, "softest stable spring [N/m]", 0.5, 1, CHIANG, MOST),
    Problem("masses hinf stiffest", MASSES_HINF, "stiffest stable spring [N/m]", 2.0, 1, CHIANG, LEAST),
    Problem("masses hinf settling", MASSES_HINF, "settling, from 5 % to 2 % [s]", 15.0, 0, CHIANG),
    Problem("masses instability", "two masses, design A", "probability of instability", 0.160, 3, STENGEL, "=", False),
)


def figure_of(key: str) -> Bounds:
    """The figure of a problem between its bounds."""
    match key.split(" ", 1):
        case ["satellite", "loop"]:
            return satellite_loop()
        case ["satellite", "norm"]:
            return satellite_norm()
        case ["satellite", "mu"]:
            return satellite_mu()
        case ["column", part]:
            return column(part)
        case ["tank", setting]:
            return tank_zero(setting)
        case ["masses", figure]:
            return Bounds(*two_mass_figure(figure))
        case _:
            return benner()
