"""The proposed law as printed in each reading, and repaired, with one change at a time."""

from dataclasses import replace

import casadi as ca
import numpy as np

from studies.paper.card import CARD
from studies.paper.comparison import SCENARIOS
from studies.paper.figures import GAINS
from studies.paper.laws import ARM, PRINTED_ARM, proposed_as_printed
from workbench.controllers.aosmc_rgs import SHAPES
from workbench.core import Dynamics, Signals
from workbench.notation.formula import Formula, Relation, Symbol, symbol
from workbench.notation.reader import formula_of, read
from workbench.study.document.document import (
    Cell,
    Column,
    Diverged,
    Equation,
    Itemize,
    Measured,
    Paragraph,
    Phrase,
    Section,
    Table,
)
from workbench.study.pictures.traces import Window, components
from workbench.study.study import Outcome, Results

CHANGES = {
    "none": "none: all four slips repaired",
    "(3)": "slip (3): C[1,2] without velocity, in model and observer",
    "(24)": "slip (24): D_hat is the integral of eta",
    "(28)": "slip (28): qd_d and qdd_d in place of the reference velocity",
    "(33)": "slip (33): the minus sign",
    "D_hat in (10)": "one repair more: the observer (10) is given D_hat, an oracle",
}
LATE = 5.0  # s, from when on an error counts as late
SHORT = 10.0  # s, the horizon at which changes and readings are compared with one another
FAR = 10.0  # rad, beyond which a path is lost
PLANTS = {"derived arm": ARM, "printed arm": PRINTED_ARM}


LEFT = (
    "Not touched here: observer (10) has no D (one repair more in the table); its convergence for any positive "
    "definite L1, L2 (Theorem 1); (34) run forward, which does not minimise (32); the lost 1/phi in A of (31), for "
    "which (34) has no consistent unit; and the finite time of (42)."
)


def gain_floor(outcome: Outcome) -> np.ndarray:
    """The smallest eigenvalue of the symmetric part of K over time, (N,), in N m; NaN where the run is gone."""
    K = outcome.measurement.trajectories["controller.K"][0]
    finite = np.isfinite(K).all(axis=(1, 2))
    floor = np.full(len(K), np.nan)
    floor[finite] = np.linalg.eigvalsh((K + K.transpose(0, 2, 1))[finite] / 2)[:, 0]
    return floor


def loses_positivity(outcome: Outcome) -> float | None:
    """The first kept time at which K is no longer positive definite, in s."""
    below = np.flatnonzero(gain_floor(outcome) <= 0)
    return float(outcome.t[below[0]]) if below.size else None


def leaves(outcome: Outcome) -> float | None:
    """The first kept time at which an error is beyond `FAR`, or no number any more, in s."""
    e = outcome.measurement.trajectories["e"][0]
    beyond = np.flatnonzero(~(np.abs(e) <= FAR).all(axis=1))
    return float(outcome.t[beyond[0]]) if beyond.size else None


def printed_section(results: Results, small_q: Table) -> Section:
    """As printed, in each reading of (33), on both arms; then with a small Q."""
    rows: list[tuple[Cell, ...]] = []
    for scenario, title in SCENARIOS.items():
        for shape in SHAPES:
            runs = [results[f"{scenario} as printed, {plant}", shape] for plant in PLANTS]
            rows.append((title, shape, *(_when(f(run)) for run in runs for f in (loses_positivity, leaves))))
    times = (f"{plant}: {what}" for plant in PLANTS for what in ("K not positive", f"|e| > {FAR:g} rad"))
    table = Table(
        "as_printed",
        "AOSMC-RGS as printed, with (3), (24), (28) and the minus of (33), in each reading of (33), over 10 s: when "
        "the gain is lost, and when the path is.",
        (Column("scenario"), Column("reading of (33)"), *(Column(time, "s", "right") for time in times)),
        tuple(rows),
        (
            *(f"{name}: {meaning}." for name, meaning in SHAPES.items()),
            "First kept times (every 10 ms). K not positive: the symmetric part of K has an eigenvalue of zero or "
            "below.",
        ),
    )
    outcome = results["FS as printed, derived arm", "outer"]
    end = max(0.5, outcome.diverged_at or 10.0)
    return Section(
        "As printed",
        (
            Paragraph(
                "Equation (33) multiplies a matrix, a vector and a vector of signs, which has no consistent shape: "
                "each reading gives it one. With its minus sign the gain falls, while (29) asks it to stay "
                "positive definite. The readings, from the expression that is simulated:"
            ),
            Equation(readings(), note="(33) as printed, in its readings outer, elementwise, diagonal and norm"),
            Paragraph(
                "The law and its observer believe in (3) as printed. What moves is the derived arm, or, beside it, "
                "an arm that itself obeys (3) as printed."
            ),
            table,
            Paragraph("Q and R are not stated, and Q = R = I is assumed here. With a smaller Q, K falls more slowly:"),
            small_q,
            components(
                "printed_gain",
                "The gain of the law as printed (first scenario, reading 'outer', derived arm) until the run ends.",
                outcome,
                GAINS,
                (symbol("K"), " [N m]"),
                (Window(0.0, end, (-40.0, 20.0)),),
            ),
        ),
    )


def _when(time: float | None) -> str:
    return "never" if time is None else f"{time:.2f}"


def readings() -> tuple[Formula, ...]:
    """K' of (33) in each reading, printed from the law's own expression: s stands for the sliding variable."""
    s, zero = ca.SX.sym("s", 2), ca.SX.zeros(2)
    P = ca.SX.sym("P", 2, 2)
    names = {f"s_{i}": f"s_{i + 1}" for i in range(2)} | {
        f"P_{i + 2 * j}": f"P_{i + 1}{j + 1}" for i in range(2) for j in range(2)
    }
    law = proposed_as_printed("FS").controller
    still = Signals(q=zero, qd=zero, qdd=zero), Signals(q=zero, qd=s, d=zero)  # s = qd where q = q_ref and qd_ref = 0
    rates = [
        replace(law, gain_shape=shape, riccati="frozen", Q=None, R=None).rate(
            ca.SX(0), {"K": ca.SX.zeros(2, 2), "P": P}, still[1], still[0]
        )["K"]
        for shape in SHAPES
    ]
    return tuple(Relation(Symbol("K", dots=1), "=", formula_of(rate, names)) for rate in rates)


def _ends(outcome: Outcome) -> tuple[Cell, Cell]:
    if outcome.diverged_at is not None:
        return Diverged(outcome.diverged_at), Diverged(outcome.diverged_at)
    return Measured(*outcome.score("RMSE (43)", 0)), Measured(*outcome.score("RMSE (43)", 1))


def _right_entry() -> Formula:
    """C[1,2] of the derived arm."""
    arm = Dynamics.of(ARM)
    return Relation(symbol("C_12"), "=", formula_of(arm.C[0, 1], arm.names()))


def _reference_velocity() -> Formula:
    """The reference velocity of the sliding laws."""
    qd_d, Lambda, e = (ca.SX.sym(name) for name in ("qd_d", "Lambda", "e"))
    return Relation(symbol("qd_r"), "=", read(qd_d - Lambda * e))


def _repairs() -> tuple[Phrase, ...]:
    """The repair of each slip."""
    return (
        (
            "(3): ",
            _right_entry(),
            ", for which ",
            Symbol("M", dots=1),
            " \N{MINUS SIGN} 2",
            symbol("C"),
            " is skew-symmetric.",
        ),
        (
            "(24): ",
            Relation(symbol("D_hat"), "=", symbol("eta")),
            ", which follows ",
            symbol("D"),
            ". It must know ",
            symbol("D"),
            ", so it is an oracle, and marked as one.",
        ),
        (
            "(28): the reference velocity ",
            _reference_velocity(),
            " in place of ",
            symbol("qd_d"),
            ", without which the term ",
            read(ca.SX.sym("Lambda") * ca.SX.sym("e_2")),
            " of (30) stays uncancelled.",
        ),
        "(33): a plus, so that the gain grows with the error, in the reading outer. The fitted Q and R need it; "
        "with a smaller Q the law can track without it.",
    )


def repair_section(results: Results, tracking: tuple[Paragraph, Table]) -> Section:
    """One slip put back at a time, then two slips repaired alone."""
    before, after = (results["one change", change].score("late error", 1)[0] for change in ("none", "D_hat in (10)"))
    rows = [_row(words, results["one change", change]) for change, words in CHANGES.items()]
    columns = (
        Column("change"),
        Column("K loses positivity at", "s", "right"),
        Column("RMSE of q1", "rad", "right"),
        Column("RMSE of q2", "rad", "right"),
        Column("late error of q1", "rad", "right"),
        Column("late error of q2", "rad", "right"),
    )
    return Section(
        "A repair of four slips, and a smaller one that tracks",
        (
            Itemize(_repairs()),
            Table(
                "slips",
                f"The repaired law with one slip of the print put back, or one repair more: first scenario, over "
                f"{SHORT:g} s, with Q = {np.asarray(CARD['Q'])[0, 0]:g} I, R = {np.asarray(CARD['R'])[0, 0]:g} I.",
                columns,
                tuple(rows),
                (
                    f"Late error: the largest |e| from {LATE:g} s on.",
                    "Diverged: a state is no longer a finite number; when that is depends on the step.",
                ),
            ),
            Paragraph(
                (
                    "The late error is the bias of observer (10), which leaves out ",
                    symbol("D"),
                    f": joint 2 falls from {before:.3f} to {after:.3f} rad where the observer is given ",
                    symbol("D_hat"),
                    ", which here is filtered from the true disturbance. In RMSE over the horizon the initial error "
                    "hides it.",
                )
            ),
            *tracking,
            Paragraph(LEFT),
        ),
    )


def _row(words: str, outcome: Outcome) -> tuple[Cell, ...]:
    lost = _when(loses_positivity(outcome))
    if outcome.diverged_at is not None:
        return (words, lost, *_ends(outcome), None, None)
    return (words, lost, *_ends(outcome), *(Measured(*outcome.score("late error", joint)) for joint in (0, 1)))
