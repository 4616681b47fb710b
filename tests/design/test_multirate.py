"""Several periods over their common one: runs by DOP853 from each unit state decide, and loops of one period."""

from fractions import Fraction

import control
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from workbench.design.frequency import common_period, hold_loop, lift_rates

A = np.array([[0.0, 1.0], [-1.0, -0.2]])
RATES = control.ss(A, [[0, 1], [1, 0]], [[0, 1], [1, 0]], 0)
THREE = control.ss(A, [[0, 1, 0.3], [1, 0, 0.2]], [[0, 1], [1, 0], [1, 1]], 0)


def gain(k, h):
    return control.ss([], [], [], [[k]], h)


def pi(k, ki, h):
    return control.ss([[1.0]], [[1.0]], [[ki]], [[k]], h)


def sorted_poles(lifted):
    return np.sort_complex(np.round(lifted.poles.values, 12))


@pytest.mark.parametrize(
    ("plant", "laws", "period"),
    [
        (RATES, [gain(1.0, 0.05), pi(0.5, 0.1, 0.1)], 0.1),
        (RATES, [pi(1.0, 0.02, 0.02), pi(0.5, 0.1, 0.03)], 0.06),
        (THREE, [gain(1.0, 0.1), pi(0.5, 0.1, 0.15), gain(0.2, 0.25)], 1.5),
    ],
)
def test_the_map_is_that_of_runs_from_each_unit_state(plant, laws, period):
    lifted = lift_rates(plant, laws)
    assert lifted.period == pytest.approx(period, rel=1e-15)
    n, memory = len(plant.A), sum(law.nstates for law in laws)
    columns = [run(plant, laws, period, start[:n], start[n:]) for start in np.eye(n + memory)]
    np.testing.assert_allclose(np.eye(n + memory) + lifted.change, np.transpose(columns), atol=1e-11)


def run(plant, laws, period, x, memory):
    """The states of the plant and the laws after the common period, by DOP853 at 1e-13."""
    z = np.split(memory, np.cumsum([law.nstates for law in laws])[:-1])
    counts = [round(period / law.dt) for law in laws]
    u, instants = np.zeros(len(laws)), sorted({k / count for count in counts for k in range(count)})
    for now, then in zip(instants, [*instants[1:], 1.0], strict=True):
        for i, (law, count) in enumerate(zip(laws, counts, strict=True)):
            if abs(now * count - round(now * count)) < 1e-9:
                y = plant.C[i : i + 1] @ x
                u[i] = -(law.C @ z[i] + law.D @ y)[0]
                z[i] = law.A @ z[i] + law.B @ y
        flow = solve_ivp(
            lambda t, x: plant.A @ x + plant.B @ u, (0, (then - now) * period), x, "DOP853", rtol=1e-13, atol=1e-15
        )
        x = flow.y[:, -1]
    return np.concatenate([x, *z])


def test_equal_periods_are_one_loop():
    h, laws = 0.1, [gain(1.0, 0.1), pi(0.5, 0.1, 0.1)]
    both = control.append(*laws)
    one = hold_loop(RATES, control.ss(both.A, both.B, both.C, both.D, h))
    np.testing.assert_allclose(sorted_poles(lift_rates(RATES, laws)), sorted_poles(one), atol=1e-11)


def test_a_law_without_effect_at_twice_the_period_squares_the_poles():
    plant = control.ss(A, np.eye(2), np.eye(2), 0)
    one = lift_rates(plant, [pi(0.5, 0.1, 0.1), gain(0.0, 0.1)]).poles.values
    two = lift_rates(plant, [pi(0.5, 0.1, 0.1), gain(0.0, 0.2)]).poles.values
    np.testing.assert_allclose(np.sort_complex(one**2), np.sort_complex(two), atol=1e-12)


@pytest.mark.parametrize(
    ("periods", "period", "counts"),
    [
        ([0.1, 0.3], 0.3, (3, 1)),
        ([1 / 3, 0.5], 1.0, (3, 2)),
        ([Fraction(1, 3), Fraction(1, 7)], 1.0, (3, 7)),
        ([0.1, Fraction(1, 4)], 0.5, (5, 2)),
        ([0.001, 1], 1.0, (1000, 1)),
        ([0.2], 0.2, (1,)),
        ([6e-3, 4e-3, 10e-3], 60e-3, (10, 15, 6)),
    ],
)
def test_the_common_period_is_the_least_common_multiple(periods, period, counts):
    found = common_period(periods)
    assert found[0] == pytest.approx(period, rel=4e-16)
    assert found[1] == counts


@pytest.mark.parametrize("other", [0.1 * 2**0.5, 0.1 * np.pi, 0.1000001, 1e-6, 0.1 * (1 + 1e-13)])
def test_periods_without_a_common_one_are_refused_by_name(other):
    with pytest.raises(ValueError, match=r"`common_period\(.*0\.1 s.* no common period"):
        lift_rates(RATES, [gain(1.0, 0.1), gain(1.0, other)])


@pytest.mark.parametrize("period", [0.0, -0.1, np.nan, np.inf, "a", Fraction(-1, 3)])
def test_a_period_that_is_none_is_refused(period):
    with pytest.raises(ValueError, match=r"periods=\[1\].* must be a positive"):
        common_period([0.1, period])


@pytest.mark.parametrize(
    ("laws", "words"),
    [
        ([], "at least one"),
        ([gain(1.0, 0.1)], "each one once"),
        ([gain(1.0, 0.1), control.ss([[-1.0]], [[1.0]], [[1.0]], 0)], r"laws=\[1\]\)` must be in discrete time"),
        ([gain(np.nan, 0.1), gain(1.0, 0.1)], "finite"),
    ],
)
def test_laws_that_do_not_fit_are_refused(laws, words):
    with pytest.raises(ValueError, match=words):
        lift_rates(RATES, laws)


def test_periods_as_fractions_take_the_place_of_doubles():
    laws = [gain(1.0, 1 / 3), gain(1.0, 0.5)]
    lifted = lift_rates(RATES, laws, [Fraction(1, 3), Fraction(1, 2)])
    assert (lifted.period, lifted.counts) == (1.0, (3, 2))
    with pytest.raises(ValueError, match="got 1/3, 1 for 0.333333, 0.5 s"):
        lift_rates(RATES, laws, [Fraction(1, 3), Fraction(1)])
