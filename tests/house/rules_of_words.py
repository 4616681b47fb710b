"""The laws of the house on names, words and places of files, each a function from sources to what breaks it."""

from __future__ import annotations

import ast
import re

from tests.house.sources import (
    Sources,
    imports,
    nodes_of,
    statements,
    statements_of,
)

JOINT = re.compile(r"(?<![a-z])joint(?!s? distribution)", re.IGNORECASE)  # `isdisjoint` and `adjoint` are free

# Lines of C, C++, JavaScript, CMake and markup in a string of several lines.
FOREIGN = re.compile(
    r"^\s*#\s*(include|define|if)\b|^\s*(static|typedef|enum|struct|void)\b.*[;{]$|=> \{|"
    r"^\s*(const|let|function) \w+.*[;{]$|^\w+\(.*\)$|</\w+>",
    re.MULTILINE,
)
# A line that may import from a test file: most have none, and are not parsed.
OF_A_TEST = re.compile(r"^[ \t]*(?:from|import)[ \t][\w.,\\\s]*?\btest_", re.MULTILINE)
NO_OPENINGS = ("What", "Who", "Whether", "How")


def folders_without_init(paths: list[str]) -> list[str]:
    """Folders of modules that import-linter cannot see."""
    held = set(paths)
    folders = {path.rpartition("/")[0] for path in held}
    return [
        f"{folder}/: a folder of modules needs an __init__.py, or import-linter does not see it; add one."
        for folder in sorted(folders)
        if f"{folder}/__init__.py" not in held
    ]


def tests_that_import_tests(held: Sources) -> list[str]:
    """Test files that take something from another test file."""
    return [
        f"{path}:{line}: `{module}` is a test file; what two tests share is in tests/support."
        for path, text in held.items()
        if OF_A_TEST.search(text)
        for line, module, _ in imports(path, text)
        if module.startswith("tests.") and module.rpartition(".")[2].startswith("test_")
    ]


def tests_in_other_folders(held: Sources) -> list[str]:
    """Tests that are in no folder of a room, of the studies or of the house."""
    rooms = {path.split("/")[1] for path in held if path.startswith("workbench/") and path.count("/") > 1}
    return [
        f"{path}: a test is in the folder of its room, in `studies` or in `house`."
        for path in held
        if path.startswith("tests/") and path.rpartition("/")[2].startswith("test_")
        if path.split("/")[1] not in rooms | {"studies", "house"}
    ]


def files_of_one_name(held: Sources) -> list[str]:
    """Modules of the workbench that share a name, but `__init__`."""
    places: dict[str, list[str]] = {}
    for path in held:
        if path.startswith("workbench/"):
            places.setdefault(path.rpartition("/")[2], []).append(path)
    return [
        f"{paths[0]}: `{name}` is also {', '.join(paths[1:])}; name each for what sets it apart."
        for name, paths in places.items()
        if len(paths) > 1 and name != "__init__.py"
    ]


def question_openings(held: Sources) -> list[str]:
    """Docstrings that open with a question word."""
    return [
        f"{path}:{getattr(node, 'lineno', 1)}: a docstring says what the thing is and does not open with `{word}`; "
        "write 'The ...', 'True if ...' or the verb."
        for path, node in statements(held)
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef)
        if (word := (ast.get_docstring(node) or "").partition(" ")[0]) in NO_OPENINGS
    ]


def words_of_arms(held: Sources) -> list[str]:
    """Joints of an arm in a room that any plant needs."""
    return [
        f"{path}:{number}: a joint is a word of `arms`; say what any plant has."
        for path, text in held.items()
        if path.startswith("workbench/") and path.split("/")[1] not in {"arms", "cli", "__init__.py", "__init__.pyi"}
        for number, line in enumerate(text.splitlines(), 1)
        if JOINT.search(line)
    ]


def foreign_text(held: Sources) -> list[str]:
    """Strings of four lines and more, but docstrings, that hold text in another language."""
    breaches = []
    for path, source in ((path, source) for path, source in held.items() if path.startswith("workbench/")):
        opened = (ast.Module, ast.ClassDef, ast.FunctionDef)
        heads = [n.body[0] for n in statements_of(source) if isinstance(n, opened) and ast.get_docstring(n)]
        docstrings = {id(head.value) for head in heads if isinstance(head, ast.Expr)}
        for node in nodes_of(source):
            text = node.value if isinstance(node, ast.Constant) and id(node) not in docstrings else None
            if isinstance(text, str) and text.count("\n") >= 3 and (found := FOREIGN.search(text)):
                breaches.append(
                    f"{path}:{node.lineno}: `{found[0].strip()}` is text in another language; put it in a file of "
                    "`templates` with the ending of its language."
                )
    return breaches
