"""Names in C: the members of structs and the variables of a law, each for one thing."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import NamedTuple

from workbench.core import Layout
from workbench.core.validation.refusals import describe
from workbench.core.validation.signatures import check_arguments

WORDS = """
auto break case char const continue default do double else enum extern float for goto if inline int long register
restrict return short signed sizeof static struct switch typedef union unsigned void volatile while _Bool _Complex
_Imaginary asm bool class delete false friend namespace new operator private protected public template this throw
true try typename using virtual explicit export mutable catch and or not xor main step errno
bitand bitor compl and_eq or_eq xor_eq not_eq nullptr constexpr typeid alignas alignof wchar_t
char16_t char32_t decltype noexcept static_assert thread_local dynamic_cast static_cast const_cast reinterpret_cast
linux unix i386 NAN INFINITY EOF
NULL I
"""
HEADERS = frozenset(
    [
        "stdint",
        "stdbool",
        "float",
        "math",
        "string",
        "stdlib",
        "stdio",
        "assert",
        "errno",
        "limits",
        "time",
        "signal",
        "locale",
    ]
)
MACRO = re.compile(r"(FLT|DBL|LDBL|DECIMAL|U?INT)\w*_\w+|M_\w+")
KEYWORDS = frozenset(WORDS.split())
# Names that the code itself uses.
OWN = frozenset(("state", "readings", "references", "commands", "flags", "loop_room", "parameters", "k", "t", "done"))
LONGEST = 40  # letters, so that a function's name is within the 63 that C99 tells apart
TRIGRAPH = re.compile(r"\?(?=\?)")
IDENTIFIER = re.compile(r"[A-Za-z][A-Za-z0-9_]*")


@check_arguments
def prefix_of(name: str) -> str:
    """A name as the prefix of all that is visible in C; a ValueError if it cannot be one."""
    if not isinstance(name, str) or not IDENTIFIER.fullmatch(name) or len(name) > LONGEST or name in KEYWORDS | HEADERS:
        raise ValueError(
            f"`name` must be an identifier of C of at most {LONGEST} letters, digits and '_' that begins with a letter "
            f"and is no word of the language and no header of its library, as 'motor_law' is; got {describe(name)}."
        )
    return name


def member(name: str) -> str:
    """The member of a struct for a quantity: 'plant.arm.links[0].mass' is plant_arm_links_0_mass."""
    text = re.sub(r"_+", "_", re.sub(r"[^A-Za-z0-9_]", "_", name)).strip("_") or "x"
    return f"x_{text}" if text[0].isdigit() or text in KEYWORDS or MACRO.fullmatch(text) else text


@check_arguments
def members(layout: Layout) -> dict[str, str]:
    """The member of each quantity of a layout; a ValueError if two would be one."""
    names = {name: member(name) for name in layout.names}
    taken: dict[str, str] = {}
    for name, own in names.items():
        if own in taken:
            raise ValueError(
                f"Two quantities would be one member of a struct in C: '{taken[own]}' and '{name}' both become "
                f"'{own}'. Rename one of them."
            )
        taken[own] = name
    return names


class Variables:
    """Variables of a function, which are told apart by an ending."""

    def __init__(self, reserved_names: Iterable[str] = ()) -> None:
        self.taken = {*KEYWORDS, *OWN, *reserved_names}

    def new(self, name: str) -> str:
        """The name, or one like it that is not taken."""
        variable = member(name)
        if re.fullmatch(r"(w|turn|c|array|carried|copy|made|pass|row)_\d+", variable):
            variable = f"x_{variable}"
        while variable in self.taken:
            variable += "_"
        self.taken.add(variable)
        return variable

    def entries(self, name: str, shape: tuple[int, ...]) -> list[str]:
        """A variable for each number of a quantity, column by column: `K_12`, or `K_1_12` beyond nine."""
        if not shape:
            return [self.new(name)]
        between = "_" if max(shape) > 9 else ""
        order = indices(shape)
        return [self.new(f"{name}_{between.join(str(i + 1) for i in index)}") for index in order]


def indices(shape: tuple[int, ...]) -> list[tuple[int, ...]]:
    """The indices of a quantity in their order in a vector: column by column."""
    if len(shape) == 1:
        return [(i,) for i in range(shape[0])]
    return [(i, j) for j in range(shape[1]) for i in range(shape[0])]


def comment(text: str) -> str:
    r"""A text that ends no comment and begins none, nor joins lines: `??/` is a backslash in C, as all trigraphs are.

    What is not printable, as a mark that turns the direction of writing, stands as its code.
    """
    lines = [line.expandtabs(4).rstrip("\\ \r") for line in TRIGRAPH.sub("? ", text).split("\n")]
    plain = "\n".join("".join(c if c.isprintable() else f"<U+{ord(c):04X}>" for c in line) for line in lines)
    return plain.replace("*/", "* /").replace("/*", "/ *")


def letter_of(name: str, symbols: Mapping[str, str]) -> str:
    """The book's letter of a quantity: what its layout calls it, else the last part of its name."""
    return symbols.get(name) or name.rpartition(".")[2]


class Member(NamedTuple):
    """A number of a layout in C: its variable, where its value comes from, and its label."""

    variable: str
    source: str
    label: str


def entries_of(variables: Variables, layout: Layout, struct: str, form: str = "{}") -> list[Member]:
    """A variable for each number of a layout, whose value is a member of a struct."""
    names, found = members(layout), list[Member]()
    symbols = {entry.name: entry.symbol for entry in layout.entries}
    for entry in layout.entries:
        own = variables.entries(form.format(letter_of(entry.name, symbols)), entry.shape)
        for i, (variable, label) in enumerate(zip(own, entry.labels(), strict=True)):
            found.append(Member(variable, f"{struct}{names[entry.name]}{f'[{i}]' if entry.shape else ''}", label))
    return found


def places_of(layout: Layout) -> list[str]:
    """The members of a struct for the numbers of a layout, in their order."""
    names = members(layout)
    return [
        f"{names[entry.name]}{f'[{i}]' if entry.shape else ''}" for entry in layout.entries for i in range(entry.size)
    ]
