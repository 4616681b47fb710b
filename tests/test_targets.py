"""Targets: what a law takes of them, and what is said of those that fail."""

import pytest
from browsers import needs_node
from compilers import needs_llvmlite
from targets_here import needs_aarch64, needs_clang, needs_cortex_m, needs_gcc, needs_valgrind
from test_c_code import motor_law

from workbench.handover.c_code import c_code
from workbench.handover.recording import record
from workbench.handover.replays import compare
from workbench.handover.targets import TARGETS
from workbench.handover.targets.compilers import CompiledProgram
from workbench.handover.targets.programs import TargetError, run
from workbench.handover.targets.size import code_and_data, deepest


def result_of(target, periods=200):
    """A law of a motor on a target."""
    sampled = motor_law()
    law = sampled.law()
    return compare(target, c_code(law, "law"), record(sampled, law, periods))


@needs_clang
def test_clang_gives_the_same_bits_and_its_stack_is_not_told():
    result = result_of(TARGETS["clang-O2"])
    assert result.equal
    assert result.figures.stack is None
    assert result.figures.smallest > 0
    assert result.figures.data == 0  # all that changes is its owner's


@needs_node
@needs_llvmlite
def test_the_engine_of_a_browser_gives_the_same_bits():
    assert result_of(TARGETS["browser"]).equal


@needs_gcc
@needs_valgrind
def test_optimised_code_takes_fewer_instructions_and_less_stack():
    plain, fast = (result_of(TARGETS[key]).figures for key in ("gcc-O0", "gcc-O2"))
    assert plain.instructions > 1.5 * fast.instructions > 30
    assert plain.stack > fast.stack
    assert plain.code > fast.code


@needs_aarch64
def test_instructions_of_64_bit_arm_are_about_those_of_this_processor():
    figures = result_of(TARGETS["arm64"]).figures
    assert 30 < figures.instructions < 1000


@needs_cortex_m
def test_a_processor_without_doubles_takes_many_more_instructions():
    m4, m7 = (result_of(TARGETS[key]).figures for key in ("cortex-m4f", "cortex-m7"))
    assert m4.instructions > 5 * m7.instructions > 100
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
