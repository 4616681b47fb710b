"""Texts from outside in C: docstrings, names, units and notes that would mean something to a compiler."""

import subprocess
from dataclasses import replace

import pytest

import workbench as wb
from tests.support.c_runs import COMPILERS, WARNINGS, needs_compiler
from tests.support.digital_laws import motor_law
from workbench.handover.c99.c_files import c_code
from workbench.handover.c99.c_names import comment

STRICT = (*WARNINGS, "-trigraphs", "-Wtrigraphs", "-Wcomment")
TEXTS = (
    "what is it??/",
    "what is it??/\n int evil;",
    "*??/\n/ int evil; /*",
    "????/ ??= ??( ??) ??' ??< ??> ??! ??-",
    "ends with a backslash \\",
    "ends with one \\\n and goes on",
    "ends with one and a blank \\ \nand goes on",
    "/*/ */ /* // *\\/",
    "\u202eturned\u2066 \u2028 and \x00 \x1b[31m \x7f",
    "a\ttab\r\nand lines\f\v",
    "\udcff no letter",
    "öö/ \u00a0 π ≤ θ",
    "/",
    "*",
)


def law_with(text):
    """A law whose equations, notes, title and signals have this text."""
    law = motor_law().law()
    stages = tuple(
        replace(stage, title=f"Law: {text}", equations=f"{text}\n\n    u = K y   {text}") for stage in law.stages
    )
    return replace(law, stages=stages, notes=(text,))


@pytest.mark.parametrize("text", TEXTS, ids=range(len(TEXTS)))
def test_a_text_joins_no_lines_and_ends_no_comment(text):
    plain = comment(text)
    assert "??" not in plain
    assert "*/" not in plain
    assert "/*" not in plain
    assert not any(line.endswith("\\") for line in plain.split("\n"))
    assert all(c.isprintable() or c == "\n" for c in plain)


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """The sources of laws with these texts, as code and as exports."""
    folder = tmp_path_factory.mktemp("texts")
    kept = [text for text in TEXTS if "\udcff" not in text]
    for i, text in enumerate(kept):
        c_code(law_with(text), "law", warnings=(text,), command=text).write(folder / str(i))
    wb.export(law_with(" ".join(kept)), "c", folder / "all", name="other", warnings=tuple(kept))
    return sorted(folder.glob("*/*.c"))


@needs_compiler
@pytest.mark.parametrize("compiler", COMPILERS)
def test_no_compiler_warns_of_a_text_with_trigraphs_on(compiler, written):
    assert len(written) == len(TEXTS)  # all but one, and all of them in an export
    subprocess.run([compiler, *STRICT, "-fsyntax-only", *written], check=True, timeout=60)


def test_common_letters_stay():
    text = "K_p (b r - y) + I,  θ ≤ π/2, 100 % of 3*x/y; what?"
    assert comment(text) == text
