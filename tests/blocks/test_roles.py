"""Roles: what a law is given, read from its equations."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from tests.support.arms import arm_instruments
from tests.support.marches import marched
from workbench.arms.laws import AosmcRgs, ArmPID, SlidingMode
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.arms.observers import (
    ArmFullState,
    Luenberger,
    MomentumObserver,
    OracleFilter,
    StateAndDisturbanceObserver,
)
from workbench.blocks.laws import StateFeedback
from workbench.blocks.loop import ClosedLoop, Instruments, roles
from workbench.blocks.observers import LinearObserver
from workbench.blocks.plants import CartPole
from workbench.blocks.signals import CombinedReference, Constant, Sines
from workbench.core import Roles, information_classes
from workbench.study.evidence.law_tables import information_table

ARM, I = paper_arm(), np.eye(2)
PLANT, WANTED = Manipulator(ARM, q=[0.1, 0.2]), Sines("q", "rad", [1.0, 1.0], [1.0, 1.0])
BARE, WEIGHED = ArmPID([9.0, 9.0], [1.0, 1.0], [3.0, 3.0]), ArmPID([9.0, 9.0], [1.0, 1.0], [3.0, 3.0], ARM)
SMC = SlidingMode(ARM, [1.0, 1.0], [2.0, 2.0], 0.1)
OBSERVER = Luenberger(ARM, 30 * I, 50 * I, q_hat=[0.1, 0.2])
MOMENTUM = StateAndDisturbanceObserver(OBSERVER, MomentumObserver(ARM, 20.0))
PROPOSED = AosmcRgs(ARM, [1.0, 1.0], 0.1, K=5 * I, P=10 * I, Q=599 * I, R=6.43 * I, gain_shape="elementwise")


def given(law, observer=None):
    return roles(ClosedLoop(PLANT, observer or ArmFullState(2), law, WANTED))


def test_a_pid_on_readings_is_given_no_model():
    held = given(BARE)
    assert (held.law, held.observer) == ("ArmPID", "")
    assert held.readings == {"q": ("read",), "qd": ("read",)}
    assert held.reference == ("q_ref", "qd_ref")
    assert held.models == {}
    assert (held.unread, held.truths) == ((), ())
    assert (held.law_states, held.observer_states) == (2, 0)


def test_of_a_model_only_what_acts_counts():
    assert given(WEIGHED).models == {"controller.model": ("G",)}
    smc = given(SMC)
    assert smc.models == {"controller.model": ("M", "C", "G")}
    assert smc.reference == ("q_ref", "qd_ref", "qdd_ref")


def test_an_observer_that_follows_a_plant_by_its_equations_is_given_a_model():
    plant, wanted = CartPole(), CombinedReference((Constant("x", "m", [0.0]), Constant("phi", "rad", [0.0])))
    law = StateFeedback.of(plant, [[-70.0, -38.0, 106.0, 21.0]], follow=("x", "phi"))
    observer = LinearObserver(plant, [[9.0, 0.0], [40.0, 0.0], [0.0, 30.0], [0.0, 300.0]])
    blind = StateFeedback.of(plant, np.zeros((1, 4)), follow=("x", "phi"))
    held = {name: roles(ClosedLoop(plant, observer, law, wanted)) for name, law in (("LQG", law), ("none", blind))}
    assert held["LQG"].models == {"observer.model": ("f",)}
    assert held["none"].models == {"observer.model": ()}
    table = information_table("given", "What each is given.", held)
    assert [row[4] for row in table.rows] == ["– / f", "– / unused"]
    assert table.notes[-1].startswith("Model f: the equations")
    assert len(information_table("given", "What it is given.", {"PID": given(BARE)}).notes) == 1


def test_a_plant_with_an_arm_counts_as_a_model_by_the_matrices_of_that_arm():
    observer = LinearObserver(PLANT, np.vstack([30 * np.eye(4)[:2], 99 * np.eye(4)[:2]]))
    held = roles(ClosedLoop(PLANT, observer, SMC, WANTED))
    assert held.models["observer.model.arm"] == ("M", "C", "G")
    assert "observer.model" not in held.models


def test_a_law_behind_observers_reads_positions_alone():
    held = given(PROPOSED, MOMENTUM)
    assert held.observer == "Luenberger + momentum"
    assert held.readings == {"q": ("estimated",), "qd": ("estimated",)}
    assert held.models["observer.state.model"] == ("M", "C", "G")
    assert held.models["observer.disturbance.model"] == ("M", "C", "G")
    assert held.unread == ("d",)
    assert not held.truths
    assert held.observer_states == 6


def test_an_observer_of_momentum_on_readings_hands_on_a_velocity_that_is_read():
    observer = StateAndDisturbanceObserver(ArmFullState(2), MomentumObserver(ARM, 20.0))
    held = given(PROPOSED, observer)
    assert held.readings["qd"] == ("read",)
    assert held.unread == ("d",)


def test_an_oracle_is_told_from_an_estimate():
    held = given(PROPOSED, StateAndDisturbanceObserver(OBSERVER, OracleFilter(2, 20.0)))
    assert held.truths == ("d",)
    assert held.unread == ("d",)
    assert not given(PROPOSED, MOMENTUM).truths


def test_an_estimate_that_the_law_does_not_use_is_none():
    """SMC takes no D_hat, so neither that nor the model behind it acts."""
    held = given(SMC, StateAndDisturbanceObserver(ArmFullState(2), MomentumObserver(ARM, 20.0)))
    assert not held.unread
    assert held.models["observer.disturbance.model"] == ()
    held = given(SMC, StateAndDisturbanceObserver(ArmFullState(2), OracleFilter(2, 20.0)))
    assert not held.truths


def test_a_model_that_acts_on_nothing_is_told():
    """Without D gain and weight of the arm: a term whose gain is 0 does not count."""
    unused = replace(OBSERVER, model=ARM)
    held = given(replace(BARE, Kp=[0.0, 0.0], Kd=[0.0, 0.0], Ki=[0.0, 0.0]), unused)
    assert held.models == {"observer.model": ()}
    assert held.readings == {"q": (), "qd": ()}
    assert given(replace(BARE, Kd=[0.0, 0.0])).readings["qd"] == ()


def test_a_velocity_behind_a_filter_is_filtered_and_one_from_positions_estimated():
    filters = pytest.importorskip("workbench.arms.observers.arm_full_state")
    held = given(SMC, filters.VelocityFilter(2, 100.0))
    assert held.readings == {"q": ("read",), "qd": ("filtered",)}
    held = given(SMC, filters.DirtyDerivative(2, 100.0, q_hat=[0.1, 0.2]))
    assert held.readings == {"q": ("read",), "qd": ("estimated",)}


def test_laws_that_only_a_computer_runs_have_roles_too():
    assert given(replace(SMC, saturation="implicit")).models == given(SMC).models


@dataclass(frozen=True)
class Computed:
    loop: ClosedLoop
    instruments: Instruments


def test_a_loop_of_a_computer_has_the_roles_of_its_loop_whatever_the_noise():
    closed = ClosedLoop(PLANT, MOMENTUM, PROPOSED, WANTED)
    assert roles(Computed(closed, arm_instruments(2, noise_q=0.001))) == closed.roles == roles(closed)


READINGS = [("q", slice(2)), ("qd", slice(2, 4))]


@pytest.mark.parametrize(("law", "observer"), [(BARE, ArmFullState(2)), (SMC, OBSERVER), (PROPOSED, MOMENTUM)])
@pytest.mark.parametrize(("reading", "which"), READINGS)
def test_a_disturbed_reading_moves_the_torque_if_and_only_if_the_roles_say_so(law, observer, reading, which):
    """The oracle: the loop of a computer twice, once with noise on this reading, for a few periods."""
    closed = ClosedLoop(PLANT, observer, law, WANTED)
    digital = closed.digital(1e-3, arm_instruments(2, noise_q=1e-3, noise_qd=1e-2))
    noise = np.zeros((6, 4))
    calm = marched(digital.step(1), noise)
    noise[:, which] = 1.0
    apart = np.abs(np.array(marched(digital.step(1), noise)) - calm)[:, digital.states.slice("hold.tau")].max(axis=1)
    ways = set(closed.roles.readings[reading])
    assert bool(apart[0] > 0) == ("read" in ways)
    assert bool(apart.max() > 0) == bool(ways - {"estimated"} if reading == "qd" else ways)


def test_only_laws_of_equal_information_are_compared():
    held = {
        "PID": given(BARE),
        "SMC": given(SMC),
        "proposed": given(PROPOSED, MOMENTUM),
        "SMC + layer": given(replace(SMC, phi=1.0)),
        "proposed, oracle": given(PROPOSED, StateAndDisturbanceObserver(OBSERVER, OracleFilter(2, 20.0))),
    }
    assert information_classes(held) == (("PID",), ("SMC", "SMC + layer"), ("proposed",), ("proposed, oracle",))
    assert information_classes({}) == ()


def test_what_is_no_loop_is_refused():
    for odd in (3, BARE, Roles, ClosedLoop):
        with pytest.raises(ValueError, match=r"`roles\(loop\)` must be a `ClosedLoop`"):
            roles(odd)


def test_the_table_of_information_says_what_each_law_is_given():
    unused = StateAndDisturbanceObserver(ArmFullState(2), MomentumObserver(ARM, 20.0))
    loops = {
        "PID": ClosedLoop(PLANT, ArmFullState(2), BARE, WANTED),
        "proposed": Computed(ClosedLoop(PLANT, MOMENTUM, PROPOSED, WANTED), arm_instruments(2)),
        "SMC": given(SMC, unused),
        "PID again": given(BARE),
        "oracle": given(PROPOSED, StateAndDisturbanceObserver(OBSERVER, OracleFilter(2, 20.0))),
    }
    table = information_table("given", "Who is given what.", loops, dict.fromkeys(loops, 4))
    assert [len(row) for row in table.rows] == [len(table.columns)] * 5
    assert [row[:7] for row in table.rows] == [
        ("PID", "A", None, "read", None, None, "2"),
        ("proposed", "B", "Luenberger + momentum", "estimated", "MCG / MCG", "estimated", "8 / 6"),
        ("SMC", "C", "momentum", "read", "MCG / unused", None, "0 / 2"),
        ("PID again", "A", None, "read", None, None, "2"),
        ("oracle", "D", "Luenberger + oracle", "estimated", "MCG / MCG", "oracle", "8 / 6"),
    ]
    damped = information_table("given", "", {"P": given(replace(BARE, Kd=[0.0, 0.0]))})
    assert damped.rows[0][3] == "read, unused"
    assert {row[-1] for row in table.rows} == {4}
    assert len(information_table("given", "", loops).columns) == len(table.columns) - 1


def test_a_table_of_information_needs_loops_and_all_counts():
    with pytest.raises(ValueError, match="at least one; got none"):
        information_table("given", "", {})
    with pytest.raises(ValueError, match=r"'PID'.*must be a `ClosedLoop` or the `Roles` of one"):
        information_table("given", "", {"PID": 3})
    with pytest.raises(ValueError, match=r"searched_numbers=...\)` must have a number for each"):
        information_table("given", "", {"PID": given(BARE)}, {"SMC": 3})
    with pytest.raises(ValueError, match=r"searched_numbers=\{'PID': ...\}\)`.*at least 0"):
        information_table("given", "", {"PID": given(BARE)}, {"PID": -1})
