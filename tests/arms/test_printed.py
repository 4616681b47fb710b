"""A paper's printed matrices against the derived ones."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from studies.paper.printed_arm import PrintedArm
from workbench.arms.dynamics import Dynamics
from workbench.arms.mechanics import PlanarArm, paper_arm, robot
from workbench.arms.mechanics.planar_arm import PointMass
from workbench.arms.paper_equations.entry_comparison import compare, compare_sheet, entry_verdicts
from workbench.arms.paper_equations.printed_equations import read_sheet

DERIVED = Dynamics.of(paper_arm())
PAPER = Dynamics.of(PrintedArm())
REPAIRED = Dynamics.of(PrintedArm(coriolis="repaired"))


def by_label(printed, derived=DERIVED):
    return {verdict.label: verdict for verdict in compare(printed, derived)}


def with_entry(matrix: str, place, value) -> Dynamics:
    """The repaired arm with one entry replaced by value(q, qd, m1, l1, m2, l2, g)."""
    d = Dynamics.of(PrintedArm(coriolis="repaired"))
    changed = ca.SX(getattr(d, matrix))
    changed[place] = value(d.q, d.qd, *ca.vertsplit(d.symbols))
    return replace(d, **{matrix: changed})


def test_the_printed_paper_is_wrong_in_c12_and_nowhere_else():
    verdicts = compare(PAPER, DERIVED)
    assert [v.label for v in verdicts] == [
        "M[1,1]",
        "M[1,2]",
        "M[2,1]",
        "M[2,2]",
        "C[1,1]",
        "C[1,2]",
        "C[2,1]",
        "C[2,2]",
        "G[1]",
        "G[2]",
    ]
    assert {v.label for v in verdicts if v.kind == "differs"} == {"C[1,2]"}
    assert {v.kind for v in verdicts if v.label != "C[1,2]"} == {"same"}


def test_the_repaired_arm_is_proved_to_be_the_derived_one():
    assert {v.kind for v in compare(REPAIRED, DERIVED)} == {"same"}


def test_anyone_can_replay_the_witness():
    verdict = by_label(PAPER)["C[1,2]"]
    assert str(verdict.witness) == "q = (0.5, 1), qd = (1, -1), nominal parameters"
    assert verdict.witness.replay == "M, C, G = dynamics.matrices((0.5, 1), (1, -1))"
    C = PAPER.matrices((0.5, 1), (1, -1))[1]
    assert C[0, 1] == verdict.printed_value == pytest.approx(1 + np.cos(1.0), rel=1e-15)
    assert verdict.right_value == DERIVED.matrices((0.5, 1), (1, -1))[1][0, 1] == 0.0


def test_the_right_entry_is_an_expression_of_the_derived_arm():
    verdict, d = by_label(PAPER)["C[1,2]"], DERIVED
    at = ca.Function("at", [d.q, d.qd, d.symbols], [verdict.right, verdict.difference, verdict.printed_entry])
    right, difference, printed = (float(x) for x in at([0.3, 0.7], [2.0, 0.5], d.p.default))
    assert right == pytest.approx(-np.sin(0.7) * 2.5, rel=1e-14)
    assert difference == pytest.approx(printed - right, rel=1e-14)


def test_the_printed_entry_gives_a_wrong_torque():
    assert by_label(PAPER)["C[1,2]"].same_torque == "refuted"


def test_another_factorisation_of_the_same_torque_is_told_from_a_wrong_one():
    # C[1,1] = 0 and C[1,2] = -m2 l1 l2 sin q2 (2 q1' + q2') give the same C qd as the Christoffel symbols
    d = with_entry("C", (0, 0), lambda q, qd, *p: 0)
    C = ca.SX(d.C)
    _, l1, m2, l2, _ = ca.vertsplit(d.symbols)
    C[0, 1] = -m2 * l1 * l2 * ca.sin(d.q[1]) * (2 * d.qd[0] + d.qd[1])
    verdicts = by_label(replace(d, C=C))
    assert {label for label, v in verdicts.items() if v.kind == "differs"} == {"C[1,1]", "C[1,2]"}
    assert {verdicts[label].same_torque for label in ("C[1,1]", "C[1,2]")} == {"proved"}
    assert verdicts["C[2,1]"].same_torque is None


MISPRINTS = {
    "a sign": ("M", (0, 1), lambda q, qd, m1, l1, m2, l2, g: m2 * (l2**2 - l1 * l2 * ca.cos(q[1]))),
    "a factor": ("M", (0, 0), lambda q, qd, m1, l1, m2, l2, g: m1 * l1**2 + m2 * (l1**2 + l2**2 + l1 * l2)),
    "the wrong length": ("M", (1, 1), lambda q, qd, m1, l1, m2, l2, g: m2 * l1**2),
    "the wrong mass": ("G", (1, 0), lambda q, qd, m1, l1, m2, l2, g: m1 * g * l2 * ca.sin(q[0] + q[1])),
    "a cosine for a sine": ("G", (1, 0), lambda q, qd, m1, l1, m2, l2, g: m2 * g * l2 * ca.cos(q[0] + q[1])),
    "an angle": ("G", (1, 0), lambda q, qd, m1, l1, m2, l2, g: m2 * g * l2 * ca.sin(q[1])),
    "a velocity": ("C", (1, 0), lambda q, qd, m1, l1, m2, l2, g: m2 * l1 * l2 * ca.sin(q[1]) * qd[1]),
    "a power": ("M", (1, 1), lambda q, qd, m1, l1, m2, l2, g: m2 * l2),
    "a nearly right number": (
        "C",
        (1, 0),
        lambda q, qd, m1, l1, m2, l2, g: 1.00001 * m2 * l1 * l2 * ca.sin(q[1]) * qd[0],
    ),
}


@pytest.mark.parametrize("misprint", MISPRINTS)
def test_each_kind_of_misprint_is_found_in_its_entry_alone(misprint):
    matrix, place, value = MISPRINTS[misprint]
    verdicts = compare(with_entry(matrix, place, value), DERIVED)
    wrong = [v for v in verdicts if v.kind != "same"]
    assert [(v.kind, v.matrix, v.row, v.column) for v in wrong] == [("differs", matrix, place[0] + 1, place[1] + 1)]
    assert wrong[0].printed_value != wrong[0].right_value


def test_a_misprint_that_hides_at_the_nominal_parameters_is_found_at_others():
    # all lengths and masses of the paper's arm are 1, so l1 for l2 shows nowhere at its nominal parameters
    verdict = by_label(with_entry("M", (1, 1), lambda q, qd, m1, l1, m2, l2, g: m2 * l1**2))["M[2,2]"]
    assert verdict.witness.changed_parameters
    assert "links[1].length" in str(verdict.witness)
    dynamics = DERIVED  # the name in the line to replay
    names = {"dynamics": dynamics}
    exec(verdict.witness.replay, names)
    assert names["M"][1, 1] == pytest.approx(verdict.right_value, rel=1e-15)


def test_expressions_beyond_the_normal_form_are_never_silently_the_same():
    hidden = with_entry("M", (1, 1), lambda q, qd, m1, l1, m2, l2, g: m2 * ca.exp(2 * ca.log(l2)))
    wrong = with_entry("M", (1, 1), lambda q, qd, m1, l1, m2, l2, g: m2 * l2**2 * (1 + ca.tanh(q[1]) ** 2))
    verdict = by_label(hidden)["M[2,2]"]
    assert verdict.kind == "not refuted"
    assert "400 samples" in verdict.evidence
    assert by_label(wrong)["M[2,2]"].kind == "differs"


def test_a_rounded_number_is_not_the_number():
    verdict = by_label(with_entry("M", (1, 1), lambda q, qd, m1, l1, m2, l2, g: m2 * l2**2 * (1 + 1e-12)))["M[2,2]"]
    assert verdict.kind == "not refuted"  # proved to differ by the normal form, below what a witness could show
    assert "the normal forms differ" in verdict.evidence


def test_entries_that_are_not_numbers_somewhere_do_not_hide_a_difference():
    broken = with_entry("M", (1, 1), lambda q, qd, m1, l1, m2, l2, g: m2 * l2**2 / ca.sqrt(q[1]))
    assert by_label(broken)["M[2,2]"].kind == "differs"


def test_arms_that_cannot_be_compared_are_refused():
    with pytest.raises(ValueError, match="2 printed and 3 derived"):
        compare(PAPER, Dynamics.of(robot("planar-3r")))
    with pytest.raises(LookupError, match=r"no 'links\[0\].com' among"):
        compare(Dynamics.of(robot("planar-2r")), DERIVED)


def test_parameters_are_matched_by_name_and_not_by_place():
    reordered = Dynamics.of(PlanarArm((PointMass(1.0, 1.0), PointMass(1.0, 1.0))))
    order = [4, 3, 2, 1, 0]
    layout = type(reordered.p)(tuple(reordered.p.entries[i] for i in order))
    turned = replace(reordered, p=layout, symbols=reordered.symbols[order])
    assert {v.kind for v in compare(turned, DERIVED)} == {"same"}


def test_the_printed_arm_has_two_links():
    with pytest.raises(ValueError, match="has two links"):
        PrintedArm(links=(PointMass(1.0, 1.0),))


def test_the_study_names_the_wrong_entry_and_prints_the_right_one():
    from studies.a0_two_link_arm import study
    from workbench.core.notation import text

    page = study.sections(None)
    wrong, skewness = page.findings
    assert (wrong.answer, skewness.answer) == ("C[1,2] of (3)", "false")
    assert page.answer.startswith("Of the 10 printed entries of (2) to (4), 9 are right")
    claims, entries, _ = page.sections
    assert [type(block).__name__ for block in claims.blocks[:2]] == ["Figure", "Verdict"]
    equation = next(block for block in claims.blocks if getattr(block, "name", "") == "right_c12")
    assert text.emit(equation.lines[0]) == "C_12 = -m_2*l_1*l_2*(qd_1 + qd_2)*sin(q_2)"
    printed = {row[0]: text.emit(row[2]) for row in entries.blocks[0].rows}
    assert printed["C[1,2]"] == "m_2*(l_2^2 + l_1*l_2*cos(q_2))"


def test_a_sheet_is_compared_with_the_arm_it_was_read_for():
    one, two = (Dynamics.of(robot(name)) for name in ("planar-1r", "planar-2r"))
    with pytest.raises(LookupError, match="this one has no '._2'"):
        compare_sheet(read_sheet("M_11 = m_2*l_2^2", two, "text"), one)
    with pytest.raises(LookupError, match=r"An arm with 1 joint has no entry 'M'\[0,1\]"):
        entry_verdicts({("M", 0, 1): ca.SX(1)}, one)
