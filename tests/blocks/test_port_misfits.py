"""Ports that do not fit, and blocks that return something else than their ports say, are refused with their names."""

import math
import warnings

import casadi as ca
import numpy as np
import pytest

from tests.support.motor_blocks import Motor, law, motor, plant
from workbench.blocks.loop import (
    AbstractObserver,
    AbstractPlant,
    ClosedLoop,
    open_loop,
)
from workbench.core import block, layout


def observer(**own):
    plain = {
        "reads": layout(omega="rad/s"),
        "gives": layout(omega="rad/s"),
        "estimate": lambda self, t, z, y: {"omega": y.omega},
    }
    return block(type("Watcher", (AbstractObserver,), {**plain, **own}))()


MISFITS = [
    (
        lambda: motor(reference=None),
        "`PI` follows 'omega', and the loop has no reference: give `ClosedLoop(reference=...)` one that gives it, as a "
        "`Step` does.",
    ),
    (lambda: motor(plant=plant()), "`PI` reads 'omega', where `Tank` gives 'x'."),
    (
        lambda: motor(observer=observer(gives=layout(omega="deg/s"))),
        "`PI` reads 'omega' in [rad/s], where `Watcher` gives it in [deg/s].",
    ),
    (
        lambda: motor(observer=observer(reads=layout(omega=("rad/s", [0, 0])))),
        "`Watcher` reads 'omega' as 2 numbers, where `Motor` gives it as one number.",
    ),
    (
        lambda: motor(observer=observer(reads=layout(omgea="rad/s"))),
        "`Watcher` reads 'omgea', where `Motor` gives 'omega'; did you mean 'omega'?",
    ),
    (
        lambda: motor(observer=observer(inputs=layout(u="V"))),
        "`Watcher` counts on 'u', where `Motor` has as inputs 'v'.",
    ),
    (
        lambda: motor(controller=law(drives=layout(v="V", brake="N m"))),
        "`Own` drives 'brake', where `Motor` has as inputs 'v'.",
    ),
    (
        lambda: motor(controller=law(drives=layout())),
        "Every input of `Motor` must be driven: nothing drives 'v', as `Own` drives nothing.",
    ),
    (
        lambda: motor(plant=plant(inputs=layout(v="V", w="V")), controller=law()),
        "nothing drives 'w', as `Own` drives 'v'.",
    ),
    (lambda: ClosedLoop(Motor()), "`ClosedLoop(controller=...)` must be an `AbstractController`; got None."),
    (
        lambda: motor(plant=plant(truths=layout(d="V")), observer=observer(reads=layout(d="V")), controller=law()),
        "`Watcher` reads 'd', which no instrument of `Tank` gives: read one of 'x', or declare `uses_truth = True`.",
    ),
    (
        lambda: ClosedLoop(plant(outputs=layout(v="m")), controller=law()),
        "here 'v' would stand for two of them: rename an input or an output of `Tank`.",
    ),
]


@pytest.mark.parametrize(("make", "says"), MISFITS)
def test_ports_that_do_not_fit_are_refused_with_both_blocks(make, says):
    with pytest.raises(ValueError) as error:
        make()
    assert says in str(error.value)


RETURNS = [
    ([1.0, 2.0], "`Own.command(...)` must return 'v'; it returned [1.0, 2.0]."),
    (None, "`Own.command(...)` must return 'v'; it returned None."),
    ({}, "`Own.command(...)` must return 'v'; it returned an empty mapping, without 'v'."),
    ({"v": 1.0, "w": 2.0}, "`Own.command(...)` must return 'v', and no more; it returned 'w' too."),
    ({"v": ca.SX.zeros(2)}, "`Own.command(...)` must return 'v' in shape (1, 1); it returned shape (2, 1)."),
    ({"v": "fast"}, "`Own.command(...)` must return 'v' as an expression of shape (1, 1); it returned 'fast'."),
]


@pytest.mark.parametrize(("returned", "says"), RETURNS)
@pytest.mark.parametrize("make", [lambda loop: loop.ode(), lambda loop: loop.digital(0.1)])
def test_a_law_that_returns_something_else_is_refused_by_class_and_method(returned, says, make):
    with pytest.raises(ValueError) as error:
        make(ClosedLoop(Motor(), controller=law(command=lambda self, t, z, est, ref: returned)))
    assert str(error.value).startswith(says)


@pytest.mark.parametrize(
    "command",
    [
        lambda self, t, z, est, ref: {"v": math.sin(est.omega)},
        lambda self, t, z, est, ref: {"v": float(t)},
        lambda self, t, z, est, ref: {"v": max(est.omega, 0.0)},
        lambda self, t, z, est, ref: {"v": 1.0 if est.omega > 0 else 2.0},
    ],
)
def test_a_law_that_takes_a_symbol_for_a_number_is_refused_and_gives_no_nan(command):
    """Python's `math` makes NaN of CasADi's symbols without a word: every run would have been called diverged."""
    loop = ClosedLoop(Motor(), controller=law(reads=layout(omega="rad/s"), command=command))
    says = r"`Own.command\(...\)` must compute with symbols .* is no number: take `ca.sin`.*`ca.if_else\(c, a, b\)`"
    for make in (lambda: loop.ode(), lambda: loop.digital(0.1)):
        with pytest.raises(ValueError, match=says):
            make()


def test_numpys_functions_serve_in_a_law_without_a_warning():
    own = law(reads=layout(omega="rad/s"), command=lambda self, t, z, est, ref: {"v": np.sin(est.omega)})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ode = ClosedLoop(Motor(), controller=own).ode()
    assert ode.outputs_at(0.0, [0.0, 0.5])["v"] == math.sin(0.5)


@pytest.mark.parametrize("port", ["reads", "follows", "drives", "memory"])
def test_a_port_that_is_no_layout_is_refused_by_its_name(port):
    with pytest.raises(ValueError, match=rf"`Own.{port}` must be a `Layout`, as .* of names and units; got 'v'\."):
        ClosedLoop(Motor(), controller=law(**{port: "v"}))


def test_a_plant_that_cannot_move_is_refused():
    with pytest.raises(ValueError, match=r"`Tank` must have a `rate`, or an `update` and a `period`"):
        open_loop(plant(rate=AbstractPlant.rate))


def test_each_method_of_each_block_is_held_to_its_port():
    def says(loop):
        with pytest.raises(ValueError) as error:
            loop.ode()
        return str(error.value)

    def odd(self, *given):
        return {"odd": 0}

    assert "`Tank.rate(...)` must return 'x'" in says(ClosedLoop(plant(rate=odd), controller=law()))
    assert "`Tank.measure(...)` must return 'x'" in says(ClosedLoop(plant(measure=odd), controller=law()))
    assert "`Tank.applied_inputs(...)` must return 'v'" in says(ClosedLoop(plant(applied_inputs=odd), controller=law()))
    assert "`Watcher.estimate(...)` must return 'omega'" in says(motor(observer=observer(estimate=odd)))
    assert "`Own.rate(...)` must return an empty mapping" in says(ClosedLoop(Motor(), controller=law(rate=odd)))
    assert "`Own.signals(...)` must return a mapping; it returned None" in says(
        ClosedLoop(Motor(), controller=law(signals=lambda self, z, est, ref: None))
    )
