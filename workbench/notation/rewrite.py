"""Formulas made of other formulas: parts replaced, the rest as it was."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

from workbench.notation import build
from workbench.notation.formula import Call, Formula, Power, Product, Quotient, Sum, Symbol, children


def parts(formula: Formula) -> Iterator[Formula]:
    """A formula and all that it is made of, from the outside in."""
    yield formula
    for part in children(formula):
        yield from parts(part)


def substitute(formula: Formula, meanings: Mapping[Symbol, Formula]) -> Formula:
    """The formula with each symbol that has a meaning replaced by it."""
    if isinstance(formula, Symbol):
        return meanings.get(formula, formula)
    return rebuilt(formula, [substitute(part, meanings) for part in children(formula)])


def rebuilt(formula: Formula, among: Sequence[Formula]) -> Formula:
    """A formula of the same kind with other parts; of a sum or a product there may be more or fewer."""
    rules: dict[type, Callable[..., Formula]] = {
        Sum: lambda *terms: build.total(terms),
        Product: lambda *factors: build.product(factors),
        Quotient: build.quotient,
        Power: build.power,
    }
    if isinstance(formula, Call):
        return build.call(formula.function, *among)
    return rules[type(formula)](*among) if type(formula) in rules else formula
