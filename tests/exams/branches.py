"""Branches: a function that asks `if` of a symbol, called once for every way through it, the ways joined again."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from typing import Any

import casadi as ca

MOST, DEEPEST = 256, 64  # ways through a function, and questions on one of them: a loop may ask without end

Asked = list[tuple[ca.SX, bool]]  # what was asked on a way, and what was answered


def branched(f: Callable[[], ca.SX]) -> ca.SX:
    """The value of f on each way through its conditions, as one expression.

    Raises
    ------
    ValueError
        If there are too many ways, or one that asks too much.
    """
    ways: list[tuple[Asked, ca.SX]] = []
    answers: list[bool] = []
    while True:
        with _answering(answers) as asked:
            ways.append((asked, f()))
        if len(ways) > MOST:
            raise ValueError(f"it has more than {MOST} ways through its conditions")
        answers = [answer for _, answer in asked]
        while answers and not answers[-1]:
            answers.pop()
        if not answers:
            return _joined(ways, 0)
        answers[-1] = False


@contextlib.contextmanager
def _answering(answers: list[bool]) -> Iterator[Asked]:
    """While this lasts, a condition with a symbol is answered as planned, and beyond the plan with yes."""
    asked: Asked = []
    plain = ca.SX.__bool__

    def answer(condition: Any) -> bool:
        if condition.is_constant():
            return bool(plain(condition))
        if len(asked) >= DEEPEST:
            raise ValueError(f"it asks more than {DEEPEST} questions on one way")
        asked.append((_with_surface(condition), answers[len(asked)] if len(asked) < len(answers) else True))
        return asked[-1][1]

    ca.SX.__bool__ = answer
    try:
        yield asked
    finally:
        ca.SX.__bool__ = plain


def _with_surface(condition: ca.SX) -> ca.SX:
    """The same condition without ==, != and a bare number, which have no surface for the reference mode to find."""
    if condition.is_op(ca.OP_EQ):
        return ca.fabs(condition.dep(0) - condition.dep(1)) <= 0
    if condition.is_op(ca.OP_NE):
        return ca.fabs(condition.dep(0) - condition.dep(1)) > 0
    known = (ca.OP_LT, ca.OP_LE, ca.OP_NOT, ca.OP_AND, ca.OP_OR)
    return condition if any(condition.is_op(code) for code in known) else ca.fabs(condition) > 0


def _joined(ways: list[tuple[Asked, ca.SX]], depth: int) -> ca.SX:
    asked, value = ways[0]
    if len(asked) == depth:
        return value
    yes, no = ([way for way in ways if way[0][depth][1] is answer] for answer in (True, False))
    return ca.if_else(asked[depth][0], _joined(yes, depth + 1), _joined(no, depth + 1))
