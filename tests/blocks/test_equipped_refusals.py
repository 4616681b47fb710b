"""Sensors and actuators that fit no plant, and elements that give something else than they say, are refused."""

import casadi as ca
import pytest

from tests.support.equipped_motor import Mixed, Motor
from workbench.blocks.loop import AbstractPlant, Instruments, open_loop
from workbench.blocks.plants import (
    AbstractElement,
    Backlash,
    EquippedPlant,
    FirstOrder,
    Saturation,
)
from workbench.core import block, initial, layout


@block
class Discrete(AbstractPlant):
    """x+ = x + v."""

    period = 0.1
    x: float = initial(0.0, unit="V")
    inputs = layout(v="V")
    outputs = layout(x="V")

    def update(self, t, x, u):
        return {"x": x.x + u.v}


REFUSED = [
    (lambda: EquippedPlant(Motor(), (Saturation("w", -1, 1),)), LookupError, "no 'w' among the 1 inputs of the plant"),
    (
        lambda: EquippedPlant(Motor(), (), (FirstOrder("omga", 1),)),
        LookupError,
        "no 'omga' among the 1 outputs of the plant. Did you mean 'omega'",
    ),
    (
        lambda: EquippedPlant(Motor(), (Saturation("v", [-1.0], 1),)),
        ValueError,
        r"`Saturation\(low=...\)` in `actuators` must be one number, as 'v' is; got shape \(1,\)",
    ),
    (
        lambda: EquippedPlant(Mixed(), (FirstOrder("tau", [1.0, 2.0, 3.0]),)),
        ValueError,
        r"`FirstOrder\(time_constant=...\)` in `actuators` must be 2 numbers, one for each of 'tau', or one for all",
    ),
    (
        lambda: EquippedPlant(Mixed(), (Saturation("tau", -1, 1),)),
        ValueError,
        r"`Saturation\(low=...\)` in `actuators` must be 2 numbers, one for each of 'tau' \(in N, N m\)",
    ),
    (
        lambda: EquippedPlant(Motor(), (), (Instruments.of(Motor(), noise={"omega": 0.1}),)),
        ValueError,
        "white noise in continuous time has no step, so give the instruments to `digital",
    ),
    (lambda: EquippedPlant(Motor(), Saturation("v", -1, 1)), ValueError, "one alone is written"),
    (
        lambda: EquippedPlant(
            EquippedPlant(Motor(), (), (FirstOrder("omega", 0.1),)), (), (Saturation("omega", -1, 1),)
        ),
        ValueError,
        "must leave the name 'omega_true' .* put all sensors of 'omega' into one `EquippedPlant`",
    ),
    (
        lambda: EquippedPlant(Discrete(), (FirstOrder("v", 0.1),)),
        ValueError,
        r"`FirstOrder` of 'v' in `actuators` must move in discrete time, as `Discrete` does.*without a `time_constant`",
    ),
    (
        lambda: open_loop(EquippedPlant(Motor(), (), (Backlash("omega", 0.1),))),
        ValueError,
        r"`EquippedPlant` has 'omega.driven_side', which moves at the instants of a comp.*give it its `time_constant`",
    ),
]


@pytest.mark.parametrize(("make", "kind", "says"), REFUSED)
def test_equipment_that_fits_no_plant_is_refused(make, kind, says):
    with pytest.raises(kind, match=says):
        make()


@pytest.mark.parametrize(
    ("out", "rate", "says"),
    [
        (lambda v: ca.vertcat(v, v), {}, r"`Odd.output\(...\)` must return 'v' in shape \(1, 1\); it returned shape"),
        (
            lambda v: v,
            {"lag": 0},
            r"`Odd.rate\(...\)` must return an empty mapping, and no more; it returned 'lag' too",
        ),
    ],
)
def test_an_element_of_ones_own_is_asked_for_its_signal_and_its_states(out, rate, says):
    @block
    class Odd(AbstractElement):
        def output(self, z, v):
            return out(v)

        def rate(self, z, v):
            return rate

    with pytest.raises(ValueError, match=says):
        open_loop(EquippedPlant(Motor(), (Odd("v"),)))
