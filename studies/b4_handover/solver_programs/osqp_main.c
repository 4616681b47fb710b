/* Reads states, has OSQP solve from each, and writes ticks, iterations, success, no heap and the first input. */
#include "osqp.h"
#include "mpc_workspace.h"
#include "platform.h"
#include "problem.h"

static double low[ROWS], high[ROWS];

int main(void)
{
    uint64_t head[2], figures[4];
    double x[NX];
    int i;
    platform_start();
    platform_read(head, sizeof head);
    for (i = 0; i < STAGES * NU; i++) {
        low[(STAGES + 1) * NX + i] = lowest[i % NU];
        high[(STAGES + 1) * NX + i] = highest[i % NU];
    }
    for (uint64_t left = head[0]; left > 0; left--) {
        platform_read(x, sizeof x);
        const uint32_t begin = platform_ticks();
        for (i = 0; i < NX; i++) low[i] = high[i] = -x[i];
        osqp_update_data_vec(&mpc_solver, OSQP_NULL, low, high);
        osqp_solve(&mpc_solver);
        figures[0] = (uint32_t)(platform_ticks() - begin);
        figures[1] = (uint64_t)mpc_solver.info->iter;
        figures[2] = (uint64_t)(mpc_solver.info->status_val == OSQP_SOLVED);
        figures[3] = 0;
        platform_write(figures, sizeof figures);
        platform_write(mpc_solver.solution->x + (STAGES + 1) * NX, NU * sizeof(double));
    }
    platform_end();
    return 0;
}
