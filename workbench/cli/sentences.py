"""What went wrong, in one sentence with its place in the user's own script."""

from __future__ import annotations

from pathlib import Path

# What the workbench raises on purpose; anything else is a bug of ours and shows its traceback.
SAID = (ValueError, LookupError, OSError, MemoryError)


def is_said(error: Exception) -> bool:
    """Whether an error was raised on purpose; that of a case is judged by its cause."""
    in_case = type(error).__name__ == "CaseError" and error.__cause__ is not None
    return isinstance(error.__cause__ if in_case else error, SAID)


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
        return f"{shown(error.filename or str(script))}{line}: "
    folder, found = script.parent.resolve(), ""
    at: BaseException | None = error
    while at is not None:  # that of a case comes from another one, which knows more
        step = at.__traceback__
        while step is not None:
            file = Path(step.tb_frame.f_code.co_filename)
            if file.is_file() and file.resolve().parent == folder:
                found = f"{shown(str(file))}, line {step.tb_lineno}: "
            step = step.tb_next
        at = at.__cause__
    return found


def shown(file: str) -> str:
    """A file as the user would name it."""
    path = Path(file)
    return str(path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path)


def printable(text: str) -> str:
    r"""A text in one line that a terminal only shows: what it would act upon, as ESC, stands there as \x1b.

    Letters of all scripts stay. Line ends, marks that turn the direction of writing, and halves of characters are
    escaped too: a file's name may hold them, and none may look like more than what it is.
    """
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in text)
