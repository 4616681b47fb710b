"""The order of two values with their errors."""

from __future__ import annotations

from workbench.core.validation.signatures import check_arguments


@check_arguments
def order(a: tuple[float, float], b: tuple[float, float], margin: float = 0.0) -> str:
    """The side of value b on which value a lies, "below" or "above", or "undecided".

    It is undecided where the gap is within the sum of both errors, or within `margin` of the smaller value.

    Examples
    --------
    >>> wb.evidence.order((1.0, 0.1), (2.0, 0.1)), wb.evidence.order((1.0, 0.6), (2.0, 0.6))
    ('below', 'undecided')
    """
    gap, error = b[0] - a[0], a[1] + b[1]
    if not abs(gap) > max(error, margin * min(abs(a[0]), abs(b[0]))):
        return "undecided"
    return "below" if gap > 0 else "above"
