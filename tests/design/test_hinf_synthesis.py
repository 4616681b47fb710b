"""H-infinity and H2 synthesis against closed forms, a second implementation by SciPy, and the closed loop itself."""

import control
import numpy as np
import pytest
from scipy import linalg

import workbench as wb
from workbench.design.matrices import DesignError
from workbench.design.synthesis.coprime_margin import four_block_plant

ONE = [[1.0]]


def scalar(a, b=1.0, D11=0.0):
    """x' = a x + w1 + b u with the errors x and u, and the measurement x + w2."""
    return wb.synthesis.GeneralizedPlant(
        A=[[a]],
        B1=[[1.0, 0.0]],
        B2=[[b]],
        C1=[[1.0], [0.0]],
        C2=ONE,
        D11=[[D11, 0.0], [0.0, 0.0]],
        D12=[[0.0], [1.0]],
        D21=[[0.0, 1.0]],
        D22=[[0.0]],
    )


def random_plant(seed, n, dt=None, direct=0.3):
    """A plant with full direct terms and some unstable modes."""
    rng = np.random.default_rng(seed)
    nu, ny = (int(k) for k in rng.integers(1, 3, 2))
    nw, nz, draw = ny + int(rng.integers(0, 3)), nu + int(rng.integers(0, 3)), rng.standard_normal
    A = draw((n, n)) / np.sqrt(n)
    A = A if dt else A - rng.uniform(0.2, 1.3) * np.eye(n)
    return wb.synthesis.GeneralizedPlant(
        A, draw((n, nw)), draw((n, nu)), draw((nz, n)), draw((ny, n)), direct * draw((nz, nw)), draw((nz, nu)),
        draw((ny, nw)), direct * draw((ny, nu)), dt=dt,
    )  # fmt: skip


def passes_by_scipy(plant, gamma):
    """Whether SciPy's Riccati solver finds X, Y >= 0 with rho(XY) < gamma^2, without any of our transformations."""
    solutions = []
    p = plant.parts
    for part in (p, p.dual()):
        B, D1, nw = np.hstack([part.B1, part.B2]), np.hstack([part.D11, part.D12]), part.B1.shape[1]
        R = D1.T @ D1
        R[:nw, :nw] -= gamma**2 * np.eye(nw)
        # gamma must exceed the direct term that no control reaches: the signs of R tell
        if (linalg.eigvalsh(R) < 0).sum() != nw:
            return False
        try:
            X = linalg.solve_continuous_are(part.A, B, part.C1.T @ part.C1, R, s=part.C1.T @ D1)
        except linalg.LinAlgError:
            return False
        # of eigenvalues on the axis, which rounding moves to either side, SciPy returns what solves no equation
        gain = np.linalg.solve(R, B.T @ X + D1.T @ part.C1)
        residual = part.A.T @ X + X @ part.A - (X @ B + part.C1.T @ D1) @ gain + part.C1.T @ part.C1
        if np.abs(residual).max() > 1e-6 * max(np.abs(X).max(), 1) ** 2:
            return False
        closed = part.A - B @ gain
        if np.linalg.eigvals(closed).real.max() >= 0 or linalg.eigvalsh(X)[0] < -1e-6 * max(np.abs(X).max(), 1e-6):
            return False
        solutions.append(X)
    return np.abs(np.linalg.eigvals(solutions[0] @ solutions[1])).max() < gamma**2


@pytest.mark.parametrize("a", [-3.0, -1.0, 0.0, 0.5, 2.0])
def test_the_least_gamma_of_a_scalar_plant_is_its_closed_form(a):
    # X = Y solves 2 a X - (1 - 1/gamma^2) X^2 + 1 = 0, and is gamma at the optimum
    answer = wb.hinf_controller(scalar(a))
    gamma = answer.gamma.value
    assert gamma == pytest.approx(a + np.hypot(a, np.sqrt(2)), rel=1e-9)
    assert answer.gamma.low < gamma < answer.gamma.high


@pytest.mark.parametrize("seed", [0, 2, 3, 5])
def test_both_sides_of_gamma_hold_by_another_solver_and_by_the_loop_itself(seed):
    plant = random_plant(seed, n=2 + seed)
    answer = wb.hinf_controller(plant)
    # SciPy's solutions have some 1e-8 where the optimum is a limit of existence
    assert passes_by_scipy(plant, answer.gamma.value * (1 + 1e-5))
    assert not passes_by_scipy(plant, answer.gamma.value * (1 - 1e-5))
    assert answer.gamma.low <= answer.norm.gain.high <= answer.gamma.value * (1 + 1e-5)
    assert answer.poles.real.max() < 0
    peak = max(gain_by_parts(plant, answer.controller, 1j * w) for w in np.logspace(-3, 4, 200))
    assert peak <= answer.norm.gain.high * (1 + 1e-6)  # the controller has a mode 1e6 times faster than the rest


def whole_plant(plant):
    """The plant from w and u to z and y."""
    p = plant.parts
    return control.ss(
        p.A, np.hstack([p.B1, p.B2]), np.vstack([p.C1, p.C2]), np.block([[p.D11, p.D12], [p.D21, p.D22]])
    )  # fmt: skip


def gain_by_parts(plant, controller, s):
    """The largest singular value from w to z at s, from the answers of plant and controller, not from a closed loop."""
    _, nw, nu, nz, _ = plant.sizes
    P, K = whole_plant(plant)(s, squeeze=False), controller(s, squeeze=False)
    inner = np.linalg.solve(np.eye(nu) - K @ P[nz:, nw:], K @ P[nz:, :nw])
    return np.linalg.norm(P[:nz, :nw] + P[:nz, nw:] @ inner, 2)


def bound_at_each_frequency(plant):
    """The largest norm, over frequency, that no feedback can reduce: Parrott's theorem at each frequency by itself."""
    _, nw, _, nz, _ = plant.sizes
    whole = whole_plant(plant)

    def bound(omega):
        M = whole(1j * omega)
        rows, columns = linalg.null_space(M[:nz, nw:].conj().T), linalg.null_space(M[nz:, :nw])
        parts = rows.conj().T @ M[:nz, :nw], M[:nz, :nw] @ columns
        return max((np.linalg.norm(part, 2) for part in parts if part.size), default=0.0)

    grid = np.concatenate([[0.0], np.logspace(-3, 3, 600)])
    best = max(range(len(grid)), key=lambda k: bound(grid[k]))
    near = np.linspace(grid[max(best - 1, 0)], grid[min(best + 1, len(grid) - 1)], 200)
    return max(bound(omega) for omega in near)


@pytest.mark.parametrize("seed", [6, 8, 11])
def test_the_optimum_is_no_less_than_the_bound_of_any_one_frequency(seed):
    plant = random_plant(seed, n=4)
    answer, bound = wb.hinf_controller(plant), bound_at_each_frequency(plant)
    assert bound <= answer.gamma.value * (1 + 1e-10)
    if "Riccati" in answer.limit:  # eigenvalues meet on the axis, at the frequency of the bound
        assert answer.gamma.value == pytest.approx(bound, rel=1e-8)  # of the grid


def test_a_sampled_plant_has_the_gamma_of_its_loop_around_the_circle():
    plant = random_plant(3, n=3, dt=0.5)
    answer = wb.hinf_controller(plant)
    loop = plant.close(answer.controller)
    assert np.abs(answer.poles).max() < 1
    peak = max(np.linalg.norm(loop(np.exp(1j * phi)), 2) for phi in np.linspace(0, np.pi, 400))
    assert peak <= answer.norm.gain.high * (1 + 1e-6) <= answer.gamma.value * (1 + 1e-5)


def test_a_direct_term_that_nothing_reaches_decides_alone():
    # a third disturbance is, times 5, a second error
    plant = wb.synthesis.GeneralizedPlant(
        A=[[-1.0]], B1=[[1.0, 0.0, 0.0]], B2=ONE, C1=[[0.1], [0.0], [0.0]], C2=ONE,
        D11=[[0.0] * 3, [0.0, 0.0, 5.0], [0.0] * 3], D12=[[0.0], [0.0], [1.0]], D21=[[0.0, 1.0, 0.0]], D22=[[0.0]],
    )  # fmt: skip
    answer = wb.hinf_controller(plant)
    assert answer.gamma.value == pytest.approx(5.0, rel=1e-9)
    assert "D11" in answer.limit


def test_an_asked_gamma_is_kept_and_one_below_the_least_is_refused():
    answer = wb.hinf_controller(scalar(0.0), gamma=2.0)
    assert answer.norm.gain.high <= 2.0
    with pytest.raises(DesignError, match=r"gamma = 1.2 is infeasible.*1\.41421356.*spectral radius"):
        wb.hinf_controller(scalar(0.0), gamma=1.2)


GOOD = {
    "A": [[-1.0, 0.0], [0.0, 1.0]], "B1": [[1.0, 0.0], [1.0, 0.0]], "B2": [[1.0], [1.0]],
    "C1": [[1.0, 0.0], [0.0, 0.0]], "C2": [[1.0, 1.0]], "D11": np.zeros((2, 2)),
    "D12": [[0.0], [1.0]], "D21": [[0.0, 1.0]], "D22": [[0.0]],
}  # fmt: skip
OSCILLATOR = {"A": [[0.0, 2.0], [-2.0, 0.0]], "B2": [[0.0], [1.0]], "C2": [[1.0, 0.0]]}


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"B2": [[1.0], [0.0]]}, r"\(A, B2\) is not stabilisable.*mode 1"),
        ({"C2": [[1.0, 0.0]]}, r"\(C2, A\) is not detectable.*mode 1"),
        ({"D12": [[0.0], [0.0]]}, "D12 must have full column rank 1"),
        ({"D21": [[0.0, 0.0]]}, "D21 must have full row rank 1"),
        ({**OSCILLATOR, "C1": np.zeros((2, 2))}, r"loses column rank at w = 2 rad/s"),
        ({**OSCILLATOR, "B1": np.zeros((2, 2))}, r"loses row rank at w = 2 rad/s"),
    ],
)
@pytest.mark.parametrize("design", [wb.hinf_controller, wb.h2_controller])
def test_each_condition_is_refused_by_its_name(design, change, words):
    with pytest.raises(DesignError, match=words):
        design(wb.synthesis.GeneralizedPlant(**{**GOOD, **change}))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"C2": [[1.0, 1.0, 0.0]]}, r"C2 must be a matrix of shape \(any, 2\)"),
        ({"D11": [[np.nan, 0.0], [0.0, 0.0]]}, r"D11 must hold finite numbers; D11\[0, 0\] is nan"),
        ({"dt": -1.0}, "dt must be a positive period"),
        ({"controls": ("a", "b")}, "controls must name each of the 1"),
    ],
)
def test_a_plant_of_bad_matrices_is_refused(change, words):
    with pytest.raises(ValueError, match=words):
        wb.synthesis.GeneralizedPlant(**{**GOOD, **change})


def test_a_sampled_plant_is_refused_with_its_own_modes_and_frequencies():
    unmoved = {**GOOD, "A": [[0.5, 0.0], [0.0, 1.2]], "B2": [[1.0], [0.0]], "dt": 0.1}
    with pytest.raises(DesignError, match=r"not stabilisable.*mode 1\.2 of A"):
        wb.hinf_controller(wb.synthesis.GeneralizedPlant(**unmoved))
    turn = np.array([[np.cos(0.3), np.sin(0.3)], [-np.sin(0.3), np.cos(0.3)]])  # 3 rad/s at this period
    free = {**GOOD, **OSCILLATOR, "A": turn, "C1": np.zeros((2, 2)), "dt": 0.1}
    with pytest.raises(DesignError, match=r"w = 3 rad/s.*unit circle"):
        wb.h2_controller(wb.synthesis.GeneralizedPlant(**free))


def test_a_direct_path_from_the_control_to_the_measurement_changes_no_gamma():
    p = random_plant(5, n=3)
    bare = wb.synthesis.GeneralizedPlant(p.A, p.B1, p.B2, p.C1, p.C2, p.D11, p.D12, p.D21, 0 * p.D22)
    assert wb.hinf_controller(p).gamma.value == pytest.approx(wb.hinf_controller(bare).gamma.value, rel=1e-9)


def test_lqg_is_the_h2_controller_of_its_weights_and_noises():
    G = control.ss([[0.0, 1.0], [2.0, -0.3]], [[0.0], [1.0]], [[1.0, 0.0]], 0.0)
    Q, R, Qn, Rn = np.diag([4.0, 1.0]), [[0.25]], np.diag([0.0, 9.0]), [[0.01]]
    plant = wb.synthesis.GeneralizedPlant(
        A=G.A, B1=np.hstack([np.sqrt(Qn), np.zeros((2, 1))]), B2=G.B, C1=np.vstack([np.sqrt(Q), np.zeros((1, 2))]),
        C2=G.C, D11=np.zeros((3, 3)), D12=[[0.0], [0.0], [0.5]], D21=[[0.0, 0.0, 0.1]], D22=[[0.0]],
    )  # fmt: skip
    h2, lqg = wb.h2_controller(plant), wb.lqg(G, Q, R, Qn, Rn)
    for name in ("A", "B", "C", "D"):
        assert getattr(h2.controller, name) == pytest.approx(getattr(lqg.controller, name), rel=1e-9, abs=1e-9)
    assert h2.norm.gain.value == pytest.approx(h2.least, rel=1e-10)


@pytest.mark.parametrize("dt", [None, 0.5])
def test_no_controller_near_that_of_h2_has_a_smaller_norm(dt):
    plant = random_plant(11, n=2, dt=dt, direct=0.0)
    best = wb.h2_controller(plant)
    K = best.controller
    rng = np.random.default_rng(1)
    for _ in range(12):
        A, B, C, D = (M + 1e-3 * rng.standard_normal(M.shape) * (M != 0) for M in (K.A, K.B, K.C, K.D))
        changed = wb.h2_norm(plant.close(control.ss(A, B, C, D, dt or 0)))
        assert changed.gain.value >= best.norm.gain.value * (1 - 1e-12)


def test_h2_refuses_a_direct_term_from_noise_to_error():
    with pytest.raises(DesignError, match="D11 must be zero"):
        wb.h2_controller(scalar(0.0, D11=1.0))


@pytest.mark.parametrize("dt", [None, 0.1])
def test_the_margin_of_coprime_factors_is_the_inverse_of_the_four_block_gamma(dt):
    G = control.ss([[0.3, 1.0], [0.0, -0.7]], np.eye(2), [[1.0, 0.5], [0.0, 1.0]], [[0.0, 0.2], [0.0, 0.1]], dt or 0)
    answer = wb.coprime_margin(G, fraction=0.9)
    assert answer.b_opt == pytest.approx(1 / wb.hinf_controller(four_block_plant(G)).gamma.value, rel=1e-8)
    assert 0.9 * answer.b_opt * (1 - 1e-9) <= answer.margin.low < answer.b_opt


def test_the_margin_of_a_scalar_plant_is_its_closed_form():
    # X = Z = a + sqrt(a^2 + 1) for 1/(s - a)
    for a in (-2.0, 0.0, 1.0, 30.0):
        X = a + np.hypot(a, 1.0)
        found = wb.coprime_margin(control.ss(a, 1.0, 1.0, 0.0)).b_opt
        assert found == pytest.approx(1 / np.sqrt(1 + X * X), rel=1e-13)


@pytest.mark.parametrize(
    ("B", "C", "words"), [([[0.0], [1.0]], [[1.0, 1.0]], "stabilisable"), ([[1.0], [1.0]], [[0.0, 1.0]], "detectable")]
)
def test_a_hidden_unstable_mode_has_no_margin(B, C, words):
    with pytest.raises(DesignError, match=f"not {words}.*mode 1"):
        wb.coprime_margin(control.ss([[1.0, 0.0], [0.0, -1.0]], B, C, 0.0))
