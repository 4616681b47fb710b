"""The sources of the house: every file as text, as a tree, and by its statements and imports."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
Sources = Mapping[str, str]


def sources(*folders: str) -> dict[str, str]:
    """Every Python file of the given folders."""
    files = (file for folder in folders for file in sorted((ROOT / folder).rglob("*.py")))
    return {file.relative_to(ROOT).as_posix(): file.read_text(encoding="utf-8") for file in files}


@cache
def tree_of(text: str) -> ast.Module:
    return ast.parse(text)


@cache
def nodes_of(text: str) -> tuple[ast.AST, ...]:
    nodes: list[ast.AST] = [tree_of(text)]
    for node in nodes:  # which grows meanwhile; of whether a name is read or written no law asks
        for value in map(vars(node).get, node._fields):
            parts = value if isinstance(value, list) else [value]
            nodes += [part for part in parts if isinstance(part, ast.AST) and not isinstance(part, ast.expr_context)]
    return tuple(nodes)


@cache
def statements_of(text: str) -> tuple[ast.AST, ...]:
    """The module and all its statements, at any depth, without what is within an expression."""
    nodes: list[ast.AST] = [tree_of(text)]
    for node in nodes:  # which grows meanwhile
        for name in ("body", "handlers", "orelse", "finalbody", "cases"):
            nodes += getattr(node, name, [])
    return tuple(nodes)


@cache
def imports_of(text: str) -> tuple[ast.Import | ast.ImportFrom, ...]:
    return tuple(node for node in statements_of(text) if isinstance(node, ast.Import | ast.ImportFrom))


def nodes(held: Sources) -> Iterator[tuple[str, ast.AST]]:
    for path, text in held.items():
        for node in nodes_of(text):
            yield path, node


def statements(held: Sources) -> Iterator[tuple[str, ast.AST]]:
    for path, text in held.items():
        for node in statements_of(text):
            yield path, node


def module_of(path: str) -> str:
    return path.removesuffix(".py").removesuffix("/__init__").replace("/", ".")


def imports(path: str, text: str) -> Iterator[tuple[int, str, str]]:
    """Line, module and, if any, the name taken from it; also inside functions and under TYPE_CHECKING."""
    package = module_of(path) if path.endswith("/__init__.py") else module_of(path).rpartition(".")[0]
    for node in imports_of(text):
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name, "") for alias in node.names)
        else:
            parents = package.split(".")[: len(package.split(".")) + 1 - node.level] if node.level else []
            module = ".".join([*parents, *([node.module] if node.module else [])])
            yield from ((node.lineno, module, alias.name) for alias in node.names)


def dotted(node: ast.AST) -> str:
    if isinstance(node, ast.Attribute):
        return f"{dotted(node.value)}.{node.attr}"
    return node.id if isinstance(node, ast.Name) else "?"
