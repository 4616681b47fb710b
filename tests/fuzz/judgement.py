"""Which outcomes of a call are raw: what the workbench did not say itself."""

from __future__ import annotations

import dis
import re
from pathlib import Path
from types import TracebackType

ROOT = Path(__file__).resolve().parents[2]
HOUSE = str(ROOT / "workbench") + "/"
RAISE = dis.opmap["RAISE_VARARGS"]
COUNT = re.compile(
    r"missing \d+ required|takes .* arguments? but|takes no arguments|unexpected keyword|multiple values|abstract class"
)


def raw(error: BaseException) -> str | None:
    """Kind and place of a raw error; None of a refusal in the workbench's own words, and of Python's own of a call.

    Python's word on a script that is no Python, which another call may have written, is passed on as it is.
    """
    if isinstance(error, SyntaxError) and Path(error.filename or "").is_file():
        return None
    frame = _innermost(error)
    place = frame.tb_frame.f_code.co_filename
    inside = place.startswith(HOUSE)
    if (
        isinstance(error, TypeError)
        and COUNT.search(str(error))
        and (not inside or place.endswith("core/validation/signatures.py"))
    ):
        return None
    raised = inside and frame.tb_frame.f_code.co_code[frame.tb_lasti] == RAISE
    if raised and isinstance(error, ValueError | LookupError) and _one_line(error):
        return None
    return f"{type(error).__name__} at {_place_in_house(error)}"


def _one_line(error: BaseException) -> bool:
    return str(error).isprintable() and len(str(error)) < 2_000


def _innermost(error: BaseException) -> TracebackType:
    traceback = error.__traceback__
    assert traceback is not None
    while traceback.tb_next is not None:
        traceback = traceback.tb_next
    return traceback


def _place_in_house(error: BaseException) -> str:
    """The innermost line of the workbench that the error went through."""
    place, traceback = "no line of the workbench", error.__traceback__
    while traceback is not None:
        file = traceback.tb_frame.f_code.co_filename
        if file.startswith(HOUSE):
            place = f"workbench/{file.removeprefix(HOUSE)}:{traceback.tb_lineno}"
        traceback = traceback.tb_next
    return place
