"""The laws of the house on files, functions, calls, classes and types, each a function from sources to breaches."""

from __future__ import annotations

import ast

from tests.house.sources import (
    Sources,
    dotted,
    imports,
    nodes,
    statements,
    tree_of,
)

LINES_OF_A_FILE, LINES_OF_A_FUNCTION = 300, 50
BANNED_CALLS = {
    "super": "write a final class, and share by calling a function",
    "print": "return the text; only the command line prints",
    "eval": "no text is executed",
    "exec": "no text is executed",
    "compile": "no text is executed",
}
BANNED_NAMES = {
    "sympify": "it executes text; build the expression from CasADi symbols",
    "yaml.load": "it makes objects from text; use yaml.safe_load",
}
BANNED_IMPORTS = {
    "pickle": "it executes what it reads; write plain numbers and text",
    "dill": "it executes what it reads; write plain numbers and text",
    "marshal": "it is no format; write plain numbers and text",
    "shelve": "it pickles; write plain numbers and text",
    "random": "it has one hidden state; take a numpy.random.Generator as an argument",
}

# What of numpy.random has no hidden global state.
SEEDED = {"Generator", "BitGenerator", "SeedSequence", "PCG64", "PCG64DXSM", "Philox", "default_rng"}

# Rooms whose public names have doors; the others follow.
ROOMS_WITH_DOORS = {
    "arms/laws",
    "arms/mechanics",
    "arms/observers",
    "blocks/laws",
    "blocks/loop",
    "blocks/observers",
    "blocks/plants",
    "core",
    "engine",
    "engine/metrics",
}

# Rooms in which explicit `Any` stands only at doors: of a library without types, or of what is read from outside.
ROOMS_WITHOUT_ANY = ("arms", "blocks", "cli", "core", "design", "engine", "handover", "proofs", "report", "study")
DOORS_WITH_ANY = {
    "arms/observer_gains/matrix_inequalities.py": "CVXPY",
    "core/block.py": "dataclasses: a declared field fits any type, as a number of a user's block does",
    "core/expressions.py": "CasADi's buffers, and the protocols by which NumPy calls its symbols",
    "core/validation/type_hints.py": "typing: a hint of a user's, Any among them",
    "engine/trajectories.py": "the figure of Matplotlib that runs have",
    "report/figures/pen.py": "matplotlib",
    "report/figures/style.py": "matplotlib",
    "report/object_plots.py": "the picture that an object has",
    "study/__init__.py": "names that are loaded when they are asked for",
    "study/executors.py": "distributed",
    "study/ledger/chunk.py": "json",
    "study/user_values.py": "values of a study's author",
}
CONTRACTS = {"wb.Controller", "wb.Observer", "wb.Plant", "wb.Reference"}  # abstract, by short names of the face


def long_files(held: Sources) -> list[str]:
    """Files beyond the budget."""
    return [
        f"{path}:{lines}: a file has at most {LINES_OF_A_FILE} lines, this one {lines}; find its second idea."
        for path, text in held.items()
        if (lines := len(text.splitlines())) > LINES_OF_A_FILE
    ]


def long_functions(held: Sources) -> list[str]:
    """Functions beyond the budget, from `def` to the last line, the examples of their docstrings not counted."""
    return [
        f"{path}:{node.lineno}: a function has at most {LINES_OF_A_FUNCTION} lines, "
        f"`{node.name}` has {lines}; give its parts names."
        for path, node in statements(held)
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
        and (lines := (node.end_lineno or node.lineno) - node.lineno + 1 - _examples(node)) > LINES_OF_A_FUNCTION
    ]


def _examples(node: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """How many lines of the docstring are examples, with their heading."""
    _, heading, shown = (ast.get_docstring(node) or "").partition("\nExamples\n--------\n")
    return len(shown.splitlines()) + 3 if heading else 0


def banned_calls(held: Sources) -> list[str]:
    """Calls and imports that the house does without."""
    breaches = []
    for path, node in nodes(held):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in BANNED_CALLS:
            name = node.func.id
            breaches.append(f"{path}:{node.lineno}: no `{name}(...)`: {BANNED_CALLS[name]}.")
        if isinstance(node, ast.Name | ast.Attribute):
            name = dotted(node)
            for banned, advice in BANNED_NAMES.items():
                if name == banned or name.endswith(f".{banned}"):
                    breaches.append(f"{path}:{node.lineno}: no `{banned}`: {advice}.")
    for path, text in held.items():
        for line, module, name in imports(path, text):
            for banned in {module.partition(".")[0], name} & (BANNED_IMPORTS | BANNED_NAMES).keys():
                breaches.append(f"{path}:{line}: no `{banned}`: {(BANNED_IMPORTS | BANNED_NAMES)[banned]}.")
    return breaches


def global_seeds(held: Sources) -> list[str]:
    """Random numbers that do not come from a generator or seed handed in."""
    breaches = []
    advice = "take a numpy.random.Generator or a seed as an argument"
    for path, node in nodes(held):
        legacy = isinstance(node, ast.Attribute) and node.attr not in SEEDED
        if legacy and dotted(node.value) in {"np.random", "numpy.random"}:
            breaches.append(f"{path}:{node.lineno}: `np.random.{node.attr}` has a hidden global state; {advice}.")
        unseeded = isinstance(node, ast.Call) and not node.args and not node.keywords
        if unseeded and dotted(node.func).rpartition(".")[2] == "default_rng":
            breaches.append(f"{path}:{node.lineno}: `default_rng()` without a seed cannot be repeated; {advice}.")
    return breaches


def cached_results(held: Sources) -> list[str]:
    """Functions of the results that hide in a cache what a study must declare, or compute once for its page."""
    return [
        f"{path}:{node.lineno}: `{node.name}` keeps what it computes from the results in a cache; declare it as "
        "`Study(works=...)`, or compute it once in `sections`."
        for path, node in nodes(held)
        if path.startswith("studies/") and isinstance(node, ast.FunctionDef)
        if any("cache" in ast.unparse(one) for one in node.decorator_list)
        if any(one.annotation and "Results" in ast.unparse(one.annotation) for one in node.args.args)
    ]


def inherited_final_classes(held: Sources) -> list[str]:
    """Classes that are inherited from, and are neither abstract, nor a protocol, a tuple or an exception."""
    bases = {node.name: _bases(node) for _, node in nodes(held) if isinstance(node, ast.ClassDef)}

    def is_exception(name: str) -> bool:
        return name.endswith(("Error", "Exception", "Warning")) or any(map(is_exception, bases.get(name, [])))

    def extendable(name: str) -> bool:
        abstract = name.lstrip("_").startswith("Abstract")
        return abstract or is_exception(name) or bool({"Protocol", "NamedTuple"} & set(bases[name]))

    return [
        f"{path}:{node.lineno}: a class is abstract or final, and `{node.name}` inherits from `{base}`; "
        f"name it Abstract{base} and leave nothing in it to override, or hold one instead."
        for path, node in nodes(held)
        if isinstance(node, ast.ClassDef)
        for base in _bases(node)
        if base in bases and not extendable(base)
    ]


def _bases(node: ast.ClassDef) -> list[str]:
    plain = (dotted(base.value if isinstance(base, ast.Subscript) else base) for base in node.bases)
    return [f"Abstract{base[3:]}" if base in CONTRACTS else base.rpartition(".")[2] for base in plain]


def _has_door(node: ast.AST, words: set[str]) -> bool:
    """Whether a function or class refuses by its hints, by a word of the vocabulary, or has nothing to refuse."""
    decorators = {dotted(d.func if isinstance(d, ast.Call) else d) for d in getattr(node, "decorator_list", [])}
    if isinstance(node, ast.FunctionDef):
        called = {dotted(part.func) for part in ast.walk(node) if isinstance(part, ast.Call)}
        return bool(decorators & {"check_arguments"} or called & words or not node.args.args)
    if isinstance(node, ast.ClassDef):
        return (
            bool(decorators & {"check_arguments", "block"} or {"NamedTuple"} & set(_bases(node)))
            or "Abstract" in node.name
        )
    return True


def names_without_door(held: Sources) -> list[str]:
    """Public names of the rooms with doors, those in `__all__`, that have none."""
    breaches = []
    for path, node in nodes(held):
        if path.removeprefix("workbench/").removesuffix("/__init__.py") not in ROOMS_WITH_DOORS:
            continue
        if not (isinstance(node, ast.Assign) and dotted(node.targets[0]) == "__all__"):
            continue
        public = set(ast.literal_eval(node.value))
        for file, text in held.items():
            if not file.startswith(path.removesuffix("__init__.py")):
                continue
            words = {name for _, module, name in imports(file, text) if "validation" in module} | {"checked"}
            breaches += [
                f"{file}:{part.lineno}: `{part.name}` is public and has no door; write `@check_arguments` above it."
                for part in tree_of(text).body
                if isinstance(part, ast.FunctionDef | ast.ClassDef) and part.name in public
                if not _has_door(part, words)
            ]
    return breaches


def explicit_any(held: Sources) -> list[str]:
    """Annotations with `Any` in a room that has true types, but at its doors."""
    doors = {f"workbench/{path}" for path in DOORS_WITH_ANY}
    return [
        f"{path}:{node.lineno}: explicit `Any`; write the true type, `object` where it is narrowed, or "
        "`workbench.design.control_system.System` for a system of python-control."
        for path, node in nodes({path: text for path, text in held.items() if path not in doors})
        if path.startswith("workbench/") and path.split("/")[1] in ROOMS_WITHOUT_ANY
        if isinstance(node, ast.Name) and node.id == "Any"
    ]


def mutable_dataclasses(held: Sources) -> list[str]:
    """Dataclasses that are not frozen."""
    breaches = []
    for path, node in statements(held):
        for decorator in node.decorator_list if isinstance(node, ast.ClassDef) else []:
            call = decorator if isinstance(decorator, ast.Call) else None
            if dotted(call.func if call else decorator).rpartition(".")[2] != "dataclass":
                continue
            frozen = call is not None and any(
                k.arg == "frozen" and isinstance(k.value, ast.Constant) and k.value.value is True for k in call.keywords
            )
            if not frozen:
                breaches.append(
                    f"{path}:{node.lineno}: `{node.name}` is not frozen; an object is whole when it is made: "
                    "write `@dataclass(frozen=True)`."
                )
    return breaches
