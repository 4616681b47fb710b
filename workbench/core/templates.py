"""Text in other languages, as files in the folder `templates` of a package, filled in by Jinja if they end with '.j2'.

What is filled in is data: a name from outside is never read as a template. Pages and XML are escaped; in all other
languages the caller makes a text harmless. A word that the caller does not give is an error.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import jinja2

ESCAPED_ENDINGS = (".html.j2", ".xml.j2")


def template_bytes(package: str, path: str) -> bytes:
    """Content of a file in the folder `templates` of a package."""
    return files(package).joinpath("templates", *path.split("/")).read_bytes()


def template_text(package: str, path: str) -> str:
    """Text of a file in the folder `templates` of a package, with the line ends of UNIX."""
    return template_bytes(package, path).decode("utf-8").replace("\r\n", "\n")


def fill(package: str, path: str, /, **words: object) -> str:
    """Text of a template of a package with `words` filled in."""
    return _environment(package).get_template(path).render(words)


@cache
def _environment(package: str) -> jinja2.Environment:
    import jinja2  # a tenth of a second, which only those wait who fill a template

    environment = jinja2.Environment(
        loader=jinja2.FunctionLoader(lambda path: template_text(package, path)),
        autoescape=lambda path: path is not None and path.endswith(ESCAPED_ENDINGS),
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.filters["initializer"] = _initializer
    return environment


def _initializer(values: Iterable[object]) -> str:
    """The values of an array as C and C++ write them."""
    return f"{{{', '.join(map(str, values))}}}"
