"""Signs that a log cannot tell are said, and bounds exclude the mirror image."""

import numpy as np
import pytest

import workbench as wb

T = np.linspace(0.0, 20.0, 801)
U = 3 * np.sin(1.1 * T) + 2 * np.sin(3.3 * T)
FREE = ["J", "b", "f", "w"]


def friction(t, x, u, p, m):
    return [(u[0] - p.b * x[0] - p.f * m.tanh(x[0] / p.w)) / p.J]


LAYOUT = wb.layout(J=("kg m^2", 1.0), b=("N m s/rad", 0.5), f=("N m", 1.0), w=("rad/s", 0.3))
AXIS = wb.open_loop(wb.OdePlant.of(friction, states=("speed:rad/s",), inputs=("u:N m",), p=LAYOUT))


def log(system=AXIS, seed=1):
    run = wb.identification.simulate_log(system, wb.Dataset.of(T, {"u": U}, {"u": "N m"}), ["speed"])
    noisy = run["speed"].ravel() + 0.01 * np.random.default_rng(seed).standard_normal(T.size)
    return wb.Dataset.of(T, {"u": U, "speed": noisy}, {"u": "N m", "speed": "rad/s"})


LOG = log()
SENTENCE = "No output changes with the other sign of f and w at once: the mirror image fits as well."


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_both_minima_of_a_smooth_friction_are_said_to_have_a_mirror_image(side):
    found = wb.fit(AXIS, LOG, FREE, start={"f": 0.7 * side, "w": 0.5 * side})
    assert np.sign(found.values["w"]) == side
    assert found.warnings[0].startswith(SENTENCE)


def test_bounds_of_one_number_exclude_the_mirror_image_and_move_no_other_estimate():
    free = wb.fit(AXIS, LOG, FREE, start={"w": 0.5})
    found = wb.fit(AXIS, LOG, FREE, start={"w": 0.5}, bounds={"w": (0.0, 10.0)})
    assert found.warnings == ()
    np.testing.assert_allclose(found.theta, free.theta, rtol=1e-6)  # the way to a minimum changes with bounds


def test_signs_that_the_log_tells_are_not_said_to_be_mirrored():
    found = wb.fit(AXIS, LOG, ["J", "b", "f"])
    assert found.warnings == ()


def test_a_number_that_enters_squared_has_a_mirror_image_alone():
    plant = wb.OdePlant.of(
        lambda t, x, u, p: [u[0] * p.k**2 - p.a * x[0]],
        states=("speed:rad/s",),
        inputs=("u:N m",),
        p=wb.layout(k=("", 1.5), a=("1/s", 1.0)),
    )
    system = wb.open_loop(plant)
    found = wb.fit(system, log(system), ["k", "a"])
    assert found.warnings[0].startswith("No output changes with the other sign of k: ")


def test_an_estimate_at_a_bound_of_the_call_is_said():
    found = wb.fit(AXIS, LOG, FREE, start={"w": 0.5}, bounds={"w": (0.4, 10.0)})
    assert found.values["w"] == pytest.approx(0.4, rel=1e-5)
    assert "An estimate lies on its bound, where its interval does not hold: w." in found.warnings


@pytest.mark.parametrize(
    ("bounds", "words"),
    [
        ({"w": (1.0, 2.0)}, "start 0.5 within"),
        ({"w": (2.0, 0.1)}, "increasing"),
        ({"q": (0.0, 1.0)}, "There is no 'q'"),
    ],
)
def test_bounds_that_cannot_hold_are_refused(bounds, words):
    with pytest.raises((ValueError, LookupError), match=words):
        wb.fit(AXIS, LOG, FREE, start={"w": 0.5}, bounds=bounds)
