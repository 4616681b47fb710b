// Reads states, has TinyMPC solve from each, and writes ticks, iterations, success, bytes of heap and the first input.
#include "tiny_api.hpp"

extern "C" {
#include "platform.h"
extern void (*starters_begin[])(void), (*starters_end[])(void);
}

#include "problem.h"

extern "C" size_t heap_in_use(void);

static TinySolver *solver;

static void prepare(void)
{
    tinyMatrix A = Map<const Matrix<double, NX, NX>>(A_columns), B = Map<const Matrix<double, NX, NU>>(B_columns);
    tinyVector drifting = Map<const Matrix<double, NX, 1>>(drift);
    tinyMatrix Q = tinyMatrix::Zero(NX, NX), R = tinyMatrix::Zero(NU, NU);
    Q.diagonal() = Map<const Matrix<double, NX, 1>>(Q_diagonal);
    R.diagonal() = Map<const Matrix<double, NU, 1>>(R_diagonal);
    tiny_setup(&solver, A, B, drifting, Q, R, PENALTY, NX, NU, STAGES + 1, 0);
    tinyMatrix x = tinyMatrix::Constant(NX, STAGES + 1, 1e17), low(NU, STAGES), high(NU, STAGES);
    for (int i = 0; i < NU; i++) {
        low.row(i).setConstant(lowest[i]);
        high.row(i).setConstant(highest[i]);
    }
    tiny_set_bound_constraints(solver, -x, x, low, high);
    solver->settings->en_state_bound = 0; // no state has a limit
    for (int i = 0; i < NU; i++) solver->work->Uref.row(i).setConstant(wanted[i]);
#ifdef CONE_SIZE
    VectorXi start(1), size(1), nowhere(0);
    tinyVector slope(1), no_slope(0);
    start << CONE_START;
    size << CONE_SIZE;
    slope << CONE_SLOPE;
    tiny_set_cone_constraints(solver, nowhere, nowhere, no_slope, start, size, slope);
    solver->settings->en_input_soc = 1;
#endif
}

int main(void)
{
    uint64_t head[2], figures[4];
    double x[NX], u[NU];
    for (void (**start)(void) = starters_begin; start < starters_end; start++) (*start)();
    platform_start();
    platform_read(head, sizeof head);
    prepare();
    for (uint64_t left = head[0]; left > 0; left--) {
        platform_read(x, sizeof x);
        const uint32_t begin = platform_ticks();
        for (int i = 0; i < NX; i++) solver->work->x(i, 0) = x[i];
        tiny_solve(solver);
        figures[0] = (uint32_t)(platform_ticks() - begin);
        figures[1] = (uint64_t)solver->solution->iter;
        figures[2] = (uint64_t)solver->solution->solved;
        figures[3] = heap_in_use();
        for (int i = 0; i < NU; i++) u[i] = solver->solution->u(i, 0);
        platform_write(figures, sizeof figures);
        platform_write(u, sizeof u);
    }
    platform_end();
    return 0;
}
