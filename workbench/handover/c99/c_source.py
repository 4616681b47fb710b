"""The source of a law in C: a pipeline from a request to graph, variables, lines and text."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import NamedTuple

from workbench.core.templates import template_text
from workbench.engine.machines.c_elementary_functions import definitions
from workbench.engine.machines.c_real import DOUBLE, SINGLE
from workbench.handover.c99.c_advance import advance_of
from workbench.handover.c99.c_assignments import CCall
from workbench.handover.c99.c_costs import CallCost, costs_of
from workbench.handover.c99.c_header import about, block
from workbench.handover.c99.c_interface import init_of, reset_of, step_of
from workbench.handover.c99.c_parameters import refuse_numbers_beyond_single
from workbench.handover.c99.c_request import Request
from workbench.handover.c99.c_variables import variables_of
from workbench.handover.law_graph import graph_of_law


class CSource(NamedTuple):
    """The text of NAME.c, and what a call of its step costs."""

    text: str
    costs: CallCost


def source_of(request: Request) -> CSource:
    """The source of a law, from the graph that every machine evaluates; equal numbers of parameters stay two.

    Raises
    ------
    ValueError
        If a number of the law has no finite value in single precision.
    """
    if request.precision == "single" and not request.settable:
        refuse_numbers_beyond_single(request.law)
    graph = graph_of_law(request.law, settable=True, fused_products=request.fused_products)
    advance = advance_of(request, graph, variables_of(request, graph))
    parts = [*_called(request, advance.calls), "\n".join(advance.lines)]
    parts += ["\n".join(lines) for lines in (step_of(request), reset_of(request), init_of(request))]
    functions = "\n\n".join(parts) + "\n"
    costs = costs_of(graph, functions, request.name, advance.room)
    return CSource(_around(request, costs, functions), costs)


@cache
def guards() -> str:
    """The lines by which a source refuses a compiler that would change its arithmetic."""
    return template_text("workbench.handover", "c99/guards.h").rstrip("\n")


def _called(request: Request, calls: Sequence[CCall]) -> list[str]:
    """The definitions of what is called, of each format."""
    return [
        text
        for real in (DOUBLE, SINGLE)
        for text in definitions(
            request.name, real, [call.name for call in calls if call.real is real], request.hardware
        )
    ]


def _around(request: Request, costs: CallCost, functions: str) -> str:
    """The text of NAME.c around its functions."""
    library = ["#include <math.h>"] if request.hardware else []
    head = [*block(about(request, costs)), f'#include "{request.name}.h"', "", *library, guards(), ""]
    return "\n".join([*head, functions])
