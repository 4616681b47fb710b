"""The files of test vectors: what a law got and sent in its loop, for whoever tests it on another machine."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from workbench.core import Layout, SampledLaw
from workbench.core.templates import fill
from workbench.core.validation.refusals import known_name
from workbench.core.validation.signatures import check_arguments
from workbench.handover.c99.c_names import member, places_of, prefix_of
from workbench.handover.memory_digest import Reals

if TYPE_CHECKING:
    Rows: TypeAlias = tuple[Reals, Reals, Reals]  # readings, references and commands, a row an instant
else:
    Rows = tuple[object, object, object]  # which a door leaves as they are: it would make doubles of floats


@check_arguments
def vector_files(law: SampledLaw, rows: Rows, form: str, name: str | None) -> Mapping[str, str]:
    """The files of a form, see `Recording.write`."""
    writer = FORMS[known_name(form, FORMS, "forms of test vectors")]
    return writer(law, rows, prefix_of(member(law.name) if name is None else name))


def signals_of(law: SampledLaw) -> Layout:
    """The readings, references and commands of a law below 'y.', 'r.' and 'u.'."""
    return law.readings.with_prefix("y.") + law.references.with_prefix("r.") + law.commands.with_prefix("u.")


def _csv(law: SampledLaw, rows: Rows, name: str) -> Mapping[str, str]:
    heads = ["k", *(f'"{label}"' if "," in label else label for label in signals_of(law).labels)]
    lines = [f"# {law.name}: what it got and sent in its loop, every {law.period!r} s, by control-workbench"]
    lines += [
        ",".join(heads),
        *(",".join([str(k), *map(_decimal, row)]) for k, row in enumerate(np.concatenate(rows, axis=1))),
    ]
    return {f"{name}_vectors.csv": "\n".join([*lines, ""])}


def _decimal(number: np.floating) -> str:
    """The shortest decimal that is this number to its last bit."""
    return repr(number.item()) if number.dtype == np.float64 else str(number)


def _c(law: SampledLaw, rows: Rows, name: str) -> Mapping[str, str]:
    real = "float" if rows[2].dtype == np.float32 else "double"
    ports = {"readings": (law.readings, "y"), "references": (law.references, "r")}
    ports = {port: pair for port, pair in ports.items() if pair[0].size}
    end = "f" if real == "float" else ""  # hexadecimal, which is the number itself
    arrays = [
        {"letter": letter, "rows": [[f"{float(number).hex()}{end}" for number in row] for row in part]}
        for letter, part in zip("yru", rows, strict=True)
        if part.shape[1]
    ]
    copies = [
        (port, place, f"{letter}[k][{i}]")
        for port, (layout, letter) in ports.items()
        for i, place in enumerate(places_of(layout))
    ]
    words = {"name": name, "upper": name.upper(), "real": real}
    head = {"law": law.name, "period": repr(law.period), "periods": len(rows[2]), "arrays": arrays}
    calls = {"ports": list(ports), "copies": copies, "commands": list(places_of(law.commands))}
    return {
        f"{name}_vectors.h": fill("workbench.handover", "vectors/vectors.h.j2", **words, **head),
        f"{name}_check.c": fill("workbench.handover", "vectors/check.c.j2", **words, **calls),
    }


FORMS: Mapping[str, Callable[[SampledLaw, Rows, str], Mapping[str, str]]] = {"csv": _csv, "c": _c}
