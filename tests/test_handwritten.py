"""The law of a1 written in C by hand is the same law, so that it may be the peer of the generated code."""

import ctypes
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from studies.paper.laws import proposed_repaired

HANDWRITTEN = Path(__file__).parent.parent / "studies/performance/handwritten"
needs_gcc = pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed: apt-get install gcc")


@pytest.fixture(scope="module")
def peer(tmp_path_factory):
    library = tmp_path_factory.mktemp("handwritten") / "peer.so"
    warnings = "-Wall -Wextra -Wconversion -Wshadow -Wpedantic -Werror".split()
    command = ["gcc", "-std=c99", "-O2", *warnings, "-shared", "-fPIC", HANDWRITTEN / "aosmc_rgs.c", "-o", library, "-lm"]
    subprocess.run(command, check=True, timeout=60)
    return ctypes.CDLL(str(library))


def rows_to_columns(z):
    """The memory with K and P row by row, as C has them, column by column, as CasADi has them, and back."""
    return np.concatenate([z[:6], z[6:10].reshape(2, 2).T.ravel(), z[10:].reshape(2, 2).T.ravel()])


@needs_gcc
def test_the_law_written_by_hand_is_the_law(peer):
    law = proposed_repaired("FS").digital(1e-3).law(truths=("d",))
    number = ctypes.c_double
    state = (number * 14)()
    peer.aosmc_init(state)
    np.testing.assert_array_equal(rows_to_columns(np.array(state)), law.memory.default)
    random = np.random.default_rng(6)
    for _ in range(200):
        z, y, r = law.memory.default + random.normal(size=14), random.normal(size=4), random.normal(size=6)
        state, tau = (number * 14)(*rows_to_columns(z)), (number * 2)()
        peer.aosmc_step(state, (number * 4)(*y), (number * 6)(*r), tau)
        want_z, want_u = law.F(0, z, y, r, law.parameters.default)
        np.testing.assert_allclose(rows_to_columns(np.array(state)), np.array(want_z).ravel(), rtol=1e-10, atol=1e-10)
        np.testing.assert_allclose(np.array(tau), np.array(want_u).ravel(), rtol=1e-10, atol=1e-10)
