"""The section on one law in two settings: its few sweeps, and many with a polish, with proofs of infeasible states."""

from __future__ import annotations

import workbench as wb
from studies.d2_planning.certificates import PIECES, Conflict, Piece
from studies.d2_planning.posed_problems import INFEASIBLE, POSED
from studies.d2_planning.settings import COUNTS, PERIODS, REACH, STARTS, Errors

Column = wb.document.TableColumn
ROUNDING = 1e-12


def section(results: wb.Results) -> wb.Section:
    """Both settings on posed problems, infeasible states, and a published law."""
    words = (
        "The solver of the law has two settings. In a computer it makes the few sweeps of its design in each period, "
        "and goes on in the next from there. As an exact solver, ",
        wb.document.Code("exact_mpc"),
        ", it makes 25 sweeps from no memory. It then solves for the active rows by orthogonal factors, and changes "
        "the active set until all conditions of optimality hold: the polish. It returns a solution with its "
        "certificate, or the limits that conflict, with a proof. Both settings stand here side by side, with the "
        "number of sweeps that would do without the polish.",
    )
    how = (
        f"The sample has {STARTS} closed loops of {PERIODS} periods of the exact law on the linear model, from random "
        f"directions in which the LQR answer passes a limit by a factor of up to {REACH:g}. Only moves from states at "
        "which the LQR answer passes a limit count, as the law is exact elsewhere. The designs have chosen their "
        "sweeps by another sample, in which all moves err by at most 0.01 of a span; the published law has those of "
        "its spectrum. Larger errors here show what a sample is worth. Where rows depend on each other, as with hard "
        "limits on states, a few moves need thousands of sweeps. There the exact solver owes its answer to the polish."
    )
    blocks = (wb.Paragraph(words), wb.Paragraph(how), settings_table(results), conflict_table(results))
    return wb.Section("One law in two settings", (*blocks, published_table(results)))


def settings_table(results: wb.Results) -> wb.document.ReportTable:
    """The errors of both settings."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for name, one in zip(POSED, results.work("settings"), strict=True):
        residual = max(one.violation, one.sign, one.gap)
        many = str(one.many.sweeps) if one.late == 0 else f"> {one.many.sweeps}"
        rows.append((name, "design", str(one.few.sweeps), *error_cells(one.few), None))
        rows.append((f"{one.method}, {one.moves} moves", "1e-8", many, *error_cells(one.many), None))
        rows.append((f"{one.changes} changes of the active set", "exact", "25", *5 * (None,), f"{residual:.0e}"))
    columns = (
        Column("problem"),
        Column("setting"),
        Column("sweeps", align="right"),
        Column("move: median", align="right"),
        Column("largest", align="right"),
        Column("> 0.01", align="right"),
        Column("cost: median", align="right"),
        Column("largest", align="right"),
        Column("KKT", align="right"),
    )
    notes = (
        "Below the name of a problem stand the method of its design, the number of moves, and the largest number of "
        "changes of the active set in a polish. Design: the sweeps of the law in a period. 1e-8: as many as bring each "
        f"move within this error, of numbers up to {COUNTS[-1]}. Exact: 25 sweeps and the polish. Errors of moves in "
        "spans of an input, with the share of moves that err by more than 0.01, and of the costs of loops, relative; "
        f"both beside the exact solution, and 0 below {ROUNDING:g}. KKT: the largest relative violation of a limit, "
        "multiplier of a wrong sign, or gap of the cost.",
    )
    caption = "Both settings of the law on posed problems."
    return wb.document.ReportTable("settings", caption, columns, tuple(rows), notes)


def error_cells(one: Errors) -> tuple[str, ...]:
    """The errors of a setting as text."""
    moves = in_words(one.median_move), in_words(one.largest_move), f"{100 * one.beyond:.2g} %"
    return (*moves, in_words(one.median_cost), in_words(one.largest_cost))


def in_words(value: float) -> str:
    """An error to one digit; those of rounding as 0."""
    return "0" if value < ROUNDING else f"{value:.0e}"


def conflict_table(results: wb.Results) -> wb.document.ReportTable:
    """Infeasible states with the limits that conflict."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for name, one in zip(INFEASIBLE, results.work("conflicts"), strict=True):
        rows.append(
            (name, conflict_words(one), one.margin, proof_words(one), f"{one.needed_count} of {len(one.limits)}")
        )
    columns = (
        Column("state and limits", width=26),
        Column("limits that conflict", width=14),
        Column("margin", align="right", digits=2),
        Column("proof", width=10),
        Column("needed", align="right"),
    )
    notes = (
        "Margin: by how much the limits are missed along the Farkas vector, whose largest entry is 1. Needed: without "
        "it, the others of the conflict have a solution with a passed certificate.",
    )
    return wb.document.ReportTable(
        "conflicts", "States from which no input keeps the limits.", columns, tuple(rows), notes
    )


def conflict_words(one: Conflict) -> str:
    """The limits that conflict; a state that has a solution is said."""
    return wb.document.join_names(one.limits) if one.limits else "none: it has a solution"


def proof_words(one: Conflict) -> str:
    """The kind of the proof."""
    return "exact arithmetic" if one.is_proved else "to rounding"


def published_table(results: wb.Results) -> wb.document.ReportTable:
    """The published law beside both settings."""
    rows = [
        (name, number_words(gain, offset), in_words(piece.exact), in_words(piece.few))
        for (name, (_, gain, offset)), piece in zip(PIECES.items(), pieces(results), strict=True)
    ]
    columns = (
        Column("piece"),
        Column("printed law"),
        Column("exact: difference", align="right"),
        Column("few sweeps: difference", align="right"),
    )
    notes = (
        "Bemporad, Morari, Dua and Pistikopoulos (2002), section 7.1. The largest difference from the printed gains "
        "and offsets, which have four digits behind the point. The few sweeps are from no memory. P solves P = A P A' "
        "+ Q, to which the printed gains belong.",
    )
    caption = "A published law in both settings."
    return wb.document.ReportTable("published_law", caption, columns, tuple(rows), notes)


def pieces(results: wb.Results) -> tuple[Piece, ...]:
    """The pieces of the published law."""
    return tuple(results.work("published"))


def number_words(gain: tuple[float, float], offset: float) -> str:
    """A piece as it is printed."""
    if gain == (0.0, 0.0):
        return f"u = {offset:g}".replace("-", "−")
    end = f" + {offset:.4f}" if offset else ""
    return f"u = [{gain[0]:.4f}, {gain[1]:.4f}] x{end}".replace("-", "−")
