"""The programs that are printed of an arm: they run elsewhere and compute the same numbers."""

import ctypes
import json
import re
import shutil
import subprocess
import sys
from functools import cache

import numpy as np
import pytest

from tests.support.arms import random_arm
from tests.support.cases import heavy_but
from workbench.arms.dynamics import Dynamics
from workbench.arms.mechanics import SpatialArm, SpatialLink, paper_arm, robot
from workbench.arms.mechanics.arm_catalogue import planar
from workbench.cli.derive import text_of

# The bar: 1e-15 of the largest entry. The operations are the model's own, so in truth no bit differs.
SCALED = 1e-15

RUBBING = SpatialLink(
    "slide", 1.0, (0.1, 0.0, 0.2), (0.1, 0.0, 0.0, 0.1, 0.0, 0.1), joint="prismatic", viscous=0.3, coulomb=0.5
)
ARMS = {
    "paper-arm": paper_arm(),
    **{f"planar-{n}r": planar(n) for n in (1, 3, 6)},
    **{f"random-{n}r": random_arm(n, np.random.default_rng(n)) for n in (2, 4)},
    **{name: robot(name) for name in ("cart-pole", "scara", "ur5")},
    "rubbing": SpatialArm((RUBBING, SpatialLink("hinge", 2.0, (0.3, 0.1, 0.0), RUBBING.inertia, parent=0))),
}


@cache
def model_of(name):
    """The model of an arm, of which every language prints its program."""
    return Dynamics.of(ARMS[name], name) if name in ARMS else Dynamics.of(robot(name), name, symbolic=False)


COMPILER = shutil.which("cc")

PRINTS = """
import json, sys
import numpy as np
sys.path.insert(0, {folder!r})
import arm
rows = []
for state in json.loads({states!r}):
    q, qd, v, p = map({kind}, state)
    M, C, G = arm.dynamics(q, qd, p)
    answers = [M, C, G, arm.inverse_dynamics(q, qd, v, p), arm.forward_dynamics(q, qd, v, p)]
    rows.append([np.array(x).tolist() for x in answers])
print(json.dumps(rows))
"""


def states(model, count=20):
    """Random states, an acceleration or torque, and parameters near the nominal ones."""
    rng = np.random.default_rng(3)
    q, qd, v = rng.uniform(-1, 1, (3, count, model.dof)) * [[[3.0]], [[2.0]], [[10.0]]]
    return list(zip(q, qd, v, model.p.default * rng.uniform(0.9, 1.1, (count, model.p.size)), strict=True))


def in_python(model, form):
    """M, C, G, the inverse and the forward dynamics of a printed module, which imports nothing of the workbench."""
    text, arm = text_of(model, form), {}
    assert set(re.findall(r"^\s*(?:import|from) (\S+)", text, re.MULTILINE)) <= {"math", "struct", "numpy", "casadi"}
    exec(compile(text, "arm.py", "exec"), arm)
    rows = []
    for q, qd, v, p in states(model):
        q, qd, v, p = (x.tolist() for x in (q, qd, v, p))
        rows.append([*arm["dynamics"](q, qd, p), arm["inverse_dynamics"](q, qd, v, p)])
        rows[-1].append(arm["forward_dynamics"](q, qd, v, p))
    return [[np.squeeze(np.array(x)) for x in row] for row in rows]


def in_a_python_of_its_own(model, form, folder, kind="list"):
    """The same, from a process that has loaded nothing else."""
    (folder / "arm.py").write_text(text_of(model, form), encoding="utf-8")
    given = json.dumps([[x.tolist() for x in state] for state in states(model)])
    code = PRINTS.format(folder=str(folder), states=given, kind=kind)
    done = subprocess.run([sys.executable, "-W", "error", "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    return [[np.squeeze(np.array(x)) for x in row] for row in json.loads(done.stdout)]


def in_c(model, folder, optimized="-O1"):
    """The same of a printed C file, compiled as C99 and nothing else, warnings being errors."""
    (folder / "arm.c").write_text(text_of(model, "c"), encoding="utf-8")
    strict = ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", optimized, "-shared", "-fPIC"]
    subprocess.run([COMPILER, *strict, "arm.c", "-o", "arm.so"], cwd=folder, check=True, timeout=60)
    library = ctypes.CDLL(str(folder / "arm.so"))
    n = model.dof
    rows = []
    for q, qd, v, p in states(model):
        outs = [np.zeros(shape) for shape in ((n, n), (n, n), n, n, n)]
        call(library.workbench_dynamics, q, qd, p, *outs[:3])
        call(library.workbench_inverse_dynamics, q, qd, v, p, outs[3])
        call(library.workbench_forward_dynamics, q, qd, v, p, outs[4])
        rows.append([np.squeeze(x) for x in outs])
    return rows


def call(function, *arrays):
    doubles = ctypes.POINTER(ctypes.c_double)
    function(*(np.ascontiguousarray(x).ctypes.data_as(doubles) for x in arrays))


def check(model, rows):
    for (q, qd, v, p), (M, C, G, tau, qdd) in zip(states(model), rows, strict=True):
        ours = model.matrices(q, qd, p)
        for x, y in zip(ours, (M, C, G), strict=True):
            assert np.all(np.abs(y - np.squeeze(x)) <= SCALED * np.abs(x).max())
        size = np.abs(ours[0]) @ np.abs(v) + np.abs(ours[1]) @ np.abs(qd) + np.abs(ours[2])
        assert np.all(np.abs(model.torque(q, qd, v, p) - tau) <= SCALED * size.max())
        # a linear system, solved by another elimination: backward stable, so the residual is what must be small
        qdd = np.atleast_1d(qdd)
        residual = model.torque(q, qd, qdd, p) - v
        assert np.all(np.abs(residual) <= 20 * SCALED * (np.abs(ours[0]) @ np.abs(qdd) + size + np.abs(v)).max())


LONG = ("planar-6r", "random-4r", "ur5", "panda")  # which take seconds to be printed, or their C to be compiled
each = pytest.mark.parametrize("name", heavy_but([*ARMS, "panda"], *(name for name in ARMS if name not in LONG)))


@each
def test_the_python_agrees_with_the_model(name):
    check(model_of(name), in_python(model_of(name), "python"))


@each
def test_the_casadi_functions_agree_with_the_model(name):
    check(model_of(name), in_python(model_of(name), "casadi"))


@pytest.mark.parametrize("form", ["python", "casadi"])
def test_a_printed_module_runs_where_nothing_else_is_loaded(form, tmp_path):
    check(model_of("paper-arm"), in_a_python_of_its_own(model_of("paper-arm"), form, tmp_path))


@pytest.mark.parametrize("kind", ["tuple", "np.array"])
def test_printed_friction_takes_tuples_and_arrays_alike(kind, tmp_path):
    rubbing = model_of("rubbing")
    check(rubbing, in_a_python_of_its_own(rubbing, "python", tmp_path, kind))


@pytest.mark.skipif(COMPILER is None, reason="there is no C compiler `cc` here")
@each
def test_the_c_compiles_without_a_warning_and_agrees_with_the_model(name, tmp_path):
    # the compiler takes three seconds to optimize a long file, which is made of the same lines as the short ones
    check(model_of(name), in_c(model_of(name), tmp_path, "-O0" if name in LONG else "-O1"))
