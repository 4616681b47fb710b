/*
 * PID2: a control law that runs once in 0.01 s.
 *
 * Made by control-workbench 0.1.0.
 * Fingerprint of its equations and numbers: 7efe65be0df7551b
 * Numbers of 64 bits (double precision), each product and each sum rounded by itself: the portable
 *     arithmetic.
 * Compile it without options that change arithmetic, such as -ffast-math, -funsafe-math-optimizations,
 *     or -ffp-contract=fast of clang.
 * On Cortex-M3 and M4 GCC's library rounds some differences wrongly: take the form cortex-m4.
 *
 * It reads omega [rad/s].
 * It follows omega [rad/s].
 * It commands v [V].
 * Safe command, where a flag is raised: v = 0 V. The memory then stays, but for commands on their way,
 *     which become the safe one; after a long gap call the reset.
 * All is in the state: one for each loop, whose calls do not overlap. A period without a call is lost.
 */
#include "law.h"

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

static uint64_t law_bits(double x)
{
    union { double number; uint64_t word; } both;
    both.number = x;
    return both.word;
}

static bool law_finite(double x)
{
    return (law_bits(x) & 0x7ff0000000000000u) != 0x7ff0000000000000u; /* also under options that assume it */
}

static bool law_advance(law_state *state,
                        const law_readings *readings,
                        const law_references *references,
                        law_commands *commands)
{
    /* Readings and memory */
    const double omega = readings->omega;
    const double omega_ref = references->omega;
    const double I_1 = state->controller_integral[0];
    const double f_1 = state->controller_filter[0];

    /* Numbers of the law */
    const double K_i_1 = 20.0; /* controller.Ki[0] [V/rad] */
    const double K_p_1 = 10.0; /* controller.Kp[0] [V s/rad] */

    /*
     * Law: PID2
     *
     * PID with two degrees of freedom from an output y and its reference r to an input u, component by component:
     *
     *     v  = u0 + Kp (b r - y) + I + Kd N (w - f),      u = v within low and high
     *     w  = c (r - y0) - (y - y0)
     *     I' = Ki (r - y) + anti-windup,             I(0) = 0
     *     f' = N (w - f),                            f(0) = 0
     *
     * about the point (y0, u0), with weights b, c of what is wanted; without limits, which may be None,
     * u = u0 + Kp (b r - y) + Ki / s (r - y) + Kd s / (1 + s / N) (c r - y), as of MATLAB's `pid2`.
     * "clamping" stops the integral while v is beyond a limit and Ki (r - y) drives it farther; "back-calculation" adds
     * (u - v) / Tt to I'. Limits in `Instruments` are not known to the law: give it the same.
     *
     * In a computer that runs it once in h seconds the filter is a backward difference and the integral a forward one:
     *
     *     f_k = (f_(k-1) + N h w_k) / (1 + N h),     I_(k+1) = I_k + h (Ki (r_k - y_k) + anti-windup)
     */
    const double w_1 = (1.0 * omega_ref) - omega;
    const double w_2 = w_1 - f_1;
    const double v = (0.0 * (0.5 * w_2)) + (I_1 + ((K_p_1 * w_1) + 0.0));

    /* Memory of the controller */
    const double integral_next = (0.01 * ((omega_ref - omega) * K_i_1)) + I_1;
    const double filter_next = (w_2 * 0.5) + f_1;

    /* Nothing is kept that is not finite. */
    const bool done = law_finite(integral_next) &&
        law_finite(filter_next) &&
        law_finite(v);
    if (done) {
        state->controller_integral[0] = integral_next;
        state->controller_filter[0] = filter_next;
        commands->v = v;
    }
    return done;
}

unsigned law_step(law_state *state,
                  const law_readings *readings,
                  const law_references *references,
                  law_commands *commands)
{
    unsigned flags = (unsigned)LAW_OK;
    if (!law_finite(readings->omega)) {
        flags |= (unsigned)LAW_BAD_READING;
    }
    if (!law_finite(references->omega)) {
        flags |= (unsigned)LAW_BAD_REFERENCE;
    }
    if ((flags == 0u) && !law_advance(state, readings, references, commands)) {
        flags |= (unsigned)LAW_BAD_COMMAND;
    }
    if (flags != 0u) {
        commands->v = 0.0;
    }
    state->flags = flags;
    return flags;
}

void law_reset(law_state *state)
{
    state->controller_integral[0] = 0.0;
    state->controller_filter[0] = 0.0;
    state->flags = 0u;
}

void law_init(law_state *state)
{
    law_reset(state);
}
