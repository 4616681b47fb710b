"""The cases of a test of which some are light, and all others run by `make test-all` only."""

import pytest


def heavy_but(cases, *light):
    """The cases in their order, marked as heavy but for these."""
    return [
        case
        if case in light
        else pytest.param(*(case if isinstance(case, tuple) else (case,)), marks=pytest.mark.heavy)
        for case in cases
    ]
