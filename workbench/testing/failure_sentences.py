"""The sentences of a test that fails: the block, the rule, the thing that came, and the remedy."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import NoReturn
from unittest import SkipTest

from workbench.core.validation.refusals import error_text

LONGEST = 600  # characters of a refusal: one that is longer is not read in a terminal


def name_of_block(block: object) -> str:
    """The name of the class of a block."""
    return type(block).__name__


def fail(call: str, must: str, came: str, remedy: str) -> NoReturn:
    """Raise the `AssertionError` of a rule: "`call` must ...; it ...: remedy."."""
    __tracebackhide__ = True  # pytest shows the test and this sentence
    raise AssertionError(f"`{call}` must {must}; {came}: {remedy}.")


@contextmanager
def no_refusal(call: str, must: str, remedy: str) -> Iterator[None]:
    """Turn what is raised within the `with` into the failure of a rule."""
    __tracebackhide__ = True
    try:
        yield
    except (AssertionError, SkipTest):
        raise
    except (ValueError, LookupError) as error:
        fail(call, must, f"the workbench refused it with '{error}'", remedy)
    except Exception as error:
        fail(call, must, f"it raised {error_text(error)}", remedy)


def skip(reason: str) -> NoReturn:
    """Skip a test, as `unittest` and pytest understand it."""
    raise SkipTest(reason)
