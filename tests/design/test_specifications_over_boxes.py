"""Specifications over a box of parameters: proved, refuted with a witness, or searched."""

import math

import casadi as ca
import numpy as np
import pytest

import workbench as wb
from tests.support.specified_loops import SLIDE, Slide, closed_forms, loop_of, peak_of_S
from workbench.design.loop_boxes import DampingAbove, DecayAbove, GainBelow, LoopFamily, ParameterBox, prove_over_box

OMEGA = 2.0


@wb.block
class Bent(wb.Plant):
    """A mass on a hardening spring under a constant load, whose rest moves with its numbers."""

    m: float = wb.parameter(default=1.0, unit="kg", low=0, strict=True)
    k: float = wb.parameter(default=1.0, unit="N/m", low=0)
    load: float = wb.parameter(default=1.0, unit="N")
    top: float = wb.parameter(default=1e9, unit="N")
    x: float = wb.initial(default=0.1, unit="m")
    v: float = wb.initial(default=0.0, unit="m/s")
    inputs, outputs = wb.layout(F="N"), wb.layout(x="m", v="m/s")

    def rate(self, t, x, u):
        return {"x": x.v, "v": (u.F + self.load - self.k * x.x - x.x**3 - 0.4 * x.v) / self.m}


@wb.block
class Limited(wb.Plant):
    """A mass with friction whose force has a limit, a corner of its equations."""

    m: float = wb.parameter(default=1.0, unit="kg", low=0, strict=True)
    x: float = wb.initial(default=0.0, unit="m")
    v: float = wb.initial(default=0.0, unit="m/s")
    inputs, outputs = wb.layout(F="N"), wb.layout(x="m", v="m/s")

    def rate(self, t, x, u):
        return {"x": x.v, "v": (ca.fmin(u.F, 50.0) - x.v) / self.m}


def worst_zeta():
    """Of c in [0.9, 1.1] and m in [0.8, 1.2] with Kp = 4: zeta = c / (2 sqrt(Kp m)) is least at a corner."""
    return 0.9 / (2 * math.sqrt(4 * 1.2))


BOX = {"plant.m": (0.8, 1.2), "plant.c": (0.9, 1.1)}


def test_a_box_is_proved_up_to_its_exact_worst_case_and_refuted_beyond_it_with_a_witness_at_its_corner():
    linear, zeta = wb.linear_loop(SLIDE), worst_zeta()
    exact = {"Ms": peak_of_S(zeta), "damping": zeta, "decay": 0.9 / (2 * 1.2)}
    kept = wb.Specification(Ms=1.1 * exact["Ms"], damping=0.9 * zeta, decay=0.9 * exact["decay"])
    verdicts = kept.check(linear, box=BOX, draws=16)
    for one in verdicts:
        assert one.kind == "proved", one
        assert one.figure.value.value == pytest.approx(exact[one.name], rel=1e-6)
    assert verdicts.is_proved
    broken = wb.Specification(Ms=0.99 * exact["Ms"], damping=1.01 * zeta, decay=1.01 * exact["decay"])
    for one in broken.check(linear, box=BOX, draws=16):
        assert one.kind == "refuted", one
        assert one.witness == {"plant.m": 1.2, "plant.c": 0.9}
        again = broken.check(wb.linear_loop(SLIDE, values=one.witness))[one.name]
        assert again.kind == "fails"
        assert again.figure.value.value == pytest.approx(one.figure.value.value, rel=1e-9)
        assert one.ruling.kind == "refuted"
        assert repr(one.witness["plant.m"]) in one.ruling.witness


def test_what_has_no_proof_is_searched_and_says_so():
    spec = wb.Specification(overshoot=80.0, phase_margin=10.0, delay_margin=1e-3, bandwidth=(1.0, 9.0), rise_time=2.0)
    linear = wb.linear_loop(SLIDE)
    verdicts = spec.check(linear, box=BOX, draws=8)
    zeta = worst_zeta()
    for one in verdicts:
        assert one.kind == "not refuted", one
        assert one.verdict == f"holds at {one.draws} draws"
        assert "No proof" in one.evidence
    assert verdicts.holds
    assert not verdicts.is_proved
    overshoot = 100 * math.exp(-math.pi * zeta / math.sqrt(1 - zeta**2))
    assert verdicts["overshoot"].figure.value.value == pytest.approx(overshoot, rel=1e-3)  # at the corner
    assert verdicts["phase_margin"].figure.value.value == pytest.approx(closed_forms(zeta)["phase_margin"], rel=1e-6)
    assert str(verdicts) == str(spec.check(linear, box=BOX, draws=8))


def test_an_unstable_draw_refutes_every_limit():
    loop = loop_of(Slide(), Kp=4.0, Ki=2.0)  # stable for Ki m < Kp c
    one = wb.Specification(phase_margin=1.0).check(wb.linear_loop(loop), box={"plant.c": (0.3, 1.5)}, draws=16)
    verdict = one["phase_margin"]
    assert verdict.kind == "refuted"
    assert verdict.witness["plant.c"] < 0.5
    assert "not stable" in verdict.evidence


@pytest.fixture(scope="module")
def bent():
    linear = wb.linear_loop(loop_of(Bent(), Kp=8.0, Ki=4.0, Kd=4.0, N=50.0))
    box = ParameterBox.of(
        "box", linear.parameters, {"plant.m": (0.9, 1.1), "plant.load": (0.5, 1.5), "plant.k": (0.8, 1.2)}
    )
    theta = box.at(np.random.default_rng(0).uniform(size=(100, 3)))
    return linear, box, theta, linear.rows(box.columns(theta))


def test_the_enclosed_matrices_hold_those_of_all_draws_although_the_rest_moves(bent):
    linear, box, theta, rows = bent
    family = LoopFamily.of(linear, box.labels, ("F_load",), ("F",))
    middle, radius = (box.low + box.high) / 2, (box.high - box.low) / 2
    found = family.enclose(middle[np.newaxis], radius[np.newaxis])
    M = family.matrices(rows.x[:, list(family.moving_states)], theta)
    assert np.ptp(rows.x, axis=0).max() > 0.1  # the rest moves
    away = np.abs(M - found.middle - np.einsum("kqw,nk->nqw", found.slopes[0], theta - middle))
    assert (away <= found.rest[0] + 1e-12 * np.abs(M)).all()
    A, model = M[:, : family.order, : family.order], rows.models.closed_model
    assert np.abs(A - model.A).max() <= 1e-9 * np.abs(A).max()  # two roads to one Jacobian


def test_what_is_proved_over_a_box_holds_at_every_draw(bent):
    (linear, box, theta, rows), margin = bent, 1.2
    omega = np.geomspace(0.05, 300, 600)
    peak = np.abs(rows.response(omega, "S").values).max()
    poles = rows.poles
    family, draws = LoopFamily.of(linear, box.labels, ("F_load",), ("F",)), (theta, rows.x)
    least, slowest = float((-poles.real / np.abs(poles)).min()), float((-poles.real).min())
    conditions = {
        GainBelow(margin * peak, ("F_load",), ("F",), 1.0): GainBelow(0.99 * peak, ("F_load",), ("F",), 1.0),
        DampingAbove(least / margin): DampingAbove(least * 1.01),
        DecayAbove(slowest / margin): DecayAbove(slowest * 1.01),
    }
    for kept, broken in conditions.items():
        assert prove_over_box(family, kept, box, draws, 3000).is_proved, kept
        assert not prove_over_box(family, broken, box, draws, 300).is_proved, broken


@pytest.mark.heavy
def test_a_proof_that_is_not_found_says_why():
    computer = wb.linear_loop(wb.DigitalLoop(SLIDE, 1e-2))
    limited = wb.linear_loop(loop_of(Limited()))
    late = wb.linear_loop(SLIDE, delays={"F": 1e-2})
    spec = wb.Specification(Ms=4.0)
    narrow = {"plant.m": (0.95, 1.05)}
    for linear, word in ((computer, "continuous"), (limited, "corner"), (late, "delays")):
        one = spec.check(linear, box=narrow, draws=4)["Ms"]
        assert one.kind == "not refuted", one
        assert word in one.evidence
    few = spec.check(wb.linear_loop(SLIDE), box=BOX, draws=16, parts=0)["Ms"]
    assert "budget of 0 boxes" in few.evidence


@pytest.mark.heavy
def test_the_line_of_a_witness_is_of_the_same_loop_with_its_delay_and_its_kept_states():
    motor = wb.DCMotor()
    law = wb.PID(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0)
    loop = wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0))
    late = wb.linear_loop(loop, delays={"v": 0.02})
    specification = wb.Specification(phase_margin=25.0)
    refuted = specification.check(late, box={"plant.J": (0.005, 0.03)}, draws=8)["phase_margin"]
    assert refuted.kind == "refuted"
    again = eval(refuted.witness_line, {"linear_loop": wb.linear_loop, "loop": loop})
    (found,) = specification.check(again)
    assert found.kind == "fails"
    assert found.figure.value.value == pytest.approx(refuted.figure.value.value, rel=1e-9)  # of two searches for a rest
