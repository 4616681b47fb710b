"""Specifications as claims: verdicts at a point and over boxes, beside closed forms of a loop of second order."""

import math

import casadi as ca
import control
import numpy as np
import pytest

import workbench as wb
from workbench.design.loop_boxes import GainBelow, LoopFamily, ParameterBox, PolesDamped, PolesDecay, prove_over_box
from workbench.design.matrices import Refused

OMEGA = 2.0


@wb.block
class Slide(wb.Plant):
    """A mass with friction: m x'' = F - c x'."""

    m: float = wb.parameter(default=1.0, unit="kg", low=0, strict=True)
    c: float = wb.parameter(default=1.0, unit="N s/m", low=0)
    x: float = wb.initial(default=0.0, unit="m")
    v: float = wb.initial(default=0.0, unit="m/s")
    inputs, outputs = wb.layout(F="N"), wb.layout(x="m", v="m/s")

    def rate(self, t, x, u):
        return {"x": x.v, "v": (u.F - self.c * x.v) / self.m}


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


@wb.block
class Proportional(wb.Controller):
    """F = k (x_ref - x)."""

    k: float = wb.parameter(default=4.0, unit="N/m")
    reads = follows = wb.layout(x="m")
    drives = wb.layout(F="N")

    def command(self, t, z, est, ref):
        return {"F": self.k * (ref.x - est.x)}


def loop_of(plant, **gains):
    law = wb.PID2(wb.layout(x="m"), plant.inputs, **gains) if gains else Proportional()
    return wb.ClosedLoop(plant, controller=law, reference=wb.Step("x", "m", 0.5))


SLIDE = loop_of(Slide())


def second_order(zeta):
    """The loop gain whose T is omega^2 / (s^2 + 2 zeta omega s + omega^2)."""
    return control.tf([OMEGA**2], [1, 2 * zeta * OMEGA, 0])


def peak_of_S(zeta):
    """Åström and Hägglund (2006), Advanced PID Control, section 4.6."""
    root = math.sqrt(8 * zeta**2 + 1)
    return math.sqrt((root**2 + (4 * zeta**2 + 1) * root) / (root**2 + (4 * zeta**2 - 1) * root))


def closed_forms(zeta):
    shrink, drop = 1 - 2 * zeta**2, 10**-0.3
    return {
        "Ms": peak_of_S(zeta),
        "Mt": 1 / (2 * zeta * math.sqrt(1 - zeta**2)),
        "bandwidth": OMEGA * math.sqrt(shrink + math.sqrt(shrink**2 - 1 + 1 / drop)),
        "damping": zeta,
        "decay": zeta * OMEGA,
        "phase_margin": math.degrees(math.atan2(2 * zeta, math.sqrt(math.sqrt(1 + 4 * zeta**4) - 2 * zeta**2))),
        "overshoot": 100 * math.exp(-math.pi * zeta / math.sqrt(1 - zeta**2)),
    }


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
            exact = 1e-10 if one.figure.proved else 1e-3  # a sampled step is known to its stated error
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
    assert verdicts.proved
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
    assert not verdicts.proved
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
    found = family.enclosed(middle[np.newaxis], radius[np.newaxis])
    M = family.matrices(rows.x[:, list(family.moving)], theta)
    assert np.ptp(rows.x, axis=0).max() > 0.1  # the rest moves
    away = np.abs(M - found.middle - np.einsum("kqw,nk->nqw", found.slopes[0], theta - middle))
    assert (away <= found.rest[0] + 1e-12 * np.abs(M)).all()
    A, model = M[:, : family.order, : family.order], rows.models.closed
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
        PolesDamped(least / margin): PolesDamped(least * 1.01),
        PolesDecay(slowest / margin): PolesDecay(slowest * 1.01),
    }
    for kept, broken in conditions.items():
        assert prove_over_box(family, kept, box, draws, 3000).proved, kept
        assert not prove_over_box(family, broken, box, draws, 300).proved, broken


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
    reference = wb.Together((wb.Step("h1", "m", 1.0), wb.Step("h2", "m", 1.5)))
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
    assert [(b.forbidden, float(b.gains[0])) for b in spec.gain_bounds("S")] == [("above", 1.5)]
    top, low, high = spec.gain_bounds("T")
    assert (top.gains[0], low.forbidden, low.frequencies[-1], high.frequencies[0]) == (1.2, "below", 1.0, 5.0)
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
    with pytest.raises(Refused, match="must have a stable loop"):
        spec.check(control.tf([4], [1, -1, 0]))
    with pytest.raises(Refused, match="must have a stable loop: The closed loop is not stable: the mode"):
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


def test_the_line_of_a_witness_is_of_the_same_loop_with_its_delay_and_its_kept_states():
    motor = wb.DCMotor()
    law = wb.PID2(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0)
    loop = wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0))
    late = wb.linear_loop(loop, delays={"v": 0.02})
    specification = wb.Specification(phase_margin=25.0)
    refuted = specification.check(late, box={"plant.J": (0.005, 0.03)}, draws=8)["phase_margin"]
    assert refuted.kind == "refuted"
    again = eval(refuted.witness_line, {"linear_loop": wb.linear_loop, "loop": loop})
    (found,) = specification.check(again)
    assert found.kind == "fails"
    assert found.figure.value.value == pytest.approx(refuted.figure.value.value, rel=1e-9)  # of two searches for a rest


def test_a_sampled_loop_gain_with_several_channels_is_refused_by_the_name_of_the_call():
    two = control.ss(0.9 * np.eye(2), 0.5 * np.eye(2), np.eye(2), np.zeros((2, 2)), 0.1)
    with pytest.raises(
        ValueError, match=r"`Specification.check\(loop=...\)` takes a sampled loop gain with one channel"
    ):
        wb.Specification(decay=1.0).check(two)
