"""The laws as they are simulated, printed from their own expressions for an arm of one joint."""

from dataclasses import dataclass, replace
from typing import Any

import casadi as ca
import numpy as np

from studies.paper.laws import RIVALS, proposed_repaired
from workbench.core import AbstractArm, Layout, Signals, lift
from workbench.loop import AbstractArmController
from workbench.notation.formula import Formula, Relation, Symbol, symbol
from workbench.notation.reader import formula_of
from workbench.study.document.document import Equation, Paragraph, Section

NAMES = {"q": "q_hat", "qd": "qd_hat", "d": "D_hat", "q_ref": "q_d", "qd_ref": "qd_d", "qdd_ref": "qdd_d"}
IN_WORDS = ("Fuzzy-ASMC", "super-twisting")  # their expressions say less than a sentence
LETTERS = {letter: ca.SX.sym(letter) for letter in "MCG"}


@dataclass(frozen=True)
class Letters(AbstractArm):
    """An arm of one joint whose matrices are the letters M, C, G: the law stays readable."""

    dof = 1

    def mass_matrix(self, q: ca.SX) -> ca.SX:
        """The letter M."""
        return LETTERS["M"]

    def coriolis_matrix(self, q: ca.SX, qd: ca.SX) -> ca.SX:
        """The letter C."""
        return LETTERS["C"]

    def gravity_vector(self, q: ca.SX) -> ca.SX:
        """The letter G."""
        return LETTERS["G"]


def one_joint(law: AbstractArmController) -> AbstractArmController:
    """The same law with its arrays cut down to one joint, on an arm of letters."""
    arrays = {name: value for name, value in vars(law).items() if isinstance(value, np.ndarray)}
    changes: dict[str, Any] = {name: value[(slice(0, 1),) * value.ndim] for name, value in arrays.items()}
    if getattr(law, "model", None) is not None:
        changes["model"] = Letters()
    if hasattr(law, "centres"):
        changes |= {"centres": np.zeros((1, 2)), "widths": np.ones(2)}
    return replace(law, **changes)


def printed(layout: Layout) -> dict[str, str]:
    """The letter of each number: one joint needs no index, and the memory of PID is z."""
    names = layout.printed()
    for entry in layout.entries:
        if entry.size == 1:
            names[entry.labels()[0]] = "z" if entry.name == "integral" else entry.symbol or entry.name
    return names


def equations(law: AbstractArmController) -> tuple[Formula, ...]:
    """tau = ... and the rate of each memory of a law, from the expressions that are simulated."""
    lifted = lift(one_joint(law))
    memory: Layout = lifted.block.memory
    t, z = ca.SX(0), memory.view(memory.symbols())
    signal = {name: ca.SX.sym(name) for name in NAMES}
    est = Signals(q=signal["q"], qd=signal["qd"], d=signal["d"])
    ref = Signals(q=signal["q_ref"], qd=signal["qd_ref"], qdd=signal["qdd_ref"])
    names = NAMES | printed(memory) | printed(lifted.layout)
    formulas: list[Formula] = [Relation(Symbol("tau"), "=", formula_of(lifted.block.torque(t, z, est, ref), names))]
    for name, rate in lifted.block.rate(t, z, est, ref).items():
        letter = symbol("z" if name == "integral" else memory[name].symbol or name)
        formulas.append(Relation(replace(letter, dots=1), "=", formula_of(rate, names)))
    return tuple(formulas)


def laws_section() -> Section:
    """Every law on one joint."""
    laws = {"AOSMC-RGS, repaired": proposed_repaired("FS").controller} | dict(RIVALS)
    about = (
        "Each law for an arm of one joint, printed from the expression that is simulated; hats are what the observer "
        "gives, the index d is what is wanted. RBF-ASMC is shown with one node. Fuzzy-ASMC is ASMC with its learning "
        "rate scaled by the rule base of the card. The super-twisting algorithm, which the paper does not have, is "
        "added as a modern rival."
    )
    lines = (Equation(equations(law), note=name) for name, law in laws.items() if name not in IN_WORDS)
    return Section("The laws, as they are simulated", (Paragraph(about), *lines))
