"""The laws of the house that a machine can hold, each a function from sources to what breaks it.

Sources are a mapping of paths, as in "workbench/core/ode.py", to text, so that every rule can be shown
a small piece of bad code. A breach names file, line, rule, and what to do.
"""

from __future__ import annotations

import ast
import graphlib
import re
import sys
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LINES_OF_A_FILE, LINES_OF_A_FUNCTION = 300, 50

# One door per library: where a library may be imported, under workbench/ (a folder ends with a slash).
DOORS = {
    "click": "cli/",
    "clarabel": "arms/observer_gains/matrix_inequalities.py",
    "control": "design/",
    "cvxpy": "arms/observer_gains/matrix_inequalities.py",
    "flint": "proofs/interval.py",
    "distributed": "study/executors.py",
    "dask": "study/executors.py",
    "jinja2": "core/templates.py",
    "llvmlite": "engine/kernel/llvm.py",
    "matplotlib": "report/figures/",
    "rich": "cli/progress.py",
    "SALib": "study/uncertainty/indices.py",
    "threadpoolctl": "design/matrices.py",
    "typst": "report/pdf.py",
}

# The bench measures python-control as its users call it, and not what the door makes of it; so does a reader's own law.
BESIDE_THE_DOOR = {("control", "studies/performance/peers.py"), ("control", "studies/own_law.py")}

# A study has the workbench by its face alone; but these measure the time of its inner parts, each by itself.
INNER_PARTS = {"studies/performance/inner_parts.py", "studies/b2_sobol_cost/inner_parts.py"}
BESIDE_STUDIES = {"studies", "workbench", "numpy", "casadi", "scipy"}
# Peers against which a study holds the workbench; those of `studies/performance` are many.
PEERS = {
    "studies/own_law.py": {"control"},
    "studies/b0_robots/sympy_chain.py": {"sympy"},
    "studies/b0_robots/mujoco_arm.py": {"mujoco"},
}
OF_ANOTHER_STUDY = "`{}` is of another study; what two share is the workbench's, or the paper's in studies/paper."

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
POOLS = {"asyncio", "concurrent", "joblib", "multiprocessing", "threading"}  # what a study declares as `works` instead
# What of numpy.random has no hidden global state.
SEEDED = {"Generator", "BitGenerator", "SeedSequence", "PCG64", "PCG64DXSM", "Philox", "default_rng"}

# Participles and riddles that have stood for the noun of a file.
NO_NAMES = {
    *("accumulated", "adjusted", "answered", "asked", "bounded", "found", "frozen", "given", "held", "kept", "listed"),
    *(
        "located",
        "made",
        "measured",
        "merged",
        "prepared",
        "read",
        "ready",
        "said",
        "shown",
        "tuned",
        "waiting",
        "written",
    ),
}
JOINT = re.compile(r"(?<![a-z])joint(?!s? distribution)", re.IGNORECASE)  # `isdisjoint` and `adjoint` are free
# Lines of C, C++, JavaScript, CMake and markup in a string of several lines.
FOREIGN = re.compile(
    r"^\s*#\s*(include|define|if)\b|^\s*(static|typedef|enum|struct|void)\b.*[;{]$|=> \{|"
    r"^\s*(const|let|function) \w+.*[;{]$|^\w+\(.*\)$|</\w+>",
    re.MULTILINE,
)
NO_OPENINGS = ("What", "Who", "Whether", "How")

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
ROOMS_WITHOUT_ANY = ("proofs", "report", "study")
DOORS_WITH_ANY = {
    "report/figures/pen.py": "matplotlib",
    "report/figures/style.py": "matplotlib",
    "report/object_plots.py": "the picture that an object has",
    "study/__init__.py": "names that are loaded when they are asked for",
    "study/executors.py": "distributed",
    "study/ledger/chunk.py": "json",
    "study/user_values.py": "values of a study's author",
}
CONTRACTS = {"wb.Controller", "wb.Observer", "wb.Plant", "wb.Reference"}  # abstract, by short names of the face

Sources = Mapping[str, str]


def sources(*folders: str) -> dict[str, str]:
    """Every Python file of the given folders."""
    files = (file for folder in folders for file in sorted((ROOT / folder).rglob("*.py")))
    return {file.relative_to(ROOT).as_posix(): file.read_text(encoding="utf-8") for file in files}


@cache
def _tree(text: str) -> ast.Module:
    return ast.parse(text)


@cache
def _all_of(text: str) -> tuple[ast.AST, ...]:
    nodes: list[ast.AST] = [_tree(text)]
    for node in nodes:  # which grows meanwhile; of whether a name is read or written no law asks
        for value in map(vars(node).get, node._fields):
            parts = value if isinstance(value, list) else [value]
            nodes += [part for part in parts if isinstance(part, ast.AST) and not isinstance(part, ast.expr_context)]
    return tuple(nodes)


@cache
def _statements_of(text: str) -> tuple[ast.AST, ...]:
    """The module and all its statements, at any depth, without what is within an expression."""
    nodes: list[ast.AST] = [_tree(text)]
    for node in nodes:  # which grows meanwhile
        for name in ("body", "handlers", "orelse", "finalbody", "cases"):
            nodes += getattr(node, name, [])
    return tuple(nodes)


@cache
def _imports_of(text: str) -> tuple[ast.Import | ast.ImportFrom, ...]:
    return tuple(node for node in _statements_of(text) if isinstance(node, ast.Import | ast.ImportFrom))


def _nodes(held: Sources) -> Iterator[tuple[str, ast.AST]]:
    for path, text in held.items():
        for node in _all_of(text):
            yield path, node


def _statements(held: Sources) -> Iterator[tuple[str, ast.AST]]:
    for path, text in held.items():
        for node in _statements_of(text):
            yield path, node


def _module(path: str) -> str:
    return path.removesuffix(".py").removesuffix("/__init__").replace("/", ".")


def _imports(path: str, text: str) -> Iterator[tuple[int, str, str]]:
    """Line, module and, if any, the name taken from it; also inside functions and under TYPE_CHECKING."""
    package = _module(path) if path.endswith("/__init__.py") else _module(path).rpartition(".")[0]
    for node in _imports_of(text):
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name, "") for alias in node.names)
        else:
            parents = package.split(".")[: len(package.split(".")) + 1 - node.level] if node.level else []
            module = ".".join([*parents, *([node.module] if node.module else [])])
            yield from ((node.lineno, module, alias.name) for alias in node.names)


def _dotted(node: ast.AST) -> str:
    if isinstance(node, ast.Attribute):
        return f"{_dotted(node.value)}.{node.attr}"
    return node.id if isinstance(node, ast.Name) else "?"


def open_side_doors(held: Sources) -> list[str]:
    """Libraries that are imported elsewhere than at their door."""
    breaches = []
    for path, text in held.items():
        for line, module, _ in _imports(path, text):
            library = module.partition(".")[0]
            door = f"workbench/{DOORS.get(library, '')}"
            inside = path.startswith(door) if door.endswith("/") else path == door
            inside = inside or (library, path) in BESIDE_THE_DOOR
            if library in DOORS and not inside:
                breaches.append(f"{path}:{line}: {library} has one door, {door}; call what that file offers.")
    return breaches


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
        for path, node in _statements(held)
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
        and (lines := (node.end_lineno or node.lineno) - node.lineno + 1 - _examples(node)) > LINES_OF_A_FUNCTION
    ]


def _examples(node: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """How many lines of the docstring are examples, with their heading."""
    _, heading, shown = (ast.get_docstring(node) or "").partition("\nExamples\n--------\n")
    return len(shown.splitlines()) + 3 if heading else 0


def import_cycles(held: Sources) -> list[str]:
    """Modules that import each other, by any kind of import; a parent package's own import does not count."""
    modules = {_module(path): path for path in held}
    graph: dict[str, set[str]] = {}
    for path, text in held.items():
        me = _module(path)
        for _, module, name in _imports(path, text):
            target = f"{module}.{name}" if f"{module}.{name}" in modules else module
            if target in modules and target != me:
                graph.setdefault(me, set()).add(target)
    try:
        graphlib.TopologicalSorter(graph).prepare()
    except graphlib.CycleError as error:
        ring = " <- ".join(error.args[1])
        return [f"{modules[error.args[1][0]]}: modules import each other, {ring}; move what both need a floor down."]
    return []


def banned_calls(held: Sources) -> list[str]:
    """Calls and imports that the house does without."""
    breaches = []
    for path, node in _nodes(held):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in BANNED_CALLS:
            name = node.func.id
            breaches.append(f"{path}:{node.lineno}: no `{name}(...)`: {BANNED_CALLS[name]}.")
        if isinstance(node, ast.Name | ast.Attribute):
            dotted = _dotted(node)
            for name, advice in BANNED_NAMES.items():
                if dotted == name or dotted.endswith(f".{name}"):
                    breaches.append(f"{path}:{node.lineno}: no `{name}`: {advice}.")
    for path, text in held.items():
        for line, module, name in _imports(path, text):
            for banned in {module.partition(".")[0], name} & (BANNED_IMPORTS | BANNED_NAMES).keys():
                breaches.append(f"{path}:{line}: no `{banned}`: {(BANNED_IMPORTS | BANNED_NAMES)[banned]}.")
    return breaches


def global_seeds(held: Sources) -> list[str]:
    """Random numbers that do not come from a generator or seed handed in."""
    breaches = []
    advice = "take a numpy.random.Generator or a seed as an argument"
    for path, node in _nodes(held):
        legacy = isinstance(node, ast.Attribute) and node.attr not in SEEDED
        if legacy and _dotted(node.value) in {"np.random", "numpy.random"}:
            breaches.append(f"{path}:{node.lineno}: `np.random.{node.attr}` has a hidden global state; {advice}.")
        unseeded = isinstance(node, ast.Call) and not node.args and not node.keywords
        if unseeded and _dotted(node.func).rpartition(".")[2] == "default_rng":
            breaches.append(f"{path}:{node.lineno}: `default_rng()` without a seed cannot be repeated; {advice}.")
    return breaches


def pools_in_studies(held: Sources) -> list[str]:
    """Studies that run something beside themselves, out of sight of ledger, estimate and Ctrl-C."""
    return [
        f"{path}:{line}: a study imports no {module}; declare what it computes as `Study(works=...)`."
        for path, text in held.items()
        if path.startswith("studies/")
        for line, module, _ in _imports(path, text)
        if module.partition(".")[0] in POOLS
    ]


def imports_of_studies(held: Sources) -> list[str]:
    """Imports of a study beyond `wb`, its own folder, `studies.paper`, Python's own library and three more."""
    breaches = []
    for path, text in held.items():
        if not path.startswith("studies/"):
            continue
        own = ".".join(path.removesuffix(".py").split("/")[:2])
        for line, module, name in _imports(path, text):
            top, home = module.partition(".")[0], ".".join(f"{module}.{name}".split(".")[:2])
            if top == "studies" and home not in (own, "studies.paper"):
                breaches.append(f"{path}:{line}: {OF_ANOTHER_STUDY.format(module)}")
            elif top == "workbench" and (module != "workbench" or name) and path not in INNER_PARTS:
                breaches.append(
                    f"{path}:{line}: a study writes `import workbench as wb`, and has nothing from `{module}`."
                )
            elif (
                top not in BESIDE_STUDIES | sys.stdlib_module_names | PEERS.get(path, set())
                and "studies/performance/" not in path
            ):
                breaches.append(f"{path}:{line}: {module} is no library of a study; ask the workbench for it.")
    return breaches


def cached_results(held: Sources) -> list[str]:
    """Functions of the results that hide in a cache what a study must declare, or compute once for its page."""
    return [
        f"{path}:{node.lineno}: `{node.name}` keeps what it computes from the results in a cache; declare it as "
        "`Study(works=...)`, or compute it once in `sections`."
        for path, node in _nodes(held)
        if path.startswith("studies/") and isinstance(node, ast.FunctionDef)
        if any("cache" in ast.unparse(one) for one in node.decorator_list)
        if any(one.annotation and "Results" in ast.unparse(one.annotation) for one in node.args.args)
    ]


def folders_without_init(paths: list[str]) -> list[str]:
    """Folders of modules that import-linter cannot see."""
    held = set(paths)
    folders = {path.rpartition("/")[0] for path in held}
    return [
        f"{folder}/: a folder of modules needs an __init__.py, or import-linter does not see it; add one."
        for folder in sorted(folders)
        if f"{folder}/__init__.py" not in held
    ]


def inherited_final_classes(held: Sources) -> list[str]:
    """Classes that are inherited from, and are neither abstract, nor a protocol, a tuple or an exception."""
    bases = {node.name: _bases(node) for _, node in _nodes(held) if isinstance(node, ast.ClassDef)}

    def is_exception(name: str) -> bool:
        return name.endswith(("Error", "Exception", "Warning")) or any(map(is_exception, bases.get(name, [])))

    def extendable(name: str) -> bool:
        abstract = name.lstrip("_").startswith("Abstract")
        return abstract or is_exception(name) or bool({"Protocol", "NamedTuple"} & set(bases[name]))

    return [
        f"{path}:{node.lineno}: a class is abstract or final, and `{node.name}` inherits from `{base}`; "
        f"name it Abstract{base} and leave nothing in it to override, or hold one instead."
        for path, node in _nodes(held)
        if isinstance(node, ast.ClassDef)
        for base in _bases(node)
        if base in bases and not extendable(base)
    ]


def _has_door(node: ast.AST, words: set[str]) -> bool:
    """Whether a function or class refuses by its hints, by a word of the vocabulary, or has nothing to refuse."""
    decorators = {_dotted(d.func if isinstance(d, ast.Call) else d) for d in getattr(node, "decorator_list", [])}
    if isinstance(node, ast.FunctionDef):
        called = {_dotted(part.func) for part in ast.walk(node) if isinstance(part, ast.Call)}
        return bool(decorators & {"door"} or called & words or not node.args.args)
    if isinstance(node, ast.ClassDef):
        return bool(decorators & {"door", "block"} or {"NamedTuple"} & set(_bases(node))) or "Abstract" in node.name
    return True


def names_without_door(held: Sources) -> list[str]:
    """Public names of the rooms with doors, those in `__all__`, that have none."""
    breaches = []
    for path, node in _nodes(held):
        if path.removeprefix("workbench/").removesuffix("/__init__.py") not in ROOMS_WITH_DOORS:
            continue
        if not (isinstance(node, ast.Assign) and _dotted(node.targets[0]) == "__all__"):
            continue
        public = set(ast.literal_eval(node.value))
        for file, text in held.items():
            if not file.startswith(path.removesuffix("__init__.py")):
                continue
            words = {name for _, module, name in _imports(file, text) if "validation" in module} | {"checked"}
            breaches += [
                f"{file}:{part.lineno}: `{part.name}` is public and has no door; write `@door` above it."
                for part in _tree(text).body
                if isinstance(part, ast.FunctionDef | ast.ClassDef) and part.name in public
                if not _has_door(part, words)
            ]
    return breaches


def words_of_arms(held: Sources) -> list[str]:
    """Joints of an arm in a room that any plant needs."""
    return [
        f"{path}:{number}: a joint is a word of `arms`; say what any plant has."
        for path, text in held.items()
        if path.startswith("workbench/") and path.split("/")[1] not in {"arms", "cli", "__init__.py", "__init__.pyi"}
        for number, line in enumerate(text.splitlines(), 1)
        if JOINT.search(line)
    ]


def explicit_any(held: Sources) -> list[str]:
    """Annotations with `Any` in a room that has true types, but at its doors."""
    doors = {f"workbench/{path}" for path in DOORS_WITH_ANY}
    return [
        f"{path}:{node.lineno}: explicit `Any`; write the true type, `object` where it is narrowed, or "
        "`workbench.design.control_system.System` for a system of python-control."
        for path, node in _nodes({path: text for path, text in held.items() if path not in doors})
        if path.startswith("workbench/") and path.split("/")[1] in ROOMS_WITHOUT_ANY
        if isinstance(node, ast.Name) and node.id == "Any"
    ]


def tests_that_import_tests(held: Sources) -> list[str]:
    """Test files that take something from another test file."""
    return [
        f"{path}:{line}: `{module}` is a test file; what two tests share is in tests/support."
        for path, text in held.items()
        for line, module, _ in _imports(path, text)
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
    """Modules of the workbench that share a name, but `__init__` and a room's `contract`."""
    places: dict[str, list[str]] = {}
    for path in held:
        if path.startswith("workbench/"):
            places.setdefault(path.rpartition("/")[2], []).append(path)
    return [
        f"{paths[0]}: `{name}` is also {', '.join(paths[1:])}; name each for what sets it apart."
        for name, paths in places.items()
        if len(paths) > 1 and name not in {"__init__.py", "contract.py"}
    ]


def participles(held: Sources) -> list[str]:
    """Files whose name is a participle or a riddle."""
    return [
        f"{path}: `{name}` tells nothing of what is in the file; take the noun of the field."
        for path in held
        if (name := path.rpartition("/")[2].removesuffix(".py")) in NO_NAMES
    ]


def question_openings(held: Sources) -> list[str]:
    """Docstrings that open with a question word."""
    return [
        f"{path}:{getattr(node, 'lineno', 1)}: a docstring says what the thing is and does not open with `{word}`; "
        "write 'The ...', 'True if ...' or the verb."
        for path, node in _statements(held)
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef)
        if (word := (ast.get_docstring(node) or "").partition(" ")[0]) in NO_OPENINGS
    ]


def foreign_text(held: Sources) -> list[str]:
    """Strings of four lines and more, but docstrings, that hold text in another language."""
    breaches = []
    for path, source in ((path, source) for path, source in held.items() if path.startswith("workbench/")):
        opened = (ast.Module, ast.ClassDef, ast.FunctionDef)
        heads = [n.body[0] for n in _statements_of(source) if isinstance(n, opened) and ast.get_docstring(n)]
        docstrings = {id(head.value) for head in heads if isinstance(head, ast.Expr)}
        for node in _all_of(source):
            text = node.value if isinstance(node, ast.Constant) and id(node) not in docstrings else None
            if isinstance(text, str) and text.count("\n") >= 3 and (found := FOREIGN.search(text)):
                breaches.append(
                    f"{path}:{node.lineno}: `{found[0].strip()}` is text in another language; put it in a file of "
                    "`templates` with the ending of its language."
                )
    return breaches


def _bases(node: ast.ClassDef) -> list[str]:
    plain = (_dotted(base.value if isinstance(base, ast.Subscript) else base) for base in node.bases)
    return [f"Abstract{base[3:]}" if base in CONTRACTS else base.rpartition(".")[2] for base in plain]


def mutable_dataclasses(held: Sources) -> list[str]:
    """Dataclasses that are not frozen."""
    breaches = []
    for path, node in _statements(held):
        for decorator in node.decorator_list if isinstance(node, ast.ClassDef) else []:
            call = decorator if isinstance(decorator, ast.Call) else None
            if _dotted(call.func if call else decorator).rpartition(".")[2] != "dataclass":
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
