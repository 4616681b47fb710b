"""A package of ROS 2 around the C of a law: a plug-in of ros2_control, which a controller manager loads."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from typing import TYPE_CHECKING

from workbench.core.layout import Entry, Layout
from workbench.core.notation.comments import harmless
from workbench.core.templates import fill
from workbench.core.validation.refusals import describe, known_name, require
from workbench.core.validation.signatures import check_arguments
from workbench.handover.c99.c_files import CCode
from workbench.handover.c99.c_names import members
from workbench.handover.export_seal import MARK

if TYPE_CHECKING:
    from markupsafe import Markup

LIBRARIES = ("controller_interface", "pluginlib", "rclcpp", "rclcpp_lifecycle")
OF_REFERENCES = ("realtime_tools", "std_msgs")
PACKAGE = re.compile(r"[a-z](_?[a-z0-9])*")
INTERFACE = re.compile(r"[A-Za-z][A-Za-z0-9_]*(/[A-Za-z][A-Za-z0-9_]*)+")


@check_arguments
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
    words = _words(code, name, named)
    in_xml = words | {"title": _in_xml(harmless(code.law.name))}
    return {
        f"include/{name}/{code.name}_controller.hpp": _text("controller.hpp.j2", words),
        f"src/{code.name}_controller.cpp": _text("controller.cpp.j2", words),
        **{f"src/{file}": text for file, text in code.files.items()},
        "package.xml": _text("package.xml.j2", in_xml),
        "CMakeLists.txt": _text("CMakeLists.txt.j2", words),
        f"{code.name}_controller.xml": _text("plugin.xml.j2", in_xml),
        "README.md": _text("README.md.j2", words | {"interfaces": list(_interface_rows(code, named))}),
    }


def _text(template: str, words: Mapping[str, object]) -> str:
    return fill("workbench.handover", f"ros2/{template}", **words)


def _in_xml(text: str) -> Markup:
    """The text escaped, which a template does not escape again."""
    from markupsafe import Markup

    return Markup(escape(text))


def _package(name: str) -> str:
    if not isinstance(name, str) or not PACKAGE.fullmatch(name):
        raise ValueError(
            "`ros2(package=...)` must be small letters, digits and single '_', with a letter first and no '_' last, as "
            f"'arm_controller' is; got {describe(name)}."
        )
    return name


def _libraries(code: CCode) -> tuple[str, ...]:
    return LIBRARIES + (OF_REFERENCES if code.law.references.size else ())


def _interfaces(code: CCode, asked: Mapping[str, str | Sequence[str]]) -> dict[str, list[str]]:
    """The interfaces of each reading and command, one a number."""
    law = code.law
    for name in asked:
        known_name(name, [*law.readings.names, *law.commands.names], "readings and commands of the law")
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
                f"{'s' if entry.size != 1 else ''}, each as 'axis1/position' is; got {describe(words)}."
            )
        named[entry.name] = names
    for port in (law.readings, law.commands):
        flat = [name for entry in port.entries for name in named[entry.name]]
        if twice := sorted({name for name in flat if flat.count(name) > 1}):
            raise ValueError(f"`ros2(interfaces=...)` must name each interface once; '{twice[0]}' came more often.")
    return named


def _words(code: CCode, package: str, named: Mapping[str, Sequence[str]]) -> dict[str, object]:
    """The words that the templates fill in."""
    law = code.law
    parameters = law.parameters if code.settable else Layout()
    return {
        "name": code.name,
        "upper": code.name.upper(),
        "package": package,
        "mark": MARK,
        "title": harmless(law.name),
        "real": code.real,
        "readings": law.readings.size,
        "commands": law.commands.size,
        "references": [harmless(f"{x}{_unit(e)}") for e in law.references.entries for x in e.labels()],
        "parameters": [(own, parameters[name].size) for name, own in members(parameters).items()],
        "libraries": _libraries(code),
        "state_interfaces": _names(law.readings, named),
        "command_interfaces": _names(law.commands, named),
        "safe": [f"{float(x)!r}{'f' * (code.real == 'float')}" for x in code.safe],
        "period": repr(law.period),
        "rate": f"{1 / law.period:.9g}",
    }


def _names(port: Layout, named: Mapping[str, Sequence[str]]) -> list[str]:
    return [name for entry in port.entries for name in named[entry.name]]


def _interface_rows(code: CCode, named: Mapping[str, Sequence[str]]) -> Iterable[tuple[str, str]]:
    """Each interface with its signal."""
    for word, port in (("reading", code.law.readings), ("command", code.law.commands)):
        for entry in port.entries:
            for label, name in zip(entry.labels(), named[entry.name], strict=True):
                yield name, f"{word} {harmless(label)}{_unit(entry)}"


def _unit(entry: Entry) -> str:
    return f" [{harmless(entry.unit)}]" if entry.unit else ""
