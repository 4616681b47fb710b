/* AOSMC-RGS with its observers for the arm of two links, written by hand: the peer of the generated code. */
#ifndef AOSMC_RGS_H
#define AOSMC_RGS_H

typedef struct { double a[2][2]; } matrix; /* a[row][column] */

typedef struct {
    double q_hat[2];  /* rad */
    double qd_hat[2]; /* rad/s */
    double d_hat[2];  /* N m */
    matrix K;         /* N m */
    matrix P;         /* N m/rad */
} aosmc_rgs_state;

typedef struct { double q[2], d[2]; } aosmc_rgs_readings;
typedef struct { double q[2], qd[2], qdd[2]; } aosmc_rgs_references;

void aosmc_rgs_init(aosmc_rgs_state *state);
void aosmc_rgs_step(aosmc_rgs_state *state, const aosmc_rgs_readings *y, const aosmc_rgs_references *r, double tau[2]);

#endif
