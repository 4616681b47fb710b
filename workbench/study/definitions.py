"""Definitions: a digest of values, and of the contents of every function and class that they call."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator

import casadi as ca

from workbench import __version__
from workbench.engine.arithmetic import VERSION
from workbench.study.definition_text import Definition, Reader


class Definitions:
    """The definitions of a process as texts that are the same in every process; each text is made once."""

    def __init__(self) -> None:
        self._contents: dict[int, tuple[Definition, str, tuple[Definition, ...]]] = {}

    def digest(self, *roots: object) -> str:
        """The digest of values and of all definitions that they call (64 hexadecimal digits).

        Raises
        ------
        UnseenError
            If they use a value whose contents cannot be inspected; the message names the value and its place.
        """
        found: list[Definition] = []
        text = [Reader(found, "the item").text(root) for root in roots]
        digest = hashlib.sha256(repr(((__version__, VERSION, ca.CasadiMeta.version()), text)).encode())
        for content in self._reached(found):
            digest.update(content.encode())
        return digest.hexdigest()

    def _reached(self, found: list[Definition]) -> Iterator[str]:
        """The contents of definitions and of all definitions that they call, in breadth-first order."""
        met: dict[int, Definition] = {}
        while found:
            definition = found.pop(0)
            if id(definition) not in met:
                met[id(definition)] = definition
                content, called = self._content(definition)
                found += called
                yield content

    def _content(self, definition: Definition) -> tuple[str, tuple[Definition, ...]]:
        if id(definition) not in self._contents:
            called: list[Definition] = []
            reader = Reader(called, f"'{definition.__module__}.{definition.__qualname__}'")
            text = reader.of_class(definition) if isinstance(definition, type) else reader.of_function(definition)
            self._contents[id(definition)] = definition, text, tuple(called)
        return self._contents[id(definition)][1:]
