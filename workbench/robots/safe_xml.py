"""XML from strangers: elements and attributes alone, no entities, no other file, nothing deep and nothing huge.

References
----------
Python's library reference, "XML security": the attacks that each of the limits ends.
"""

from __future__ import annotations

from pathlib import Path
from xml.etree.ElementTree import Element, TreeBuilder
from xml.parsers import expat

from workbench.validation.refusals import described

LARGEST = 2_000_000  # bytes of a file
DEEPEST = 64  # elements within each other
MOST = 50_000  # elements in all
LONGEST_PATH = 300  # characters of a path that a message shows


class RefusedXmlError(ValueError):
    """What is no XML, or more than plain XML."""


def element_of(text: bytes, source: str) -> Element:
    """The root element of XML; `source` names it in a message.

    Raises
    ------
    RefusedXmlError
        If it is not well-formed, has a DOCTYPE, or is above the limits of size and depth.
    """
    if len(text) > LARGEST:
        raise RefusedXmlError(f"{source} has more than {LARGEST} bytes, the most that is read.")
    parser, builder, depth, count = expat.ParserCreate(), TreeBuilder(), 0, 0
    parser.buffer_text = True

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal depth, count
        depth, count = depth + 1, count + 1
        if depth > DEEPEST or count > MOST:
            what = f"nests elements deeper than {DEEPEST}" if depth > DEEPEST else f"has more than {MOST} elements"
            raise RefusedXmlError(f"{source} {what}, in line {parser.CurrentLineNumber}: that is no robot.")
        builder.start(tag, attributes)

    def end(tag: str) -> None:
        nonlocal depth
        depth -= 1
        builder.end(tag)

    def doctype(*_: object) -> None:
        raise RefusedXmlError(
            f"{source} has a DOCTYPE in line {parser.CurrentLineNumber}; entities and other files are never read: "
            "take it out."
        )

    parser.StartElementHandler, parser.EndElementHandler, parser.StartDoctypeDeclHandler = start, end, doctype
    try:
        parser.Parse(text, True)
    except RefusedXmlError:
        raise
    except expat.ExpatError as error:
        what = expat.ErrorString(error.code)
        raise RefusedXmlError(
            f"{source} is no well-formed XML: {what} in line {error.lineno}, column {error.offset + 1}."
        ) from None
    except (ValueError, LookupError):
        raise RefusedXmlError(f"{source} is in an encoding that is not known; write it in UTF-8.") from None
    return builder.close()


def element_in(file: Path) -> Element:
    """The root element of an XML file, which is the only file that is opened.

    Raises
    ------
    LookupError
        If there is no such file, or it cannot be read.
    RefusedXmlError
        As `element_of`.
    """
    name = described(str(file), LONGEST_PATH)
    try:
        if not file.is_file():  # a folder, a pipe, which would wait for a writer, or nothing
            raise LookupError(f"There is no file {name}.")
        with file.open("rb") as handle:
            text = handle.read(LARGEST + 1)
    except (OSError, ValueError) as error:  # of a path with a null character, say
        raise LookupError(f"{name} cannot be read: {getattr(error, 'strerror', None) or error}.") from None
    return element_of(text, name)
