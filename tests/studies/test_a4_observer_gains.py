"""The study of observer gains: its late error leaves out the jumps of the reference, and nothing else."""

import numpy as np
import pytest

from studies.a4_observer_gains.candidates import COLUMNS
from studies.a4_observer_gains.pages import definitions_table
from studies.a4_observer_gains.settled_error import settled_error
from studies.paper.laws import rival
from workbench.engine.metrics import late_error, measure

AFTER, APART, H = 1.0, 2.0, 2e-3


@pytest.mark.parametrize("clear", [0.5, 1.0])
def test_the_late_error_is_the_largest_outside_the_time_after_each_jump(clear):
    metrics = settled_error("settled", AFTER, clear, APART), late_error(AFTER)
    found = measure(rival("SS", "PID").ode(), metrics, until=5.0, h=H, every=H)
    t, e = found.trajectories.t, np.abs(found.trajectories["e"][0])
    steps = np.round(t / H).astype(int)  # whole steps, in which the times of jumps are exact
    counts = (steps >= round(AFTER / H)) & (steps % round(APART / H) >= round(clear / H))
    settled = [found.score("settled", joint).pair[0] for joint in (0, 1)]
    np.testing.assert_allclose(settled, e[counts].max(axis=0), rtol=1e-12)
    late = [found.score("late error", joint).pair[0] for joint in (0, 1)]
    np.testing.assert_allclose(late, [0.8, 0.4], rtol=0.2)  # the heights of the jumps, which it measures
    assert all(one < other for one, other in zip(settled, late, strict=True))


def test_each_column_of_the_audits_has_one_definition():
    rows = definitions_table().rows
    assert [row[0] for row in rows] == [head for head, *_ in COLUMNS]
    assert len({row[1] for row in rows}) == len(rows)
