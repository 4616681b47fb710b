"""Errors at the command line: one sentence with its place in the user's own script, and an exit status."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from traceback import format_exception
from typing import NoReturn

import click

# What the workbench raises on purpose; anything else is a bug of ours and shows its traceback.
ON_PURPOSE = (ValueError, LookupError, OSError, MemoryError)


def _is_on_purpose(error: Exception) -> bool:
    """True if an error was raised on purpose; that of a case is judged by its cause."""
    in_case = type(error).__name__ == "CaseError" and error.__cause__ is not None
    return isinstance(error.__cause__ if in_case else error, ON_PURPOSE)


def sentence(error: BaseException) -> str:
    """The message of an error in one line, with its kind where the message alone would not be understood."""
    if isinstance(error, OSError) and error.strerror:
        file = f" '{error.filename}'" if error.filename else ""
        return f"{error.strerror}:{file}." if file else f"{error.strerror}."
    text = " ".join(str(error.msg if isinstance(error, SyntaxError) else error).split())
    speaks = type(error) in (ValueError, LookupError) or type(error).__module__.startswith("workbench.")
    return text if speaks else f"{type(error).__name__}: {text}"


def place(error: BaseException, script: Path) -> str:
    """File and line of the user's script, or of a file beside it, where an error arose; empty if nowhere there."""
    if isinstance(error, SyntaxError):
        line = f", line {error.lineno}" if error.lineno else ""
        return f"{short_path(error.filename or str(script))}{line}: "
    folder, found = script.parent.resolve(), ""
    at: BaseException | None = error
    while at is not None:  # that of a case comes from another one, which knows more
        step = at.__traceback__
        while step is not None:
            file = Path(step.tb_frame.f_code.co_filename)
            if file.is_file() and file.resolve().parent == folder:
                found = f"{short_path(str(file))}, line {step.tb_lineno}: "
            step = step.tb_next
        at = at.__cause__
    return found


def short_path(file: str) -> str:
    """A file as the user would name it."""
    path = Path(file)
    return str(path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path)


def printable(text: str) -> str:
    r"""A text in one line with all characters escaped on which a terminal would act: ESC becomes \x1b.

    Letters of all scripts stay. Line ends, marks that turn the direction of writing, and halves of characters are
    escaped too: a file's name may hold them.
    """
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in text)


def printable_lines(text: str) -> str:
    """The same of a text of several lines, whose ends stay."""
    return "\n".join(map(printable, text.split("\n")))


def aside(text: str) -> None:
    """Print a line on stderr."""
    click.echo(printable(text), err=True)


@contextmanager
def one_sentence(script: Path | None = None) -> Iterator[None]:
    """Turn an error raised on purpose, or by the user's own script, into one sentence and an exit status."""
    try:
        yield
    except KeyboardInterrupt as stop:
        leave(str(stop) or "stopped; no report was written.", 130)
    except BrokenPipeError:  # the reader of our output has left, as `head` does
        let_go_of_output()
        sys.exit(0)
    except Exception as error:
        where = place(error, script) if script is not None else ""
        if not where and not _is_on_purpose(error):
            raise
        leave(where + sentence(error), 2, error)


@contextmanager
def of_the_study(script: Path, function: Callable[..., object]) -> Iterator[None]:
    """Give an error its place in the script, or that of the `function` of the study that it comes from."""
    from workbench.report.folder import ReportError
    from workbench.study.case_runs import CaseError

    code = getattr(function, "__code__", None)
    of_function = (
        f"{short_path(code.co_filename)}, line {code.co_firstlineno}: " if code else f"{short_path(str(script))}: "
    )
    try:
        yield
    except SystemExit as error:
        where = place(error, script) or of_function
        leave(f"{where}the study ended by itself, with status {error.code}, before its report was written.", 2)
    except (ReportError, CaseError, OSError, MemoryError):
        raise
    except Exception as error:
        leave((place(error, script) or of_function) + sentence(error), 2, error)


def leave(message: str, status: int, error: BaseException | None = None) -> NoReturn:
    """Print an error, with Python's traceback if that was asked for, and end the process."""
    click.echo(printable(f"workbench: {message}"), err=True)
    if error is not None and (context := click.get_current_context(silent=True)) and context.params.get("traceback"):
        for line in "".join(format_exception(error)).splitlines():
            aside(line)
    sys.exit(status)


def let_go_of_output() -> None:
    """Discard all further output, as its reader has gone."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
