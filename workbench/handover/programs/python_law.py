"""A law as a module of Python that needs nothing but `math` and `struct`, with the bits of the portable arithmetic."""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np

from workbench.core.layout import Entry, Layout
from workbench.core.notation.comments import harmless
from workbench.core.sampled_law import SampledLaw
from workbench.core.validation.number_types import Values
from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments
from workbench.engine.kernel.graph import Graph
from workbench.engine.kernel.plan import graph_of
from workbench.engine.machines.python_elementary_functions import definitions
from workbench.engine.machines.python_spelling import literal
from workbench.handover.c99.c_files import safe_command
from workbench.handover.c99.c_interface import queue_places
from workbench.handover.export_seal import MARK
from workbench.handover.law_graph import behind_limits
from workbench.handover.programs.python_lines import lines_of

OWN = '''class Law:
    """The law: `step` once in `PERIOD` seconds."""

    def __init__(self, **parameters):
        if unknown := set(parameters) - set(PARAMETERS):
            raise LookupError(f"This law has the parameters {sorted(PARAMETERS)}; got {sorted(unknown)}.")
        self.parameters = copied(PARAMETERS) | parameters
        self.reset()

    def reset(self):
        """The memory as it is at the start; the parameters stay."""
        self.k, self.flags, self.memory = 0, OK, copied(MEMORY)

    def step(self, readings, references=None):
        """The commands by name, for readings and references by name.

        A value is a float, or a list of them; a matrix lies column by column. Where a number is not finite `flags`
        says which. Unless the law answers it, the commands are `SAFE`, and the memory stays, but for commands on their
        way.
        """
        readings, references = taken("reading", readings, READINGS), taken("reference", references or {}, REFERENCES)
        flags = OK if finite(readings, READINGS) else BAD_READING
        flags |= OK if finite(references, REFERENCES) else BAD_REFERENCE
        if flags == OK or ANSWERS_MISSING:
            memory, commands, inner = moved(float(self.k), self.memory, readings, references, self.parameters)
            good = finite(commands, SAFE) and finite(memory, MEMORY) and not any(map(math.isnan, inner))
            flags |= OK if good else BAD_COMMAND
        self.k, self.flags = self.k + 1, flags
        if flags & BAD_COMMAND or (flags != OK and not ANSWERS_MISSING):
            self.memory |= copied(SAFE_QUEUE)
            return copied(SAFE)
        self.memory = memory
        return commands


def taken(noun, values, names):
    """The values of these names as floats, or lists of them."""
    if set(values) != set(names):
        raise LookupError(f"The law needs a {noun} of each of {sorted(names)}; got {sorted(values)}.")
    held = {}
    for name, one in names.items():
        numbers = [float(x) for x in values[name]] if isinstance(one, list) else float(values[name])
        if isinstance(one, list) and len(numbers) != len(one):
            raise ValueError(f"The {noun} '{name}' must have {len(one)} numbers; got {len(numbers)}.")
        held[name] = numbers
    return held


def copied(values):
    """Values by name, with lists of their own."""
    return {name: list(value) if isinstance(value, list) else value for name, value in values.items()}


def finite(values, names):
    """True if every number of these names is finite."""
    return all(
        math.isfinite(x)
        for name in names
        for x in (values[name] if isinstance(values[name], list | tuple) else [values[name]])
    )
'''
FLAGS = ("OK", "BAD_READING", "BAD_REFERENCE", "BAD_COMMAND")


@check_arguments
def python_law(law: SampledLaw, name: str = "", *, safe: Values | None = None) -> str:
    """The text of a module with the class `Law`, which has the bits of the simulation in the portable arithmetic.

    Parameters
    ----------
    name
        What the module says that it is; the law's own name if none is given.
    safe
        As of `c_code`.

    Raises
    ------
    ValueError, LookupError
        If a safe command is beyond a limit, or is for no command of the law.
    """
    graph = graph_of(law.step)
    graph = Graph(graph.nodes, (*graph.results, *behind_limits(graph)))
    variables, size = _Variables(law), law.step.states.size
    lines, results = lines_of(graph, law.period, variables.of)
    functions, memory = definitions(lines), law.memory.size
    head = [f'"""{harmless(name or law.name)}: a law that runs once in {law.period!r} s.', "", *_about(law), '"""', ""]
    head += [
        "import math",
        *(["import struct"] if "def bits(x):" in functions else []),
        "",
        f"PERIOD = {law.period!r}  # s",
    ]
    head += [f"{flag} = {value}" for flag, value in zip(FLAGS, (0, 1, 2, 4), strict=True)]
    head += [f"ANSWERS_MISSING = {law.answers_missing}  # readings and references that are not finite"]
    safest = safe_command(law, safe)
    waiting = Layout(tuple(entry for entry in law.memory.entries if entry.name in queue_places(law)))
    named = law.commands.unpack(safest)
    queued = [np.ravel(named[name], order="F") for entry in waiting.entries for name in queue_places(law)[entry.name]]
    head += _table("PARAMETERS", law.parameters) + _table("MEMORY", law.memory)
    head += _table("READINGS", law.readings) + _table("REFERENCES", law.references)
    head += _table("SAFE", law.commands, safest)
    head += _table("SAFE_QUEUE", waiting, np.concatenate([*queued, np.zeros(0)])) + ["", ""]
    body = ["def moved(k, memory, readings, references, parameters):"]
    body += [
        '    """The memory after this instant, the commands, and what limits stand before."""',
        *(f"    {x}" for x in variables.reads()),
    ]
    body += [f"    {line}" for line in lines]
    body += [f"    after = {_mapping(law.memory, results[:memory])}"]
    body += [f"    commands = {_mapping(law.commands, results[memory:size])}"]
    body += [f"    return after, commands, [{', '.join(results[size:])}]"]
    return "\n".join([*head, *functions, *body, "", "", OWN.rstrip("\n")]) + "\n"


class _Variables:
    """The variable of each number that a law is handed."""

    def __init__(self, law: SampledLaw) -> None:
        self.law = law
        self.ports: Mapping[str, tuple[str, Layout]] = {
            "z": ("memory", law.memory),
            "u": ("", law.commands),
            "p": ("parameters", law.parameters),
            "y": ("readings", law.readings),
            "r": ("references", law.references),
        }
        self.names = {letter: _named(letter, port) for letter, (_, port) in self.ports.items()}
        self.used: set[str] = set()

    def of(self, source: str, entry: int) -> str:
        """The variable of an entry of the states [z; u], or of the parameters [p; y; r], of the law's step."""
        if source == "k":
            return "k"
        names = [name for letter in ("zu" if source == "x" else "pyr") for name in self.names[letter]]
        self.used.add(names[entry])
        return names[entry]

    def reads(self) -> list[str]:
        """The lines that take the variables that are used out of their mappings."""
        lines = []
        for letter, (mapping, port) in self.ports.items():
            for entry in port.entries:
                names = self.names[letter][port.slice(entry.name)]
                if self.used.intersection(names):
                    value = f"{mapping}[{_quoted(entry.name)}]"
                    lines.append(f"{', '.join(names)}{',' * (len(names) == 1 and entry.shape != ())} = {value}")
        return lines


def _named(letter: str, port: Layout) -> list[str]:
    names: list[str] = []
    for label in port.labels:
        name = f"{letter}_{re.sub(r'[^A-Za-z0-9]+', '_', label).strip('_')}"
        while name in names:
            name += "_"
        names.append(name)
    return names


def _about(law: SampledLaw) -> list[str]:
    lines = [f"Made by {MARK}; the digest of its equations, period and numbers is {law.fingerprint[:16]}.", ""]
    for word, port in (("Readings", law.readings), ("References", law.references), ("Commands", law.commands)):
        entries = ", ".join(f"{e.name}{f' [{e.unit}]' if e.unit else ''}" for e in port.entries)
        lines += [f"{word}: {harmless(entries) or 'none'}."]
    return lines + [harmless(note) for note in law.notes]


def _table(name: str, port: Layout, values: Array | None = None) -> list[str]:
    flat = port.default if values is None else values
    rows = [(e, _numbers(e, [literal(float(x)) for x in flat[port.slice(e.name)]])) for e in port.entries]
    return (
        [f"{name} = {{", *(f"    {_quoted(e.name)}: {text},{_unit(e)}" for e, text in rows), "}"]
        if rows
        else [f"{name} = {{}}"]
    )


def _quoted(name: str) -> str:
    return f'"{name}"' if re.fullmatch(r"[\w.\[\]]+", name, re.ASCII) else repr(name)


def _unit(entry: Entry) -> str:
    return f"  # {harmless(entry.unit)}" if entry.unit else ""


def _mapping(port: Layout, texts: list[str]) -> str:
    parts = (f"{_quoted(e.name)}: {_numbers(e, texts[port.slice(e.name)])}" for e in port.entries)
    return f"{{{', '.join(parts)}}}"


def _numbers(entry: Entry, texts: list[str]) -> str:
    return texts[0] if entry.shape == () else f"[{', '.join(texts)}]"
