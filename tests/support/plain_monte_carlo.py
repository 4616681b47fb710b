"""The 'paper' scenario of a8 once more, in plain C from the equations of the paper: no part of the workbench runs.

The computer runs at 1 kHz; the arm moves by one Runge-Kutta step a period.
"""

import ctypes
import subprocess
from dataclasses import astuple, dataclass

import numpy as np

PERIOD, STEPS = 1e-3, 6000
NOISE = np.array([1e-4, 5e-3])  # rad, rad/s
ACCEPTABLE = {"RMSE": 0.5, "late RMSE": 0.005, "TV": 300.0, "effort": 50.0}
LAWS = {  # with the numbers of each that are tuned
    "RBF-ASMC": ("Lambda_1", "Lambda_2", "phi", "K(0)", "gamma", "Gamma", "sigma"),
    "SMC": ("Lambda_1", "Lambda_2", "phi", "K_1", "K_2"),
    "AOSMC-RGS": ("Lambda_1", "Lambda_2", "phi", "K(0)", "P(0)", "Q", "R"),
}
OBSERVERS = ("L1", "L2", "l")

PROGRAM = r"""
#include <math.h>

enum { RBF, SMC, AOSMC };
enum { NODES = 5 };

/* equations (2) to (4), with the C of the Christoffel symbols for (3), of masses and lengths p = m1, m2, l1, l2:
   M_11, M_12 = M_21, M_22, m2 l1 l2 sin q2, G_1 and G_2 */
static void entries(const double *p, const double *q, double *e)
{
    double near = p[1] * p[3], far = p[1] * p[2] * p[3], shoulder = (p[0] + p[1]) * p[2];
    double coupled = far * cos(q[1]), hand = 9.81 * near * sin(q[0] + q[1]);
    e[2] = near * p[3], e[1] = e[2] + coupled, e[0] = shoulder * p[2] + e[2] + 2 * coupled;
    e[3] = far * sin(q[1]), e[4] = 9.81 * shoulder * sin(q[0]) + hand, e[5] = hand;
}

/* M^-1 (tau - C qd - G) by Cramer's rule */
static void accelerate(const double *p, const double *q, const double *qd, const double *tau, double *found)
{
    double e[6], u, v;
    entries(p, q, e);
    u = tau[0] + e[3] * qd[1] * (2 * qd[0] + qd[1]) - e[4], v = tau[1] - e[3] * qd[0] * qd[0] - e[5];
    found[0] = (e[2] * u - e[1] * v) / (e[0] * e[2] - e[1] * e[1]);
    found[1] = (e[0] * v - e[1] * u) / (e[0] * e[2] - e[1] * e[1]);
}

static void wanted(double t, double *r, double *rd, double *rdd)
{
    const double amplitude[2] = {1.0, 0.5}, frequency[2] = {2.0, 3.0};
    for (int j = 0; j < 2; ++j) {
        double w = frequency[j];
        r[j] = amplitude[j] * sin(w * t), rd[j] = amplitude[j] * w * cos(w * t);
        rdd[j] = -amplitude[j] * w * w * sin(w * t);
    }
}

/* the arm of a draw: masses and lengths, friction, push, pace and phase of the disturbance */
typedef struct { double p[4], friction, push[2], pace[2], phase[2], start[2]; } Draw;

static void rate(const Draw *arm, double t, const double *x, const double *tau, double *out)
{
    double left[2];
    for (int j = 0; j < 2; ++j) {
        double qd = x[2 + j], disturbance = arm->push[j] * sin(arm->pace[j] * t + arm->phase[j]);
        left[j] = tau[j] - arm->friction * (0.1 * qd + 0.2 * tanh(qd / 0.05)) - disturbance;
    }
    out[0] = x[2], out[1] = x[3];
    accelerate(arm->p, x, x + 2, left, out + 2);
}

/* one classical Runge-Kutta step of the arm */
static void move(const Draw *arm, double t, double h, double *x, const double *tau)
{
    double k[4][4], y[4];
    rate(arm, t, x, tau, k[0]);
    for (int n = 1; n < 4; ++n) {
        double s = n == 3 ? h : h / 2;
        for (int j = 0; j < 4; ++j)
            y[j] = x[j] + s * k[n - 1][j];
        rate(arm, t + s, y, tau, k[n]);
    }
    for (int j = 0; j < 4; ++j)
        x[j] += h / 6 * (k[0][j] + 2 * k[1][j] + 2 * k[2][j] + k[3][j]);
}

/* Z of A Z = Z0, four rows and two columns, by elimination with pivots */
static void eliminate(double A[4][4], double Z[4][2])
{
    for (int i = 0; i < 4; ++i) {
        int pivot = i;
        for (int r = i + 1; r < 4; ++r)
            pivot = fabs(A[r][i]) > fabs(A[pivot][i]) ? r : pivot;
        for (int c = 0; c < 4; ++c) {
            double a = A[i][c];
            A[i][c] = A[pivot][c], A[pivot][c] = a;
        }
        for (int c = 0; c < 2; ++c) {
            double z = Z[i][c];
            Z[i][c] = Z[pivot][c], Z[pivot][c] = z;
        }
        for (int r = 0; r < 4; ++r) {
            double share = r == i ? 0 : A[r][i] / A[i][i];
            for (int c = 0; c < 4; ++c)
                A[r][c] -= share * A[i][c];
            for (int c = 0; c < 2; ++c)
                Z[r][c] -= share * Z[i][c];
        }
    }
    for (int i = 0; i < 4; ++i)
        for (int c = 0; c < 2; ++c)
            Z[i][c] /= A[i][i];
}

/* (34) in a Cayley step of its Hamiltonian: with P = Y / X, X' = -A X + B Y and Y' = Q X + A^T Y, where A = -M^-1 K */
static void riccati(double h, const double *e, double K[2][2], double P[2][2], const double *B, double Q)
{
    double det = e[0] * e[2] - e[1] * e[1], A[2][2], H[4][4] = {{0}}, left[4][4], Z[4][2];
    for (int c = 0; c < 2; ++c) {
        A[0][c] = -(e[2] * K[0][c] - e[1] * K[1][c]) / det;
        A[1][c] = -(e[0] * K[1][c] - e[1] * K[0][c]) / det;
    }
    for (int i = 0; i < 2; ++i) {
        H[i][2 + i] = B[i], H[2 + i][i] = Q;
        for (int c = 0; c < 2; ++c)
            H[i][c] = -A[i][c], H[2 + i][2 + c] = A[c][i];
    }
    for (int i = 0; i < 4; ++i)
        for (int c = 0; c < 2; ++c) {
            Z[i][c] = i < 2 ? i == c : P[i - 2][c];
            for (int n = 0; n < 4; ++n) {
                left[i][n] = (i == n) - h / 2 * H[i][n];
                Z[i][c] += h / 2 * H[i][n] * (n < 2 ? n == c : P[n - 2][c]);
            }
        }
    eliminate(left, Z);
    double size = Z[0][0] * Z[1][1] - Z[0][1] * Z[1][0];
    for (int i = 0; i < 2; ++i) {
        P[i][0] = (Z[2 + i][0] * Z[1][1] - Z[2 + i][1] * Z[1][0]) / size;
        P[i][1] = (Z[2 + i][1] * Z[0][0] - Z[2 + i][0] * Z[0][1]) / size;
    }
    P[0][1] = P[1][0] = (P[0][1] + P[1][0]) / 2;
}

static double sign(double x) { return (x > 0) - (x < 0); }
static double clipped(double x, double most) { return x > most ? most : x < -most ? -most : x; }

/* a run: the sums of squared errors, of those of the second half, of squared torques, and of changes, for each joint */
static void run(long steps, double h, int law, const double *n, const double *observers, const Draw *arm,
                const double *noise, long stride, double sums[4][2])
{
    const double model[4] = {1, 1, 1, 1}, limit[2] = {100.0, 50.0}, *Lambda = n;
    double phi = n[2], x[4] = {arm->start[0], arm->start[1], 0, 0}, last[2] = {0, 0};
    double seen[4] = {arm->start[0], arm->start[1], 0, 0}, p[2] = {0, 0}, d[2] = {0, 0};
    double gain[2] = {n[3], law == SMC ? n[4] : n[3]}, W[NODES][2] = {{0}};
    double K[2][2] = {{n[3], 0}, {0, n[3]}}, P[2][2] = {{n[4], 0}, {0, n[4]}};
    for (long k = 0; k < steps; ++k, noise += stride) {
        double t = (double)k * h, read[4], e[6], r[2], rd[2], rdd[2], err[2], s[2], tau[2], H[NODES];
        for (int j = 0; j < 4; ++j)
            read[j] = x[j] + noise[j / 2 * (stride / 2) + j % 2];
        const double *q = observers ? seen : read, *qd = q + 2;
        entries(model, q, e);
        if (observers) { /* an observer of the momentum */
            d[0] = observers[2] * (p[0] - e[0] * qd[0] - e[1] * qd[1]);
            d[1] = observers[2] * (p[1] - e[1] * qd[0] - e[2] * qd[1]);
        }
        wanted(t, r, rd, rdd);
        double a[2], v[2];
        for (int j = 0; j < 2; ++j) {
            err[j] = q[j] - r[j], s[j] = qd[j] - rd[j] + Lambda[j] * err[j];
            a[j] = rdd[j] - Lambda[j] * (qd[j] - rd[j]), v[j] = rd[j] - Lambda[j] * err[j];
        }
        tau[0] = e[0] * a[0] + e[1] * a[1] - e[3] * qd[1] * v[0] - e[3] * (qd[0] + qd[1]) * v[1] + e[4] + d[0];
        tau[1] = e[1] * a[0] + e[2] * a[1] + e[3] * qd[0] * v[0] + e[5] + d[1];
        for (int i = 0; i < NODES && law == RBF; ++i) { /* a network of Gaussians along (e, ed) */
            double c = -1 + 0.5 * i, size = 0;
            for (int j = 0; j < 2; ++j)
                size += pow(err[j] - c, 2) + pow(qd[j] - rd[j] - c, 2);
            H[i] = exp(-size / 2);
            for (int j = 0; j < 2; ++j)
                tau[j] += H[i] * W[i][j];
        }
        for (int j = 0; j < 2; ++j)
            tau[j] -= law == AOSMC ? K[j][0] * clipped(s[0] / phi, 1) + K[j][1] * clipped(s[1] / phi, 1)
                                   : gain[j] * clipped(s[j] / phi, 1);
        for (int j = 0; j < 2; ++j)
            tau[j] = clipped(tau[j], limit[j]);
        if (law == RBF) /* a gain that grows with |s| */
            for (int j = 0; j < 2; ++j) {
                gain[j] += h * n[4] * fabs(s[j]);
                for (int i = 0; i < NODES; ++i)
                    W[i][j] += h * (-n[5] * H[i] * s[j] - n[6] * W[i][j]);
            }
        if (law == AOSMC) { /* (33) with a plus as an outer product in Euler steps */
            double grown[2][2], B[2] = {Lambda[0] * Lambda[0] / n[6], Lambda[1] * Lambda[1] / n[6]};
            for (int i = 0; i < 2; ++i)
                for (int j = 0; j < 2; ++j)
                    grown[i][j] = K[i][j] + h * (P[i][0] * s[0] + P[i][1] * s[1]) * sign(s[j]);
            riccati(h, e, K, P, B, n[5]);
            for (int i = 0; i < 4; ++i)
                K[i / 2][i % 2] = grown[i / 2][i % 2];
        }
        if (observers) { /* observer (10) in Cayley steps of its correction */
            double L1 = observers[0], L2 = observers[1], free[2];
            double turned[2] = {0, -e[3] * (seen[2] + seen[3]) * seen[2]}; /* C^T qd */
            accelerate(model, seen, seen + 2, tau, free);
            for (int j = 0; j < 2; ++j) {
                double w = (read[j] - seen[j]) / (1 + h / 2 * L1 + h * h / 4 * L2);
                p[j] += h * (tau[j] + turned[j] - e[4 + j] - d[j]);
                seen[j] += h * seen[2 + j] + h * h / 2 * free[j] + h * (L1 + h * L2) * w;
                seen[2 + j] += h * (free[j] + L2 * w);
            }
        }
        double after[2];
        for (int j = 0; j < 2; ++j)
            err[j] = pow(x[j] - r[j], 2);
        move(arm, t, h, x, tau);
        wanted(t + h, after, rd, rdd);
        for (int j = 0; j < 2; ++j) { /* trapezoids: errors of 1e-6 at 1 ms */
            double mean = (err[j] + pow(x[j] - after[j], 2)) / 2;
            sums[0][j] += mean, sums[1][j] += 2 * k >= steps ? mean : 0;
            sums[2][j] += tau[j] * tau[j], sums[3][j] += k ? fabs(tau[j] - last[j]) : 0;
            last[j] = tau[j];
        }
    }
}

/* draws in rows (count, 13), noise (steps, 2, count, 2), and the sums (count, 4, 2) */
void runs(long count, long steps, double h, int law, const double *n, const double *observers, const double *draws,
          const double *noise, double *sums)
{
    for (long i = 0; i < count; ++i) {
        const double *d = draws + 13 * i;
        Draw arm = {{d[0], d[1], d[2], d[3]}, d[4], {d[5], d[6]}, {d[7], d[8]}, {d[9], d[10]}, {d[11], d[12]}};
        run(steps, h, law, n, observers, &arm, noise + 2 * i, 4 * count, (double (*)[2])(sums + 8 * i));
    }
}
"""


@dataclass(frozen=True)
class Draws:
    """Shares of the nominal numbers, phases and starts of B arms, as a8 draws them: (B, 2), and (B, 1) of friction."""

    masses: np.ndarray
    lengths: np.ndarray
    friction: np.ndarray
    push: np.ndarray
    pace: np.ndarray
    phase: np.ndarray
    start: np.ndarray

    @staticmethod
    def of(rng, count):
        uniform = rng.uniform
        masses, lengths = uniform(0.8, 1.2, (count, 2)), uniform(0.97, 1.03, (count, 2))
        friction, push = uniform(0, 2, (count, 1)), uniform(0, 2, (count, 1)) * [0.5, 0.4]
        pace, phase = uniform(0.5, 2, (count, 1)) * [3.0, 4.0], uniform(0, 2 * np.pi, (count, 2))
        return Draws(masses, lengths, friction, push, pace, phase, [np.pi, -np.pi] + uniform(-0.2, 0.2, (count, 2)))


def compiled(compiler, folder):
    """The program, as a function of a law, its numbers, those of both observers or None, draws and a generator."""
    (folder / "plain.c").write_text(PROGRAM, encoding="utf-8")
    line = [compiler, "-std=c99", "-O2", "-Wall", "-Werror", "-shared", "-fPIC", "plain.c", "-o", "plain.so", "-lm"]
    subprocess.run(line, cwd=folder, check=True, timeout=60)
    program = ctypes.CDLL(str(folder / "plain.so")).runs

    def costs(law, numbers, observers, draws, rng):
        """The cost of each draw, (B,), as a8 defines it."""
        rows = np.ascontiguousarray(np.hstack(astuple(draws)))
        noise = rng.standard_normal((STEPS, 2, len(rows), 2)) * NOISE[:, None, None]
        sums = np.zeros((len(rows), 4, 2))
        own = np.array([numbers[name] for name in LAWS[law]])
        seen = None if observers is None else np.array([observers[name] for name in OBSERVERS])
        places = [
            None if part is None else part.ctypes.data_as(ctypes.c_void_p) for part in (own, seen, rows, noise, sums)
        ]
        counts = ctypes.c_long(len(rows)), ctypes.c_long(STEPS), ctypes.c_double(PERIOD)
        program(*counts, list(LAWS).index(law), *places)
        squares, late, effort, changes = sums.transpose(1, 0, 2)
        found = {
            "RMSE": np.sqrt(squares / STEPS),
            "late RMSE": np.sqrt(2 * late / STEPS),
            "TV": changes / (STEPS * PERIOD),
            "effort": np.sqrt(effort / STEPS),
        }
        return sum(np.hypot(*value.T) / ACCEPTABLE[name] for name, value in found.items())

    return costs
