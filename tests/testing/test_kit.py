"""Each test of a kit can fail: a bad block is caught by the test that is for it, in one sentence with its name."""

from dataclasses import dataclass, replace
from itertools import count
from types import SimpleNamespace
from unittest import SkipTest

import casadi as ca
import numpy as np
import pytest

import workbench as wb
from tests.support.kits import assert_caught, kit_of
from tests.support.motor_blocks import PI, Motor
from workbench.handover.targets import CalledTarget
from workbench.testing import (
    LawTests,
    PlantTests,
    batch_bits,
    form_checks,
    law_tests,
    live_checks,
    plant_tests,
)

CALLS = count()


def law(**own):
    """The tests of a PI law with other methods or fields."""
    return kit_of(LawTests, "law", wb.block(type("Own", (wb.Controller,), _body(PI, own))))


def plant(**own):
    """The tests of a motor with other methods or fields."""
    more = {name: own.pop(name) for name in ("stored_energy", "lossless") if name in own}
    return kit_of(PlantTests, "plant", wb.block(type("Own", (wb.Plant,), _body(Motor, own))), **more)


def _body(cls, own):
    """The annotations, declarations and methods of a block, to be declared anew, and others in their place."""
    fields = cls.__dataclass_fields__
    annotations = {name: fields[name].type for name in fields} | own.pop("annotations", {})
    names = ("inputs", "outputs", "reads", "follows", "drives", "command", "rate")
    body = {name: vars(cls)[name] for name in names if name in vars(cls)}
    made = {name: _declared(field) for name, field in fields.items()}
    return {"__annotations__": annotations, "__doc__": "Own.", **body, **made, **own}


def _declared(field):
    quantity = field.metadata["quantity"]
    if not quantity.is_symbolic:
        return wb.initial(field.default, unit=quantity.unit)
    return wb.parameter(field.default, unit=quantity.unit, low=quantity.bounds.low, strict=quantity.bounds.strict)


@dataclass(frozen=True)
class Bare(wb.Controller):
    """A law that is no block."""

    reads = follows = wb.layout(omega="rad/s")
    drives = wb.layout(v="V")

    def command(self, t, z, est, ref):
        return {"v": ref.omega - est.omega}


class Lenient(PI):
    """A law that takes any number: its class has no `@block` of its own."""

    def __post_init__(self):
        """Check nothing."""


def counted(self, t, z, est, ref):
    return {"v": self.kp * (ref.omega - est.omega) + self.ki * z.z * next(CALLS)}


def without_unit(self, t, z, est, ref):
    return {"v": 50.0 * (ref.omega - est.omega)}


def of_another_unit(self, t, z, est, ref):
    return {"v": self.kp * (ref.omega - est.omega) + self.kp * z.z}


def remember(self):
    object.__setattr__(self, "twice", 2 * self.kp)


def squared(self):
    object.__setattr__(self, "ki", self.kp**2)


def remembered(self, t, z, est, ref):
    return {"v": self.twice * (ref.omega - est.omega)}


def lost(self, t, z, est, ref):
    return {"v": self.kp * ca.log(-(est.omega**2) - ref.omega**2)}


def unspoken(self, t, z, est, ref):
    return {"v": self.kp * ca.erf(ref.omega - est.omega)}


def two(self, t, z, est, ref):
    return {"v": ca.vertcat(est.omega, ref.omega)}


BLOCKS = [
    (kit_of(LawTests, "law", Bare), "test_each_number_is_declared", "`Bare` must be a class with `@wb.block`"),
    (
        law(annotations={"gain": float}, gain=2.0),
        "test_each_number_is_declared",
        r"`Own.gain` must be declared with its unit.*bare number 2\.0",
    ),
    (
        kit_of(LawTests, "law", Lenient),
        "test_each_number_refuses",
        r"`Lenient\(kp=...\)` must refuse a bad value; it took",
    ),
    (law(command=counted), "test_the_same_arguments", "`Own` must give the same equations each time; the second time"),
    (law(command=two), "test_the_same_arguments", r"shape \(1, 1\); it returned shape \(2, 1\)"),
    (law(command=without_unit), "test_each_equation_has_the_units", r"`Own.command\(...\)` must give 'v' in \[V\]"),
    (law(command=of_another_unit), "test_each_equation_has_the_units", "times as many 's' everywhere"),
    (law(mixed_units="it adds"), "test_each_equation_has_the_units", "it declares 'it adds': take `mixed_units` out"),
    (
        law(__post_init__=remember, command=remembered),
        "test_each_number_can_be_varied",
        "`Own` must have equations with its numbers as symbols; it raised AttributeError.*'twice'",
    ),
    (law(__post_init__=squared), "test_each_number_can_be_varied", "`Own.drives.v` must follow each number"),
    (law(command=lost), "test_runs_have_the_same_bits", "must run; a state of the loop .* is not finite"),
    (law(drives=wb.layout(omega="V")), "test_its_ports", "`Own` must have ports that a loop can connect"),
    (law(command=two), "test_its_ports", "must fit its loop in continuous time; the workbench refused it"),
    (law(command=lost), "test_a_run_in_a_computer", "must run in a computer"),
    (law(command=unspoken), "test_it_is_written_in_each_form", "must be exported in the form 'c'; .*ERF"),
    (law(command=unspoken), "test_its_module_of_python", "run in a computer|module of Python"),
    (law(command=unspoken), "test_its_live_page", "must have a live page"),
    (law(exportable=False), "test_it_is_written_in_each_form", "must be refused by each export.*'c.*' was written"),
    (law(exportable=False), "test_its_live_page", "its page is live"),
    (plant(states=wb.layout(i="A")), "test_the_same_arguments", "must answer with the signals that its ports declare"),
    (
        plant(rate=lambda self, t, x, u: {"i": ca.log(x.i - x.i) * u.v, "omega": -x.omega}),
        "test_it_starts_at_its_declared_state",
        r"`Own.rate.i` must be finite at the start",
    ),
    (
        plant(stored_energy=lambda self, plant, x: -(plant.L * x.i**2 + plant.J * x.omega**2) / 2),
        "test_its_energy",
        "must make no energy",
    ),
    (
        plant(stored_energy=lambda self, plant, x: (plant.L * x.i**2 + plant.J * x.omega**2) / 2, lossless=True),
        "test_its_energy",
        "must keep its energy but for the power of its inputs",
    ),
    (kit_of(PlantTests, "plant", PI), "test_each_jacobian", r"must return a `wb.Plant`"),
]


@pytest.mark.parametrize(("tests", "start", "says"), BLOCKS, ids=[row[1] for row in BLOCKS])
def test_a_bad_block_is_caught(tests, start, says):
    assert_caught(tests, start, says)


def test_what_no_machine_can_run_is_skipped_where_it_is_declared_so():
    tests = law(command=unspoken, exportable=False)
    tests.test_it_is_written_in_each_form()
    tests.test_its_live_page_computes_the_same_numbers()
    with pytest.raises(SkipTest, match="declared not to be exportable"):
        tests.test_its_c_code_has_the_bits_of_its_loop()


def test_a_stair_so_fine_that_it_has_a_slope_and_no_derivative_is_caught():
    def rate(self, t, x, u):
        return {"i": u.v - ca.floor(1e9 * x.i) / 1e9, "omega": -x.omega}

    assert_caught(plant(rate=rate), "test_each_jacobian_is_exact", "must have the exact derivative by 'states.i'")


def test_a_linear_model_with_another_matrix_is_caught(monkeypatch):
    wrong = SimpleNamespace(A=np.eye(2), B=np.zeros((2, 1)), C=np.zeros((1, 2)))
    monkeypatch.setattr(plant_tests, "linearize", lambda *given, **more: wrong)
    assert_caught(plant(), "test_its_linearisation", "must have the exact matrix A")


def test_an_engine_whose_bits_depend_on_the_company_is_caught(monkeypatch):
    true = batch_bits.simulate

    def simulate(step, p, x0, **more):
        run = true(step, p, x0, **more)
        return replace(run, x=run.x * (1 + 2.0**-52 * len(run.x)))

    monkeypatch.setattr(batch_bits, "simulate", simulate)
    assert_caught(law(), "test_runs_have_the_same_bits", "numbers of its runs differ alone")


def test_a_machine_with_other_bits_is_caught(monkeypatch):
    wrong = CalledTarget("wrong", lambda y, r: (100.0 * (r - y), None))
    monkeypatch.setitem(law_tests.TARGETS, "numpy", wrong)
    assert_caught(law(), "test_its_graph", "must give the bits of its loop on the target 'wrong'; at instant 0 'v' is")
    text = form_checks.python_law
    monkeypatch.setattr(form_checks, "python_law", lambda *given: text(*given).replace("50.0", "50.00000000000001"))
    assert_caught(law(), "test_its_module_of_python", "must give the bits of its loop in Python; .* from instant 0 on")
    true = live_checks._in_node
    monkeypatch.setattr(live_checks, "_in_node", lambda *given: np.nextafter(true(*given), 1.0))
    if live_checks.shutil.which("node"):
        assert_caught(law(), "test_its_live_page", "must give the bits of the portable arithmetic on its page")
