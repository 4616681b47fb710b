"""The citation of a study, a loop or a block: it names what the docstrings name, and leaves no block out."""

import importlib
import inspect
import pkgutil
import re
from types import FunctionType

import pytest
from hypothesis import given
from hypothesis import strategies as st

import workbench as wb
from studies.own_law import study as motor_study
from studies.paper.laws import RIVALS, proposed_as_printed, rival
from workbench.core.publications import Publication, publications_in, references_section
from workbench.study.bibtex import SPECIAL, bibtex_keys, escape_latex

MOTOR = wb.DCMotor()


def motor_loop():
    law = wb.PID(MOTOR.outputs, MOTOR.inputs, Kp=100.0, Ki=200.0)
    return wb.ClosedLoop(MOTOR, controller=law, reference=wb.Step("omega", "rad/s", 1.0))


def users(citation):
    return {use.block for _, uses in citation.publications for use in uses}


def documented_classes(*rooms):
    """The public classes of some rooms whose docstrings have a section of references."""
    for room in rooms:
        package = importlib.import_module(room)
        for module in pkgutil.walk_packages(package.__path__, f"{room}."):
            for name, thing in vars(importlib.import_module(module.name)).items():
                own = inspect.isclass(thing) and thing.__module__ == module.name and not name.startswith("_")
                if own and references_section(thing.__doc__):
                    yield thing


CLASSES = [*documented_classes("workbench.blocks", "workbench.arms", "workbench.study.uncertainty")]


@pytest.mark.parametrize("law", RIVALS)
def test_each_rival_law_of_the_paper_has_a_reference(law):
    assert type(RIVALS[law]).__name__ in users(wb.cite(rival("FS", law)))


def test_the_law_and_both_observers_of_the_paper_name_their_sections_of_one_publication():
    (paper,) = [
        uses for work, uses in wb.cite(proposed_as_printed("FS")).publications if work.text.startswith("Adaptive obs")
    ]
    assert dict(paper) == {
        "Luenberger": "section 3.1",
        "PrintedFilter": "section 3.2",
        "AosmcRgs": "sections 3.3 and 3.4",
    }


@pytest.mark.parametrize("kind", CLASSES, ids=lambda kind: kind.__name__)
def test_authors_and_year_of_each_reference_are_read_where_they_stand(kind):
    section = references_section(kind.__doc__)
    entries = publications_in(section)
    assert entries
    for publication, place in entries:
        assert not re.search(r"\(\d{4}\)", publication.work), "a year that was not read"
        assert publication.authors == "" or re.fullmatch(r"\d{4}", publication.year)
        assert place.count("(") == place.count(")")
    words = " ".join(f"{work.text} {place}" for work, place in entries)
    assert set(re.findall(r"\w+", section)) == set(re.findall(r"\w+", words)), "words were lost or added"


def test_laws_observers_plants_signals_and_designs_are_among_the_classes():  # else the test above tests nothing
    assert {"SuperTwisting", "Luenberger", "DCMotor", "WayPoints", "SobolDesign"} <= {kind.__name__ for kind in CLASSES}


def test_a_loop_in_a_computer_has_the_citation_of_its_loop():
    loop = motor_loop()
    for other in (loop.ode(), loop.digital(1e-3), wb.DigitalLoop(loop, 1e-3)):
        assert wb.cite(other).publications == wb.cite(loop).publications
        assert wb.cite(other).without_reference == wb.cite(loop).without_reference == ("Step",)


def test_a_block_without_a_reference_is_listed_by_its_name():
    citation = wb.cite(motor_study)
    assert {"PI", "LinearLaw", "RMSE"} <= set(citation.without_reference)
    assert "Without a reference: PI, " in repr(citation)
    assert citation.remarks == ()


def test_one_publication_stands_once_with_its_longest_list_of_authors():
    short, long = (wb.arms.laws.ComputedTorque, wb.ArmPID)
    works = [publications_in(references_section(law.__doc__))[0][0] for law in (short, long)]
    assert works[0].authors == "Siciliano et al."
    assert works[0] != works[1]
    assert works[0].identity == works[1].identity
    model = wb.paper_arm()
    plant = wb.Manipulator(model, q=[0.1, 0.0])
    law = wb.arms.laws.ComputedTorque(model, Kp=[1.0, 1.0], Kd=[1.0, 1.0])
    citation = wb.cite(wb.ClosedLoop(plant, wb.ArmFullState(2), law, wb.Sines("q", "rad", [1.0, 1.0], [1.0, 1.0])))
    (robotics,) = [work for work, _ in citation.publications if "Robotics: Modelling" in work.text]
    assert robotics.authors == "Siciliano, Sciavicco, Villani and Oriolo"


def study_with(docstring, **parts):
    """A study whose module has this docstring."""
    sections = FunctionType((lambda results: []).__code__, {"__doc__": docstring})
    return wb.Study("mine", "T", "Q?", "M.", sections, **parts)


def test_a_study_names_its_own_publications_in_the_docstring_of_its_module():
    study = study_with(
        "A study.\n\nReferences\n----------\n.. [1] Doe and Roe (2020), On loops, J. Loops 3, table 2.\n"
    )
    ((work, uses),) = wb.cite(study).publications
    assert work == Publication("Doe and Roe", "2020", "On loops, J. Loops 3")
    assert uses == (("the study 'mine'", "table 2"),)


def test_what_follows_from_results_is_said_to_be_unknown():
    run = wb.Run(wb.open_loop(MOTOR), (wb.effort("omega"),), until=1.0)
    work = wb.Work("plain", documented_work, (1.0,))
    study = study_with("", cases=lambda tuned: (wb.Case("speed", "no law", run),), works=(work,))
    citation = wb.cite(study)
    assert citation.remarks == ("The cases of the study follow from its results, so what they use is not listed.",)
    assert users(citation) == {"the work 'plain'"}


def documented_work(item: float) -> float:
    """The same number.

    References
    ----------
    Doe (2021), Numbers.
    """
    return item


def test_equations_without_blocks_are_said_to_be_unknown():
    ode = wb.core.with_quadrature(wb.open_loop(MOTOR), {})
    assert wb.cite(ode).remarks == ()  # equations keep the blocks that they were made from
    bare = wb.Ode.of("bare", wb.layout(x="m"), wb.layout(), *bare_equations())
    assert wb.cite(bare).remarks == ("The loop is given by its equations, so its blocks are not known.",)


def bare_equations():
    import casadi as ca

    t, x, p = ca.SX.sym("t"), ca.SX.sym("x"), ca.SX(0, 1)
    return (t, x, p), {"x": -x}, {"y": x}


@given(st.text())
def test_no_character_of_a_text_is_a_command_of_latex(text):
    escaped = escape_latex(text)
    bare = re.sub(r"\\(?:textbackslash|textasciitilde|textasciicircum)\{\}|\\[&%$#_{}]", "", escaped)
    assert not set(bare) & set(SPECIAL)
    assert "\n" not in escaped


@given(st.lists(st.builds(Publication, st.text(), st.sampled_from(["", "1990"]), st.text(min_size=1)), max_size=40))
def test_the_keys_of_bibtex_are_all_different_and_plain(works):
    keys = bibtex_keys(works)
    assert len(set(keys)) == len(works)
    assert all(re.fullmatch(r"[a-z0-9]+", key) for key in keys)


def test_bibtex_has_an_entry_for_each_publication_and_the_fields_that_are_known():
    citation = wb.cite(motor_loop())
    text = citation.bibtex()
    assert re.findall(r"@misc\{(\w+),", text) == ["controlworkbench", "astrom2006", "messner"]
    assert "author = {Astrom and Hagglund},\n  year = {2006},\n  note = {Advanced PID Control},\n}" in text
    assert f"note = {{Version {wb.__version__}}}" in text
    assert "author" not in text[text.index("@misc{messner") :]  # a reference without a year has no field but its text
    assert text.count("{") == text.count("}")


def test_a_name_of_several_words_and_et_al_are_bibtex_names():
    work = Publication("De Luca, Mattone et al.", "2003", "A & B")
    from workbench.study.bibtex import bibtex_entry

    entry = bibtex_entry("deluca2003", work, work.work)
    assert "author = {{De Luca} and Mattone and others}" in entry
    assert r"note = {A \& B}" in entry


def test_a_docstring_from_outside_is_escaped_in_a_notebook():
    @wb.block
    class Evil(wb.Plant):
        """A plant.

        References
        ----------
        <script>alert(1)</script>, section 1.
        """

        inputs, outputs = wb.layout(v="V"), wb.layout(y="V")

    page = wb.cite(Evil())._repr_html_()
    assert "<script>" not in page
    assert "&lt;script&gt;" in page


@pytest.mark.parametrize("thing", [3, "study", None, wb.DCMotor, wb])
def test_something_else_is_refused_in_a_sentence(thing):
    with pytest.raises(ValueError, match=r"`cite\(subject\)` must be a `Study`, a loop such as a `ClosedLoop`, or a b"):
        wb.cite(thing)
