"""The study of measured logs: what it reads, what it refuses, and what its fits reach on logs that they did not see."""

import os
from pathlib import Path

import pytest

from studies.c1_real_logs import logs, pendulum, positioning

FOLDER = Path(os.environ.get("LOGS") or Path(__file__).parents[3] / "shared" / "data")
needs_logs = pytest.mark.skipif(not FOLDER.is_dir(), reason="needs the measured logs beside the repository")


@pytest.fixture(autouse=True)
def folder(monkeypatch):
    """The folder beside the repository, whatever LOGS says."""
    paths, wrong = logs.read_folder(str(FOLDER))
    monkeypatch.setattr(logs, "PATHS", paths)
    monkeypatch.setattr(logs, "WRONG", wrong)
    for name, file in logs.MODELS.items():
        if file in paths:
            monkeypatch.setitem(logs.PUBLISHED_MODELS, name, logs.read_model(paths[file]))


def test_a_log_that_is_not_there_is_named_with_its_source(monkeypatch):
    monkeypatch.setattr(logs, "PATHS", logs.read_folder("")[0])
    with pytest.raises(FileNotFoundError, match=r"make reports LOGS=FOLDER.*commit 947f1c5edd3f"):
        logs.log_path(logs.EXCITATIONS[0])


def test_a_log_with_other_bytes_is_refused(monkeypatch, tmp_path):
    path = tmp_path / logs.TANKS
    path.parent.mkdir()
    path.write_text("uEst\n1\n", encoding="utf-8")
    paths, wrong = logs.read_folder(str(tmp_path))
    assert paths == {}
    monkeypatch.setattr(logs, "WRONG", wrong)
    with pytest.raises(ValueError, match="with the SHA-256 ef2388"):
        logs.log_path(logs.TANKS)


@needs_logs
def test_an_excitation_that_was_held_out_is_nearer_than_in_all_published_models():
    one = pendulum.fold(logs.EXCITATIONS[1])
    assert [one.beaten(joint) for joint in range(2)] == [3, 3]
    assert one.condition < 10
    assert one.distance < 0.1  # standard errors to rigid bodies


@needs_logs
def test_each_log_of_the_other_design_alone_is_refused_by_name():
    first, second = map(pendulum.refusal_of, logs.POOR_LOGS)
    assert "No rigid body has these numbers" in first
    assert "which was held out, the model explains less than a constant" in second


@needs_logs
def test_mass_and_frictions_of_the_carriage_are_the_published_ones_to_one_per_cent():
    found = positioning.by_inverse_dynamics()
    for word in positioning.PUBLISHED:
        assert found.values[word] == pytest.approx(positioning.PUBLISHED[word], rel=0.01), word
