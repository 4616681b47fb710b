"""The vocabulary of refusals: each function returns a clean value, or raises one sentence that says what does not fit.

`call` names the argument as its user wrote it, as in "Run(h=...)"; `of` says what is counted: " of seconds". A value is
refused by a `ValueError`, an unknown name by a `LookupError`.
"""

from __future__ import annotations

import difflib
import inspect
import os
import reprlib
from collections.abc import Iterable
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Integers = NDArray[np.signedinteger]
T = TypeVar("T")

LONGEST = 60  # how much of a value a message shows
LONGEST_NAME = 200
LONGEST_PATH, LONGEST_PART = 4096, 255  # bytes of a path, and of each name in it, on all usual disks
MOST = 2**53  # beyond it whole numbers are no longer exact as doubles
WORDS = {int: "a whole number", float: "a number", bool: "True or False", str: "text", type(None): "None"}


def refusal(call: str, must: str, value: object, advice: str = "") -> ValueError:
    """The error that says what an argument must be, and what value came."""
    return ValueError(f"`{call}` must be {must}; got {describe(value)}{advice}.")


def require(call: str, value: object, kind: type[T], advice: str = "") -> T:
    """An instance of `kind`."""
    if not isinstance(value, kind):
        raise refusal(call, WORDS.get(kind) or with_article(kind), value, advice or advice_for(kind, value))
    return value


def advice_for(kind: type, value: object) -> str:
    """The advice that the table `WAYS` of a class has for a value of another class; empty if it has none."""
    known = getattr(kind, "WAYS", {}).get(type(value).__name__, "")
    return known and f": {known}"


def error_text(error: BaseException) -> str:
    """The class and the message of an error of the user's own function, on one short line."""
    try:
        message = "".join(c if c.isprintable() else " " for c in " ".join(str(error).split()))
    except Exception:  # an error may raise another one when it is asked for its text
        message = ""
    return f"{type(error).__name__}{message and f': {message[: 4 * LONGEST]}'}"


def several(call: str, value: object, kind: type[T], least: int = 0) -> tuple[T, ...]:
    """A tuple or list of one kind, at least so many, as a tuple; one alone is refused."""
    if not isinstance(value, list | tuple):
        alone = ": one alone is written `(...,)`, with its comma" if isinstance(value, kind) else ""
        raise refusal(call, f"a tuple of {name_of(kind)}", value, alone)
    for i, item in enumerate(value):
        if not isinstance(item, kind):
            raise refusal(call, f"a tuple of {name_of(kind)}", item, f" at [{i}]")
    if len(value) < least:
        raise ValueError(f"`{call}` must be a tuple of at least {least} {name_of(kind)}; got {len(value) or 'none'}.")
    return tuple(value)


def text(call: str, value: object) -> str:
    """Text that can be written to a file and is not blank."""
    clean = as_text(value)
    if clean is None or not clean.strip():
        raise refusal(call, "text that says something, in characters that can be written", value)
    return clean


def name(call: str, value: object) -> str:
    """Text that messages and tables can print in one line."""
    clean = as_text(value)
    if not clean or not clean.isprintable() or len(clean) > LONGEST_NAME:
        raise refusal(call, f"a name, at most {LONGEST_NAME} characters that can be printed in a line", value)
    return clean


def one_of(call: str, value: object, choices: Iterable[str]) -> str:
    """One of a few words."""
    known = list(choices)
    if not isinstance(value, str) or value not in known:
        all_of_them = ", ".join(map(repr, known))
        raise ValueError(f"`{call}` is one of {all_of_them}; got {describe(value)}.{nearest(value, known)}")
    return str(value)


def known_name(name: object, names: Iterable[str], of: str) -> str:
    """One of the known names, whose kind is `of` ("parameters of this loop"); else a `LookupError`."""
    held = list(names)
    if isinstance(name, str) and name in held:
        return str(name)
    if not isinstance(name, str):
        raise LookupError(f"The {of} go by names, which are text; got {describe(name)}.")
    shown = (one if isinstance(one, str) else describe(one) for one in held[:12])
    near = nearest(name, held) or f" They are: {', '.join(shown) or 'none'}{', ...' if len(held) > 12 else ''}."
    raise LookupError(f"There is no {describe(name)} among the {len(held)} {of}.{near}")


def whole(call: str, value: object, least: int = 1, most: int | None = None, of: str = "", why: str = "") -> int:
    """A whole number from `least` to `most`, by default 2^53; `why` is a clause that gives the reason."""
    clean, top = as_whole(value), MOST if most is None else most
    if clean is None or not least <= clean <= top:
        beyond = most is not None or (clean is not None and clean > top)
        must = f"a whole number{of} from {least} to {'2^53' if top == MOST else top}" if beyond else None
        must = must or (f"a positive whole number{of}" if least == 1 else f"a whole number{of}, at least {least}")
        raise refusal(call, must + (f", {why}" if why else ""), value)
    return clean


def seed(call: str, value: object) -> int:
    """A seed of random numbers, which is the key of a generator."""
    clean = as_whole(value)
    if clean is None or not 0 <= clean < 2**64:
        raise refusal(call, "a whole number from 0 to 2^64 - 1, the key of a generator", value)
    return clean


def finite(call: str, value: object, of: str = "", *, low: float = -np.inf, high: float = np.inf) -> float:
    """A finite number within [low, high]."""
    clean = as_number(value)
    if clean is None or not (np.isfinite(clean) and low <= clean <= high):
        ends = [f"at least {low:g}" if low > -np.inf else "", f"at most {high:g}" if high < np.inf else ""]
        raise refusal(call, f"a finite number{of}" + "".join(f", {end}" for end in ends if end), value)
    return clean


def positive(call: str, value: object, of: str = "") -> float:
    """A number that is positive, finite and of full accuracy."""
    clean = as_number(value)
    if clean is None or not np.finfo(float).tiny <= clean < np.inf:
        why = ", which a float does not hold to full accuracy" if clean is not None and 0 < clean < 1 else ""
        raise refusal(call, f"a positive, finite number{of}", value, why)
    return clean


def seconds(call: str, value: object) -> float:
    """A span of time in s that is positive, finite and of full accuracy."""
    return positive(call, value, " of seconds")


def multiple(call: str, span: float, unit: float, of: str) -> int:
    """The number of units in a span, both in s; `of` names the unit."""
    count = span / unit
    if count > MOST:
        raise ValueError(f"`{call}` must be at most 2^53 times {of} {unit:g} s, to be counted; got {span:g} s.")
    # 1e-6 of a unit: what the rounding of the quotient can do at a billion units
    if round(count) < 1 or abs(count - round(count)) > 1e-6 * max(1.0, count * 1e-6):
        raise ValueError(f"`{call}` must be a multiple of {of} {unit:g} s; got {span:g} s.")
    return round(count)


def numbers(call: str, value: object, ndim: int | None = None) -> Array:
    """A new array of doubles, of `ndim` axes if that is given."""
    array = as_array(value)
    if array is None or (ndim is not None and array.ndim != ndim):
        kinds = {0: "a single number", 1: "a vector of numbers", 2: "a matrix of numbers"}
        raise refusal(call, "a number or an array of numbers" if ndim is None else kinds[ndim], value)
    return array


def vector(call: str, value: object, size: int, of: str) -> Array:
    """A vector (size,), also from a row or a column; `of` names the things that its numbers belong to."""
    array = as_array(value)
    if array is None:
        raise refusal(call, "a vector of numbers", value)
    if array.shape not in ((size,), (size, 1), (1, size)):
        raise ValueError(f"`{call}` must have shape ({size},), one number for each of the {of}; got {array.shape}.")
    return array.ravel()


def matrix(call: str, value: object, rows: int | None = None, columns: int | None = None) -> Array:
    """A matrix of finite numbers, with so many rows and columns if they are given."""
    array = numbers(call, value, 2)
    if (rows, columns) != (rows if rows is None else array.shape[0], columns if columns is None else array.shape[1]):
        want = tuple("any" if size is None else size for size in (rows, columns))
        raise ValueError(f"`{call}` must have shape ({want[0]}, {want[1]}); got {array.shape}.")
    if not np.isfinite(array).all():
        place = tuple(map(int, np.argwhere(~np.isfinite(array))[0]))
        raise ValueError(f"`{call}` must be a matrix of finite numbers; got {array[place]:g} at {list(place)}.")
    return array


def as_whole(value: object) -> int | None:
    """A whole number of any type as an `int`; None for anything else, such as True."""
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value[()]
    counts = isinstance(value, int | np.integer) and not isinstance(value, bool | np.timedelta64)
    return int(value) if counts else None  # type: ignore[call-overload]


def as_number(value: object) -> float | None:
    """A real number of any type as a `float`; None for anything else, such as True or 10**400."""
    if type(value) is float:
        return value
    array = as_array(value)
    return float(array) if array is not None and array.ndim == 0 else None


def as_text(value: object) -> str | None:
    """Text in characters that can be written; None for anything else."""
    if not isinstance(value, str):
        return None
    try:
        value.encode()
    except UnicodeEncodeError:  # a lone surrogate
        return None
    return str(value) if type(value) is np.str_ else value


def as_path(value: object) -> str | os.PathLike[str] | None:
    """A path that a file can have here; None for anything else, such as one with NUL, or of too many characters."""
    try:
        place = os.fsencode(os.fspath(value))  # type: ignore[call-overload]
    except (TypeError, ValueError):
        return None
    longest = max(map(len, place.split(os.fsencode(os.sep))))
    fits = b"\0" not in place and len(place) < LONGEST_PATH and longest <= LONGEST_PART
    return value if isinstance(value, str | os.PathLike) and fits else None


def as_array(value: object) -> Array | None:
    """A new array of doubles; None for a value that is no array of numbers, overflows, or is masked in part."""
    try:
        array = np.array(value)
        if array.dtype.kind not in "iuf" or np.ma.is_masked(value):
            return None
        with np.errstate(over="raise"):
            return array.astype(np.float64)
    except Exception:  # an object of the user's may raise anything when it is asked for its numbers
        return None


def as_objects(value: object) -> NDArray[np.object_]:
    """An array of the objects in lists, even of unequal lengths; of None for what refuses to be looked into."""
    try:
        return np.array(value, dtype=object)
    except Exception:  # an object of the user's may raise anything when it is asked for its items
        return np.array(None, dtype=object)


def describe(value: object, longest: int = LONGEST) -> str:
    """A value in a few printable words: `a PID, which is an AbstractController`."""
    try:
        return "".join(c if c.isprintable() else " " for c in _describe(value, longest))
    except Exception:  # an object of the user's may raise anything when it is asked for its text
        return with_article(type(value))


def _describe(value: object, longest: int) -> str:
    if isinstance(value, type):
        return f"the class `{value.__name__}` itself: make one with `{value.__name__}(...)`"
    if callable(value) and hasattr(value, "__name__"):
        return f"the function `{value.__name__}` itself: call it"
    if isinstance(value, np.ndarray):
        return f"an array of shape {value.shape}" + ("" if value.dtype.kind in "iuf" else f" and kind {value.dtype}")
    if value is None or isinstance(value, bool | int | float | complex | str | bytes | np.generic):
        plain = value.item() if isinstance(value, np.generic) else value
        short = repr(plain[:longest] if isinstance(plain, str | bytes) else plain)
        return short if len(short) <= longest else f"{short[:longest]}..."
    if type(value) in (list, tuple, dict, set):
        return _SHORT.repr(value)
    bases = [base for base in type(value).__mro__[1:] if inspect.isabstract(base)]
    return with_article(type(value)) + (f", which is {with_article(bases[0])}" if bases else "")


class _Short(reprlib.Repr):
    """A short text of containers: their first items, each as a message describes it."""

    def repr_instance(self, x: object, level: int) -> str:
        return describe(x)


_SHORT = _Short()


def with_article(kind: object) -> str:
    """A class with its article, in backticks."""
    name = name_of(kind)
    return f"{'an' if name[1] in 'AEIOaeio' else 'a'} {name}"


def name_of(kind: object) -> str:
    """The name of a class, in backticks."""
    return f"`{getattr(kind, '__name__', kind)}`"


def nearest(name: object, names: Iterable[str]) -> str:
    """The question "Did you mean ...?" with the known name nearest to a misspelt one; empty if none is near."""
    held = [one for one in names if isinstance(one, str)]
    close = difflib.get_close_matches(name[:LONGEST], held, n=1, cutoff=0.6) if isinstance(name, str) else []
    return f" Did you mean '{close[0]}'?" if close else ""
