"""The units of printed entries."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from workbench.arms.dynamics import Dynamics
from workbench.arms.mechanics import paper_arm
from workbench.arms.paper_equations.arm_letters import fix_parameters
from workbench.arms.paper_equations.entry_units import read_unit, units_of
from workbench.arms.paper_equations.printed_equations import read_sheet
from workbench.core import Entry, Layout
from workbench.core.notation.loop_recursions import formula_of
from workbench.core.units import ONE, read

PAPER = Dynamics.of(paper_arm())


def sliding() -> Dynamics:
    """A mass on a slide that turns: M = diag(I + m r^2, m), with r the second joint."""
    p = Layout((Entry("mass", np.array(1.0), "kg", symbol="m"), Entry("inertia", np.array(1.0), "kg m^2", symbol="I")))
    q, qd = (Layout((Entry(letter, np.zeros(2)),)).symbols() for letter in ("q", "qd"))
    symbols = p.symbols()
    m, inertia = ca.vertsplit(symbols)
    M = ca.diag(ca.vertcat(inertia + m * q[1] ** 2, m))
    C = ca.blockcat([[m * q[1] * qd[1], m * q[1] * qd[0]], [-m * q[1] * qd[0], 0]])
    return Dynamics("slide", q, qd, ca.densify(M), C, ca.SX.zeros(2, 1), p, symbols, units=("rad", "m"))


UNITS = {"kg m^2/s": "kg m^2/s", "N m": "kg m^2/s^2", "N m/(rad s)": "kg m^2/s^3", "rad": "", "": ""}


@pytest.mark.parametrize("declared", UNITS)
def test_a_unit_is_read_in_kilograms_metres_and_seconds(declared):
    assert read_unit(declared) == read(UNITS[declared])


@pytest.mark.parametrize("unknown", ["furlong", "mm", "l", "?"])
def test_a_unit_that_nobody_knows_and_one_with_a_factor_is_none(unknown):
    assert read_unit(unknown) is None


MISMATCHES = {
    "M_22 = m_2*l_2": "it is in kg m, where kg m^2 is right",
    "C_12 = m_2*l_2^2": "it is in kg m^2, where kg m^2/s is right",
    "G_1 = m_1*l_1*g + m_2*g": "m_1*l_1*g in kg m^2/s^2 is added to m_2*g in kg m/s^2",
    "G_1 = m_1*l_1*g*sin(l_1)": "sin is taken of l_1, in m",
    "C_12 = m_2*l_1*l_2*(qd_1 + q_2)": "qd_1 in 1/s is added to q_2 in 1",
    "M_22 = m_2*l_1^2": "",
    "M_22 = 0": "",
    "G_2 = 9.8*m_2*l_2": "",
    "C_21 = 0.5*qd_1": "",
    "C_21 = qd_1": "it is in 1/s, where kg m^2/s is right",
    "G_2 = 2*m_2*l_2/3": "it is in kg m, where kg m^2/s^2 is right",
}


@pytest.mark.parametrize("said", MISMATCHES)
def test_units_that_do_not_match_are_said(said):
    ((place, formula),) = read_sheet(said, PAPER, "text").entries.items()
    assert units_of(PAPER).mismatch(place, formula) == MISMATCHES[said]


def test_all_derived_entries_have_the_units_they_should():
    for arm in (PAPER, sliding()):
        units = units_of(arm)
        for matrix in "MCG":
            entries = getattr(arm, matrix)
            for i, j in np.ndindex(entries.shape):
                printed = formula_of(entries[i, j], arm.names())
                assert units.mismatch((matrix, i + 1, j + 1), printed) == ""


def test_a_joint_that_slides_has_a_unit_of_its_own():
    assert units_of(sliding()).joints == (ONE, read("m"))
    assert str(units_of(sliding()).of_entry(("C", 1, 2))) == "kg m/s"


def test_where_a_parameter_is_given_as_a_number_numbers_may_have_its_unit():
    assert units_of(fix_parameters(PAPER, {"gravity": 10.0})) is None


def test_an_arm_with_an_unknown_unit_has_none():
    arm = sliding()
    strange = Layout((Entry("mass", np.array(1.0), "stone", symbol="m"), arm.p.entries[1]))
    assert units_of(replace(arm, p=strange)) is None
