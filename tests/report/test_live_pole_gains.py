"""Poles that several gains move on a live page: a state feedback, two gains of one kind, and a computer."""

import math

import control
import numpy as np
import pytest

import workbench as wb
from studies.performance.chromium import open_browser, open_page
from tests.support.browsers import needs_chromium
from tests.support.compilers import needs_llvmlite
from tests.support.pole_handles import MAP, PLACED, POLES, SHOWN, STILL, TOLD, drag, gains, knobs, loop, nearest, poles

pytestmark = [needs_chromium, needs_llvmlite]


@pytest.fixture(scope="module")
def browser():
    with open_browser() as browser:
        yield browser


MASSES = control.ss(
    [[0, 0, 1, 0, 0], [0, 0, 0, 1, 0], [-1, 1, 0, 0, 0], [1, -1, 0, 0, 0], [0, 0, 0, 0, -0.5]],
    [[0], [0], [1], [0], [0]], np.eye(5), 0,
    inputs="f", outputs=["x1", "x2", "v1", "v2", "slow"], states=["x1", "x2", "v1", "v2", "slow"],
)  # fmt: skip
CONTROLLED = control.ss(MASSES.A[:4, :4], MASSES.B[:4], np.eye(4), 0)


def feedback(K):
    plant = wb.LinearPlant(MASSES)
    return wb.ClosedLoop(plant, controller=wb.StateFeedback.of(plant, [[*K, 0.0]]))


def test_the_gains_of_a_state_feedback_place_a_pair_and_hold_the_other_poles(tmp_path, browser):
    K, placed = (wb.place(CONTROLLED, [pole, pole.conjugate(), -2, -3]).K[0] for pole in (-1 + 1j, -1.5 + 1.5j))
    room = 1.2 * max(abs(placed - K))
    turned = [wb.Knob(f"k{i + 1}", f"controller.K[0,{i}]", k - room, k + room) for i, k in enumerate(K)]
    written = wb.live(feedback(K), until=0.1, knobs=turned).write(tmp_path / "masses.html")
    with open_page(written, browser=browser) as page:
        page.until(SHOWN)
        assert all(abs(complex(*one) + 0.5) > 0.1 for one in page.value(POLES))  # no gain moves it
        stop = drag(page, -1 + 1j, -1.5 + 1.5j)
        assert abs(stop - (-1.5 + 1.5j)) < PLACED
        found = knobs(page)
        np.testing.assert_allclose([found[f"k{i + 1}"] for i in range(4)], placed, rtol=PLACED)
        assert page.value(f"{MAP}.choice.selectedOptions[0].textContent") == "k1, k2, k3 and k4, and no other pole"
        stop = drag(page, -1.5 + 1.5j, -2.5 + 1.7j)  # on the straight way until a gain ends
        found = knobs(page)
        assert max(abs(found[f"k{i + 1}"] - k) for i, k in enumerate(K)) == pytest.approx(room, rel=PLACED)
        direction = (stop - (-1.5 + 1.5j)) / (-1 + 0.2j)
        assert abs(direction.imag) < PLACED
        assert 0 < direction.real < 1
        held = poles(feedback([found[f"k{i + 1}"] for i in range(4)]))
        for expected in (-2, -3):
            assert nearest(held, expected) == pytest.approx(expected, rel=PLACED)
        assert "as far on the way there as the other poles stay" in page.value(TOLD)
        assert page.complaints == []


@wb.block
class TwoGains(wb.Controller):
    """v = a b e with e = omega_ref - omega: two gains that move poles the same way, and a third that moves none."""

    a: float = wb.parameter(unit="V s/rad")
    b: float = wb.parameter(unit="1")
    c: float = wb.parameter(unit="V")

    reads = follows = wb.layout(omega="rad/s")
    drives = wb.layout(v="V")

    def command(self, t, z, est, ref):
        return {"v": self.a * self.b * (ref.omega - est.omega) + self.c}


@pytest.mark.heavy
def test_two_knobs_that_move_a_pair_the_same_way_place_nothing_and_one_is_followed(tmp_path, browser):
    def alike(a):
        law = TwoGains(a, 2.0, 1.0)
        return wb.ClosedLoop(wb.DCMotor(), controller=law, reference=wb.Step("omega", "rad/s", 1.0))

    start = nearest(poles(alike(50.0)), 10j)
    with open_page(wb.live(alike(50.0), until=0.1).write(tmp_path / "alike.html"), browser=browser) as page:
        page.until(SHOWN)
        offered = page.value(f"[...{MAP}.choice.options].map((one) => one.textContent)")
        assert sorted(offered) == ["controller.a alone", "controller.b alone"]
        both = f"{MAP}.records.find(({{at}}) => at.im > 0).choices = [{{knobs: [0, 1], holds: false, key: 'both'}}]"
        page.value(both)  # as if a reader had chosen them where they differ
        drag(page, start, start - 3)
        assert math.isclose(nearest([complex(*one) for one in page.value(POLES)], start).imag, start.imag)
        found = knobs(page)
        assert found["controller.a"] * found["controller.b"] == pytest.approx(100, rel=1e-6)
        page.value("livePage.bench.reset()")
        page.until(f"{STILL} && !livePage.answers.size")
        page.value(both)
        stop = drag(page, start, start + 2j)
        found = knobs(page)
        assert (found["controller.a"] != 50) != (found["controller.b"] != 2)
        assert abs(stop - (start + 2j)) < PLACED * abs(stop)
        followed = "a" if found["controller.a"] != 50 else "b"
        assert page.value(TOLD) == (
            "Here controller.a and controller.b do not place this pole in one way: "
            f"it follows controller.{followed} alone."
        )
        assert page.complaints == []


@pytest.mark.heavy
def test_in_a_computer_a_pair_is_placed_in_the_plane_of_its_periods(tmp_path, browser):
    closed = wb.DigitalLoop(loop(), 0.01)
    start = nearest(poles(closed, substeps=2), 0.95 + 0.1j)
    with open_page(wb.live(closed, until=0.2, h=5e-3).write(tmp_path / "computer.html"), browser=browser) as page:
        page.until(SHOWN)
        target = start + 0.005 - 0.01j
        stop = drag(page, start, target)
        assert abs(stop - target) < PLACED
        found = nearest(poles(wb.DigitalLoop(loop(**gains(page)), 0.01), substeps=2), target)
        assert found == pytest.approx(stop, rel=1e-9)
        assert page.complaints == []
