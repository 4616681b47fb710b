"""A package of ROS 2 around the C of a law: a plug-in of ros2_control, which a controller manager loads."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from html import escape

from workbench.core.layout import Entry, Layout
from workbench.core.notation.comments import harmless
from workbench.core.validation.refusals import described, known, require
from workbench.core.validation.signatures import door
from workbench.handover.c99.c_code import CCode
from workbench.handover.c99.c_names import members
from workbench.handover.export_seal import MARK
from workbench.handover.wrappers import ros2_package_texts as package_texts
from workbench.handover.wrappers import ros2_texts as texts

LIBRARIES = ("controller_interface", "pluginlib", "rclcpp", "rclcpp_lifecycle")
OF_REFERENCES = ("realtime_tools", "std_msgs")
PACKAGE = re.compile(r"[a-z](_?[a-z0-9])*")
INTERFACE = re.compile(r"[A-Za-z][A-Za-z0-9_]*(/[A-Za-z][A-Za-z0-9_]*)+")


@door
def ros2(
    code: CCode, package: str | None = None, interfaces: Mapping[str, str | Sequence[str]] | None = None
) -> dict[str, str]:
    """The files of a package of ROS 2, by their paths, with a controller of ros2_control that runs the law.

    Readings are state interfaces, and commands are command interfaces of the hardware. References, if any, come as a
    `std_msgs/Float64MultiArray` on ~/references, in the order of the header; before the first one the controller
    commands what is safe.

    Parameters
    ----------
    package
        The name of the package; that of the law in small letters, with '_controller', unless given.
    interfaces
        The interface of each number of a reading or command, as {"q": ("axis1/position", "axis2/position")}; those
        that are not named are NAME/signal_0, NAME/signal_1, ...

    Raises
    ------
    ValueError
        If the name of a package or an interface cannot be one, or a signal has another number of interfaces.
    LookupError
        If `interfaces` names neither a reading nor a command.
    """
    code = require("ros2(code=...)", code, CCode)
    name = _package(re.sub(r"_+", "_", f"{code.name.lower()}_controller") if package is None else package)
    named = _interfaces(code, interfaces or {})
    held = _held(code, name, named)
    return {
        f"include/{name}/{code.name}_controller.hpp": texts.HEADER.substitute(held),
        f"src/{code.name}_controller.cpp": texts.SOURCE.substitute(held),
        **{f"src/{file}": text for file, text in code.files.items()},
        "package.xml": package_texts.PACKAGE.substitute(
            held, title=escape(held["title"]), depends="\n".join(f"  <depend>{x}</depend>" for x in _libraries(code))
        ),
        "CMakeLists.txt": package_texts.BUILD.substitute(
            held,
            finds="\n".join(f"find_package({x} REQUIRED)" for x in _libraries(code)),
            depends=" ".join(_libraries(code)),
        ),
        f"{code.name}_controller.xml": package_texts.PLUGIN.substitute(held, title=escape(held["title"])),
        "README.md": package_texts.README.substitute(held, rows="\n".join(_rows(code, named)), references=_heard(code)),
    }


def _package(name: str) -> str:
    if not isinstance(name, str) or not PACKAGE.fullmatch(name):
        raise ValueError(
            "`ros2(package=...)` must be small letters, digits and single '_', with a letter first and no '_' last, as "
            f"'arm_controller' is; got {described(name)}."
        )
    return name


def _libraries(code: CCode) -> tuple[str, ...]:
    return LIBRARIES + (OF_REFERENCES if code.law.references.size else ())


def _interfaces(code: CCode, asked: Mapping[str, str | Sequence[str]]) -> dict[str, list[str]]:
    """The interfaces of each reading and command, one a number."""
    law = code.law
    for name in asked:
        known(name, [*law.readings.names, *law.commands.names], "readings and commands of the law")
    named: dict[str, list[str]] = {}
    for entry in (*law.readings.entries, *law.commands.entries):
        words = asked.get(entry.name)
        own = members(Layout((entry,)))[entry.name]
        if words is None:
            names = [f"{code.name}/{own}_{i}" for i in range(entry.size)]
        else:
            names = [words] if isinstance(words, str) else list(words)
        if len(names) != entry.size or not all(isinstance(n, str) and INTERFACE.fullmatch(n) for n in names):
            raise ValueError(
                f"`ros2(interfaces={{'{entry.name}': ...}})` must be {entry.size} interface"
                f"{'s' if entry.size != 1 else ''}, each as 'axis1/position' is; got {described(words)}."
            )
        named[entry.name] = names
    for port in (law.readings, law.commands):
        flat = [name for entry in port.entries for name in named[entry.name]]
        if twice := sorted({name for name in flat if flat.count(name) > 1}):
            raise ValueError(f"`ros2(interfaces=...)` must name each interface once; '{twice[0]}' came more often.")
    return named


def _held(code: CCode, package: str, named: Mapping[str, Sequence[str]]) -> dict[str, str]:
    """The parts of the texts."""
    law, parameters = code.law, code.settable and bool(code.law.parameters.size)
    held = {
        "name": code.name,
        "upper": code.name.upper(),
        "package": package,
        "mark": MARK,
        "title": harmless(law.name),
        "real": code.real,
        "readings": str(law.readings.size),
        "commands": str(law.commands.size),
        "references": str(law.references.size),
        "state_names": _strings(law.readings, named),
        "command_names": _strings(law.commands, named),
        "safe": ", ".join(f"{float(x)!r}{'f' * (code.real == 'float')}" for x in code.safe),
        "period": repr(law.period),
        "rate": f"{1 / law.period:.9g}",
    }
    held |= dict.fromkeys(("reference_includes", "reference_members", "reference_assertion", "subscription"), "")
    held |= dict.fromkeys(("unheard", "forget", "reference", "settings", "declarations"), "")
    if law.references.size:
        held |= {
            "reference_includes": texts.REFERENCE_INCLUDES,
            "reference_members": texts.REFERENCE_MEMBERS.substitute(held),
            "reference_assertion": texts.REFERENCE_ASSERTION.substitute(held),
            "subscription": texts.SUBSCRIPTION.substitute(held),
            "unheard": texts.UNHEARD,
            "forget": "  wanted_.writeFromNonRT(Wanted());\n",
            "reference": "&wanted->values, ",
        }
    if parameters:
        rows = "\n".join(_parameters(code))
        held["reference_assertion"] += texts.PARAMETERS.substitute(rows=rows)
        held |= {"settings": texts.SETTINGS.substitute(), "declarations": texts.DECLARATIONS}
    return held


def _strings(port: Layout, named: Mapping[str, Sequence[str]]) -> str:
    return "\n".join(f'  "{name}",' for entry in port.entries for name in named[entry.name])


def _parameters(code: CCode) -> Iterable[str]:
    layout = code.law.parameters
    for name, own in members(layout).items():
        yield f'  {{"{own}", {layout[name].size}, offsetof({code.name}_parameters, {own})}},'


def _rows(code: CCode, named: Mapping[str, Sequence[str]]) -> Iterable[str]:
    for word, port in (("reading", code.law.readings), ("command", code.law.commands)):
        for entry in port.entries:
            for label, name in zip(entry.labels(), named[entry.name], strict=True):
                yield f"| `{name}` | {word} {harmless(label)}{_unit(entry)} |"


def _unit(entry: Entry) -> str:
    return f" [{harmless(entry.unit)}]" if entry.unit else ""


def _heard(code: CCode) -> str:
    labels = [harmless(f"{label}{_unit(entry)}") for entry in code.law.references.entries for label in entry.labels()]
    if not labels:
        return "What is wanted is built into the law.\n"
    return (
        f"What is wanted comes on `~/references` as a `std_msgs/msg/Float64MultiArray` of {len(labels)} numbers: "
        f"{', '.join(labels)}. Before the first message the safe command acts.\n"
    )
