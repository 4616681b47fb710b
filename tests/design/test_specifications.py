"""Specifications as claims: verdicts at a point and over boxes, beside closed forms of a loop of second order."""

import math

import casadi as ca
import control
import numpy as np
import pytest

import workbench as wb
from tests.support.specified_loops import SLIDE, Slide, closed_forms, loop_of, peak_of_S
from workbench.design.matrices import DesignError

OMEGA = 2.0


def second_order(zeta):
    """The loop gain whose T is omega^2 / (s^2 + 2 zeta omega s + omega^2)."""
    return control.tf([OMEGA**2], [1, 2 * zeta * OMEGA, 0])


def limits(forms, share):
    """A specification that each figure keeps by a share of it; one of a negative share it breaks."""
    low = {name: forms[name] * (1 - share) for name in ("damping", "decay", "phase_margin")}
    high = {name: forms[name] * (1 + share) for name in ("Ms", "Mt", "overshoot")}
    if share < 0:
        return wb.Specification(**low, **high, bandwidth=(0.0, forms["bandwidth"] * (1 + share)))
    return wb.Specification(**low, **high, bandwidth=(forms["bandwidth"] * (1 - share), math.inf))


@pytest.mark.parametrize("zeta", [0.2, 0.5, 0.65])
def test_figures_of_second_order_are_their_closed_forms_and_limits_on_both_sides_are_told_apart(zeta):
    forms = closed_forms(zeta)
    for share, kind in ((1e-3, "holds"), (-1e-3, "fails")):
        for one in limits(forms, share).check(second_order(zeta)):
            assert one.kind == kind, one
            value = one.figure.value
            exact = 1e-10 if one.figure.is_proved else 1e-3  # a sampled step is known to its stated error
            assert value.low - exact * value.value <= forms[one.name] <= value.high + exact * value.value
            assert (one.margin > 0) == (kind == "holds")


def test_a_limit_between_the_bounds_of_a_figure_is_undecided():
    figure = wb.Specification(damping=0.4).check(second_order(0.5))["damping"].figure.value
    assert figure.low < 0.5 < figure.high
    verdicts = wb.Specification(damping=0.5).check(second_order(0.5))
    assert verdicts["damping"].kind == "undecided"
    assert not verdicts.holds


def test_a_linear_loop_has_the_figures_of_its_loop_gain():
    linear = wb.linear_loop(SLIDE)
    zeta = 1 / (2 * math.sqrt(4.0))
    spec = wb.Specification(Ms=4.0, damping=0.1, overshoot=80.0, bandwidth=(1.0, 9.0), gain_margin=2.0, noise_gain=5.0)
    ours, theirs = spec.check(linear), spec.check(second_order(zeta))
    for name in ("Ms", "damping", "overshoot", "bandwidth"):
        assert ours[name].figure.value.value == pytest.approx(theirs[name].figure.value.value, rel=1e-6)
    assert ours["noise_gain"].figure.value.value == pytest.approx(4 * peak_of_S(zeta), rel=1e-9)  # CS = 4 S
    assert theirs["noise_gain"].kind == "not checkable"
    assert "linear_loop" in theirs["noise_gain"].evidence
    assert ours["overshoot"].figure.of == "from x_ref to x"
    assert spec.check(linear, inputs="x_ref", outputs="x")["overshoot"].margin == ours["overshoot"].margin


BOX = {"plant.m": (0.8, 1.2), "plant.c": (0.9, 1.1)}


@wb.block
class Tanks(wb.Plant):
    """Two tanks that drain by Torricelli's law, each pump feeding both."""

    a: float = wb.parameter(default=0.5, unit="m^0.5/s", low=0)
    h1: float = wb.initial(default=1.0, unit="m")
    h2: float = wb.initial(default=1.0, unit="m")
    inputs, outputs = wb.layout(u1="m/s", u2="m/s"), wb.layout(h1="m", h2="m")

    def rate(self, t, x, u):
        return {
            "h1": u.u1 + 0.3 * u.u2 - self.a * ca.sqrt(x.h1),
            "h2": u.u2 + 0.2 * u.u1 - 0.3 * ca.sqrt(x.h2),
        }


@wb.block
class Levels(wb.Controller):
    """Two PI laws, one for each tank."""

    z1: float = wb.initial(default=0.0, unit="m s")
    z2: float = wb.initial(default=0.0, unit="m s")
    reads = follows = wb.layout(h1="m", h2="m")
    drives = wb.layout(u1="m/s", u2="m/s")

    def command(self, t, z, est, ref):
        return {"u1": ref.h1 - est.h1 + 0.3 * z.z1, "u2": ref.h2 - est.h2 + 0.3 * z.z2}

    def rate(self, t, z, est, ref):
        return {"z1": ref.h1 - est.h1, "z2": ref.h2 - est.h2}


def test_a_loop_with_several_channels_has_the_figures_of_all_at_once():
    reference = wb.CombinedReference((wb.Step("h1", "m", 1.0), wb.Step("h2", "m", 1.5)))
    linear = wb.linear_loop(wb.ClosedLoop(Tanks(), controller=Levels(), reference=reference))
    spec = wb.Specification(Mt=1.3, disk_margin=0.9, phase_margin=40.0, decay=0.1, overshoot=40.0)
    omega = np.geomspace(1e-3, 1e3, 2000)
    point = spec.check(linear)
    peak = np.linalg.norm(linear.response(omega, "T").values, 2, axis=(-2, -1)).max()
    assert point["Mt"].figure.value.high >= peak * (1 - 1e-12)
    assert point["Mt"].figure.value.low <= peak * (1 + 1e-4)  # of a grid with 300 frequencies a decade
    assert "name two" in point["overshoot"].evidence
    box = spec.check(linear, box={"plant.a": (0.48, 0.52)}, inputs="h1_ref", outputs="h1", draws=16)
    kinds = {one.name: one.kind for one in box}
    assert kinds == dict.fromkeys(("Mt", "disk_margin", "decay"), "proved") | dict.fromkeys(
        ("phase_margin", "overshoot"), "not refuted"
    )


def test_a_delay_has_no_poles_and_the_other_figures_stand():
    late = wb.Specification(Ms=4.0, damping=0.1).check(wb.linear_loop(SLIDE, delays={"F": 1e-2}))
    assert late["damping"].kind == "not checkable"
    assert "delay" in late["damping"].evidence
    assert late["Ms"].kind == "holds"


@pytest.mark.parametrize("zeta", [0.2, 0.5])
def test_a_sampled_loop_has_the_damping_and_decay_of_its_poles(zeta):
    h = 0.05
    sampled = control.sample_system(control.ss(second_order(zeta)), h)
    poles = np.log(control.feedback(sampled).poles()) / h
    verdicts = wb.Specification(damping=0.05, decay=0.05).check(sampled)
    assert verdicts["damping"].figure.value.value == pytest.approx((-poles.real / abs(poles)).min(), rel=1e-9)
    assert verdicts["decay"].figure.value.value == pytest.approx((-poles.real).min(), rel=1e-9)


def test_verdicts_become_a_table_a_ledger_and_lines():
    spec = wb.Specification(Ms=4.0, damping=0.3)
    verdicts = spec.check(wb.linear_loop(SLIDE), box=BOX, draws=16)
    table = verdicts.table("limits")
    assert [row[0] for row in table.rows] == ["Ms <= 4", "damping >= 0.3"]
    assert table.rows[0][1].text == "proved over the box"
    assert "plant.m = 1.2" in str(verdicts["damping"])
    assert "plant.m in [0.8, 1.2]" in table.caption
    ledger = verdicts.ledger
    assert [line.ruling.kind for line in ledger] == ["proved", "refuted"]
    assert "refuted" in repr(verdicts)
    assert verdicts._repr_html_().count("<tr>") == 3
    with pytest.raises(LookupError, match="Did you mean 'damping'"):
        _ = verdicts["dampin"]


def test_the_regions_of_a_nyquist_plot_are_the_limits():
    spec = wb.Specification(Ms=1.5, Mt=1.2, disk_margin=0.8)
    gains = {"Ms": lambda L: 1 / (1 + L), "Mt": lambda L: L / (1 + L), "disk": lambda L: (1 - L) / (1 + L) / 2}
    levels = {"Ms": 1.5, "Mt": 1.2, "disk": 1 / 0.8}
    for disk, (name, gain) in zip(spec.disks, gains.items(), strict=True):
        assert np.abs(gain(disk.edge)) == pytest.approx(np.full(len(disk.edge), levels[name]), rel=1e-9)
        assert abs(gain(disk.centre + 0.5 * disk.radius)) > levels[name]


def test_the_regions_of_a_bode_plot_are_the_limits():
    spec = wb.Specification(Ms=1.5, Mt=1.2, bandwidth=(1.0, 5.0), noise_gain=10.0)
    assert [(b.forbidden_side, float(b.gains[0])) for b in spec.gain_bounds("S")] == [("above", 1.5)]
    top, low, high = spec.gain_bounds("T")
    assert (top.gains[0], low.forbidden_side, low.frequencies[-1], high.frequencies[0]) == (1.2, "below", 1.0, 5.0)
    assert spec.gain_bounds("CS")[0].gains[0] == 10.0
    assert wb.bode(control.tf([1], [1, 1]), bounds=spec.gain_bounds("T")).svg.startswith("<")
    with pytest.raises(ValueError, match=r"one of 'S', 'T', 'CS'"):
        spec.gain_bounds("L")


@pytest.mark.parametrize(
    ("limits", "word"),
    [
        ({}, "at least one limit"),
        ({"Ms": 1.0}, "no loop has a smaller peak"),
        ({"Ms": math.nan}, "above 1"),
        ({"Mt": -1.0}, "above 0"),
        ({"bandwidth": (5.0, 1.0)}, "exchange its ends"),
        ({"bandwidth": (math.nan, 1.0)}, "low < high"),
        ({"bandwidth": (0.0, math.inf)}, "limits nothing"),
        ({"damping": 1.2}, "below 1"),
        ({"gain_margin": 0.5}, "above 1"),
        ({"phase_margin": 200.0}, "below 180"),
        ({"overshoot": -1.0}, "percent"),
        ({"settling_time": 0.0}, "above 0"),
    ],
)
def test_a_limit_out_of_its_range_is_refused(limits, word):
    with pytest.raises(ValueError, match=word):
        wb.Specification(**limits)


@pytest.mark.parametrize(
    ("box", "error", "word"),
    [
        ({"plant.mm": (0.8, 1.2)}, LookupError, "Did you mean 'plant.m'"),
        ({"plant.m": (-1.0, 1.2)}, ValueError, "within the bounds of 'plant.m', finite, with 0 < value"),
        ({"plant.m": (1.2, 0.8)}, ValueError, "low < high"),
        ({"plant.m": (1.0, 1.0)}, ValueError, "leave out"),
        ({"plant.m": (0.8, math.nan)}, ValueError, "finite ends"),
        ({"plant.m": 0.8}, ValueError, "a pair"),
        ({}, ValueError, "at least one parameter"),
    ],
)
def test_a_box_that_is_none_is_refused(box, error, word):
    with pytest.raises(error, match=word):
        wb.Specification(Ms=2.0).check(wb.linear_loop(SLIDE), box=box)


def test_loops_without_figures_are_refused():
    spec = wb.Specification(Ms=2.0)
    with pytest.raises(DesignError, match="must have a stable loop"):
        spec.check(control.tf([4], [1, -1, 0]))
    with pytest.raises(DesignError, match="must have a stable loop: The closed loop is not stable: the mode"):
        spec.check(wb.linear_loop(loop_of(Slide(), Kp=4.0, Ki=8.0)))
    with pytest.raises(ValueError, match="as `linear_loop` makes it"):
        spec.check(SLIDE)
    with pytest.raises(ValueError, match="has no parameters"):
        spec.check(second_order(0.5), box=BOX)
    with pytest.raises(ValueError, match="T alone"):
        spec.check(second_order(0.5), inputs="x")
    with pytest.raises(LookupError, match="x_ref"):
        spec.check(wb.linear_loop(SLIDE), inputs="x_reff", outputs="x")
    with pytest.raises(ValueError, match="or neither"):
        spec.check(wb.linear_loop(SLIDE), inputs="x_ref")


def test_a_sampled_loop_gain_with_several_channels_is_refused_by_the_name_of_the_call():
    two = control.ss(0.9 * np.eye(2), 0.5 * np.eye(2), np.eye(2), np.zeros((2, 2)), 0.1)
    with pytest.raises(
        ValueError, match=r"`Specification.check\(loop=...\)` takes a sampled loop gain with one channel"
    ):
        wb.Specification(decay=1.0).check(two)
