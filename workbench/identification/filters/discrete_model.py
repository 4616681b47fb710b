"""DiscreteModel: x+ = f(k, x, u), y = h(k, x, u), as CasADi expressions with names and units."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial

import casadi as ca

from workbench.core import Layout
from workbench.core.expressions import refuse_misfit, refuse_unknown
from workbench.core.validation.refusals import describe
from workbench.core.validation.signatures import answer, check_arguments
from workbench.core.validation.type_hints import KindError

Columns = ca.SX | Sequence[ca.SX]


@dataclass(frozen=True, eq=False, repr=False)
@check_arguments
class DiscreteModel:
    """A model in discrete time for a filter: x+ = f(k, x, u) + w, y = h(k, x, u) + v.

    `DiscreteModel.of` makes one from two functions.

    Parameters
    ----------
    states, inputs, outputs
        Names, shapes and units of x, u and y.
    x, u
        The symbols of x, (n, 1), and u, (m, 1).
    next, output
        The expressions of f, (n, 1), and h, (q, 1).
    k
        The symbol of the number of the sample, (1, 1).

    Raises
    ------
    ValueError
        If an expression does not have the size of its layout, or has a symbol other than k, x and u.

    Examples
    --------
    >>> decay = wb.filters.DiscreteModel.of(
    ...     wb.layout(level="m"), wb.layout(), wb.layout(gauge="m"), lambda x, u: 0.9 * x, lambda x, u: x
    ... )
    >>> decay
    <DiscreteModel: level -> gauge>
    """

    states: Layout
    inputs: Layout
    outputs: Layout
    x: ca.SX
    u: ca.SX
    next: ca.SX
    output: ca.SX
    k: ca.SX = field(default_factory=lambda: ca.SX.sym("k"))

    def __post_init__(self) -> None:
        sizes = {"x": self.states, "u": self.inputs, "next": self.states, "output": self.outputs}
        for name, layout in sizes.items():
            refuse_misfit("DiscreteModel", name, getattr(self, name), layout.size, 1)
        refuse_misfit("DiscreteModel", "k", self.k, 1, 1)
        symbols = {"k": self.k, "x": self.x, "u": self.u}
        refuse_unknown("DiscreteModel", symbols, next=self.next, output=self.output)

    @staticmethod
    @check_arguments
    def of(
        states: Layout,
        inputs: Layout,
        outputs: Layout,
        f: Callable[[ca.SX, ca.SX], Columns],
        h: Callable[[ca.SX, ca.SX], Columns],
    ) -> DiscreteModel:
        """A model from f(x, u) and h(x, u), which take columns of symbols and give columns or lists of expressions."""
        x, u = states.symbols(), inputs.symbols()
        columns = (
            answer(f"DiscreteModel.of({name}=...)", "give CasADi expressions", partial(function, x, u), _column)
            for name, function in (("f", f), ("h", h))
        )
        return DiscreteModel(states, inputs, outputs, x, u, *columns)

    def __repr__(self) -> str:
        return f"<DiscreteModel: {', '.join(self.states.names)} -> {', '.join(self.outputs.names)}>"


def _column(given: Columns) -> ca.SX:
    try:
        parts = given if isinstance(given, Sequence) else [given]
        return ca.densify(ca.vertcat(*(ca.SX(part) for part in parts)))
    except (NotImplementedError, TypeError) as error:
        raise KindError("CasADi expressions", describe(given)) from error
