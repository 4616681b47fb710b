"""The sources of marks that show sweeps: which sample, and what is said of it."""

import csv
import io
from dataclasses import replace

import numpy as np
import pytest

import workbench as wb
from tests.support.speed_cases import case
from workbench.report.pictures import morris_plane, quantile_bands, sobol_bars, standings_figure, tornado_figure
from workbench.report.table_text import to_csv
from workbench.study import uncertainty
from workbench.study.compiled_sweep import compile_sweep
from workbench.study.document.document import Bars, Points, ValueWithError
from workbench.study.document.phrases_and_tables import bare
from workbench.study.evidence import compare, pair_samples, same_draws
from workbench.study.evidence.comparison_tables import comparison_table
from workbench.study.uncertainty.designs import MonteCarlo, MorrisDesign, OneAtATime

FACTORS = (
    wb.Factor("gain", ("controller.Kp",), wb.LogUniform(50.0, 200.0)),
    wb.Factor("inertia", ("plant.J",), wb.Uniform(0.8, 1.2), share=True),
)


@pytest.fixture(scope="module")
def sampled():
    """The samples of a sweep of each kind of design, by its name."""
    designs = {
        "indices": wb.SobolDesign(2, 16),
        "effects": MorrisDesign(2, 4),
        "swings": OneAtATime(2),
        "draws": MonteCarlo(2, 40),
    }
    run = replace(case("PI").run, every=0.5)
    sweeps = (compile_sweep(wb.Sweep(name, run, FACTORS, design)) for name, design in designs.items())
    return {one.sweep.name: one.sample([one.chunk(0, one.sweep.design.size)]) for one in sweeps}


def numbers(figure):
    head, *rows = csv.reader(io.StringIO(to_csv(figure.numbers)))
    return [dict(zip(head, row, strict=True)) for row in rows]


def test_a_picture_of_a_sweep_reads_its_note_from_its_source_and_says_it_in_its_numbers(sampled):
    for kind, name in (("indices", "sobol"), ("effects", "morris"), ("swings", "tornado")):
        sample = sampled[kind]
        outputs = sample.score("RMSE").value
        found = getattr(uncertainty, name)(sample.design, outputs, ["y"], factors=sample.factors)
        make = {"sobol": sobol_bars, "morris": morris_plane, "tornado": tornado_figure}[name]
        source = sample.source("RMSE", law="PI")
        figure = make("f", "Caption", found, source)
        assert figure.caption == make("f", "Caption", found, sample.note_of("RMSE")).caption
        marks = [mark for mark in figure.panels[0].series if isinstance(mark, Bars | Points)]
        assert {one for mark in marks for one in np.ravel(mark.sources)} == {source}
        of = f"PI | {kind} | RMSE of omega [rad/s] | run {sample.digest[:16]}"
        assert {row["of"] for row in numbers(figure)} == {of}


def test_a_picture_of_several_outputs_has_a_source_for_each_and_says_what_they_share_once(sampled):
    sample = sampled["indices"]
    names = ("RMSE", "effort")
    outputs = np.stack([sample.score(name).value for name in names], axis=1)
    found = wb.sobol(sample.design, outputs, names, factors=sample.factors)
    sources = tuple(sample.source(name) for name in names)
    figure = sobol_bars("f", "Caption.", found, sources)
    text = "".join(figure.caption)
    assert text.count(sample.note) == 1
    assert "error of RMSE at most" in text
    assert "error of effort at most" in text
    assert {(row["output"], row["of"].split(" | ")[1].split()[0]) for row in numbers(figure)} == {
        (one, one) for one in names
    }
    with pytest.raises(ValueError, match=r"a source for each of \['RMSE', 'effort'\], in their order; got 1"):
        sobol_bars("f", "Caption.", found, sources[0])


def test_bands_of_several_laws_have_a_source_for_each(sampled):
    sample = sampled["draws"]
    bands = {law: uncertainty.quantiles(sample.design, sample.over_time("RMSE")) for law in ("a", "b")}
    sources = tuple(sample.source("RMSE", law=law) for law in bands)
    figure = quantile_bands("f", "Caption.", sample.t, bands, sources, "RMSE")
    lines = [mark for mark in figure.panels[0].series if mark.label in bands]
    assert [line.sources[1].law for line in lines] == ["a", "b"]
    assert {(row["law"], row["of"].split(" | ")[0]) for row in numbers(figure)} == {("a", "a"), ("b", "b")}
    assert "a: 40 runs" in "".join(figure.caption)


def test_laws_in_the_same_draws_read_note_and_sources_from_their_samples(sampled):
    sample = sampled["draws"]
    held = {"a": sample, "b": replace(sample, name="other")}
    values = {law: (1 + k) * one.score("RMSE").value for k, (law, one) in enumerate(held.items())}
    both = pair_samples(values, metric="RMSE", unit="rad/s", samples=held)
    assert both.note == same_draws(held)
    assert [(one.law, one.scenario, one.unit) for one in both.sources] == [
        ("a", "draws", "rad/s"),
        ("b", "other", "rad/s"),
    ]
    judged = compare(both)
    shown = [bare(row[1]) for row in comparison_table("t", "T.", [judged]).rows]
    assert [value.source.law for value in shown if isinstance(value, ValueWithError)] == ["a", "b"][: len(shown)]
    rows = numbers(standings_figure("f", "F.", {"s": {"median": judged}}, "median"))
    assert [row["of"].split(" | ")[:3] for row in rows] == [
        ["a", "draws", "RMSE [rad/s]"],
        ["b", "other", "RMSE [rad/s]"],
    ]
    with pytest.raises(ValueError, match=r"one sample for each of \['a', 'b'\]; got \['a'\]"):
        pair_samples(values, metric="RMSE", samples={"a": sample})
