"""The kinds of check: a claim bound to the function that judges it, an identity, and a search for a run.

Both sides of equations (22), (30), (31), (34), (35) and (41) stand here over symbols that any state may replace,
those of the paper's substitutions in `derivations`.
"""

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import NamedTuple

import casadi as ca
import numpy as np

import workbench as wb
from studies.a2_claims.derivations import Sides, derivations
from studies.paper.card import CARD
from studies.paper.laws import ARM, paper_observer

HORIZONS = f"horizons of {CARD['FS: horizon']:g} s (FS) and {CARD['SS: horizon']:g} s (SS)"
NAMES = ("q_hat", "qd_hat", "q", "q_d", "qd_d", "qdd_d", "D", "D_hat", "tau", "s")
SYMBOLS = {name: wb.Layout((wb.core.Entry(name, np.zeros(2)),)).symbols() for name in NAMES}
K = ca.SX.sym("K", 2, 2)
ARM_MATRICES = wb.arms.Dynamics.of(ARM)
LAMBDA, PHI = np.diag(CARD["Lambda"]), CARD["phi"]


@wb.block
class UnitMassArm(wb.arms.AbstractArm):
    """M = I, with C and G of `arm`: its acceleration tau - C qd - G is M times that of `arm`, and no quotient.

    Normal forms have no quotients, and M^-1 is one.
    """

    arm: wb.arms.AbstractArm

    @property
    def dof(self) -> int:
        return self.arm.dof

    def mass_matrix(self, q: ca.SX) -> ca.SX:
        del q
        return ca.SX(ca.DM.eye(self.dof))

    def coriolis_matrix(self, q: ca.SX, qd: ca.SX) -> ca.SX:
        return self.arm.coriolis_matrix(q, qd)

    def gravity_vector(self, q: ca.SX) -> ca.SX:
        return self.arm.gravity_vector(q)


def at(q: ca.SX, qd: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
    """M, C and G of the derived arm at nominal parameters."""
    d = ARM_MATRICES
    old, new = ca.vertcat(d.q, d.qd, d.symbols), ca.vertcat(q, qd, ca.SX(d.p.default))
    M, C, G = ca.substitute([d.M, d.C, d.G], [old], [new])
    return M, C, G


def observer_rate(model: wb.arms.AbstractArm, q: ca.SX, qd_hat: ca.SX, tau: ca.SX) -> ca.SX:
    """qd_hat' of the observer (10), with the gains of section 5, where its position is right: q_hat = q."""
    observer, t = replace(paper_observer(), model=model), ca.SX(0)
    z, y = {"q_hat": q, "qd_hat": qd_hat}, wb.Signals(q=q, qd=ca.SX.zeros(2))
    return observer.rate(t, z, y, observer.estimate(t, z, y), wb.Signals(tau=tau))["qd_hat"]


def _sides() -> dict[str, Sides]:
    q_hat, qd_hat, q, q_d, qd_d, qdd_d, D, D_hat, tau, s = (SYMBOLS[name] for name in NAMES)
    M, C, G = at(q_hat, qd_hat)
    e1, e2, lost = q_hat - q_d, qd_hat - qd_d, q - q_hat
    # (30) times M: what it says M s' is, by its first line and by its second
    first = tau - C @ qd_d - G - D + M @ (LAMBDA @ e2 - qdd_d)
    second = -K @ s - (D - D_hat) + M @ (LAMBDA @ e2)
    # ds/dt = qdd_hat - qdd_d + Lambda (q_hat' - qd_d), times M, by (10) and by (35)
    by_10 = tau - C @ qd_hat - G + M @ (CARD["L2"] @ lost - qdd_d + LAMBDA @ (e2 + CARD["L1"] @ lost))
    by_35 = tau - C @ qd_hat - G - D + M @ (LAMBDA @ e2 - qdd_d)
    law = M @ qdd_d + C @ qd_d + G + D_hat - K @ s  # (27)-(29), with s for sat(s / phi)
    repaired = M @ (qdd_d - LAMBDA @ e2) + C @ (qd_d - LAMBDA @ e1) + G + D_hat - K @ s
    unit, zero = UnitMassArm(ARM), ca.SX.zeros(2)  # with which each acceleration is M times that of the arm
    weight = at(q, zero)[2]
    arm = wb.Manipulator(unit, q=np.zeros(2)).rate(ca.SX(0), {"q": q, "qd": zero}, wb.Signals(tau=tau - D))["qd"]
    return {
        "(30), along (10)": (first, by_10),
        "(30), along (35)": (first, by_35),
        "(30), second line": (ca.substitute(first, tau, law), second),
        "(30), repaired": (ca.substitute(by_35, tau, repaired) + C @ (e2 + LAMBDA @ e1), -K @ s + D_hat - D),
        # M times (31), with sat(s / phi) replaced by s and D_hat = D in the second line of (30)
        "(31)": (ca.substitute(second, D_hat, D), -K @ s + M @ (LAMBDA @ e2)),
        # sat(s / phi) = s / phi within the layer, for which (31) has s
        "(31), replacement": (-K @ s, -K @ (s / PHI)),
        # x1~ = 0 and the arm at rest: x2~^T P2 x2~' is odd in x2~ if M x2~' is even in it
        "(22)": (observer_rate(unit, q, qd_hat, weight), observer_rate(unit, q, -qd_hat, weight)),
        # s = 0 and e1 != 0: the surface asks for e2 = -Lambda e1, the minimiser of (32) for u = 0
        "(34), input": (ca.SX(-LAMBDA @ e1), ca.SX.zeros(2)),
        # x1~ = 0: what (10) and (35) say of tau less C qd_hat and G
        "(35)": (M @ ca.solve(M, tau - C @ qd_hat - G), tau - C @ qd_hat - G - D),
        # s = 0 and e1 = 0: M e2' by (35), with the law (27)-(29)
        "(41), along (35)": (
            ca.substitute(ca.substitute(by_35, tau, law), ca.vertcat(q_d, qd_d, s), ca.vertcat(q_hat, qd_hat, 0, 0)),
            D_hat - D,
        ),
        # estimates that have found the arm at rest: M times the acceleration of the arm, less that of its copy in (10)
        "(41), along (10)": (arm - observer_rate(unit, q, zero, tau), -D),
    }


SIDES = _sides() | derivations()


def both(name: str, **values: float | tuple[float, ...]) -> tuple[wb.Array, wb.Array]:
    """Both sides of an equation at named values (q_hat=(0.5, 1), ...); what is not named is zero."""
    left, right = SIDES[name]
    symbols = SYMBOLS | {"K": ca.vec(K)}
    if odd := set(values) - set(symbols):
        raise LookupError(f"`both('{name}', ...)` knows {', '.join(symbols)}; got {sorted(odd)}.")
    numbers = [np.asarray(values.get(n, np.zeros(x.numel())), dtype=float) for n, x in symbols.items()]
    sides = ca.Function("sides", [*symbols.values()], [left, right])(*numbers)
    return np.array(sides[0]).ravel(), np.array(sides[1]).ravel()


class CheckedClaim(NamedTuple):
    """A claim with the check that judges it."""

    claim: wb.core.Claim
    check: wb.proofs.Check


def judges(name: str, statement: str, source: str, *below: wb.core.Claim) -> Callable[[wb.proofs.Check], CheckedClaim]:
    """Bind a check to its claim, with the claims below it."""
    return lambda check: CheckedClaim(wb.core.Claim(name, statement, source, below), check)


def refutation(is_broken: bool, evidence: str, witness: str, kept_hypotheses: tuple[str, ...] = ()) -> wb.proofs.Ruling:
    """The ruling of a witness against the claim, where its numbers break it."""
    return (
        wb.proofs.Ruling("refuted", evidence, witness, kept_hypotheses=kept_hypotheses)
        if is_broken
        else unbroken_claim()
    )


def unbroken_claim() -> wb.proofs.Ruling:
    """The ruling where a witness does not break the claim."""
    return wb.proofs.Ruling("not refuted", "The run or state that was to break it does not.", samples=1)


def identity_ruling(name: str) -> wb.proofs.Ruling:
    """The ruling of an equation's normal forms."""
    if (judged := wb.proofs.judge_equal(*SIDES[name])).kind == "proved":
        return wb.proofs.Ruling("proved", "Equal normal forms: an identity in all states, gains and parameters.")
    return wb.proofs.Ruling("not checkable", judged.evidence)


def identity(name: str, statement: str, source: str) -> CheckedClaim:
    """An equation that is to be an identity in all its symbols."""
    return CheckedClaim(wb.core.Claim(name, statement, source), lambda: identity_ruling(name))


def inequality(
    name: str, statement: str, source: str, evidence: str, *below: wb.core.Claim, **values: tuple[float, ...]
) -> CheckedClaim:
    """An equation whose sides differ at a plain state; `{0}` and `{1}` of the evidence are the sides there."""
    witness = ", ".join(f"{letter}={literal(value)}" for letter, value in values.items())

    def check() -> wb.proofs.Ruling:
        left, right = both(name, **values)
        differ = wb.proofs.judge_equal(*SIDES[name]).kind == "refuted" and not np.allclose(
            left, right, rtol=1e-9, atol=0
        )
        return refutation(differ, evidence.format(row(left), row(right)), f'both("{name}", {witness})')

    return CheckedClaim(wb.core.Claim(name, statement, source, below), check)


def row(values: object, digits: int = 4) -> str:
    """Numbers as a reader takes them in: (0.5, -1)."""
    return "(" + ", ".join(f"{value:.{digits}g}" for value in np.ravel(np.asarray(values, dtype=float)) + 0.0) + ")"


def literal(values: Iterable[float]) -> str:
    """A tuple as a witness types it."""
    return "(" + ", ".join(f"{value:g}" for value in values) + ")"


def numbers(*names: str) -> str:
    """Numbers that the paper leaves open, as they were taken here: Q = diag(1, 1) N m/(rad s), ..."""
    units = {given.name: given.unit for given in CARD}
    letters = {name: name.removeprefix("SS: ").removesuffix(" as printed") for name in names}
    return ", ".join(
        f"{letter} = {wb.provenance.value_text(CARD[name])} {units[name]}" for name, letter in letters.items()
    )
