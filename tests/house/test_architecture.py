"""The laws of the house: what DESIGN says of floors, doors, sizes and style, held by a machine.

Each law is one test over all files; each is also shown a piece of bad code, to prove that it can fail.
"""

import re

import pytest

from tests.house import rules, sources
from tests.house import rules_of_code as code
from tests.house import rules_of_words as words
from tests.house.contracts import broken, lint_imports

HOUSE = sources.sources("workbench", "studies")
SHOWN = '    """It.\n\n    Examples\n    --------\n    >>> f()\n    """\n'  # three lines, the examples not counted

LAWS = [
    rules.open_side_doors,
    code.long_files,
    code.long_functions,
    rules.import_cycles,
    code.banned_calls,
    code.global_seeds,
    rules.imports_of_studies,
    rules.pools_in_studies,
    code.cached_results,
    code.inherited_final_classes,
    code.mutable_dataclasses,
    code.names_without_door,
    words.files_of_one_name,
    words.words_of_arms,
    code.explicit_any,
    words.tests_that_import_tests,
    words.tests_in_other_folders,
    words.question_openings,
    words.foreign_text,
]


def holds(breaches):
    if breaches:
        pytest.fail("\n".join(breaches), pytrace=False)


def test_the_floors_and_the_hourglass_hold():
    done = lint_imports(sources.ROOT)
    if done.returncode:
        pytest.fail(done.stdout + done.stderr, pytrace=False)


def test_each_library_has_one_door():
    holds(rules.open_side_doors(HOUSE))


def test_no_file_is_longer_than_its_budget():
    holds(code.long_files(HOUSE))


def test_no_function_is_longer_than_its_budget():
    holds(code.long_functions(HOUSE))


def test_the_examples_of_a_docstring_do_not_count_as_lines_of_its_function():
    assert not code.long_functions({"workbench/a.py": f"def f():\n{SHOWN}" + "    x = 1\n" * 47})


def test_no_modules_import_each_other():
    holds(rules.import_cycles(HOUSE))


def test_nothing_prints_executes_text_or_calls_super():
    holds(code.banned_calls(HOUSE))


def test_no_random_number_comes_from_a_hidden_state():
    holds(code.global_seeds(HOUSE))


def test_no_study_has_a_pool_of_threads_or_processes():
    holds(rules.pools_in_studies(HOUSE))


def test_a_study_can_be_copied_with_its_folder_and_that_of_the_paper():
    holds(rules.imports_of_studies(HOUSE))


def test_no_study_keeps_in_a_cache_what_it_computes_from_its_results():
    holds(code.cached_results(HOUSE))


def test_every_folder_of_modules_is_a_package():
    holds(words.folders_without_init([path for path in HOUSE if path.startswith("workbench/")]))


def test_a_class_is_abstract_or_final():
    holds(code.inherited_final_classes(HOUSE))


def test_every_dataclass_is_frozen():
    holds(code.mutable_dataclasses(HOUSE))


def test_public_names_have_doors():
    holds(code.names_without_door(HOUSE))


def test_no_room_for_any_plant_speaks_of_joints():
    holds(words.words_of_arms(HOUSE))


def test_explicit_any_stands_at_doors_alone():
    holds(code.explicit_any(HOUSE))
    assert {f"workbench/{path}" for path in code.DOORS_WITH_ANY} <= HOUSE.keys()


def test_an_explicit_any_is_found_in_its_rooms_but_not_at_a_door():
    text = "from typing import Any\ndef f(x: dict[str, Any]) -> None: ..."
    rooms = {f"workbench/{room}/x.py": text for room in ("proofs", "elsewhere")}
    (breach,) = code.explicit_any(rooms | {"workbench/study/executors.py": text})
    assert breach.startswith("workbench/proofs/x.py:2: explicit `Any`")


def test_a_test_stands_in_the_folder_of_its_room_and_imports_no_other():
    held = HOUSE | sources.sources("tests")
    holds([*words.tests_that_import_tests(held), *words.tests_in_other_folders(held)])


def test_no_two_files_share_a_name():
    holds(words.files_of_one_name(HOUSE))


def test_two_files_of_one_name_are_found():
    (breach,) = words.files_of_one_name({"workbench/a/x.py": "", "workbench/b/x.py": "", "studies/x.py": ""})
    assert "workbench/b/x.py" in breach


def test_no_docstring_opens_with_a_question_word():
    holds(words.question_openings(HOUSE))


@pytest.mark.parametrize("text", ["def f(x): ...", "@dataclass(frozen=True)\nclass f: ..."])
def test_a_public_name_without_a_door_is_found(text):
    room = {"workbench/core/__init__.py": "__all__ = ['f']", "workbench/core/a.py": text}
    (breach,) = code.names_without_door(room)
    assert "workbench/core/a.py:" in breach
    assert not code.names_without_door(room | {"workbench/core/a.py": f"@check_arguments\n{text}"})
    assert not code.names_without_door(room | {"workbench/core/a.py": "def f(): ..."})


def test_the_laws_see_the_whole_house():
    assert len(HOUSE) > 50
    assert {"workbench/core/ode.py", "workbench/cli/command.py", "studies/a1_paper_tables/study.py"} <= HOUSE.keys()


# Every law can fail: its function, a file, what stands in it, and a word of the message.
BAD = [
    (rules.open_side_doors, "workbench/study/study.py", "import control", "one door"),
    (rules.open_side_doors, "workbench/study/study.py", "def f():\n    from control import ss", "study.py:2:"),
    (rules.open_side_doors, "workbench/report/html_page.py", "import matplotlib.pyplot as plt", "figures/"),
    (rules.open_side_doors, "studies/a9.py", "from rich.progress import Progress", "cli/progress.py"),
    (rules.open_side_doors, "workbench/design/x.py", "import SALib", "uncertainty/sobol_indices.py"),
    (code.long_files, "workbench/a.py", "x = 1\n" * 301, "301"),
    (code.long_functions, "workbench/a.py", "def f():\n" + "    x = 1\n" * 50, "51"),
    (code.long_functions, "workbench/a.py", f"def f():\n{SHOWN}" + "    x = 1\n" * 48, "51"),
    (code.banned_calls, "workbench/a.py", "class A(B):\n    def f(self): super().f()", "a.py:2: no `super"),
    (code.banned_calls, "workbench/a.py", "print('x')", "print"),
    (code.banned_calls, "workbench/a.py", "eval('x')", "eval"),
    (code.banned_calls, "workbench/a.py", "exec('x')", "exec"),
    (code.banned_calls, "workbench/a.py", "import pickle", "pickle"),
    (code.banned_calls, "workbench/a.py", "from pickle import loads", "pickle"),
    (code.banned_calls, "workbench/a.py", "def f():\n    import random", "a.py:2:"),
    (code.banned_calls, "workbench/a.py", "import sympy\nsympy.sympify('x')", "sympify"),
    (code.banned_calls, "workbench/a.py", "from sympy import sympify", "sympify"),
    (code.banned_calls, "workbench/a.py", "import yaml\nyaml.load(f)", "safe_load"),
    (code.global_seeds, "workbench/a.py", "import numpy as np\nnp.random.seed(0)", "a.py:2:"),
    (code.global_seeds, "workbench/a.py", "import numpy as np\nnp.random.rand(3)", "hidden"),
    (code.global_seeds, "workbench/a.py", "import numpy\nnumpy.random.normal()", "hidden"),
    (code.global_seeds, "workbench/a.py", "rng = np.random.default_rng()", "cannot be repeated"),
    (rules.imports_of_studies, "studies/a1/b.py", "from workbench.study import Case", "import workbench as wb"),
    (rules.imports_of_studies, "studies/a1/b.py", "from workbench import Case", "import workbench as wb"),
    (rules.imports_of_studies, "studies/a1/b.py", "from studies.a2.c import d", "another study"),
    (rules.imports_of_studies, "studies/a1/b.py", "from studies import a2", "another study"),
    (rules.imports_of_studies, "studies/a1/b.py", "import jax", "no library of a study"),
    (rules.pools_in_studies, "studies/a.py", "from concurrent.futures import ThreadPoolExecutor", "works"),
    (rules.pools_in_studies, "studies/a.py", "def f():\n    import threading", "a.py:2:"),
    (code.cached_results, "studies/a.py", "@cache\ndef f(results: Results): ...", "works"),
    (code.cached_results, "studies/a.py", "@functools.lru_cache(maxsize=1)\ndef f(a, held: Results): ...", "a.py:2:"),
    (code.inherited_final_classes, "workbench/a.py", "class A: ...\nclass B(A): ...", "a.py:2:"),
    (code.inherited_final_classes, "workbench/a.py", "class A(Generic[T]): ...\nclass B(A[int]): ...", "final"),
    (words.tests_that_import_tests, "tests/core/test_a.py", "from tests.core.test_b import c", "tests/support"),
    (
        words.tests_that_import_tests,
        "tests/core/test_a.py",
        "def f():\n    import os, tests.core.test_b",
        "test_a.py:2:",
    ),
    (words.tests_that_import_tests, "tests/core/test_a.py", "from .test_b import (\n    c,\n)", "tests.core.test_b"),
    (words.tests_in_other_folders, "tests/test_a.py", "", "folder of its room"),
    (words.words_of_arms, "workbench/engine/a.py", "x = 'the joint 1'", "a.py:1"),
    (words.words_of_arms, "workbench/study/a.py", "joints = 2", "any plant"),
    (words.question_openings, "workbench/a.py", '"""What marches."""', "What"),
    (words.question_openings, "workbench/a.py", 'x = 1\ndef f():\n    """Whether it holds."""', "Whether"),
    (words.foreign_text, "workbench/a.py", 'x = """\n#include <a.h>\n\n"""', "a.py:1: `#include`"),
    (words.foreign_text, "workbench/a.py", 'x = """\nconst a = 1;\n\n"""', "`templates`"),
    (code.mutable_dataclasses, "workbench/a.py", "@dataclass\nclass A: ...", "frozen"),
    (code.mutable_dataclasses, "workbench/a.py", "@dataclasses.dataclass(eq=False)\nclass A: ...", "frozen"),
]


@pytest.mark.parametrize(("law", "path", "text", "word"), BAD)
def test_every_law_can_fail(law, path, text, word):
    (breach,) = law({path: text})
    assert breach.startswith(f"{path}:")
    assert word in breach


@pytest.mark.parametrize(
    "import_back",
    [
        "from workbench.a import x",
        "def f():\n    import workbench.a",
        "if TYPE_CHECKING:\n    from workbench import a",
        "from . import a",
        "from .a import x",
    ],
)
def test_a_cycle_is_found_through_any_kind_of_import(import_back):
    (breach,) = rules.import_cycles({"workbench/a.py": "from workbench.b import y", "workbench/b.py": import_back})
    assert "workbench.a" in breach
    assert "workbench.b" in breach


def test_a_folder_without_init_is_found():
    (breach,) = words.folders_without_init(["workbench/__init__.py", "workbench/new/law.py"])
    assert breach.startswith("workbench/new/:")


GOOD = [
    "class AbstractA(ABC): ...\nclass B(AbstractA): ...",
    "class P(Protocol): ...\nclass B(P): ...",
    "class T(NamedTuple): ...\nclass B(T): ...",
    "class Refused(ValueError): ...\nclass Misspelt(Refused): ...",
    "@dataclass(frozen=True, eq=False)\nclass A: ...",
    "rng = np.random.default_rng(7)\nx: np.random.Generator = rng",
    "import control_of_something\nfunction.eval(x)\nre.compile('x')",
    "def f():\n" + "    x = 1\n" * 49,
]


@pytest.mark.parametrize("text", GOOD)
@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.__name__)
def test_no_law_forbids_what_the_house_allows(law, text):
    assert law({"workbench/a.py": text}) == []


# The contracts of import-linter, each broken in a copy of the house.
BROKEN = [
    ("core/ode.py", "import workbench.blocks.loop", "Floors"),
    ("core/ode.py", "def f():\n    import workbench.study.study", "Floors"),
    ("report/html_page.py", "import workbench.cli.command", "Floors"),
    ("engine/batch.py", "from workbench.arms.mechanics import paper_arm", "The wing"),
    ("study/case_runs.py", "def f():\n    from workbench.blocks import signals", "Hourglass"),
    ("engine/metrics/score.py", "from workbench.blocks.plants import DCMotor", "Hourglass"),
    ("study/case_runs.py", "from workbench.arms.mechanics import paper_arm", "The wing"),
    ("arms/laws/arm_pid.py", "from workbench.engine import simulate", "makers of equations never see"),
    ("new_room.py", "", "exhaustive"),
]


def test_a_contract_can_fail(tmp_path):
    assert BROKEN[0][2] in broken(tmp_path, BROKEN[:1])


@pytest.mark.heavy
def test_every_contract_can_fail(tmp_path):
    """All are broken at once; below the name of a contract stands each pair of modules that breaks it."""
    _, said = broken(tmp_path, BROKEN).split("\nBroken contracts\n")
    parts = re.split(r"\n(.+)\n-{3,}\n", said)
    below = dict(zip(parts[1::2], parts[2::2], strict=True))
    for file, text, word in BROKEN:
        module = f"workbench.{file.removesuffix('.py').replace('/', '.')}"
        pair = f"{module} -> {re.search(r'workbench[.a-z_]*', text)[0]}" if text else module.rpartition(".")[2]
        assert any(word in f"{name} {found}" and pair in found for name, found in below.items()), (pair, word)
