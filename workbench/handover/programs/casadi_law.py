"""A law as a module that makes its CasADi function, with which a solver or a simulation of one's own goes on."""

from __future__ import annotations

import keyword
from collections.abc import Iterable

import casadi as ca

from workbench.core.bounded_loop import operation_codes
from workbench.core.layout import Layout
from workbench.core.notation.comments import harmless
from workbench.core.notation.program import FUNCTION_NAMES, Dialect, straight_line
from workbench.core.sampled_law import SYMBOLS, SampledLaw
from workbench.core.validation.signatures import check_arguments
from workbench.handover.export_seal import MARK

SIGNS = {"lt": "{} < {}", "le": "{} <= {}", "eq": "{} == {}", "ne": "{} != {}"}
WORDS = {"and": "ca.logic_and({}, {})", "or": "ca.logic_or({}, {})", "not": "ca.logic_not({})"}
OWN = ("k", *SYMBOLS, "u", "z_next", "ca", "law", "after", "PERIOD", "START", "NOMINAL")
CASADI = Dialect(
    {name: f"ca.{name}" for name in FUNCTION_NAMES.split()} | {"pow": "ca.power"},
    frozenset([*OWN, *keyword.kwlist]),
    width=84,
    choices=SIGNS | WORDS | {"if_else_zero": "ca.if_else({}, {}, 0.0)"},
)
FUNCTION = """k, z, y, r, p = (ca.SX.sym(*each) for each in ({sizes}))
law = ca.Function(
    "law", [k, z, y, r, p], [*after(k, z, y, r, p)], ["k", "z", "y", "r", "p"], ["z_next", "u"]
)"""


LETTERS = 96  # of a line of a stored function


@check_arguments
def casadi_law(law: SampledLaw, name: str = "") -> str:
    """The text of a module with the function `law` (k, z, y, r, p) -> (z_next, u), the start of z and the nominal p.

    Parameters
    ----------
    name
        What the module says that it is; the law's own name if none is given.

    Raises
    ------
    ValueError
        If the law has a constant that is not finite, or an operation that no text has.
    """
    head = [f'"""{harmless(name or law.name)}: a law that runs once in {law.period!r} s, as a CasADi function.', ""]
    head += [*_about(law), '"""', "", "import casadi as ca", "", f"PERIOD = {law.period!r}  # s"]
    head += _values("START", law.memory) + _values("NOMINAL", law.parameters)
    body = _stored(law) if ca.OP_CALL in operation_codes(law.F) else _program(law)
    return "\n".join([*head, "", "", *body]) + "\n"


def _stored(law: SampledLaw) -> list[str]:
    """The lines of a law with loops, which no program without branches can write."""
    arguments = [law.k, law.z, law.y, law.r, law.p]
    text = ca.Function(
        "law", arguments, [law.update, law.command], ["k", "z", "y", "r", "p"], ["z_next", "u"]
    ).serialize()
    parts = [f'    "{text[i : i + LETTERS]}"' for i in range(0, len(text), LETTERS)]
    return [
        "# The law has loops. It is stored as CasADi stores functions.",
        "law = ca.Function.deserialize(",
        *parts,
        ")",
    ]


def _program(law: SampledLaw) -> list[str]:
    """The lines of a law without loops."""
    vectors = {"k": law.k, **{letter: getattr(law, letter) for letter in SYMBOLS}}
    own = {letter: ca.SX.sym(letter, part.numel()) for letter, part in vectors.items()}
    entries = {f"{letter}_{i}": f"{letter}[{i}]" for letter, part in own.items() for i in range(part.numel())}
    own |= {
        letter: ca.vertcat(ca.SX(0, 1), *(ca.SX.sym(n) for n in entries if n.startswith(f"{letter}_")))
        for letter in own
    }
    made = ca.densify(ca.vertcat(law.update, law.command))
    made = ca.substitute([made], [*vectors.values()], [*own.values()])[0]
    program = straight_line({"w": made}, {}, CASADI)
    results = [row[0] for row in program.entries["w"]]
    lines = [f"{variable} = {entries[symbol]}" for variable, symbol in program.inputs]
    lines += [f"{variable} = {text}" for variable, text in program.lines]
    head = ["def after(k, z, y, r, p):", '    """The memory after instant k, and the commands."""']
    ends = [f"return {_column(results[: law.memory.size])}, {_column(results[law.memory.size :])}"]
    sizes = ", ".join(f'("{letter}", {part.numel()})' for letter, part in own.items())
    body = [f"    {line}" for line in lines + ends]
    return [*head, *body, "", "", *FUNCTION.format(sizes=sizes).splitlines()]


def _about(law: SampledLaw) -> list[str]:
    lines = [f"Made by {MARK}; the digest of its equations, period and numbers is {law.fingerprint[:16]}.", ""]
    for letter, word in SYMBOLS.items():
        port = getattr(law, word)
        lines.append(f"{letter}: {harmless(', '.join(port.labels)) or 'nothing'}")
    return [*lines, f"u: {harmless(', '.join(law.commands.labels))}", *map(harmless, law.notes)]


def _values(name: str, port: Layout) -> list[str]:
    units = [unit for entry in port.entries for unit in entry.units]
    rows = zip(port.default, port.labels, units, strict=True)
    lines = [
        f"    {float(value)!r},  # {harmless(f'{label} [{unit}]' if unit else label)}" for value, label, unit in rows
    ]
    return [f"{name} = [", *lines, "]"] if lines else [f"{name} = []"]


def _column(parts: Iterable[str]) -> str:
    return f"ca.vertcat({', '.join(['ca.SX(0, 1)', *parts])})"
