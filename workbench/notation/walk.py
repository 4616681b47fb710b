"""An SX expression as a list of operations, each after its operands and each shared one once."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import casadi as ca

from workbench.validation.signatures import door

NAMES = {int(getattr(ca, name)): name.removeprefix("OP_") for name in dir(ca) if name.startswith("OP_")}


@dataclass(frozen=True)
class Operation:
    """One node: the code of its operation, the places of its operands in the list, and its name or value."""

    code: int
    operands: tuple[int, ...]
    value: float = 0.0
    name: str = ""


@dataclass(frozen=True)
class Walk:
    """The nodes of an expression in the order of evaluation, and which of them are its entries.

    `entries` holds one place for each row and column; structural zeros are nodes too.
    """

    nodes: tuple[Operation, ...]
    entries: tuple[tuple[int, ...], ...]


@door
def walk(expression: ca.SX, *, cse: bool = False) -> Walk:
    """List the operations of a matrix (n, m) of expressions; with `cse`, equal ones become one.

    Raises
    ------
    ValueError
        If the matrix is empty, or if two symbols of the expression bear one name.
    """
    matrix = ca.densify(ca.SX(expression))
    if matrix.numel() == 0:
        raise ValueError(f"An expression to be read must have entries; this one has shape {matrix.shape}.")
    symbols = ca.symvar(matrix)
    names = [symbol.name() for symbol in symbols]
    if twice := sorted(name for name, times in Counter(names).items() if times > 1):
        raise ValueError(f"Symbols are told apart by name, but two different ones are called {twice[0]!r}.")
    function = ca.Function("walk", [ca.vertcat(*symbols)], [matrix], {"cse": cse, "allow_free": False})
    nodes, places = _nodes(function, names)
    n, m = matrix.shape
    return Walk(tuple(nodes), tuple(tuple(places[i + n * j] for j in range(m)) for i in range(n)))


def _nodes(function: ca.Function, names: list[str]) -> tuple[list[Operation], dict[int, int]]:
    """The instructions of a function, with its work registers resolved; outputs by their number."""
    nodes: list[Operation] = []
    registers: dict[int, int] = {}
    outputs: dict[int, int] = {}
    for k in range(function.n_instructions()):
        code = function.instruction_id(k)
        reads, writes = function.instruction_input(k), function.instruction_output(k)
        if code == ca.OP_OUTPUT:
            outputs[writes[1]] = registers[reads[0]]
            continue
        if code == ca.OP_INPUT:
            node = Operation(code, (), name=names[reads[1]])
        elif code == ca.OP_CONST:
            node = Operation(code, (), value=function.instruction_constant(k))
        else:
            node = Operation(code, tuple(registers[read] for read in reads))
        registers[writes[0]] = len(nodes)
        nodes.append(node)
    return nodes, outputs
