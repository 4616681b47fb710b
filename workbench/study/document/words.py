"""Words for the sentences of a report: names in a row, shares in percent, and the ends of a range."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from workbench.core.validation.refusals import whole
from workbench.core.validation.signatures import answer, check_arguments
from workbench.core.validation.type_hints import fit_of

MOST_DECIMALS = 300  # of a percentage
FEW = 0.1  # a share below which a percentage has two digits, and from which on it is a whole number


@check_arguments
def join_names(names: Iterable[str], empty: str = "none") -> str:
    """Names in a row, with commas, and with "and" before the last; `empty` if there is no name.

    Examples
    --------
    >>> wb.document.join_names(["PID", "SMC", "RISE"])
    'PID, SMC and RISE'
    """
    *others, last = list(names) or [empty]
    return f"{', '.join(others)} and {last}" if others else last


@check_arguments
def percent(share: float, decimals: int | None = None) -> str:
    """A share in percent: with `decimals` decimals, by default with two digits below 10 % and whole from there on.

    Examples
    --------
    >>> wb.document.percent(0.0125), wb.document.percent(0.4567), wb.document.percent(0.4567, decimals=1)
    ('1.2 %', '46 %', '45.7 %')
    """
    if decimals is None and share < FEW:
        return f"{100 * share:.2g} %"
    digits = 0 if decimals is None else whole("percent(decimals=...)", decimals, least=0, most=MOST_DECIMALS)
    return f"{100 * share:.{digits}f} %"


@check_arguments
def span(values: Iterable[float], write: Callable[[float], str]) -> str:
    """The least and the largest value as text, or one number if both read alike; '' if there are no values.

    `write` turns a number into text, as `"{:.2g}".format` does.

    Raises
    ------
    ValueError
        If `write` raises, or gives something else than text.

    Examples
    --------
    >>> wb.document.span([0.5, 2.0, 1.0], lambda value: f"{value:.2g}")
    '0.5 to 2'
    """
    numbers = list(values)
    ends = [_written(write, end) for end in (min(numbers), max(numbers))] if numbers else [""]
    return ends[0] if ends[0] == ends[-1] else " to ".join(ends)


def _written(write: Callable[[float], str], value: float) -> str:
    """A number as a function of the user's own writes it."""
    return answer(f"span(write=...)({value:g})", "return the number as text", lambda: write(value), fit_of(str))
