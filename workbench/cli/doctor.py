"""The verb `doctor`: packages, an evaluation, a rendered page, cores and disk of this machine."""

from __future__ import annotations

import os
import platform
import sys
from collections.abc import Callable
from functools import partial
from importlib.metadata import PackageNotFoundError, requires, version
from re import match
from shutil import disk_usage

import click

from workbench import __version__
from workbench.cli.errors import one_sentence

ENOUGH_DISK = 200 * 2**20  # bytes; a report takes less than ten million


@click.command()
def doctor() -> None:
    """Check that all the workbench needs is here and works."""
    with one_sentence():
        wrong = 0
        for name, check in _checks().items():
            try:
                word, state = "ok", check()
            except Exception as error:  # whatever it is, it is what the doctor was asked for
                word, state = "wrong", f"{type(error).__name__}: {' '.join(str(error).split())}"
                wrong = 1
            click.echo(f"{word:6} {name:18} {state}")
        sys.exit(wrong)


def _checks() -> dict[str, Callable[[], str]]:
    """The checks by name: each returns the state in words, or raises."""
    return {
        "control-workbench": partial(version, "control-workbench"),
        "python": platform.python_version,
        **{name: partial(version, name) for name in _needed()},
        "casadi evaluates": _casadi_evaluates,
        "typst renders": _typst_renders,
        "control answers": _control_answers,
        "batch engine": _batch_engine,
        "cores": lambda: str(os.cpu_count()),
        "free disk": _free_disk,
    }


def _needed() -> list[str]:
    """The packages that the workbench declares as requirements; none if it is not installed."""
    try:
        lines = requires("control-workbench") or []
    except PackageNotFoundError:
        return []
    names = (match(r"[\w.-]+", line) for line in lines if "extra ==" not in line)
    return sorted(name.group() for name in names if name)


def _casadi_evaluates() -> str:
    import casadi as ca

    x = ca.SX.sym("x")
    slope = float(ca.Function("slope", [x], [ca.gradient(ca.sin(x), x)])(0.0))
    if slope != 1.0:
        raise ValueError(f"the derivative of sin at 0 is 1; got {slope!r}")
    return "the derivative of sin at 0 is 1"


def _typst_renders() -> str:
    from workbench.report.pdf import pdf
    from workbench.study.document.document import Colophon, Document

    page = pdf(Document("A page", "Does typst render?", "One page.", (), Colophon("workbench doctor", __version__)))
    if not page.startswith(b"%PDF"):
        raise ValueError("what came is no PDF")
    return f"one page of {len(page)} bytes"


def _control_answers() -> str:
    import casadi as ca
    import numpy as np

    from workbench.core import Entry, Layout, Ode
    from workbench.design import to_control

    states, t = Layout((Entry("x", np.array(1.0)),)), ca.SX.sym("t")
    x = states.symbols()
    rate = to_control(Ode.of("decay", states, Layout(), (t, x, ca.SX(0, 1)), {"x": -x}, {})).dynamics(0.0, [1.0], [])
    if rate != [-1.0]:
        raise ValueError(f"x' = -x has the rate -1 at x = 1; got {rate!r}")
    return "x' = -x has the rate -1 at x = 1"


def _batch_engine() -> str:
    from workbench.engine.kernel import cache

    try:
        from workbench.engine.kernel import llvm
    except ImportError:
        return "NumPy, as llvmlite is not here: some thirty times slower than compiled"
    rounding = "" if llvm.has_fma() else " in the portable arithmetic, as this processor has no fused multiply-add"
    place = cache.folder()
    kept = f"kept in {place}" if place else "compiled anew in every process, as their folder is off or not yours alone"
    return f"compiled{rounding}, {llvm.lanes()} runs a vector; kernels are {kept}"


def _free_disk() -> str:
    free = disk_usage(".").free
    if free < ENOUGH_DISK:
        raise OSError(f"{free / 2**20:.0f} MB are free in this folder; reports and trajectories need 200 MB")
    return f"{free / 2**30:.1f} GB in this folder"
