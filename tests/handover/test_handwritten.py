"""The law of a1 written in C by hand is the same law, so that it may be the peer of the generated code."""

import ctypes
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest

from studies.paper.laws import proposed_repaired
from tests.support.targets_here import needs_gcc, needs_valgrind
from workbench.handover.c99.c_files import c_code

HANDWRITTEN = Path(__file__).parents[2] / "studies/performance/handwritten"

MOST_INSTRUCTIONS, MOST_STACK = 1.5, 4096  # of those of the law written by hand; bytes


PERIODS = """
#include <stdlib.h>
#include "{name}.h"
int main(int count, char **texts)
{{
    const long periods = count > 1 ? strtol(texts[1], NULL, 10) : 0;
    {name}_state state;
    {name}_readings y = {{{{0.1, 0.2}}, {{0.3, 0.4}}}};
    {name}_references r = {{{{0.5, 0.1}}, {{0.2, 0.3}}, {{0.1, 0.1}}}};
    {commands};
    {name}_init(&state);
    for (long i = 0; i < periods; ++i)
        {name}_step(&state, &y, &r, {address});
    return 0;
}}
"""


def instructions_of_a_period(source, include, name, commands, address, folder):
    """The instructions of a period, compiled by gcc -O2 and counted by callgrind."""
    main, program = folder / f"{name}_main.c", folder / name
    main.write_text(PERIODS.format(name=name, commands=commands, address=address), encoding="utf-8")
    flags = ["-std=c99", "-O2", f"-I{include}"]
    subprocess.run(["gcc", *flags, main, source, "-o", program, "-lm"], check=True, timeout=60)
    counts = []
    for periods in (100, 1100):
        command = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={folder / 'out'}", program, str(periods)]
        told = subprocess.run(command, check=True, timeout=60, capture_output=True, text=True).stderr
        counts.append(int(re.search(r"Collected : (\d+)", told)[1]))
    return (counts[1] - counts[0]) / 1000


@pytest.fixture(scope="module")
def peer(tmp_path_factory):
    library = tmp_path_factory.mktemp("handwritten") / "peer.so"
    warnings = ("-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Wpedantic", "-Werror")
    command = [
        "gcc",
        "-std=c99",
        "-O2",
        *warnings,
        "-shared",
        "-fPIC",
        HANDWRITTEN / "aosmc_rgs.c",
        "-o",
        library,
        "-lm",
    ]
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
    peer.aosmc_rgs_init(state)
    np.testing.assert_array_equal(rows_to_columns(np.array(state)), law.memory.default)
    random = np.random.default_rng(6)
    for _ in range(200):
        z, y, r = law.memory.default + random.normal(size=14), random.normal(size=4), random.normal(size=6)
        state, tau = (number * 14)(*rows_to_columns(z)), (number * 2)()
        peer.aosmc_rgs_step(state, (number * 4)(*y), (number * 6)(*r), tau)
        want_z, want_u = law.F(0, z, y, r, law.parameters.default)
        np.testing.assert_allclose(rows_to_columns(np.array(state)), np.array(want_z).ravel(), rtol=1e-10, atol=1e-10)
        np.testing.assert_allclose(np.array(tau), np.array(want_u).ravel(), rtol=1e-10, atol=1e-10)


@pytest.mark.heavy
@needs_gcc
@needs_valgrind
def test_the_generated_law_takes_little_more_than_the_law_written_by_hand(tmp_path):
    code = c_code(proposed_repaired("FS").digital(1e-3).law(truths=("d",)), "generated")
    code.write(tmp_path)
    ours = instructions_of_a_period(
        tmp_path / "generated.c", tmp_path, "generated", "generated_commands u", "&u", tmp_path
    )
    source = HANDWRITTEN / "aosmc_rgs.c"
    theirs = instructions_of_a_period(source, HANDWRITTEN, "aosmc_rgs", "double u[2]", "u", tmp_path)
    assert theirs > 300  # a period was counted, and not an empty loop
    assert ours <= MOST_INSTRUCTIONS * theirs


@needs_gcc
def test_the_generated_law_needs_little_stack(tmp_path):
    c_code(proposed_repaired("FS").digital(1e-3).law(truths=("d",)), "generated").write(tmp_path)
    command = ["gcc", "-std=c99", "-O2", "-fstack-usage", "-c", "generated.c", "-o", "generated.o"]
    subprocess.run(command, check=True, timeout=60, cwd=tmp_path)
    frames = [line.split("\t") for line in (tmp_path / "generated.su").read_text().splitlines()]
    assert {kind for *_, kind in frames} == {"static"}
    assert sum(int(size) for _, size, _ in frames) <= MOST_STACK
