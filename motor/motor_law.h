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
#ifndef MOTOR_LAW_H
#define MOTOR_LAW_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define MOTOR_LAW_PERIOD 0.001 /* s, from one call of motor_law_step to the next */

enum { /* flags of motor_law_step, which may come together */
    MOTOR_LAW_OK = 0,
    MOTOR_LAW_BAD_READING = 1, /* a reading is not finite: the safe command */
    MOTOR_LAW_BAD_REFERENCE = 2, /* a reference is not finite: the same */
    MOTOR_LAW_BAD_COMMAND = 4 /* a command, also before its limits, or the memory would not be finite: the same */
};

/* What the instruments read at the instant. */
typedef struct {
    double omega; /* [rad/s] */
} motor_law_readings;

/* What is wanted at the instant. */
typedef struct {
    double omega; /* [rad/s] */
} motor_law_references;

/* What acts on the plant from the instant to the next. */
typedef struct {
    double v; /* [V] */
} motor_law_commands;

/* All that the law keeps from one instant to the next; motor_law_init fills it. */
typedef struct {
    double controller_integral[1]; /* controller.integral [V] */
    double controller_filter[1]; /* controller.filter [rad/s] */
    unsigned flags; /* those of the last motor_law_step */
} motor_law_state;

/* Fill the state: the memory at its start. */
void motor_law_init(motor_law_state *state);

/* Put the memory back to the start. */
void motor_law_reset(motor_law_state *state);

/* One instant: from readings to commands. Returns the flags. */
unsigned motor_law_step(motor_law_state *state,
                        const motor_law_readings *readings,
                        const motor_law_references *references,
                        motor_law_commands *commands);

#ifdef __cplusplus
}
#endif

#endif
/* control-workbench sha256:52d2f1e71bee207862856f02a175f0de3fd87e468ad491b67a5c152c0c44fdae */
