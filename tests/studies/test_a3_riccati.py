"""The study of the Riccati part: what it computes along a path, against closed forms."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.linalg import solve_continuous_are

from studies.a3_riccati_gains import findings, path
from studies.a3_riccati_gains.settings import ASSUMED_WEIGHTS, FORWARD, OTHERS, SETTINGS, WEIGHTS
from studies.a3_riccati_gains.study import cases, choices_of, figure
from studies.paper.laws import mass_matrices
from workbench.design.riccati_flow import rde
from workbench.engine.metrics import rmse
from workbench.study.case_runs import run
from workbench.study.study import Study


def test_the_cost_of_a_fixed_gain_is_the_integral_by_hand():
    P, end = 10 * np.eye(2), 0.2
    rate = float(path.G[0, 0]) * 10  # A = 0: s falls with B R^-1 B' P
    weight = float(path.Q[0, 0]) + rate * 10  # Q + P B R^-1 B' P
    Y = path.cost(lambda t: np.zeros((2, 2)), lambda t: P, np.array([0.0, 0.1, end]))
    expected = weight * (1 - np.exp(-2 * rate * end)) / (2 * rate)
    np.testing.assert_allclose(Y, expected * np.eye(2), rtol=10 * path.RTOL, atol=1e-9)


def test_no_choice_of_p_costs_less_than_the_backward_solution():
    t = np.linspace(0, 0.3, 5)

    def A(time):
        return np.array([[-2.0 - time, 1.0], [-0.5, -3.0 + np.sin(3 * time)]])

    least = rde(A, path.B, path.Q, path.R, path.ZERO, t, rtol=path.RTOL).P[0]
    for P in (np.zeros((2, 2)), 10 * np.eye(2), np.array([[8.0, 2.0], [2.0, 5.0]])):
        Y = path.cost(A, lambda time, P=P: P, t)
        assert np.linalg.eigvalsh(Y - least).min() > 0
        assert path.worst(Y, least) > 1


def test_the_worst_start_is_the_largest_generalised_eigenvalue():
    rng = np.random.default_rng(5)
    X, Z = (root @ root.T + np.eye(2) for root in rng.normal(size=(2, 2, 2)))
    s = np.array([np.cos(a := np.linspace(0, np.pi, 20_001)), np.sin(a)])
    ratio = np.einsum("ik,ij,jk->k", s, X, s) / np.einsum("ik,ij,jk->k", s, Z, s)
    np.testing.assert_allclose(path.worst(X, Z), ratio.max(), rtol=1e-7)  # the square of half a step of the angle


def test_the_inertia_of_the_model_is_that_of_two_point_masses():
    q = np.array([[0.3, -0.7], [1.0, 2.0]])
    c = np.cos(q[:, 1])
    expected = np.array([[3 + 2 * c, 1 + c], [1 + c, np.ones(2)]]).transpose(2, 0, 1)
    np.testing.assert_allclose(mass_matrices(q), expected, rtol=1e-14)


def test_the_median_in_time_does_not_count_an_instant_more_often_for_having_neighbours():
    t = np.concatenate([np.linspace(0, 1, 1000), np.linspace(1.1, 10, 90)])
    assert path.median_in_time(np.where(t <= 1, 7.0, 3.0), t) == 3.0
    np.testing.assert_allclose(path.median_in_time(t, t), 5.0)


@pytest.mark.parametrize(("scenario", "median"), [("FS", 2.8e-4), pytest.param("SS", 4.1e-4, marks=pytest.mark.heavy)])
def test_the_median_distance_of_p_is_that_of_scipys_solutions_at_evenly_spaced_times(scenario, median):
    (case,) = (case for case in cases(scenario, {ASSUMED_WEIGHTS: np.eye(2)}) if case.law == FORWARD)
    case = replace(case, run=replace(case.run, metrics=(rmse(),), until=path.WINDOW))
    (outcome,) = run(Study("s", "t", "q", "m", lambda results: (), cases=(case,))).outcomes
    states = outcome.measurement.trajectories
    t, K, P = states.t, states["controller.K"][0], states["controller.P"][0]
    q2 = states["observer.state.q_hat"][0, :, 1]
    M = np.array([[3 + 2 * np.cos(q2), 1 + np.cos(q2)], [1 + np.cos(q2), np.ones_like(q2)]]).transpose(2, 0, 1)
    A = -np.linalg.solve(M, K)

    def gaps(some):
        X = np.array([solve_continuous_are(A[i], path.B, path.Q, path.R) for i in some])
        return np.linalg.norm(P[some] - X, axis=(1, 2)) / np.linalg.norm(X, axis=(1, 2))

    late = np.flatnonzero(t >= 0.05)
    uneven = np.intersect1d(path.instants(len(t)), late)
    ours, evenly = path.median_in_time(gaps(uneven), t[uneven]), np.median(gaps(late[::7]))
    np.testing.assert_allclose(evenly, median, rtol=0.05)  # 140 of 981 times
    np.testing.assert_allclose(ours, evenly, rtol=0.05)


def test_each_loop_without_34_holds_the_p_that_it_names():
    mean = np.diag([8.0, 2.6])
    choices = choices_of(ASSUMED_WEIGHTS, mean)
    frozen = {
        name: fields["P"] for name, fields in choices.items() if fields.get("riccati") == "frozen" and "P" in fields
    }
    np.testing.assert_array_equal(frozen["P = its mean"], mean)
    np.testing.assert_array_equal(frozen["no adaptation"], 0)
    assert "P" not in choices["P = P(0)"]  # that of the law
    for weights in OTHERS:
        fields = choices_of(weights, mean)
        assert (fields[FORWARD]["Q"][0, 0], fields[FORWARD]["R"][0, 0]) == WEIGHTS[weights]
    assert len(SETTINGS) == 2 * len(WEIGHTS)


def test_the_word_for_a_change_needs_more_than_the_margin():
    assert findings.size(0.1) == "better with (34)"
    assert findings.size(-0.1) == "worse with (34)"
    assert findings.size(0.019) == findings.size(-0.019) == "within 2 %"


def test_a_part_is_printed_in_per_cent_with_two_digits_and_no_power_of_ten():
    assert [findings.share(part) for part in (0.0239, 3.4e-4, 3.41, 5912.0)] == [
        "2.4 %",
        "0.034 %",
        "340 %",
        "590,000 %",
    ]


def test_the_algebraic_solution_has_marks_where_its_line_lies_under_another():
    t = np.sort(np.append(np.geomspace(1e-3, 2.5, 60), np.linspace(0, 2.5, 60)))
    X = np.exp(-t)[:, None, None] * np.eye(2)
    one = SimpleNamespace(t=t, P=X, X=X, backward=SimpleNamespace(P=X), gap=lambda X: (0.0, 0.012))
    drawn = figure(one, "FS")
    for panel in drawn.panels[:2]:
        lines = {series.label: series for series in panel.series if series.look == "line"}
        (marks,) = (series for series in panel.series if series.look == "marks")
        assert (marks.label, marks.style) == ("algebraic", lines["algebraic"].style)
        np.testing.assert_allclose(marks.y, np.interp(marks.x, t, np.exp(-t)), rtol=1e-12)
        assert np.diff(marks.x).max() < 0.3  # seen all along a window of 2.5 s
    assert drawn.caption.endswith("the two differ by at most 1.2 %.")
