"""Inverse dynamics from logs: numbers come back, doubt is honest, and what no rigid body has is refused by name."""

from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import workbench as wb
from workbench.arms.dynamics import Dynamics
from workbench.arms.log_regression import JointTerms, fit_inverse_dynamics, prepare_motion, pseudo_inertias
from workbench.arms.log_regression.regression import correlation_length
from workbench.arms.mechanics import Link, PlanarArm, SpatialArm, SpatialLink
from workbench.identification import Experiment

ARM = PlanarArm((Link(0.6, 0.3, 0.2, 0.01, 0.02), Link(0.5, 0.2, 0.15, -0.005, 0.01)))
VISCOUS, COULOMB, DRIVE = np.array([0.05, 0.02]), np.array([0.3, 0.15]), np.array([0.0, 0.004])
SMOOTHING = 0.02  # rad/s
TERMS = JointTerms(smoothing=SMOOTHING)
Q, TAU = ("q1", "q2"), ("tau1", "tau2")
UNITS = {"q1": "rad", "q2": "rad", "tau1": "N m", "tau2": "N m"}


@cache
def exact_samples(seed):
    """Times, positions and torques along sums of sines, by M, C and G of the arm and not by a regressor."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 8.0, 2e-3)
    w = 2 * np.pi * np.arange(1, 6) / 5.0
    a, b = rng.normal(0.0, 1.0, (2, 5, 2)) / w[:, np.newaxis]
    phase = np.multiply.outer(t, w)
    q = np.sin(phase) @ a + np.cos(phase) @ b
    qd = np.cos(phase) @ (a * w[:, np.newaxis]) - np.sin(phase) @ (b * w[:, np.newaxis])
    qdd = -np.sin(phase) @ (a * (w**2)[:, np.newaxis]) - np.cos(phase) @ (b * (w**2)[:, np.newaxis])
    dynamics = Dynamics.of(ARM)
    tau = np.empty_like(q)
    for i, (x, v, acceleration) in enumerate(zip(q, qd, qdd, strict=True)):
        M, C, G = dynamics.matrices(x, v)
        tau[i] = M @ acceleration + C @ v + np.ravel(G)
    return t, q, tau + DRIVE * qdd + VISCOUS * qd + COULOMB * np.tanh(qd / SMOOTHING)


def exact_log(seed, noise=(0.0, 0.0), quantum=0.0, name="log", draw=0):
    """A log of the arm, with noise of the positions and torques and with quantised positions."""
    t, q, tau = exact_samples(seed)
    rng = np.random.default_rng(draw)
    q = q + noise[0] * rng.standard_normal(q.shape)
    tau = tau + noise[1] * rng.standard_normal(q.shape)
    q = quantum * np.round(q / quantum) if quantum else q
    return log_of(t, np.hstack([q, tau]), name)


def log_of(t, values, name="log"):
    """A log of both positions and both torques, (N, 4)."""
    return wb.Dataset.of(t, dict(zip((*Q, *TAU), values.T, strict=True)), UNITS, name=name)


def truth(fit):
    """The true base parameters: those of the bodies by the arm's own numbers, and frictions and drives."""
    Y = fit.base.regressor
    theta = Y.theta.copy()
    for word, values in (("viscous", VISCOUS), ("coulomb", COULOMB), ("drive", DRIVE)):
        for i, value in enumerate(values):
            theta[Y.names.index(f"link{i + 1}.{word}")] = value
    return fit.base.K @ theta


@pytest.fixture(scope="module")
def exact():
    return fit_inverse_dynamics(ARM, exact_log(3), Q, TAU, cutoff=40.0, terms=TERMS)


def test_a_log_without_noise_gives_all_base_parameters_frictions_and_drives_back(exact):
    assert exact.condition < 30
    assert len(exact.names) == 11  # six of the bodies, a drive that no body hides, and four frictions
    # the filter turns the corners of the Coulomb friction at 0.02 rad/s round, and this friction is 0.3 N m
    np.testing.assert_allclose(exact.theta, truth(exact), atol=4e-3)
    assert exact.explained_shares["log"].min() > 0.998  # the same corners are what is left
    assert exact.bodies is not None
    assert exact.bodies.is_checked
    assert exact.reasons_to_refuse == ()


def test_noise_and_quantised_positions_leave_the_truth_within_the_errors_that_are_said():
    off = []
    for seed in range(6):
        log = exact_log(3, noise=(2e-4, 0.05), quantum=3.8e-4, draw=seed)
        fit = fit_inverse_dynamics(ARM, log, Q, TAU, cutoff=20.0, terms=TERMS, physical="ignore")
        off.append((fit.theta - truth(fit)) / np.array(list(fit.standard_errors.values())))
    # 66 standard normal numbers and a bias of the corners: a root mean square above 2 has no chance if errors are right
    assert np.sqrt(np.mean(np.square(off))) < 2
    assert np.sqrt(np.mean(np.square(off))) > 0.3  # nor are the errors far too large


def test_a_hold_out_by_name_is_not_seen_by_the_fit():
    both = exact_log(3, name="first").with_experiments(exact_log(4, name="second"))
    fit = fit_inverse_dynamics(ARM, both, Q, TAU, cutoff=40.0, terms=TERMS, hold_out=["second"], physical="ignore")
    assert [motion.name for motion in fit.held_out] == ["second"]
    rows = both.experiment("second").values.copy()
    rows[:, 2:] *= 5.0  # other torques in the hold-out change its errors, and no estimate
    other = wb.Dataset((both.experiments[0], Experiment("second", both.experiments[1].t, both.signals, rows)))
    worse = fit_inverse_dynamics(
        ARM, other, Q, TAU, cutoff=40.0, terms=TERMS, hold_out=["second"], physical="ignore", even_if_refused=True
    )
    np.testing.assert_array_equal(worse.theta, fit.theta)
    assert (worse.root_mean_squares["second"] > 10 * fit.root_mean_squares["second"]).all()


def test_a_joint_that_hardly_moves_is_refused_by_the_names_of_its_numbers():
    log = exact_log(3)
    values = log.experiments[0].values.copy()
    values[:, 1] = 0.3
    stiff = log_of(log.experiments[0].t, values)
    with pytest.raises(ValueError, match=r"cannot tell .*link2\.drive.* apart: the condition is"):
        fit_inverse_dynamics(ARM, stiff, Q, TAU, cutoff=40.0, terms=TERMS)


def test_torques_of_no_rigid_body_are_refused_and_imposed_bodies_pass_the_check_of_eigenvalues():
    log = exact_log(3, noise=(0.0, 0.02))
    values = log.experiments[0].values.copy()
    motion = prepare_motion(log, Q, TAU, 40.0)[0]
    values[:, 3] -= 0.03 * motion.qdd[:, 1]  # takes more inertia from link 2 than it and its drive have
    values[:, 3] -= 0.03 * motion.qdd[:, 0]
    values[:, 2] -= 0.03 * motion.qdd.sum(axis=1)
    strange = log_of(log.experiments[0].t, values)
    with pytest.raises(ValueError, match=r"No rigid body has these numbers: .*link2\.I_zz"):
        fit_inverse_dynamics(ARM, strange, Q, TAU, cutoff=40.0, terms=TERMS)
    imposed = fit_inverse_dynamics(ARM, strange, Q, TAU, cutoff=40.0, terms=TERMS, physical="impose")
    assert imposed.bodies is not None
    matrices = pseudo_inertias(imposed.base.regressor.names, imposed.bodies.theta)
    assert min(np.linalg.eigvalsh(one)[0] for one in matrices.values()) >= 0
    np.testing.assert_allclose(imposed.base.K @ imposed.bodies.theta, imposed.theta)


def test_pseudo_inertias_of_a_body_in_space_are_its_second_moments():
    points = np.random.default_rng(0).normal(0.0, 0.1, (6, 3)) + [0.1, -0.2, 0.3]
    masses = np.linspace(0.2, 1.0, 6)
    centre = masses @ points / masses.sum()
    rest = points - centre
    I = sum(m * (p @ p * np.eye(3) - np.outer(p, p)) for m, p in zip(masses, rest, strict=True))
    link = SpatialLink("body", masses.sum(), centre, I[np.triu_indices(3)])
    Y = wb.regressor(SpatialArm((link,)))
    homogeneous = np.column_stack([points, np.ones(6)])
    expected = homogeneous.T @ (masses[:, np.newaxis] * homogeneous)
    np.testing.assert_allclose(pseudo_inertias(Y.names, Y.theta)["body"], expected, atol=1e-14)


def test_a_slide_gives_mass_friction_and_offset_in_their_units():
    slide = SpatialArm((SpatialLink("slide", 1.0, np.zeros(3), (1, 0, 0, 1, 0, 1), axis=(1, 0, 0), joint="prismatic"),))

    def force(t):
        return 40 * np.sin(7 * t) + 30 * np.sin(3 * t)

    def rate(t, x):
        return [x[1], (force(t) - 50 * x[1] - 8 * np.tanh(x[1] / 0.01) + 2) / 20]

    t = np.arange(0.0, 10.0, 1e-3)
    run = solve_ivp(rate, (0, 10), [0.0, 0.0], t_eval=t, rtol=1e-9, atol=1e-11, method="LSODA")
    log = wb.Dataset.of(t, {"x": run.y[0], "F": force(t)}, {"x": "m", "F": "N"})
    terms = JointTerms(drive=False, offset=True, smoothing=0.01)
    fit = fit_inverse_dynamics(slide, log, ["x"], ["F"], cutoff=40.0, terms=terms)
    assert dict(zip(fit.names, fit.base.units, strict=True))["slide.viscous"] == "N s/m"
    expected = {"slide.m": 20.0, "slide.viscous": 50.0, "slide.coulomb": 8.0, "slide.offset": -2.0}
    for name, value in expected.items():
        assert fit.values[name] == pytest.approx(value, rel=4e-3), name  # the corners of the friction, filtered


def test_slow_samples_have_no_weight_and_the_fit_says_so():
    terms = JointTerms(least_speed=0.1)
    fit = fit_inverse_dynamics(ARM, exact_log(3), Q, TAU, cutoff=40.0, terms=terms, physical="ignore")
    assert any("Slower than 0.1 and not weighed" in text for text in fit.warnings)
    np.testing.assert_allclose(fit.theta, truth(fit), atol=4e-3)  # sign(qd) is that friction away from zero speed


def test_the_length_of_a_correlation_is_that_of_a_moving_mean():
    noise = np.random.default_rng(0).standard_normal(20000)
    assert correlation_length(noise) == 1
    assert 40 <= correlation_length(np.convolve(noise, np.ones(50))) <= 50  # 1 - k/50 falls below 0.1 at k = 45


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"positions": ("q1",)}, "must be 2 labels"),
        ({"torques": ("tau1",)}, "must be 2 labels"),
        ({"hold_out": ["log"]}, "leave one for the fit"),
        ({"share": 1.0}, "between 0 and 1"),
        ({"cutoff": 0.4}, "leaves no sample"),
        ({"physical": "maybe"}, "check"),
    ],
)
def test_bad_arguments_are_named(change, message):
    arguments = {"positions": Q, "torques": TAU, "cutoff": 40.0} | change
    with pytest.raises(ValueError, match=message):
        fit_inverse_dynamics(ARM, exact_log(3), terms=TERMS, **arguments)
