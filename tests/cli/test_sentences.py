"""What reaches the terminal: one sentence, in which nothing is left that a terminal would act upon."""

import sys

import pytest

from workbench.cli.command import main
from workbench.cli.errors import printable

ACTED_UPON = {
    "\x1b[31m": r"\x1b[31m",
    "\x07": r"\x07",
    "\r": r"\r",
    "\n": r"\n",
    "\x00": r"\x00",
    "\x9b2J": r"\x9b2J",  # what ESC [ is in one character
    "\u202e": r"\u202e",  # turns the direction of writing
    "\u2028": r"\u2028",
    "\udcff": r"\udcff",  # a byte of a file's name that is no UTF-8
}


@pytest.mark.parametrize(("raw", "shown"), ACTED_UPON.items())
def test_what_a_terminal_acts_upon_is_shown_escaped(raw, shown):
    assert printable(f"arm {raw}.tex") == f"arm {shown}.tex"


@pytest.mark.parametrize("text", ["θ₁ = q_1, größer als π/2", "α·β ≤ γ² „Prüfstand“", "", r"\theta C:\arm"])
def test_letters_of_all_scripts_stay(text):
    assert printable(text) == text


def test_what_is_printable_is_escaped_only_once():
    assert printable(printable("\x1b")) == printable("\x1b")


@pytest.mark.parametrize("raw", [raw for raw in ACTED_UPON if raw != "\x00"])
@pytest.mark.parametrize("call", [["verify", "{}", "--robot", "rr"], ["derive", "{}"], ["{}"], ["doctor", "--{}"]])
def test_an_argument_reaches_the_terminal_escaped(call, raw, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["workbench", *(part.format(f"arm{raw}") for part in call)])
    monkeypatch.setattr("signal.signal", lambda *_: None)  # pytest's own stay
    with pytest.raises(SystemExit) as left:
        main()
    said = capsys.readouterr().err
    assert left.value.code == 2
    assert said.count("\n") == 1
    assert said[:-1].isprintable()
