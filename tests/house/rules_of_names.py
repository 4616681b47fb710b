"""The laws of the house on names of files, folders, classes, functions, arguments: no bare participle, none twice."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator

from tests.house.sources import Sources, statements

# Participles that do not end with -ed.
IRREGULAR = frozenset({
    *("begun", "broken", "built", "chosen", "done", "drawn", "driven", "fallen", "found", "given", "gone", "grown"),
    *("held", "hidden", "kept", "known", "led", "lost", "made", "met", "said", "seen", "sent", "shown", "sought"),
    *("spent", "stood", "taken", "thrown", "told", "worn", "written"),
})  # fmt: skip
PRESENT = frozenset({"growing", "missing", "moving", "reaching", "remaining", "rising", "waiting", "watching"})
# Nouns, verbs and letters that only look like participles. `ed` is the derivative of the error e.
FREE = frozenset({"bleed", "ed", "embed", "exceed", "feed", "need", "proceed", "seed", "speed", "testbed"})
# Fields whose names are keys of a file that others read, or paths of parameters on a page.
KEPT = frozenset({
    "studies/a6_unstated_choices/blocks.py: lifted", "studies/a6_unstated_choices/blocks.py: printed",
    "studies/a6_unstated_choices/blocks.py: repaired", "workbench/handover/targets/target.py: touched",
    "workbench/proofs/counterexample.py: sought", "workbench/report/live/links.py: printed",
    "workbench/report/live/page_data.py: refused",
})  # fmt: skip
WORDS = re.compile(r"[A-Z]?[a-z0-9]+|[A-Z0-9]+(?![a-z])")


def is_participle(name: str) -> bool:
    """True if a name is one word and this is a participle: `found`, `Sampled`, and not `sampled_loop`."""
    words = WORDS.findall(name)
    if len(words) != 1:
        return False
    word = words[0].lower()
    return word not in FREE and (word.endswith("ed") or word in IRREGULAR | PRESENT)


def bare_participles(held: Sources) -> list[str]:
    """Public names of files, folders, classes, functions, arguments and fields that are a participle."""
    return [
        f"{path}:{line}: {kind} `{name}` is a bare participle; take a verb, a noun, or an adjective before a noun."
        for path, text in held.items()
        if not path.startswith("tests/")
        for kind, name, line in _public_names(path, text)
        if is_participle(name) and f"{path}: {name}" not in KEPT
    ]


def classes_of_one_name(held: Sources) -> list[str]:
    """Public classes of the workbench that share a name."""
    places: dict[str, list[str]] = {}
    for path, node in statements(held):
        if path.startswith("workbench/") and isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
            places.setdefault(node.name, []).append(f"{path}:{node.lineno}")
    return [
        f"{first}: the class `{name}` is also in {', '.join(others)}; name each for what sets it apart."
        for name, (first, *others) in places.items()
        if others
    ]


def _public_names(path: str, text: str) -> Iterator[tuple[str, str, int]]:
    *folders, file = path.removesuffix(".py").split("/")
    yield ("the folder", folders[-1], 1) if file == "__init__" else ("the file", file, 1)
    for _, node in statements({path: text}):
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
            yield "the class", node.name, node.lineno
            for field in node.body:
                if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name):
                    yield "the field", field.target.id, field.lineno
        if isinstance(node, ast.FunctionDef) and (not node.name.startswith("_") or node.name == "__init__"):
            yield "the function", node.name, node.lineno
            for argument in (*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs):
                yield "the argument", argument.arg, argument.lineno
