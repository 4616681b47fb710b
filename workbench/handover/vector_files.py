"""The files of test vectors: what a law got and sent in its loop, for whoever tests it on another machine."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from string import Template
from typing import Any

import numpy as np

from workbench.core import Layout, SampledLaw
from workbench.core.validation.refusals import Array, known
from workbench.core.validation.signatures import door
from workbench.handover.c99.c_names import member, places_of, prefix_of

Rows = tuple[Any, Any, Any]  # readings, references and commands, a row an instant, as floats or doubles

HEADER = Template("""\
/* Test vectors of $law, written by control-workbench: what it got and sent in its loop, every $period s. */
#ifndef ${upper}_VECTORS_H
#define ${upper}_VECTORS_H

enum { ${upper}_PERIODS = $periods };

$arrays
#endif
""")

CHECK = Template("""\
/* Hands the test vectors to ${name}_step and compares its commands bit by bit. Written by control-workbench.
   Build it with the law: cc -std=c99 ${name}_check.c ${name}.c */
#include "${name}.h"
#include "${name}_vectors.h"
#include <stdio.h>
#include <string.h>

int main(void)
{
    static ${name}_state state;
    int k, wrong = 0;
    ${name}_init(&state);
    for (k = 0; k < ${upper}_PERIODS; ++k) {
$declared        ${name}_commands commands;
        $real sent[$commands];
        unsigned flags;
$filled        flags = ${name}_step(&state, $given&commands);
$read        if ((flags != 0u) || (memcmp(sent, ${name}_vectors_u[k], sizeof sent) != 0)) {
            if (wrong == 0) {
                printf("the first difference is in period %d, with the flags %u\\n", k, flags);
            }
            ++wrong;
        }
    }
    printf("%d of %d periods differ\\n", wrong, (int)${upper}_PERIODS);
    return wrong != 0;
}
""")


@door
def vector_files(law: SampledLaw, rows: Rows, form: str, name: str | None) -> Mapping[str, str]:
    """The files of a form, see `Recording.write`."""
    writer = FORMS[known(form, FORMS, "forms of test vectors")]
    return writer(law, rows, prefix_of(member(law.name) if name is None else name))


def signals_of(law: SampledLaw) -> Layout:
    """The readings, references and commands of a law below 'y.', 'r.' and 'u.'."""
    return law.readings.prefixed("y.") + law.references.prefixed("r.") + law.commands.prefixed("u.")


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
    arrays = {letter: part for letter, part in zip("yru", rows, strict=True) if part.shape[1]}
    words = {"name": name, "upper": name.upper(), "law": law.name, "period": repr(law.period), "real": real}
    header = HEADER.substitute(
        words,
        periods=len(rows[2]),
        arrays="\n".join(_array(f"{name}_vectors_{letter}", real, part) for letter, part in arrays.items()),
    )
    check = CHECK.substitute(
        words,
        commands=law.commands.size,
        declared="".join(f"        {name}_{port} {port};\n" for port in ports),
        filled="".join(
            f"        {port}.{place} = {name}_vectors_{letter}[k][{i}];\n"
            for port, (layout, letter) in ports.items()
            for i, place in enumerate(places_of(layout))
        ),
        given="".join(f"&{port}, " for port in ports),
        read="".join(f"        sent[{i}] = commands.{place};\n" for i, place in enumerate(places_of(law.commands))),
    )
    return {f"{name}_vectors.h": header, f"{name}_check.c": check}


def _array(name: str, real: str, rows: Array) -> str:
    """The rows as an array of C, in hexadecimal, which is the number itself."""
    end = "f" if real == "float" else ""
    lines = [f"    {{{', '.join(f'{float(number).hex()}{end}' for number in row)}}}," for row in rows]
    return "\n".join([f"static const {real} {name}[{len(rows)}][{rows.shape[1]}] = {{", *lines, "};", ""])


FORMS: Mapping[str, Callable[[SampledLaw, Rows, str], Mapping[str, str]]] = {"csv": _csv, "c": _c}
