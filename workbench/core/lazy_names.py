"""Names of a room that load when they are asked for: a room of many libraries costs no more than what is used of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any


def lazy_names(package: str, files: Mapping[str, str]) -> tuple[list[str], Callable[[str], Any]]:
    """The public names of a package, and its `__getattr__`, which loads one from its file when it is first asked for.

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
    >>> names, load = lazy_names("workbench.design", {"riccati": "lqr care"})
    >>> names, load("lqr") is wb.lqr
    (['care', 'lqr'], True)
    """
    homes = {name: file for file, names in files.items() for name in names.split()}

    def load(name: str) -> Any:
        """A name of the room, loaded from its file."""
        if name not in homes:
            raise AttributeError(f"module '{package}' has no attribute '{name}'")
        if not homes[name]:
            return import_module(f"{package}.{name}")
        return getattr(import_module(f"{package}.{homes[name]}"), name)

    return sorted(homes), load
