"""Classes of tests for blocks that are made here, and the test of one that must fail."""

import pytest


def kit_of(kind, given, made, **more):
    """The tests of a kind of block for what is made."""
    return type(f"Test{kind.__name__}", (kind,), {given: lambda self: made() if callable(made) else made, **more})()


def assert_caught(tests, start, says):
    """Assert that the test of a kit whose name begins with `start` fails with these words, in one line."""
    (name,) = [name for name in dir(tests) if name.startswith(start)]
    with pytest.raises(AssertionError, match=says) as error:
        getattr(tests, name)()
    assert str(error.value).isprintable()
    assert str(error.value).startswith("`")
