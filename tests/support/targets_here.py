"""The marks of tests that need a program of Debian, each named in what is said of a skipped one."""

import pytest

from workbench.handover.targets.external_programs import missing_programs


def needs(*programs):
    """The mark of a test that needs programs."""
    return pytest.mark.skipif(bool(missing_programs(programs)), reason=missing_programs(programs))


needs_gcc = needs("gcc")
needs_clang = needs("clang")
needs_cortex_m = needs("arm-none-eabi-gcc", "qemu-system-arm")
needs_aarch64 = needs("aarch64-linux-gnu-gcc", "qemu-aarch64")
needs_cppcheck = needs("cppcheck")
needs_valgrind = needs("valgrind")
