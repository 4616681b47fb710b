"""The study of measured logs: what it reads, what it refuses, and what its fits reach on logs that they did not see."""

import os
from pathlib import Path

import numpy as np
import pytest

import workbench as wb
from studies.c1_real_logs import logs, nested_choice, pendulum, positioning
from studies.c1_real_logs.thin_summary import thin_out

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


def test_the_inner_logs_alone_choose_a_variant():
    rng = np.random.default_rng(0)
    tables = [rng.uniform(1.0, 2.0, (len(nested_choice.VARIANTS), len(names), 2)) for names in nested_choice.LEFT_OUT]
    before = nested_choice.choose(tables)
    for table, names in zip(tables, nested_choice.LEFT_OUT, strict=True):
        if len(names) == 1:
            table[7] = 1e-3  # the best by far on each hold-out
    after = nested_choice.choose(tables)
    assert [one.variant for one in after] == [one.variant for one in before]
    assert nested_choice.choose_by_all(tables) == nested_choice.VARIANTS[7]


def test_the_best_variant_of_the_inner_logs_is_chosen():
    tables = [np.ones((len(nested_choice.VARIANTS), len(names), 2)) for names in nested_choice.LEFT_OUT]
    held_out = logs.EXCITATIONS[2]
    for table, names in zip(tables, nested_choice.LEFT_OUT, strict=True):
        if len(names) == 2 and held_out in names:
            table[11, 1 - names.index(held_out)] = 0.5  # on the log beside the hold-out
    chosen = {one.name: one.variant for one in nested_choice.choose(tables)}
    assert chosen[logs.name_of(held_out)] == nested_choice.VARIANTS[11]


@pytest.mark.parametrize("has_load", [False, True])
def test_a_variant_predicts_the_torques_of_its_own_model(has_load):
    """Torques of rigid bodies with friction, in even proportion to the load if there is one, without noise."""
    t = np.arange(0.0, 6.0, 0.005)
    q = np.column_stack([np.sin(3 * t) + 0.4 * np.sin(7 * t), np.cos(4 * t)])
    motion = np.gradient(q, t, axis=0), np.gradient(np.gradient(q, t, axis=0), t, axis=0)
    variant = nested_choice.Variant(8.0, 0.1, 0.0, False, False, has_load, 1.15)
    one = wb.arms.log_regression.PreparedMotion(
        "a", t, q, *motion, np.zeros_like(q), np.zeros_like(q), np.ones(len(t), dtype=bool)
    )
    rows = nested_choice.rows_of(variant, one, nested_choice.bodies_of(one))
    theta = np.zeros(rows.columns.shape[2])
    theta[[1, 3, 5, 7, 8, 9, 10, 11, 12]] = 0.35, 0.12, 0.12, 0.02, 0.01, 0.03, 0.01, 0.08, 0.07
    tau = rows.columns @ theta / [1.0, variant.scale]
    known = nested_choice.Rows(rows.columns, tau, rows.weights)
    motions = {name: wb.arms.log_regression.PreparedMotion(name, t, q, *motion, tau, tau, one.weighs) for name in "ab"}
    errors = nested_choice.errors_of(variant, {"a": known, "b": known}, motions, ["b"])
    np.testing.assert_allclose(errors, 0.0, atol=1e-9)  # N m, of torques up to 4 N m: rounding of normal equations


@needs_logs
def test_the_published_controller_gives_the_logged_command_from_the_logged_readings():
    late, now = positioning.controller_errors()
    assert late < 0.005  # V: an encoder of 50 nm makes some 2 mV
    assert now > 0.05


@needs_logs
def test_a_log_that_the_fit_has_seen_is_predicted_better_than_the_same_log_held_out():
    file = logs.EXCITATIONS[1]
    log = pendulum.read(logs.EXCITATIONS)
    held_out = nested_choice.errors_in(log, [logs.name_of(file)], [nested_choice.USUAL])[0, 0]
    assert (nested_choice.errors_on(logs.log_path(file), nested_choice.USUAL) < held_out).all()


@needs_logs
@pytest.mark.release  # half a minute of CPU: all 24,841 samples count, as the mass rests on the edges of the reference
def test_output_errors_in_the_loop_give_the_published_numbers_to_one_per_cent():
    found = positioning.by_output_errors(has_free_delays=False)
    for word in positioning.PUBLISHED:
        assert found.values[word] == pytest.approx(positioning.PUBLISHED[word], rel=0.01), word


def test_a_summary_holds_no_copy_of_the_log():
    t = np.linspace(0.0, 2.0, 101)
    v = 12.0 * np.sign(np.sin(5.0 * t) + 0.1)
    log = wb.Dataset.of(t, {"v": v, "omega": np.cumsum(v) / 400}, {"v": "V", "omega": "rad/s"})
    fit = wb.fit(wb.open_loop(wb.DCMotor()), log, ["J", "R"], hold_out=0.0)
    summary = thin_out(fit, 10)
    assert len(summary.experiments[0].t) == 11
    assert not any("held out" in text for text in summary.warnings)
