"""The laws as they are simulated, printed from their own expressions for an arm of one joint."""

from dataclasses import dataclass, replace
from typing import Any

import casadi as ca
import numpy as np

from studies.paper.laws import RIVALS, proposed_repaired
from workbench.controllers import AosmcRgs, RuleBase
from workbench.core import AbstractArm, Layout, Signals, lift
from workbench.loop import AbstractArmController
from workbench.notation.formula import Formula, Relation, Symbol, symbol
from workbench.notation.reader import formula_of
from workbench.study.document.document import Equation, Paragraph, Section

NAMES = {"q": "q_hat", "qd": "qd_hat", "d": "D_hat", "q_ref": "q_d", "qd_ref": "qd_d", "qdd_ref": "qdd_d"}
WORDS = {  # laws whose expressions say less than a sentence
    "Fuzzy-ASMC": "Fuzzy-ASMC is ASMC with its learning rate scaled by the rule base of the card.",
    "super-twisting": "The super-twisting algorithm, which the paper does not have, is added as a modern rival.",
}
INTEGRAL = {"integral": "z", "s_slow": "z"}  # how the memory of PID and Fuzzy-ASMC is printed


@dataclass(frozen=True)
class Letters(AbstractArm):
    """An arm of one joint whose matrices are the letters M, C, G: the law stays readable."""

    @property
    def dof(self) -> int:
        """One joint."""
        return 1

    def mass_matrix(self, q: ca.SX) -> ca.SX:
        """The letter M."""
        return LETTERS["M"]

    def coriolis_matrix(self, q: ca.SX, qd: ca.SX) -> ca.SX:
        """The letter C."""
        return LETTERS["C"]

    def gravity_vector(self, q: ca.SX) -> ca.SX:
        """The letter G."""
        return LETTERS["G"]


LETTERS = {letter: ca.SX.sym(letter) for letter in "MCG"}


def one_joint(law: AbstractArmController) -> AbstractArmController:
    """The same law with its arrays cut down to one joint, on an arm of letters."""
    changes: dict[str, Any] = {}
    for name, value in vars(law).items():
        if isinstance(value, np.ndarray):
            changes[name] = value[(slice(0, 1),) * value.ndim]
    if hasattr(law, "model") and law.model is not None:
        changes["model"] = Letters()
    if hasattr(law, "rules"):
        changes["rules"] = RuleBase(sizes=[0.0], trends=[0.0], scale=[[1.0]])
    if hasattr(law, "centres"):
        changes |= {"centres": np.zeros((1, 2)), "widths": np.ones(2)}
    return replace(law, **changes)


def equations(law: AbstractArmController) -> tuple[Formula, ...]:
    """tau = ... and the rate of each memory of a law, from the expressions that are simulated."""
    lifted = lift(one_joint(law))
    memory: Layout = lifted.block.memory
    z = memory.view(memory.symbols())
    signal = {name: ca.SX.sym(name) for name in NAMES}
    est = Signals(q=signal["q"], qd=signal["qd"], d=signal["d"])
    ref = Signals(q=signal["q_ref"], qd=signal["qd_ref"], qdd=signal["qdd_ref"])
    names = NAMES | _letters(memory) | _letters(lifted.layout)
    t = ca.SX(0)
    formulas: list[Formula] = [Relation(Symbol("tau"), "=", formula_of(lifted.block.torque(t, z, est, ref), names))]
    for name, rate in lifted.block.rate(t, z, est, ref).items():
        letter = symbol(INTEGRAL.get(name, memory[name].symbol or name))
        formulas.append(Relation(replace(letter, dots=1), "=", formula_of(rate, names)))
    return tuple(formulas)


def _letters(layout: Layout) -> dict[str, str]:
    """How each number is printed: one joint needs no index."""
    printed = layout.printed()
    for entry in layout.entries:
        if entry.size == 1:
            printed[entry.labels()[0]] = INTEGRAL.get(entry.name, entry.symbol or entry.name)
    return printed


def laws_section() -> Section:
    """Every law on one joint."""
    proposed = proposed_repaired("FS").controller
    assert isinstance(proposed, AosmcRgs)
    laws = {"AOSMC-RGS, repaired": proposed, **{name: law for name, law in RIVALS.items() if name not in WORDS}}
    return Section(
        "The laws, as they are simulated",
        (
            Paragraph(
                "Each law for an arm of one joint, printed from the expression that is simulated; hats are what the "
                "observer gives, the index d is what is wanted. RBF-ASMC is shown with one node. "
                + " ".join(WORDS.values())
            ),
            *(Equation(equations(law), note=name) for name, law in laws.items()),
        ),
    )
