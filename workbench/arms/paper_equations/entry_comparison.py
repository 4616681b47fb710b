"""A paper's printed M, C and G against the derived ones, entry by entry."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Literal

import casadi as ca

from workbench.arms.dynamics import Dynamics
from workbench.arms.identity_proofs import IdentityVerdict, Witness, fixed_parameters, judge_zero, proved_or_searched
from workbench.arms.paper_equations.arm_letters import symbols_of
from workbench.arms.paper_equations.formula_values import CASADI, at_numbers, evaluate, normal_form
from workbench.arms.paper_equations.printed_equations import Place, Sheet, is_place
from workbench.arms.paper_equations.tokens import PI
from workbench.core.notation.formula import letters, name_of
from workbench.core.notation.normal_form import NormalForm
from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import describe, known_name
from workbench.core.validation.signatures import check_arguments
from workbench.proofs.equality import Kind

Sameness = Literal["same", "differs", "not refuted"]
SAMENESS: dict[Kind, Sameness] = {"proved": "same", "refuted": "differs", "not refuted": "not refuted"}


@dataclass(frozen=True, eq=False)
@show
class EntryVerdict:
    """One printed entry beside the derived one, at a place that is counted from 1; a vector has column 1.

    The `kind` is `same` if the two are equal by normal form, `differs` if a witness shows it with the two values
    there, and `not refuted` if neither was possible. `difference` is printed - right, in the derived arm's symbols.
    `same_torque`, of an entry of C that differs, is `proved` if row i of (C_printed - C_right) qd is zero all the
    same, by another legal factorisation of one torque, and `refuted` if the torque is wrong.
    """

    matrix: str
    row: int
    column: int
    kind: Sameness
    evidence: str
    printed_entry: ca.SX
    right: ca.SX
    difference: ca.SX
    witness: Witness | None = None
    printed_value: float | None = None
    right_value: float | None = None
    same_torque: Kind | None = None

    @property
    def label(self) -> str:
        """The entry as a paper names it: `C[1,2]`, or `G[1]`."""
        return f"G[{self.row}]" if self.matrix == "G" else f"{self.matrix}[{self.row},{self.column}]"


@check_arguments
def compare(printed_dynamics: Dynamics, derived_dynamics: Dynamics) -> tuple[EntryVerdict, ...]:
    """A verdict for each entry of M, C and G, row by row; parameters are matched by name.

    `same` holds in all states and for all parameters, not only the nominal ones.

    Examples
    --------
    >>> arm = wb.arms.Dynamics.of(wb.robot("planar-1r"), "planar-1r")
    >>> [(entry.label, entry.kind) for entry in wb.arms.paper_equations.compare(arm, arm)]
    [('M[1,1]', 'same'), ('C[1,1]', 'same'), ('G[1]', 'same')]
    """
    theirs = _matrices_in_symbols_of(derived_dynamics, printed_dynamics)
    shapes = {name: matrix.shape for name, matrix in theirs.items()}
    places = [(name, i, j) for name, (rows, columns) in shapes.items() for i in range(rows) for j in range(columns)]
    return entry_verdicts({(name, i + 1, j + 1): theirs[name][i, j] for name, i, j in places}, derived_dynamics)


@check_arguments
def compare_sheet(sheet: Sheet, derived_dynamics: Dynamics) -> tuple[EntryVerdict, ...]:
    """A verdict for each entry that a sheet prints; its numbers are taken as printed, not as doubles near them.

    An entry that is finite nowhere is a ValueError, a sheet that was read for another arm a LookupError.
    """
    symbols = {
        symbol.name(): symbol
        for symbol in ca.vertsplit(ca.vertcat(derived_dynamics.q, derived_dynamics.qd, derived_dynamics.symbols))
    }
    values = {letter: symbols[name] for letter, name in symbols_of(derived_dynamics).items()}
    foreign = {letter for f in sheet.entries.values() for letter in letters(f)} - {*values, PI}
    if foreign:
        lacking = name_of(foreign.pop())
        raise LookupError(f"A sheet is compared with the arm it was read for; this one has no '{lacking}'.")
    printed = {place: evaluate(f, values, CASADI) for place, f in sheet.entries.items()}
    comparison = _Comparison(printed, derived_dynamics, sheet)
    return tuple(map(comparison.entry, printed))


@check_arguments
def entry_verdicts(printed_entries: Mapping[Place, ca.SX], derived_dynamics: Dynamics) -> tuple[EntryVerdict, ...]:
    """A verdict for each of the printed entries, which are expressions in the derived arm's symbols.

    Where a row of C is printed in part, its other entries are taken to be the derived ones.
    """
    return tuple(map(_Comparison(printed_entries, derived_dynamics).entry, printed_entries))


@dataclass(frozen=True, eq=False)
class _Comparison:
    """Printed entries beside a derived arm, with the sheet on which they were read if there is one."""

    printed_entries: Mapping[Place, ca.SX]
    derived_dynamics: Dynamics
    sheet: Sheet | None = None

    def __post_init__(self) -> None:
        for (matrix, row, column), entry in self.printed_entries.items():
            if not is_place((matrix, row, column), self.derived_dynamics.dof):
                joints = f"{self.derived_dynamics.dof} joint{'s' if self.derived_dynamics.dof > 1 else ''}"
                raise LookupError(f"An arm with {joints} has no entry {describe(matrix)}[{row},{column}].")
            if entry.numel() != 1:
                raise ValueError(f"An entry is one expression; {matrix}[{row},{column}] has shape {entry.shape}.")

    def right(self, place: Place) -> ca.SX:
        name, row, column = place
        return {"M": self.derived_dynamics.M, "C": self.derived_dynamics.C, "G": self.derived_dynamics.G}[name][
            row - 1, column - 1
        ]

    def entry(self, place: Place) -> EntryVerdict:
        name, row, column = place
        a, b = self.printed_entries[place], self.right(place)
        judgement = self.judge({place: ca.SX(1)})
        if judgement.search and not judgement.search.samples:
            why = f"the printed {name}[{row},{column}] is a number at none of the states that were tried"
            raise ValueError(f"{why}; look for a division by zero, or the root of a negative number.")
        verdict = EntryVerdict(*place, SAMENESS[judgement.kind], judgement.evidence, a, b, a - b)
        found = judgement.search.witness if judgement.search else None
        if found is None:
            return verdict
        d = self.derived_dynamics
        one, other = ca.Function("values", [d.q, d.qd, d.symbols], [a, b])(found.q, found.qd, found.p)
        torque = {("C", row, j + 1): d.qd[j] for j in range(d.dof)} if name == "C" else None
        kind = self.judge(torque).kind if torque else None
        return replace(verdict, witness=found, printed_value=float(one), right_value=float(other), same_torque=kind)

    def judge(self, weights: Mapping[Place, ca.SX]) -> IdentityVerdict:
        """The verdict on a weighted sum of printed entries against the derived one; unprinted ones count as right."""
        a, b = (
            sum((w * entry(place) for place, w in weights.items()), ca.SX(0))
            for entry in (lambda place: self.printed_entries.get(place, self.right(place)), self.right)
        )
        if (sheet := self.sheet) is None:
            return judge_zero(a - b, ca.vertcat(a, b), self.derived_dynamics)
        judgement = proved_or_searched(
            lambda: self.difference(sheet, weights).is_zero, a - b, ca.vertcat(a, b), self.derived_dynamics
        )
        found = judgement.search
        if found is None or found.witness is None:
            return judgement
        changed = {
            label: value for label, value in found.witness.changed_parameters.items() if label not in sheet.zeros
        }
        found = replace(found, witness=replace(found.witness, changed_parameters=changed))
        return IdentityVerdict(judgement.kind, f"at {found.witness}", found)

    def difference(self, sheet: Sheet, weights: Mapping[Place, ca.SX]) -> NormalForm:
        """The weighted sum of printed - right by exact arithmetic, at the numbers that the sheet holds fixed."""
        names = symbols_of(self.derived_dynamics)
        numbers = {
            label: sheet.numbers[label] for label in fixed_parameters(self.derived_dynamics) if label in sheet.numbers
        }
        total = NormalForm({})
        for place, weight in weights.items():
            if place in sheet.entries:
                apart = normal_form(sheet.entries[place], names) - NormalForm.of(self.right(place))
                total += NormalForm.of(weight) * apart
        return at_numbers(total, numbers)


def _matrices_in_symbols_of(derived_dynamics: Dynamics, printed_dynamics: Dynamics) -> dict[str, ca.SX]:
    if printed_dynamics.dof != derived_dynamics.dof:
        joints = f"{printed_dynamics.dof} printed and {derived_dynamics.dof} derived"
        raise ValueError(f"`compare(printed, derived)` needs arms of the same number of joints; got {joints}.")
    labels = derived_dynamics.p.labels
    places = [
        labels.index(known_name(label, labels, "parameters of the derived arm")) for label in printed_dynamics.p.labels
    ]
    old = ca.vertcat(printed_dynamics.q, printed_dynamics.qd, printed_dynamics.symbols)
    new = ca.vertcat(
        derived_dynamics.q, derived_dynamics.qd, derived_dynamics.symbols[places] if places else ca.SX(0, 1)
    )
    matrices = ca.substitute([printed_dynamics.M, printed_dynamics.C, printed_dynamics.G], [old], [new])
    return dict(zip("MCG", matrices, strict=True))
