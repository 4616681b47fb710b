/*
 * PID: a control law that runs once in 0.001 s.
 *
 * Made by control-workbench 0.1.0.
 * Fingerprint of its equations and numbers: 5a8a7c6bfafccc7b
 * Numbers of 64 bits (double precision), each product and each sum rounded by itself: the portable
 *     arithmetic.
 * Compile it without options that change arithmetic, such as -ffast-math, -funsafe-math-optimizations,
 *     or -ffp-contract=fast of clang.
 * On Cortex-M3 and M4 GCC's library rounds some differences wrongly: take the form cortex-m4.
 *
 * A call makes 12 sums, 11 products, 1 quotient, 4 comparisons and choices, 2 fmax, 2 fmin; 5 of them
 *     depend on numbers of the law alone.
 * Stack of a call: 8 bytes, measured: as gcc 12.2.0 -O2 lays it out for x86_64-linux-gnu.
 * Link flags: none, not even -lm. It calls no function of a library.
 *
 * It reads omega [rad/s].
 * It follows omega [rad/s].
 * It commands v [V].
 * Limits of v: -24 to 24 V.
 * Safe command, where a flag is raised: v = 0 V. The memory then stays, but for commands on their way,
 *     which become the safe one; after a long gap call the reset.
 * All is in the state: one for each loop, whose calls do not overlap. A period without a call is lost.
 */
#include "motor_law.h"

#include <float.h>
#include <stdbool.h>

#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__) || \
    defined(__NO_SIGNED_ZEROS__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))
#error "This law needs each operation rounded as IEEE 754 says: compile it without -ffast-math and its parts."
#endif
#if FLT_EVAL_METHOD != 0
#error "This law needs operations of the width of their type: on x86 compile it with -msse2 -mfpmath=sse."
#endif
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__)
#pragma GCC optimize ("fp-contract=off")
#elif defined(_MSC_VER)
#pragma fp_contract (off)
#endif

static uint64_t motor_law_bits(double x)
{
    union { double number; uint64_t word; } both;
    both.number = x;
    return both.word;
}

static bool motor_law_finite(double x)
{
    return (motor_law_bits(x) & 0x7ff0000000000000u) != 0x7ff0000000000000u; /* also under options that assume it */
}

static bool motor_law_defined(double x)
{
    return (motor_law_bits(x) & ~0x8000000000000000u) <= 0x7ff0000000000000u; /* it is a number, or infinite */
}

/* The larger number; of a number and what is none, the number. */
static double motor_law_fmax(double a, double b)
{
    const bool t0 = b != b;
    const bool t1 = a >= b;
    const double v2 = t1 ? a : b;
    const double v3 = t0 ? a : v2;
    return v3;
}

/* The smaller number; of a number and what is none, the number. */
static double motor_law_fmin(double a, double b)
{
    const bool t0 = b != b;
    const bool t1 = a <= b;
    const double v2 = t1 ? a : b;
    const double v3 = t0 ? a : v2;
    return v3;
}

static bool motor_law_advance(motor_law_state *state,
                              const motor_law_readings *readings,
                              const motor_law_references *references,
                              motor_law_commands *commands)
{
    /* Readings and memory */
    const double omega = readings->omega;
    const double omega_ref = references->omega;
    const double I_1 = state->controller_integral[0];
    const double f_1 = state->controller_filter[0];

    /*
     * Numbers of the law. To change one, edit its line here: all that depends on it is computed from this
     * line, and equal numbers are not merged. The start of the memory, the safe command and the period are
     * not made of them.
     */
    const double K_p_1 = 100.0; /* controller.Kp[0] [V s/rad] */
    const double K_i_1 = 200.0; /* controller.Ki[0] [V/rad] */
    const double K_d_1 = 0.0; /* controller.Kd[0] [V s^2/rad] */
    const double N_1 = 100.0; /* controller.N[0] [1/s] */
    const double b_1 = 1.0; /* controller.b[0] */
    const double x_c_1 = 1.0; /* controller.c[0] */
    const double u_min_1 = -24.0; /* controller.low[0] [V] */
    const double u_max_1 = 24.0; /* controller.high[0] [V] */
    const double u_0_1 = 0.0; /* controller.u0[0] [V] */
    const double y_0_1 = 0.0; /* controller.y0[0] [rad/s] */
    const double w_1 = 0.001 * N_1;
    const double w_2 = 1.0 / (w_1 + 1.0);

    /*
     * Law: PID
     *
     * A PID law with two degrees of freedom, from outputs y and their references r to inputs u of the plant:
     *
     *     v  = u0 + Kp (b r - y) + I + Kd N (w - f),      u = min(max(v, low), high)
     *     w  = c (r - y0) - (y - y0)
     *     I' = Ki (r - y) + anti-windup,             I(0) = 0
     *     f' = N (w - f),                            f(0) = 0
     *
     * Without limits it is u = u0 + Kp (b r - y) + Ki / s (r - y) + Kd s / (1 + s / N) (c r - y), as of MATLAB's `pid2`.
     *
     * The law works component by component: the first component of y drives the first component of u, and so on. With
     * several components it is a decentralised law. A single number as a gain holds for all components.
     *
     * In a computer with the period h, the derivative is a backward difference and the integral a forward difference:
     *
     *     f_k = (f_(k-1) + N h w_k) / (1 + N h),     I_(k+1) = I_k + h (Ki (r_k - y_k) + anti-windup)
     */
    const double w_3 = (x_c_1 * (omega_ref - y_0_1)) - (omega - y_0_1) - f_1;
    const double w_4 = I_1 + ((K_p_1 * ((b_1 * omega_ref) - omega)) + u_0_1);
    const double w_5 = (N_1 * K_d_1 * (w_2 * w_3)) + w_4;
    const double v = motor_law_fmin(motor_law_fmax(w_5, u_min_1), u_max_1);

    /* Memory of the controller */
    const double w_6 = (omega_ref - omega) * K_i_1;
    const double w_7 = (w_5 < u_min_1) ? motor_law_fmax(w_6, 0.0) : w_6;
    const double integral_next = (0.001 * ((u_max_1 < w_5) ? motor_law_fmin(w_7, 0.0) : w_7)) + I_1;
    const double filter_next = (w_3 * (w_1 * w_2)) + f_1;

    /* Nothing is kept that is not finite. */
    const bool done = motor_law_finite(integral_next) &&
        motor_law_finite(filter_next) &&
        motor_law_finite(v) &&
        motor_law_defined(w_5);
    if (done) {
        state->controller_integral[0] = integral_next;
        state->controller_filter[0] = filter_next;
        commands->v = v;
    }
    return done;
}

unsigned motor_law_step(motor_law_state *state,
                        const motor_law_readings *readings,
                        const motor_law_references *references,
                        motor_law_commands *commands)
{
    unsigned flags = (unsigned)MOTOR_LAW_OK;
    if (!motor_law_finite(readings->omega)) {
        flags |= (unsigned)MOTOR_LAW_BAD_READING;
    }
    if (!motor_law_finite(references->omega)) {
        flags |= (unsigned)MOTOR_LAW_BAD_REFERENCE;
    }
    if ((flags == 0u) && !motor_law_advance(state, readings, references, commands)) {
        flags |= (unsigned)MOTOR_LAW_BAD_COMMAND;
    }
    if (flags != 0u) {
        commands->v = 0.0;
    }
    state->flags = flags;
    return flags;
}

void motor_law_reset(motor_law_state *state)
{
    state->controller_integral[0] = 0.0;
    state->controller_filter[0] = 0.0;
    state->flags = 0u;
}

void motor_law_init(motor_law_state *state)
{
    motor_law_reset(state);
}
/* control-workbench sha256:bbf6b55f40f7c60423f640adc0079f960a6b59f3a3e817c980927a58fbd761bd */
