/* The equations of the paper in the order of the paper; a period is one step of explicit Euler. */
#include "aosmc_rgs.h"

#include <math.h>

static const double h = 0.001;                                  /* s */
static const double m1 = 1.0, m2 = 1.0, l1 = 1.0, l2 = 1.0;     /* kg, m */
static const double g = 9.81;                                   /* m/s^2 */
static const double l = 18.5;                                   /* 1/s */
static const double Lambda[2] = {6.0, 6.0};                     /* 1/s */
static const double phi = 0.01;                                 /* rad/s */
static const matrix L1 = {{{30.0, 0.0}, {0.0, 30.0}}};          /* 1/s */
static const matrix L2 = {{{50.0, 0.0}, {0.0, 50.0}}};          /* 1/s^2 */
static const matrix Q = {{{599.0, 0.0}, {0.0, 599.0}}};
static const matrix S = {{{36.0 / 6.43, 0.0}, {0.0, 36.0 / 6.43}}}; /* B R^-1 B' of (34) */

static matrix product(matrix x, matrix y)
{
    matrix z;
    for (int i = 0; i < 2; ++i)
        for (int j = 0; j < 2; ++j)
            z.a[i][j] = x.a[i][0] * y.a[0][j] + x.a[i][1] * y.a[1][j];
    return z;
}

static double saturated(double x)
{
    return x > 1.0 ? 1.0 : x < -1.0 ? -1.0 : x;
}

static double sign(double x)
{
    return (double)((x > 0.0) - (x < 0.0));
}

void aosmc_rgs_init(aosmc_rgs_state *state)
{
    static const aosmc_rgs_state start = {
        {0.0, 0.0}, {0.0, 0.0}, {0.0, 0.0}, {{{5.0, 0.0}, {0.0, 5.0}}}, {{{10.0, 0.0}, {0.0, 10.0}}}};
    *state = start;
}

void aosmc_rgs_step(aosmc_rgs_state *state, const aosmc_rgs_readings *y, const aosmc_rgs_references *r, double tau[2])
{
    const matrix K = state->K, P = state->P;
    const double v0 = state->qd_hat[0], v1 = state->qd_hat[1];

    /* (2) to (4): M, C and G at the estimates */
    const double c2 = cos(state->q_hat[1]), s2 = sin(state->q_hat[1]), b = m2 * l1 * l2;
    const double m22 = m2 * l2 * l2, m12 = m22 + b * c2, m11 = (m1 + m2) * l1 * l1 + m22 + 2.0 * b * c2;
    const double c11 = -b * s2 * v1, c12 = -b * s2 * (v0 + v1), c21 = b * s2 * v0;
    const double g2 = m2 * g * l2 * sin(state->q_hat[0] + state->q_hat[1]);
    const double g1 = (m1 + m2) * g * l1 * sin(state->q_hat[0]) + g2;

    /* (25) to (29) */
    double s[2], qd_r[2], qdd_r[2], relay[2];
    for (int i = 0; i < 2; ++i) {
        const double e1 = state->q_hat[i] - r->q[i], e2 = state->qd_hat[i] - r->qd[i];
        s[i] = e2 + Lambda[i] * e1;
        qd_r[i] = r->qd[i] - Lambda[i] * e1;
        qdd_r[i] = r->qdd[i] - Lambda[i] * e2;
        relay[i] = saturated(s[i] / phi);
    }
    tau[0] = m11 * qdd_r[0] + m12 * qdd_r[1] + c11 * qd_r[0] + c12 * qd_r[1] + g1 + state->d_hat[0];
    tau[1] = m12 * qdd_r[0] + m22 * qdd_r[1] + c21 * qd_r[0] + g2 + state->d_hat[1];
    for (int i = 0; i < 2; ++i)
        tau[i] -= K.a[i][0] * relay[0] + K.a[i][1] * relay[1];

    /* (33), (34) with A = -W, W = M^-1 K */
    const double over = 1.0 / (m11 * m22 - m12 * m12);
    const matrix inverse = {{{m22 * over, -m12 * over}, {-m12 * over, m11 * over}}};
    const matrix PW = product(P, product(inverse, K)), PSP = product(P, product(S, P));
    const matrix Pt = {{{P.a[0][0], P.a[1][0]}, {P.a[0][1], P.a[1][1]}}};
    const matrix WtP = product(Pt, product(inverse, K)); /* its transpose */
    for (int i = 0; i < 2; ++i) {
        const double growth = P.a[i][0] * s[0] + P.a[i][1] * s[1];
        for (int j = 0; j < 2; ++j) {
            state->K.a[i][j] += h * growth * sign(s[j]);
            state->P.a[i][j] += h * (Q.a[i][j] - WtP.a[j][i] - PW.a[i][j] - PSP.a[i][j]);
        }
    }

    /* (10), (24) */
    const double n0 = tau[0] - c11 * v0 - c12 * v1 - g1, n1 = tau[1] - c21 * v0 - g2;
    const double e[2] = {y->q[0] - state->q_hat[0], y->q[1] - state->q_hat[1]};
    for (int i = 0; i < 2; ++i) {
        const double a = inverse.a[i][0] * n0 + inverse.a[i][1] * n1;
        state->q_hat[i] += h * (state->qd_hat[i] + L1.a[i][0] * e[0] + L1.a[i][1] * e[1]);
        state->qd_hat[i] += h * (a + L2.a[i][0] * e[0] + L2.a[i][1] * e[1]);
        state->d_hat[i] -= h * l * (state->d_hat[i] - y->d[i]);
    }
}
