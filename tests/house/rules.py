"""The laws of the house that a machine can hold, each a function from sources to what breaks it.

Sources are a mapping of paths, as in "workbench/core/ode.py", to text, so that every rule can be shown
a small piece of bad code. A breach names file, line, rule, and what to do.
"""

from __future__ import annotations

import graphlib
import sys

from tests.house.sources import (
    Sources,
    imports,
    module_of,
)

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
    "mcap": "identification/datasets/mcap_reader.py",
    "mcap_ros2": "identification/datasets/mcap_reader.py",
    "pyulog": "identification/datasets/ulog_reader.py",
    "rich": "cli/progress.py",
    "SALib": "study/uncertainty/sobol_indices.py",
    "threadpoolctl": "design/matrices.py",
    "typst": "report/pdf.py",
}

# The bench measures python-control as its users call it, and not what the door makes of it; so does a reader's own law.
# And d1 makes the systems that its designs are given, as a user of `wb.tune_pid` does.
BESIDE_THE_DOOR = {
    ("control", "studies/performance/peers.py"),
    ("control", "studies/own_law.py"),
    ("control", "studies/d1_benchmarks/linear_systems.py"),
}

# A study has the workbench by its face alone; but these measure the time of its inner parts, each by itself.
INNER_PARTS = {"studies/performance/inner_parts.py", "studies/b2_sobol_cost/inner_parts.py"}
BESIDE_STUDIES = {"studies", "workbench", "numpy", "casadi", "scipy"}

# Peers against which a study holds the workbench; those of `studies/performance` are many.
PEERS = {
    "studies/own_law.py": {"control"},
    "studies/d1_benchmarks/linear_systems.py": {"control"},
    "studies/b0_robots/sympy_chain.py": {"sympy"},
    "studies/b0_robots/mujoco_arm.py": {"mujoco"},
    "studies/b4_handover/osqp_code.py": {"osqp"},
}
OF_ANOTHER_STUDY = "`{}` is of another study; what two share is the workbench's, or the paper's in studies/paper."
POOLS = {"asyncio", "concurrent", "joblib", "multiprocessing", "threading"}  # what a study declares as `works` instead


def open_side_doors(held: Sources) -> list[str]:
    """Libraries that are imported elsewhere than at their door."""
    breaches = []
    for path, text in held.items():
        for line, module, _ in imports(path, text):
            library = module.partition(".")[0]
            door = f"workbench/{DOORS.get(library, '')}"
            inside = path.startswith(door) if door.endswith("/") else path == door
            inside = inside or (library, path) in BESIDE_THE_DOOR
            if library in DOORS and not inside:
                breaches.append(f"{path}:{line}: {library} has one door, {door}; call what that file offers.")
    return breaches


def import_cycles(held: Sources) -> list[str]:
    """Modules that import each other, by any kind of import; a parent package's own import does not count."""
    modules = {module_of(path): path for path in held}
    graph: dict[str, set[str]] = {}
    for path, text in held.items():
        me = module_of(path)
        for _, module, name in imports(path, text):
            target = f"{module}.{name}" if f"{module}.{name}" in modules else module
            if target in modules and target != me:
                graph.setdefault(me, set()).add(target)
    try:
        graphlib.TopologicalSorter(graph).prepare()
    except graphlib.CycleError as error:
        ring = " <- ".join(error.args[1])
        return [f"{modules[error.args[1][0]]}: modules import each other, {ring}; move what both need a floor down."]
    return []


def pools_in_studies(held: Sources) -> list[str]:
    """Studies that run something beside themselves, out of sight of ledger, estimate and Ctrl-C."""
    return [
        f"{path}:{line}: a study imports no {module}; declare what it computes as `Study(works=...)`."
        for path, text in held.items()
        if path.startswith("studies/")
        for line, module, _ in imports(path, text)
        if module.partition(".")[0] in POOLS
    ]


def imports_of_studies(held: Sources) -> list[str]:
    """Imports of a study beyond `wb`, its own folder, `studies.paper`, Python's own library and three more."""
    breaches = []
    for path, text in held.items():
        if not path.startswith("studies/"):
            continue
        own = ".".join(path.removesuffix(".py").split("/")[:2])
        for line, module, name in imports(path, text):
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
