"""The gains that follow a specification on a live page: the largest Ki by another search, in margins of Python."""

import control
import numpy as np
import pytest

import workbench as wb
from tests.support.browsers import needs_node
from tests.support.compilers import needs_llvmlite
from tests.support.live_linear import LoopData

pytestmark = [needs_node, needs_llvmlite]
N = 20.0  # 1/s, of the filter of the derivative
KI_WITHIN, PEAK_WITHIN = 1e-3, 5e-4
PLANTS = {
    "four lags": ([1.0], [1.0, 4.0, 6.0, 4.0, 1.0]),
    "a zero on the right": ([-0.5, 1.0], [1.0, 3.0, 3.0, 1.0]),
    "an unstable pole": ([1.0], [0.1, 0.9, -1.0]),
    "a resonance": ([1.0], [1.0, 1.2, 1.2, 1.0]),
    "a negative gain": ([-2.0], [1.0, 3.0, 3.0, 1.0]),
}


def loop_of(plant, **gains):
    num, den = PLANTS[plant]
    system = wb.LinearPlant(control.ss(control.tf(num, den), inputs="v", outputs="y"))
    law = wb.PID(system.outputs, system.inputs, **{"Kp": 0.3, "Ki": 0.1, "N": N} | gains)
    return wb.ClosedLoop(system, controller=law, reference=wb.Step("y", "1", 1.0))


def asked(data, ranges, Ms, Mt=None, **values):
    """A specification of gains within ranges, asked of a worker."""
    gains = [data.knob(f"controller.{name}", *ends, sum(ends) / 2) for name, ends in ranges.items()]
    return {**data.turn(**values), "kind": "specification", "channel": 0, "gains": gains, "Ms": Ms, "Mt": Mt}


def largest_ki(omega, parts, limits, gains, is_stable, spans):
    """The largest ki near gains (k, ki, kd) by grids, of L = G (k + ki I + kd D + E); `parts` are 1/G, I, D, E."""
    g, integral, derivative, rest = parts
    Ms, Mt = limits
    discs = [(g, np.abs(g) / Ms)]
    if Mt is not None:
        discs.append((g * Mt**2 / (Mt**2 - 1), np.abs(g) * Mt / (Mt**2 - 1)))
    k, _, kd = gains
    best = (0.0, k, kd)
    for span in spans:
        _, k, kd = best
        for at in k + span * abs(k) * np.linspace(-1, 1, 25):
            for D in kd * (1 + span * np.linspace(-1, 1, 25)) if kd else [0.0]:
                for bottom, top in free_intervals(discs, integral, at + D * derivative + rest):
                    if top > best[0] and is_stable(at, (bottom + top) / 2, D):
                        best = (top, at, D)
    return best[0]


def free_intervals(discs, integral, law):
    """The intervals of ki with |law + ki integral + c| >= r for all discs (c, r), from the highest on."""
    low, high = [np.zeros(1)], [np.zeros(1)]
    for centre, r in discs:
        a, b, c = np.abs(integral) ** 2, 2 * (np.conj(integral) * (law + centre)).real, np.abs(law + centre) ** 2 - r**2
        square = b * b - 4 * a * c
        inside = square > 0
        for ends, sign in ((low, -1), (high, 1)):
            ends.append(((-b + sign * np.sqrt(square * inside)) / (2 * a))[inside])
    low, high = np.concatenate(low), np.concatenate(high)
    order = np.argsort(low)
    low, reach = low[order], np.maximum.accumulate(high[order])
    gaps = np.nonzero((low[1:] > reach[:-1]) & (reach[:-1] >= 0))[0]
    return [(reach[i], low[i + 1]) for i in gaps[::-1]]


def is_stable_in(plant):
    num, den = PLANTS[plant]

    def is_stable(k, ki, kd):
        law = np.polyadd(np.polymul([k, ki], [1 / N, 1]), [kd, 0, 0])
        return np.roots(np.polyadd(np.polymul([1 / N, 1, 0], den), np.polymul(law, num))).real.max() < 0

    return is_stable


def assert_largest(data, plant, ranges, limits, rest=0.0, **values):
    """The worker has the largest Ki of a search by grids, and Python's margins of the loop meet the limits."""
    (found,) = data.replies(asked(data, ranges, *limits, **values))
    assert found["reason"] == "", found
    turned = values | {f"controller__{name}": [v] for name, v in zip(ranges, found["values"], strict=True)}
    assert_within(data.python(**turned), limits)
    sign, (num, den) = (-1 if found["values"][1] < 0 else 1), PLANTS[plant]
    omega = np.geomspace(1e-2, 200, 1200)
    s = 1j * omega
    derivative, stable = s / (1 + s / N), is_stable_in(plant)
    gains = sign * np.array([*found["values"], 0.0][:3])
    parts = (sign * np.polyval(den, s) / np.polyval(num, s), 1 / s, derivative, sign * rest * derivative)
    best = largest_ki(
        omega, parts, limits, gains, lambda k, ki, kd: stable(sign * k, sign * ki, sign * kd + rest), (0.2, 0.01)
    )
    assert gains[1] == pytest.approx(best, rel=KI_WITHIN)


def assert_within(linear, limits):
    (margins,) = linear.margins().values()
    assert linear.stable
    peaks = [margins.margins.Ms.gain.value, margins.margins.Mt.gain.value]
    shares = [peak / limit for peak, limit in zip(peaks, limits, strict=True) if limit is not None]
    assert max(shares) == pytest.approx(1, abs=PEAK_WITHIN)


@pytest.mark.parametrize(
    ("plant", "limits"),
    [
        ("four lags", (1.4, None)),
        ("four lags", (2.0, 1.05)),
        ("a zero on the right", (1.7, 1.3)),
        ("an unstable pole", (1.8, None)),
        ("a resonance", (1.4, 1.4)),
        ("a negative gain", (1.4, None)),
    ],
)
def test_the_pi_has_the_largest_integral_gain(plant, limits):
    sign = -1 if plant == "a negative gain" else 1
    data = LoopData.of(loop_of(plant, Kp=5.0 if plant == "an unstable pole" else 0.3 * sign, Ki=0.1 * sign))
    ranges = {"Kp": (-30.0, 30.0), "Ki": (-50.0, 0.0) if sign < 0 else (0.0, 50.0)}
    assert_largest(data, plant, ranges, limits)


def test_a_derivative_that_is_no_gain_of_the_specification_stays_as_it_is():
    data = LoopData.of(loop_of("four lags", Kd=0.5))
    assert_largest(data, "four lags", {"Kp": (0.1, 10.0), "Ki": (0.01, 5.0)}, (1.4, None), rest=0.5)


@pytest.mark.parametrize(("plant", "limits"), [("four lags", (1.4, None)), ("a resonance", (1.7, 1.2))])
def test_the_pid_has_the_largest_integral_gain(plant, limits):
    data = LoopData.of(loop_of(plant, Kd=0.2))
    assert_largest(data, plant, {"Kp": (0.0, 20.0), "Ki": (0.0, 20.0), "Kd": (0.0, 20.0)}, limits)


@pytest.mark.heavy
def test_in_a_computer_the_gains_are_those_of_its_periods():
    h, loop, limits = 0.1, loop_of("four lags"), (1.5, 1.3)
    data = LoopData.of(wb.DigitalLoop(loop, h, delay=True), 0.05, 1.0)
    (found,) = data.replies(asked(data, {"Kp": (0.0, 5.0), "Ki": (0.0, 5.0)}, *limits))
    k, ki = found["values"]
    assert_within(data.python(controller__Kp=[k], controller__Ki=[ki]), limits)
    omega = np.geomspace(1e-2, 0.999 * np.pi / h, 1000)
    one, two = (
        data.python(controller__Kp=[x], controller__Ki=[0.01]).response(omega).values[:, 0, 0] for x in (1.0, 2.0)
    )
    parts = (1 / (two - one), h / (np.exp(1j * omega * h) - 1), 0, 0)

    def stable(k, ki, kd):
        return data.python(controller__Kp=[k], controller__Ki=[ki]).stable

    assert ki == pytest.approx(largest_ki(omega, parts, limits, (k, ki, 0.0), stable, (0.1, 0.005)), rel=KI_WITHIN)


@pytest.mark.heavy
def test_of_a_law_of_two_signals_one_component_follows_with_the_other_loop_closed():
    lags = np.array([[-1.0, 1, 0, 0], [0, -1, 0.5, 0], [0, 0, -1, 1], [0.3, 0, 0, -0.7]])
    system = control.ss(lags, np.eye(4)[:, [1, 3]], np.eye(4)[[0, 2]], 0, inputs=["v1", "v2"], outputs=["y1", "y2"])
    plant = wb.LinearPlant(system)
    law = wb.PID(plant.outputs, plant.inputs, Kp=[0.3, 0.2], Ki=[0.1, 0.1])
    references = wb.CombinedReference(tuple(wb.Constant(name, "1", 1.0) for name in ("y1", "y2")))
    data = LoopData.of(wb.ClosedLoop(plant, controller=law, reference=references))
    question = asked(data, {"Kp": (0.01, 5.0), "Ki": (0.01, 5.0)}, 1.5) | {"channel": 1}
    for gain in question["gains"]:
        gain["p"] = [gain["p"][0] + 1]
    (found,) = data.replies(question)
    k, ki = found["values"]
    linear = data.python(controller__Kp=[0.3, k], controller__Ki=[0.1, ki])
    assert linear.stable
    assert linear.margins()["v2"].margins.Ms.gain.value == pytest.approx(1.5, rel=PEAK_WITHIN)
    assert ki > 0.1


def test_a_gain_stops_at_the_end_of_its_range():
    data = LoopData.of(loop_of("four lags"))
    turns = [
        asked(data, {"Kp": (0.1, 0.2), "Ki": (0.0, 5.0)}, 1.4),
        asked(data, {"Kp": (0.0, 5.0), "Ki": (0.0, 0.05)}, 1.4),
    ]
    narrow, weak = data.replies(*turns)
    assert narrow["values"][0] == pytest.approx(0.2, rel=1e-5)
    assert narrow["Ms"] == pytest.approx(1.4, rel=PEAK_WITHIN)
    assert weak["values"][1] == 0.05
    assert weak["Ms"] < 1.4


def test_what_is_out_of_reach_or_no_pid_is_refused():
    data = LoopData.of(loop_of("four lags"))
    high, wrong = data.replies(
        asked(data, {"Kp": (3.0, 5.0), "Ki": (0.1, 5.0)}, 1.4),
        asked(data, {"Kp": (0.0, 5.0), "N": (1.0, 50.0)}, 1.4),
    )
    assert high == {"reason": "none"}
    assert wrong == {"reason": "structure"}
