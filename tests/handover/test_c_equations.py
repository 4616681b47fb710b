"""The printed equations of a law: the head of a docstring, and the lines with a number."""

from tests.support.digital_laws import digital
from workbench.handover.c99.c_equations import NumberedEquation, numbered_equations, opening, printed_equation

DOCSTRING = """A law on a surface.

    s      = ed + Lambda e,          e = q - q_ref      (12)
    tau    = M qdd_r - K s                             (13a)
    k_hat' = gamma |s|                                  (14)
    z[k+1] = z + T e (15)
    no     = number
    f(2)

Parameters
----------
x = no equation (1
"""


def test_the_opening_ends_above_the_first_section():
    lines = opening(DOCSTRING)
    assert (lines[0], lines[-1]) == ("A law on a surface.", "    f(2)")
    assert opening("Raises\nnothing") == []


def test_an_equation_has_a_left_side_and_a_number():
    found = list(numbered_equations(DOCSTRING))
    assert [equation.left for equation in found] == ["s", "tau", "k_hat'", "z[k+1]"]
    assert found[0] == NumberedEquation("s", "s  = ed + Lambda e,  e = q - q_ref  (12)")


def test_a_value_of_the_memory_has_the_equation_of_its_rate():
    _, law = digital("AOSMC-RGS")
    rates = {name: printed_equation(law, name) for name in law.memory.names}
    assert any("' = " in line for line in rates.values())
    assert all(line.startswith(f"{name.rpartition('.')[2]}'") for name, line in rates.items() if line)


def test_a_value_without_a_numbered_equation_has_none():
    _, law = digital("AOSMC-RGS")
    assert printed_equation(law, "controller.nothing") == ""
