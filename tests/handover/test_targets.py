"""Targets: what a law takes of them, and what is said of those that fail."""

import numpy as np
import pytest

from tests.support.digital_laws import motor_law
from tests.support.targets_here import needs_aarch64, needs_clang, needs_cortex_m, needs_gcc, needs_valgrind
from workbench.handover.bit_comparison import compare
from workbench.handover.c99.c_files import c_code
from workbench.handover.recording import record
from workbench.handover.targets import TARGETS, cortex_m, harness
from workbench.handover.targets.binary_size import code_and_data, deepest
from workbench.handover.targets.compilers import CompiledProgram
from workbench.handover.targets.external_programs import TargetError, run
from workbench.handover.targets.soft_doubles import SOFT_DOUBLES_FILE, WRAPS, soft_doubles


def result_of(target, periods=200):
    """A law of a motor on a target."""
    sampled = motor_law()
    law = sampled.law()
    return compare(target, c_code(law, "law"), record(sampled, law, periods))


@needs_clang
@pytest.mark.heavy
def test_clang_gives_the_same_bits_and_its_stack_is_not_told():
    result = result_of(TARGETS["clang-O2"])
    assert result.equal
    assert result.figures.stack is None
    assert result.figures.smallest > 0
    assert result.figures.data == 0  # all that changes is its owner's


@pytest.mark.heavy
@needs_gcc
@needs_valgrind
def test_optimised_code_takes_fewer_instructions_and_less_stack():
    plain, fast = (result_of(TARGETS[key]).figures for key in ("gcc-O0", "gcc-O2"))
    assert plain.instructions > 1.5 * fast.instructions > 30
    assert plain.stack > fast.stack
    assert plain.code > fast.code


@pytest.mark.heavy
@needs_aarch64
def test_instructions_of_64_bit_arm_are_about_those_of_this_processor():
    figures = result_of(TARGETS["arm64"]).figures
    assert 30 < figures.instructions < 1000


@needs_cortex_m
@pytest.mark.heavy
def test_a_processor_without_doubles_takes_many_more_instructions():
    m4, m7 = (result_of(TARGETS[key]).figures for key in ("cortex-m4f", "cortex-m7"))
    assert m4.instructions > 4 * m7.instructions > 100
    assert m4.stack < m4.touched < 4096  # routines for doubles are in the second alone


GRAPH = """graph: {{ title: "law.c"
node: {{ title: "law_step" label: "law_step\\nlaw.c:9:5\\n{outer} bytes (static)\\n0 dynamic objects" }}
node: {{ title: "law.c:turn" label: "turn\\nlaw.c:3:5\\n32 bytes ({kind})\\n0 dynamic objects" }}
node: {{ title: "law.c:flat" label: "flat\\nlaw.c:5:5\\n8 bytes (static)\\n0 dynamic objects" }}
node: {{ title: "__aeabi_dadd" label: "__aeabi_dadd\\n<built-in>" shape : ellipse }}
edge: {{ sourcename: "law_step" targetname: "law.c:turn" }}
edge: {{ sourcename: "law_step" targetname: "law.c:flat" }}
edge: {{ sourcename: "law.c:turn" targetname: "{below}" }}
}}
"""


@pytest.mark.parametrize(
    ("kind", "below", "depth"),
    [("static", "__aeabi_dadd", 132), ("static", "law.c:flat", 140), ("static", "law_step", None)]
    + [("dynamic", "law.c:flat", None), ("dynamic,bounded", "law.c:flat", 140)],
)
def test_the_stack_is_that_of_the_deepest_chain_and_has_no_bound_in_a_recursion(kind, below, depth, tmp_path):
    (tmp_path / "law.ci").write_text(GRAPH.format(outer=100, kind=kind, below=below), encoding="utf-8")
    assert deepest(tmp_path / "law.ci", "law_step") == depth
    assert deepest(tmp_path / "law.ci", "other_step") is None


def test_the_sizes_of_an_object_are_read_from_its_list():
    assert code_and_data("   text\t   data\t    bss\n   4870\t      8\t     16\n") == (4870, 24)


@needs_gcc
def test_a_compiler_that_fails_is_said_in_a_row_with_its_own_words():
    result = result_of(CompiledProgram("fast", "gcc", ("-ffast-math",)))
    assert not result.ran
    assert "compile it without -ffast-math" in result.reason


def test_a_program_is_ended_when_its_time_is_over(tmp_path):
    with pytest.raises(TargetError, match=r"sleep took longer than 0\.2 s"):
        run(["sleep", "20"], tmp_path, 0.2)
    with pytest.raises(TargetError, match="no-such-program cannot be started"):
        run(["no-such-program"], tmp_path, 1.0)


SUMS = """
#include "platform.h"
static double in[512][2], out[512][2];
int main(void)
{
    uint64_t left;
    int i;
    platform_start();
    for (platform_read(&left, sizeof left); left > 0; left--) {
        platform_read(in, sizeof in);
        for (i = 0; i < 512; i++) {
            out[i][0] = in[i][0] + in[i][1];
            out[i][1] = in[i][0] - in[i][1];
        }
        platform_write(out, sizeof out);
    }
    platform_end();
    return 0;
}
"""


def sums_of(pairs, folder, exact):
    """Sums and differences of pairs (512 n, 2) of doubles on a Cortex-M4F."""
    texts = {"main.c": SUMS, **cortex_m.board_files(), harness.HEADER: harness.platform_header()}
    texts[SOFT_DOUBLES_FILE] = soft_doubles()
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")
    files = ["main.c", "platform.c", *([SOFT_DOUBLES_FILE, *WRAPS] if exact else [])]
    bare = ["-nostartfiles", "-T", cortex_m.LAYOUT, "-Wconversion", "-Werror", "-o", cortex_m.PROGRAM]
    run(["arm-none-eabi-gcc", *cortex_m.STANDARD, *cortex_m.M4F, *files, *bare], folder, 60)
    (folder / "inputs").write_bytes(np.uint64(len(pairs) // 512).tobytes() + pairs.tobytes())
    cortex_m.CORTEX_M4F.emulate(folder, 60)
    return np.fromfile(folder / "answers").reshape(-1, 2)


def pairs_of(count, apart):
    """Pairs of doubles whose exponents differ by so much, many of them next to a power of two; subnormal ones too."""
    rng = np.random.default_rng(3)
    fields = rng.integers(1, 1900, count)
    fields[: count // 8] = 1  # and 0: the exponents of both are the least one
    small, big = rng.integers(0, 2**52, (2, count)), fields + apart
    big_fraction = np.where(rng.random(count) < 0.5, small[1] & 0xFFFFF, 0)
    small_fraction = np.where(rng.random(count) < 0.3, small[0] & ~0x7FFFFF, small[0])
    fields[: count // 16] = 0
    signs = rng.integers(0, 2, (2, count)) << 63
    words = [(big << 52) | big_fraction | signs[0], (fields << 52) | small_fraction | signs[1]]
    return np.stack(words, axis=1).view(float)[:, rng.permutation(2)]


@needs_cortex_m
def test_sums_of_soft_doubles_are_those_of_ieee_754(tmp_path):
    pairs = np.concatenate([pairs_of(20 * 512, apart) for apart in (0, 1, 32, 33, 34, 35, 53)])
    wanted = np.stack([pairs[:, 0] + pairs[:, 1], pairs[:, 0] - pairs[:, 1]], axis=1)
    (tmp_path / "exact").mkdir()
    assert (sums_of(pairs, tmp_path / "exact", exact=True) == wanted).all()
    (tmp_path / "libgcc").mkdir()
    wrong = (sums_of(pairs, tmp_path / "libgcc", exact=False) != wanted).any(axis=1)
    apart = np.abs(np.diff(np.maximum(pairs.view(np.uint64) >> np.uint64(52) & np.uint64(0x7FF), 1).astype(int)))[:, 0]
    assert set(apart[wrong]) <= {33}  # none at all, once GCC's library rounds them
