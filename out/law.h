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
#ifndef LAW_H
#define LAW_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define LAW_PERIOD 0.01 /* s, from one call of law_step to the next */

enum { /* flags of law_step, which may come together */
    LAW_OK = 0,
    LAW_BAD_READING = 1, /* a reading is not finite: the safe command */
    LAW_BAD_REFERENCE = 2, /* a reference is not finite: the same */
    LAW_BAD_COMMAND = 4 /* a command, also before its limits, or the memory would not be finite: the same */
};

/* What the instruments read at the instant. */
typedef struct {
    double omega; /* [rad/s] */
} law_readings;

/* What is wanted at the instant. */
typedef struct {
    double omega; /* [rad/s] */
} law_references;

/* What acts on the plant from the instant to the next. */
typedef struct {
    double v; /* [V] */
} law_commands;

/* All that the law keeps from one instant to the next; law_init fills it. */
typedef struct {
    double controller_integral[1]; /* controller.integral [V] */
    double controller_filter[1]; /* controller.filter [rad/s] */
    unsigned flags; /* those of the last law_step */
} law_state;

/* Fill the state: the memory at its start. */
void law_init(law_state *state);

/* Put the memory back to the start. */
void law_reset(law_state *state);

/* One instant: from readings to commands. Returns the flags. */
unsigned law_step(law_state *state,
                  const law_readings *readings,
                  const law_references *references,
                  law_commands *commands);

#ifdef __cplusplus
}
#endif

#endif
