"""The largest sampling period of a loop, held against closed forms of an integrator under a proportional law."""

import numpy as np
import pytest
from scipy.optimize import brentq

import workbench as wb
from workbench.engine.metrics import ise
from workbench.study.evidence import LoopLimits, LoopTrial, largest_setting

K, UNTIL = 4.0, 3.0  # 1/s, s


@wb.block
class Integrator(wb.Plant):
    """x' = u."""

    x: float = wb.initial(default=1.0, unit="m")
    inputs, outputs = wb.layout(u="m/s"), wb.layout(x="m")

    def rate(self, t, x, u):
        return {"x": u.u}


@wb.block
class Proportional(wb.Controller):
    """u = -K x."""

    K: float = wb.parameter(K, unit="1/s")
    reads, drives = wb.layout(x="m"), wb.layout(u="m/s")
    follows = wb.layout(x="m")

    def command(self, t, z, est, ref):
        return {"u": self.K * (ref.x - est.x)}


LOOP = wb.ClosedLoop(Integrator(), controller=Proportional(), reference=wb.Constant("x", "m", [0.0]))
SCAN = tuple(np.geomspace(0.02, 0.8, 13))


def integral(period):
    """The integral of x^2 up to the multiple of the period that is nearest to UNTIL, in closed form.

    x is a straight line in each period, from r^k to r^(k+1) with r = 1 - K T.
    """
    r, count = 1 - K * period, round(UNTIL / period)
    powers = count if r**2 == 1 else (1 - r ** (2 * count)) / (1 - r**2)
    return period * (1 + r + r**2) / 3 * powers


def limits(most, **changes):
    return LoopLimits(
        **{
            "loop": lambda T: wb.DigitalLoop(LOOP, T),
            "metrics": lambda T: (ise("x"),),
            "limits": {ise("x").name: most},
            "until": UNTIL,
            "longest_step": 0.5,
        }
        | changes
    )


def test_the_largest_period_is_that_of_the_closed_form():
    most = 0.3  # m^2 s, beyond the least of the integral and below its growth at the border of stability, 2 / K
    edge = brentq(lambda T: integral(T) - most, 0.35, 0.49)
    found = largest_setting(limits(most), SCAN, ratio=1.01)
    assert found.threshold.largest <= edge * (1 + 1e-9)
    assert found.threshold.next >= edge * (1 - 1e-9)
    assert found.threshold.next / found.threshold.largest <= 1.01
    assert found.sure


def test_the_shares_at_every_period_are_those_of_the_closed_form():
    found = largest_setting(limits(0.3), SCAN[::3], ratio=None)
    forms = np.array([integral(T) for T in found.threshold.values]) / 0.3
    # RK4 is exact for the cubic whose rate is the square of a straight line
    np.testing.assert_allclose(found.worst(ise("x").name), forms, rtol=1e-9)


def test_a_criterion_that_is_met_again_is_seen_by_the_scan():
    # the integral is least where x jumps to zero near 1 / K: shorter and longer periods are above a limit close to it
    least = min(integral(T) for T in SCAN)
    found = largest_setting(limits(1.02 * least), SCAN, ratio=1.01)
    assert found.threshold.largest == 0.0
    assert found.threshold.beyond
    assert "the criterion is met again at" in found.sentence


def test_a_delay_is_a_setting_too():
    # with T = 0.1 s the characteristic polynomial z^(d+1) - z^d + K T has a root beyond the circle from d = 4 on
    def stable(d):
        return max(abs(np.roots([1.0, -1.0, *[0.0] * (d - 1), 0.4]))) < 1

    kept = limits(5.0, loop=lambda d: wb.DigitalLoop(LOOP, 0.1, delay=d), until=60.0, longest_step=0.1)
    found = largest_setting(kept, tuple(map(float, range(1, 9))), ratio=None)
    last = max(d for d in range(1, 9) if stable(d))
    assert (found.threshold.largest, found.threshold.next) == (last, last + 1)


def test_several_loops_keep_their_limits_together_and_the_first_that_does_not_ends_a_trial():
    quick = limits(
        0.3,
        loop=lambda T: wb.DigitalLoop(
            wb.ClosedLoop(Integrator(), controller=Proportional(8.0), reference=wb.Constant("x", "m", [0.0])), T
        ),
    )
    alone = [largest_setting(one, SCAN[::3], ratio=None).threshold for one in (limits(0.3), quick)]
    both = largest_setting((limits(0.3), quick), SCAN[::3], ratio=None)
    assert both.threshold.largest == min(one.largest for one in alone)
    lost = both.threshold.values.index(SCAN[-1])
    assert len(both.trials[lost]) == 1
    assert np.isnan(both.worst(ise("x").name, 1)[lost])


def test_a_run_that_diverges_keeps_no_limit():
    far = limits(1e300, until=3000.0, loop=lambda T: wb.DigitalLoop(LOOP, T))
    found = largest_setting(far, (0.4, 0.6, 0.8), ratio=None)
    assert (found.threshold.largest, found.threshold.next) == (0.4, 0.6)
    assert np.isinf(found.worst(ise("x").name)[-1])


def test_an_answer_within_the_error_of_the_step_is_not_sure():
    one = {"ISE": np.array([0.99])}
    assert LoopTrial(one, {"ISE": np.array([1e-3])}).sure
    assert not LoopTrial(one, {"ISE": np.array([0.1])}).sure
    nan = {"ISE": np.array([np.nan])}
    assert LoopTrial(nan, nan).sure
    assert not LoopTrial(nan, nan).keeps_limits


@pytest.mark.parametrize(
    ("change", "kind", "words"),
    [
        ({"limits": {}}, ValueError, "finite numbers above zero"),
        ({"limits": {"ISE": 0.0}}, ValueError, "finite numbers above zero"),
        ({"until": 0.0}, ValueError, "until"),
        ({"longest_step": -1.0}, ValueError, "longest_step"),
    ],
)
def test_limits_that_are_none_are_refused(change, kind, words):
    with pytest.raises(kind, match=words):
        limits(1.0, **change)


def test_a_limit_for_no_metric_and_a_loop_that_is_none_are_refused():
    with pytest.raises(LookupError, match="metrics of the loop"):
        largest_setting(limits(1.0, limits={"RMSE": 1.0}), (0.1,))
    with pytest.raises(ValueError, match="whose `ode"):
        largest_setting(limits(1.0, loop=lambda T: None), (0.1,))
    with pytest.raises(ValueError, match="at least one `LoopLimits`"):
        largest_setting((), (0.1,))
