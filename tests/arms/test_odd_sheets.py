"""Whatever is in a file, `workbench verify` ends with a verdict or with one sentence; ODD_SHEETS=3000 tries so many."""

import os
import random
import sys
import time
from pathlib import Path

import pytest

from tests.support.cases import heavy_but
from tests.support.odd_sheets import sheet
from workbench.cli import command, verify

COUNT, LOTS = int(os.environ.get("ODD_SHEETS", "24")), 4
LONGEST, SECONDS = 600, 90  # letters of a refusal; processor time after which a sheet counts as never ending


@pytest.mark.parametrize("lot", heavy_but(range(LOTS), 0))
def test_a_sheet_that_nobody_would_print_gets_a_verdict_or_one_sentence(command, tmp_path, monkeypatch, lot):
    arm = verify.arm_of("paper-arm")
    monkeypatch.setattr(verify, "arm_of", lambda robot: arm)
    for seed in range(lot, COUNT, LOTS):
        name, content = sheet(seed)
        (tmp_path / name).write_bytes(content)
        start = time.process_time()
        done = command("verify", name, "--robot", "paper-arm")
        assert done.exception is None or isinstance(done.exception, SystemExit), seed
        assert time.process_time() - start < SECONDS, seed
        assert all(line.isprintable() for line in done.output.split("\n")), seed
        if done.exit_code == 2:
            assert done.stdout == "", seed
            assert done.stderr.startswith(f"workbench: {name}: "), seed
            assert done.stderr.count("\n") == 1, seed
            assert len(done.stderr) < LONGEST, seed
        else:
            assert done.exit_code in (0, 1), seed
            assert done.stderr == "", seed


@pytest.mark.parametrize(
    "name", ["folder", "pipe", "pipe.urdf", "circle", "nowhere", "a" * 5000, "/dev/zero", "\udcff"]
)
@pytest.mark.parametrize(
    "call", [["verify", "{}", "--robot", "paper-arm"], ["verify", "good", "--robot", "{}"], ["derive", "{}"]]
)
def test_what_is_no_file_is_refused_at_once(command, tmp_path, name, call):
    (tmp_path / "folder").mkdir()
    os.mkfifo(tmp_path / "pipe")
    os.mkfifo(tmp_path / "pipe.urdf")
    (tmp_path / "circle").symlink_to("circle")
    (tmp_path / "good").write_text("M_22 = m_2*l_2^2", encoding="utf-8")
    done = command(*(part.format(name) for part in call))
    assert (done.exit_code, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert done.stderr[:-1].isprintable()


@pytest.mark.skipif(not Path("/proc/self/pagemap").exists(), reason="a file without an end is looked for in /proc")
def test_a_file_without_an_end_is_read_to_the_most_that_is_allowed(command):
    done = command("verify", "/proc/self/pagemap", "--robot", "paper-arm")
    assert "equations take at most 50000 characters; this file has more" in done.stderr


WORDS = ["derive", "doctor", "good.txt", "nowhere.txt", "paper-arm", "paperarm", "--robot", "--format", "--numbers"]
WORDS += [
    "--help",
    "--robot=",
    "--format=c",
    "--format=x",
    "--only",
    "--xyz",
    "-h",
    "--",
    "-",
    "--=",
    "text",
    "latex",
    "",
]
WORDS += ["\x1b[2J", "--\x9b", "\u202e", "\udcff", "../x", "~", "$(id)", "%s", "{}", "-1", "1e999", "a\nb", "x" * 3000]


@pytest.mark.parametrize("lot", heavy_but(range(LOTS), 0))
def test_an_odd_command_line_is_carried_out_or_refused_in_one_sentence(tmp_path, monkeypatch, capsys, lot):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("signal.signal", lambda *_: None)  # pytest's own stay
    (tmp_path / "good.txt").write_text("M_22 = m_2*l_2^2", encoding="utf-8")
    dice = random.Random(lot)
    for _ in range(COUNT // LOTS):
        words = [dice.choice(("verify", "derive")), *dice.choices(WORDS, k=dice.randrange(5))]
        monkeypatch.setattr(sys, "argv", ["workbench", *words])
        with pytest.raises(SystemExit) as left:
            command.main()
        printed, said = capsys.readouterr()
        assert all(line.isprintable() for line in (printed + said).split("\n")), words
        if left.value.code == 2:
            assert (printed, said.count("\n")) == ("", 1), words
        else:
            assert (left.value.code in (0, 1), said) == (True, ""), words
