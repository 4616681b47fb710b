"""Methods of a block take expressions in the shapes that the block declares."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from tests.support.arms import arm_instruments
from workbench.arms.laws import ArmPID
from workbench.arms.manipulator import FirstOrderLag, Friction
from workbench.arms.mechanics import paper_arm
from workbench.core import Signals
from workbench.core.notation.formula import Symbol

ARM = paper_arm()
LAW = ArmPID([1.0, 1.0], [0.1, 0.1], [1.0, 1.0], ARM)
TWO, THREE = ca.SX.sym("x", 2), ca.SX.sym("x", 3)
MEMORY = {"integral": TWO}
HERE, WANTED = Signals(q=TWO, qd=TWO, d=TWO), Signals(q=TWO, qd=TWO, qdd=TWO)

MISSHAPEN = [
    (
        lambda: LAW.torque(TWO, MEMORY, HERE, WANTED),
        ValueError,
        "`ArmPID.torque(t=...)` must have shape (1, 1); got (2, ",
    ),
    (
        lambda: LAW.torque(0.0, MEMORY, HERE | {"qd": THREE}, WANTED),
        ValueError,
        "`ArmPID.torque(est=...)` must hold 'qd' in shape (2, 1); got (3, 1).",
    ),
    (lambda: LAW.torque(0.0, {}, HERE, WANTED), LookupError, "the whole memory, integral; got no 'integral'."),
    (lambda: LAW.torque(0.0, {"integral": THREE}, HERE, WANTED), ValueError, "'integral' in shape (2, 1); got (3, 1)."),
    (lambda: LAW.torque(0.0, MEMORY, HERE, HERE), LookupError, "all that the law follows, q, qd, qdd; got no 'qdd'."),
    (lambda: LAW.torque(0.0, MEMORY, 3.0, WANTED), ValueError, "must be a `Signals`; got 3.0."),
    (lambda: ARM.mass_matrix(np.longdouble(1)), ValueError, "must have shape (2, 1), one number for each of n = 2"),
    (lambda: Friction([1.0, 1.0], [1.0, 1.0]).torque(THREE), ValueError, "must have shape (2, 1)"),
    (lambda: arm_instruments(2).read(Signals(q=TWO, qd=TWO), TWO), ValueError, "must have shape (4, 1)"),
    (lambda: FirstOrderLag(0.1).applied_torque({}, TWO), LookupError, "got no 'tau_m'"),
]  # fmt: skip


@pytest.mark.parametrize(("call", "kind", "says"), MISSHAPEN)
def test_a_method_of_a_block_takes_expressions_in_the_shapes_that_it_declares(call, kind, says):
    with pytest.raises(kind) as error:
        call()
    assert says in str(error.value)


def test_numbers_do_for_expressions():
    assert LAW.torque(0.0, MEMORY, HERE, WANTED).shape == (2, 1)
    assert ARM.mass_matrix([0.1, np.float16(0.2)]).shape == (2, 2)


def test_a_symbol_is_text_that_can_be_written():
    with pytest.raises(ValueError, match=r"`Symbol\(letter=...\)` must be text; got '\\ud800'"):
        Symbol("\ud800")
