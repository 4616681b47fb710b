/*
 * ModelPredictive: a control law that runs once in 0.02 s.
 *
 * Made by control-workbench 0.1.0.
 * Fingerprint of its equations and numbers: 4fff60d38b790f2b
 * Numbers of 64 bits (double precision), each product and each sum rounded by itself: the portable
 *     arithmetic.
 * Compile it without options that change arithmetic, such as -ffast-math, -funsafe-math-optimizations,
 *     or -ffp-contract=fast of clang.
 * On Cortex-M3 and M4 GCC's library rounds some differences wrongly: take the form cortex-m4.
 *
 * A call makes at most 4099 sums, 4762 products, 13 quotients, 1790 comparisons and choices, 60
 *     changes of sign, 385 fmax, 64 fmin; 25 of them depend on numbers of the law alone.
 * Stack of a call: 56 bytes, measured: as gcc 12.2.0 -O2 lays it out for x86_64-linux-gnu.
 * Static memory: 1,944 bytes of state, 1,768 of them for the arrays of loops. Tables of its numbers:
 *     320 bytes of constants.
 * Link flags: none, not even -lm. It calls no function of a library.
 *
 * It reads x [m], xd [m/s], phi [rad], phid [rad/s].
 * It follows x [m].
 * It commands F [N].
 * Limits of F: -3 to 3 N.
 * Safe command, where a flag is raised: F = 0 N. The memory then stays, but for commands on their way,
 *     which become the safe one; after a long gap call the reset.
 * All is in the state: one for each loop, whose calls do not overlap. A period without a call is lost.
 * Note: the observer uses the true signals xd and phid, which no instrument gives.
 * Note: xd, phid: an input that no instrument of the plant gives.
 */
#ifndef MODELPREDICTIVE_H
#define MODELPREDICTIVE_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define MODELPREDICTIVE_PERIOD 0.02 /* s, from one call of ModelPredictive_step to the next */

enum { /* flags of ModelPredictive_step, which may come together */
    MODELPREDICTIVE_OK = 0,
    MODELPREDICTIVE_BAD_READING = 1, /* a reading is not finite: the safe command */
    MODELPREDICTIVE_BAD_REFERENCE = 2, /* a reference is not finite: the same */
    MODELPREDICTIVE_BAD_COMMAND = 4 /* a command, also before its limits, or the memory would not be finite: the same */
};

/* What the instruments read at the instant. */
typedef struct {
    double x; /* [m] */
    double xd; /* [m/s] */
    double phi; /* [rad] */
    double phid; /* [rad/s] */
} ModelPredictive_readings;

/* What is wanted at the instant. */
typedef struct {
    double x; /* [m] */
} ModelPredictive_references;

/* What acts on the plant from the instant to the next. */
typedef struct {
    double F; /* [N] */
} ModelPredictive_commands;

/* All that the law keeps from one instant to the next; ModelPredictive_init fills it. */
typedef struct {
    double controller_plan[20]; /* controller.plan */
    double controller_worst; /* controller.worst [1] */
    double loop_room[221]; /* of the loops of a call */
    unsigned flags; /* those of the last ModelPredictive_step */
} ModelPredictive_state;

/* Fill the state: the memory at its start. */
void ModelPredictive_init(ModelPredictive_state *state);

/* Put the memory back to the start. */
void ModelPredictive_reset(ModelPredictive_state *state);

/* One instant: from readings to commands. Returns the flags. */
unsigned ModelPredictive_step(ModelPredictive_state *state,
                              const ModelPredictive_readings *readings,
                              const ModelPredictive_references *references,
                              ModelPredictive_commands *commands);

#ifdef __cplusplus
}
#endif

#endif
/* control-workbench sha256:1d45990752073b446a7eb0d10d64d7ac1088e7bb33ac8ea31143b125fe30869d */
