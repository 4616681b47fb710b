"""The files of C from which a law takes its primitives: C as they stand, without a warning."""

import subprocess

import pytest

from tests.support.c_runs import COMPILERS, WARNINGS, needs_compiler
from workbench.engine.machines.c_primitives import FOLDER, HARDWARE, PRIMITIVES, numbers_of, primitive
from workbench.engine.machines.c_real import DOUBLE, SINGLE

FILES = ("c_primitives.c", "c_library.c")


@needs_compiler
@pytest.mark.parametrize("real", [DOUBLE, SINGLE], ids=["double", "single"])
@pytest.mark.parametrize("compiler", COMPILERS)
def test_a_file_of_primitives_is_c_as_it_stands(compiler, real, tmp_path):
    words = numbers_of(real) | {"sqrt_MARK": f"sqrt{real.mark}", "fma_MARK": f"fma{real.mark}"}
    head = ["#include <math.h>", "#include <stdbool.h>", "#include <stdint.h>"]
    head += [f"#define {word} {text}" for word, text in words.items()]
    (tmp_path / "words.h").write_text("\n".join([*head, ""]))
    for file in FILES:
        line = [compiler, *WARNINGS, "-Wno-unused-function", "-include", "words.h", "-c", FOLDER / file, "-o", "f.o"]
        subprocess.run(line, cwd=tmp_path, check=True, timeout=60)


def test_each_paragraph_of_the_files_is_a_primitive():
    paragraphs = "\n\n".join((FOLDER / file).read_text(encoding="utf-8").strip() for file in FILES).split("\n\n")
    assert len(paragraphs) == len(FILES) + len(PRIMITIVES) + len(HARDWARE)  # each file begins with a comment


def test_no_placeholder_is_left_in_a_primitive():
    for name in (*PRIMITIVES, *HARDWARE):
        text = primitive("law", SINGLE, name, HARDWARE)
        assert f"law_{name}f(" in text
        assert not any(word in text for word in ("NAME", "MARK", "REAL", "WORD")), text
