"""The largest value that meets a criterion: a scan of rising values, then a bisection with its bracket."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import inf, sqrt

from workbench.core.validation.refusals import finite, numbers, positive, refusal, whole
from workbench.core.validation.signatures import answer, check_arguments
from workbench.core.validation.type_hints import fit_of

Criterion = Callable[[float], bool]
Between = Callable[[float, float], float | None]
NEXT_TO_ONE = 1 + 1e-12  # of doubles closer than this, a geometric mean may be one of the two
MAX_NAMES = 5  # values that a sentence names


@dataclass(frozen=True)
@check_arguments
class Threshold:
    """The values that a search tried, in rising order, and for each of them whether it met the criterion.

    All tried values up to `largest` meet the criterion, and `next` does not. The threshold, or one of several, lies
    between these two. Nothing is claimed about values that were not tried.

    Examples
    --------
    >>> from workbench.study.evidence import find_largest
    >>> found = find_largest(lambda x: x**2 <= 2, (0.5, 1.0, 2.0), ratio=1.001)
    >>> found.largest**2 <= 2 < found.next**2, found.next / found.largest < 1.001
    (True, True)
    """

    values: tuple[float, ...]
    meets_criterion: tuple[bool, ...]

    def __post_init__(self) -> None:
        if not _rise(self.values) or len(self.values) != len(self.meets_criterion):
            raise refusal(
                "Threshold(values=..., meets_criterion=...)",
                "rising positive values, each with its answer",
                (self.values, self.meets_criterion),
            )

    @property
    def largest(self) -> float:
        """The largest value up to which all meet the criterion; 0 if the smallest value does not meet it."""
        return (0.0, *self.values)[self._count]

    @property
    def next(self) -> float:
        """The smallest value that does not meet the criterion; infinite if all values meet it."""
        return (*self.values, inf)[self._count]

    @property
    def beyond(self) -> tuple[float, ...]:
        """The values above `next` that meet the criterion again; if there are any, the criterion is not monotone."""
        later = zip(self.values[self._count :], self.meets_criterion[self._count :], strict=True)
        return tuple(value for value, good in later if good)

    @property
    def sentence(self) -> str:
        """The bracket, the range of the values that were tried, and the larger values that meet the criterion again."""
        if self.next == inf:
            bracket = f"all values up to {self.largest:.6g} meet the criterion"
        elif self.largest:
            bracket = f"{self.largest:.6g} meets the criterion and {self.next:.6g} does not"
        else:
            bracket = f"the least value, {self.next:.6g}, does not meet the criterion"
        looked = f"{len(self.values)} values were tried, from {self.values[0]:.6g} to {self.values[-1]:.6g}"
        named = ", ".join(f"{value:.6g}" for value in self.beyond[:MAX_NAMES])
        more = f" and {len(self.beyond) - MAX_NAMES} more" * (len(self.beyond) > MAX_NAMES)
        again = f"; the criterion is met again at {named}{more}" if named else ""
        return f"{bracket}; {looked}{again}"

    @property
    def _count(self) -> int:
        """The number of values before the first that does not meet the criterion."""
        return len(self.meets_criterion) if all(self.meets_criterion) else self.meets_criterion.index(False)


@check_arguments
def find_largest(
    criterion: Criterion,
    values: Sequence[float],
    *,
    ratio: float | None = 1.01,
    between: Between | None = None,
    patience: int | None = None,
) -> Threshold:
    """The largest value that meets a criterion: a scan of rising values, then a bisection before the first failure.

    `Threshold.beyond` has the larger values that meet the criterion again. A failure between two values of the scan is
    not seen, so the scan must be as fine as the criterion may vary.

    Parameters
    ----------
    criterion
        A function of a value; it is called once for each value.
    values
        Positive and rising.
    ratio
        The bisection ends when the upper end of the bracket over the lower is at most `ratio`; None for a scan alone.
    between
        A function that returns a value to be tried between two others, or None if there is none, as between adjacent
        whole numbers. If it is not given, the geometric mean is tried.
    patience
        The scan ends after `patience` values in a row that do not meet the criterion; None scans all values.

    Raises
    ------
    ValueError
        If there are no values, or they are not positive, finite and rising; `ratio` is not above 1; the criterion gives
        neither True nor False; or `between` gives a value that is not between the two.
    """
    return search("find_largest(values=...)", criterion, values, ratio, between, patience)


def search(
    where: str,
    criterion: Criterion,
    values: Sequence[float],
    ratio: float | None,
    between: Between | None,
    patience: int | None,
) -> Threshold:
    """The search of `find_largest` for a call whose argument of the values is `where`, in messages."""
    call, scanned = where.partition("(")[0], numbers(where, values, 1).tolist()
    if not _rise(scanned):
        raise refusal(where, "one value or several, positive and rising", tuple(scanned))
    most = len(scanned) if patience is None else whole(f"{call}(patience=...)", patience)
    if ratio is not None:
        _refuse_ratio(call, ratio)
    answers: dict[float, bool] = {}
    failures = 0
    for value in scanned:
        answers[value] = _asked(call, criterion, value)
        failures = 0 if answers[value] else failures + 1
        if failures == most:
            break
    found = _threshold(answers)
    if ratio is None or not 0 < found.largest < found.next < inf:
        return found
    return _threshold(answers | _bisected(call, criterion, found.largest, found.next, ratio, between))


@check_arguments
def bisect(
    criterion: Criterion, low: float, high: float, *, ratio: float = 1.01, between: Between | None = None
) -> Threshold:
    """The bracket of a threshold between a value that meets a criterion and a larger one that does not.

    Parameters
    ----------
    criterion, ratio, between
        As of `find_largest`.
    low, high
        Positive values; both are tried first.

    Raises
    ------
    ValueError
        If `low` does not meet the criterion or `high` does, or they are not positive and rising; and as of
        `find_largest`.

    Examples
    --------
    >>> wb.evidence.bisect(lambda x: x < 100, 1.0, 1000.0, ratio=1.001).sentence[:52]
    '99.9719 meets the criterion and 100.056 does not; 15'
    """
    _refuse_ratio("bisect", ratio)
    if not 0 < positive("bisect(low=...)", low) < finite("bisect(high=...)", high):
        raise refusal("bisect(low=..., high=...)", "positive, the second larger than the first", (low, high))
    answers = {end: _asked("bisect", criterion, end) for end in (low, high)}
    if answers[low] is answers[high] or not answers[low]:
        must = "a value that meets the criterion and a larger one that does not, as one threshold lies between them"
        told = ", ".join(f"{end:g} {'meets it' if good else 'does not'}" for end, good in answers.items())
        raise ValueError(f"`bisect(low=..., high=...)` must be {must}; got: {told}.")
    return _threshold(answers | _bisected("bisect", criterion, low, high, ratio, between))


def _bisected(
    call: str, criterion: Criterion, low: float, high: float, ratio: float, between: Between | None
) -> dict[float, bool]:
    """The answers inside a bracket, halved until it is no wider than `ratio` or nothing lies between its ends."""
    answers: dict[float, bool] = {}
    while high > ratio * low:
        middle = sqrt(low) * sqrt(high) if between is None else _middle(call, between, low, high)
        if middle is None:
            break
        answers[middle] = _asked(call, criterion, middle)
        low, high = (middle, high) if answers[middle] else (low, middle)
    return answers


def _middle(call: str, between: Between, low: float, high: float) -> float | None:
    """The value that `between` gives for the two ends of a bracket."""
    asked, must = f"{call}(between=...)({low:g}, {high:g})", "give a value between the two, or None"
    middle: float | None = answer(asked, must, lambda: between(low, high), fit_of(float | None), refuses=True)
    if middle is not None and not low < middle < high:
        raise ValueError(f"`{asked}` must {must}; it gave {middle!r}.")
    return middle


def _refuse_ratio(call: str, ratio: float) -> None:
    if not finite(f"{call}(ratio=...)", ratio) >= NEXT_TO_ONE:
        raise refusal(f"{call}(ratio=...)", "above 1 by at least 1e-12, as doubles are no closer", ratio)


def _rise(values: Sequence[float]) -> bool:
    """True for one positive number or several that rise."""
    return bool(values) and values[0] > 0 and values[-1] < inf and all(a < b for a, b in pairwise(values))


def _asked(call: str, criterion: Criterion, value: float) -> bool:
    must = "say by True or False if the value meets it"
    return bool(answer(f"{call}(criterion=...)({value:g})", must, lambda: criterion(value), fit_of(bool), refuses=True))


def _threshold(answers: dict[float, bool]) -> Threshold:
    values = tuple(sorted(answers))
    return Threshold(values, tuple(answers[value] for value in values))
