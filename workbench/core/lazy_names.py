"""Names of a room that load when they are asked for: a room of many libraries costs no more than what is used of it."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from importlib import import_module


def lazy_names(
    package: str, files: Mapping[str, str]
) -> tuple[list[str], Callable[[str], object], Callable[[], list[str]]]:
    """The `__all__`, `__getattr__` and `__dir__` of a package that loads a name from its file when it is asked for.

    Parameters
    ----------
    package
        The `__name__` of the package.
    files
        By file, from the package on, the names that come from it, with blanks between; the names of "" are modules of
        the package.

    Examples
    --------
    >>> from workbench.core.lazy_names import lazy_names
    >>> names, load, _ = lazy_names("workbench.design", {"riccati": "lqr care"})
    >>> names, load("lqr") is wb.lqr
    (['care', 'lqr'], True)
    """
    homes = {name: file for file, names in files.items() for name in names.split()}

    def load(name: str) -> object:
        """A name of the room, loaded from its file."""
        if name not in homes:
            raise AttributeError(f"module '{package}' has no attribute '{name}'")
        if not homes[name]:
            return import_module(f"{package}.{name}")
        return getattr(import_module(f"{package}.{homes[name]}"), name)

    def names() -> list[str]:
        """The names of the room, loaded or not, and what any package has."""
        return sorted({*vars(sys.modules[package]), *homes})

    return sorted(homes), load, names
