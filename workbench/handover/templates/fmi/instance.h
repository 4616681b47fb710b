/* One instance of the model, the same for each version of FMI. Generated code is in model.h. */
#ifndef WORKBENCH_INSTANCE_H
#define WORKBENCH_INSTANCE_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "model.h"

/* A function of the library: exported, and with the prefix of a file that is compiled into an importer. */
#define JOIN(a, b) a##b
#define JOINED(a, b) JOIN(a, b)
#ifdef FUNCTION_PREFIX
#define NAMED(name) JOINED(FUNCTION_PREFIX, name)
#else
#define NAMED(name) name
#endif
#if defined(_WIN32)
#define FMI(type, name) __declspec(dllexport) type NAMED(name)
#elif defined(__GNUC__)
#define FMI(type, name) __attribute__((visibility("default"))) type NAMED(name)
#else
#define FMI(type, name) type NAMED(name)
#endif

/* References of values: the time, the parameters and inputs, the states at the start, the outputs. */
enum { FIRST_PARAMETER = 1, FIRST_START = 1 + PARAMETERS, FIRST_OUTPUT = FIRST_START + STATES };
enum { VALUES = FIRST_OUTPUT + OUTPUTS };
enum phase { INSTANTIATED, INITIALIZATION, STEPS, TERMINATED };

/* Everything that changes: a copy of it is the state of the FMU. */
typedef struct {
    double parameters[PARAMETERS + 1];
    double start[STATES + 1];
    double states[STATES + 1];
    double outputs[OUTPUTS + 1];
    uint64_t k; /* steps of the model since the time 0 */
    int outputs_are_current;
    int phase;
} values_t;

typedef struct instance {
    values_t values;
    void (*log)(struct instance *instance, const char *sentence);
    void (*logger)(void);
    void *environment;
    char *name;
} instance_t;

/* What a serialized state begins with, as one of another model must not be taken. */
typedef struct {
    char token[48];
    values_t values;
} saved_t;

static void set_to_defaults(instance_t *instance)
{
    values_t *values = &instance->values;
    memset(values, 0, sizeof *values);
    memcpy(values->parameters, default_parameters, sizeof values->parameters);
    memcpy(values->start, default_states, sizeof values->start);
    memcpy(values->states, default_states, sizeof values->states);
}

static instance_t *new_instance(const char *name)
{
    instance_t *instance = calloc(1, sizeof *instance);
    const size_t length = (name != NULL) ? strlen(name) : 0;
    char *copy = (instance != NULL) ? calloc(length + 1, 1) : NULL;
    if (copy == NULL) {
        free(instance);
        return NULL;
    }
    if (length > 0) {
        memcpy(copy, name, length);
    }
    instance->name = copy;
    set_to_defaults(instance);
    return instance;
}

static void free_instance(instance_t *instance)
{
    if (instance != NULL) {
        free(instance->name);
        free(instance);
    }
}

static int refused(instance_t *instance, const char *sentence)
{
    instance->log(instance, sentence);
    return 0;
}

static int refused_value(instance_t *instance, size_t reference, const char *rule)
{
    char sentence[400];
    const char *name = (reference < VALUES) ? names[reference] : "a value reference without a variable";
    snprintf(sentence, sizeof sentence, "'%.200s' %s.", name, rule);
    return refused(instance, sentence);
}

static int is_finite(double value)
{
    return value - value == 0.0;
}

static double time_of(const instance_t *instance)
{
    return (double)instance->values.k * STEP;
}

static double distance(double a, double b)
{
    return (a > b) ? a - b : b - a;
}

static int get_values(instance_t *instance, const unsigned *references, size_t count, double *into)
{
    values_t *values = &instance->values;
    size_t i;
    for (i = 0; i < count; ++i) {
        const size_t reference = references[i];
        if (reference >= VALUES) {
            return refused_value(instance, reference, "cannot be read");
        }
        if (reference >= FIRST_OUTPUT) {
            if (!values->outputs_are_current) {
                model_outputs(values->k, values->states, values->parameters, values->outputs);
                values->outputs_are_current = 1;
            }
            into[i] = values->outputs[reference - FIRST_OUTPUT];
        } else if (reference >= FIRST_START) {
            into[i] = values->start[reference - FIRST_START];
        } else if (reference >= FIRST_PARAMETER) {
            into[i] = values->parameters[reference - FIRST_PARAMETER];
        } else {
            into[i] = time_of(instance);
        }
    }
    return 1;
}

static int set_values(instance_t *instance, const unsigned *references, size_t count, const double *from)
{
    values_t *values = &instance->values;
    size_t i;
    for (i = 0; i < count; ++i) {
        const size_t reference = references[i];
        if (reference < FIRST_PARAMETER || reference >= FIRST_OUTPUT) {
            return refused_value(instance, reference, "cannot be set: it is no parameter and no input");
        }
        if (!is_finite(from[i])) {
            return refused_value(instance, reference, "must be a finite number");
        }
        if (reference >= FIRST_START) {
            if (values->phase > INITIALIZATION) {
                return refused_value(instance, reference, "can be set before the first step only");
            }
            values->start[reference - FIRST_START] = from[i];
            values->states[reference - FIRST_START] = from[i];
        } else {
            values->parameters[reference - FIRST_PARAMETER] = from[i];
        }
        values->outputs_are_current = 0;
    }
    return 1;
}

static int begin_at(instance_t *instance, double start)
{
    const double steps = start / STEP;
    if (!(steps > -1e-3) || !(steps < 9e15) || distance(steps, (double)(uint64_t)(steps + 0.5)) > 1e-3) {
        return refused(instance, "The simulation must start at a whole number of steps of the model after 0 s.");
    }
    instance->values.k = (uint64_t)(steps + 0.5);
    instance->values.outputs_are_current = 0;
    return 1;
}

static int initialize(instance_t *instance)
{
    if (instance->values.phase != INSTANTIATED) {
        return refused(instance, "The initialization comes first, and once; reset the FMU before another one.");
    }
    instance->values.phase = INITIALIZATION;
    return 1;
}

static int begin_steps(instance_t *instance)
{
    if (instance->values.phase != INITIALIZATION) {
        return refused(instance, "The initialization ends where it has begun: enter it before.");
    }
    instance->values.phase = STEPS;
    return 1;
}

static int advance(instance_t *instance, uint64_t steps)
{
    values_t *values = &instance->values;
    double next[STATES + 1];
    uint64_t n;
    int i;
    for (n = 0; n < steps; ++n) {
        if (!model_step(values->k, values->states, values->parameters, next)) {
            return 0;
        }
        for (i = 0; i < STATES; ++i) {
            if (!is_finite(next[i])) {
                return 0;
            }
        }
        memcpy(values->states, next, STATES * sizeof next[0]);
        ++values->k;
        values->outputs_are_current = 0;
    }
    return 1;
}

/* Whole steps of the model with inputs held. Where it refuses, the instance is as before. */
static int do_step(instance_t *instance, double from, double length)
{
    const double steps = length / STEP;
    const values_t before = instance->values;
    char sentence[300];
    if (instance->values.phase != STEPS) {
        return refused(instance, "A step comes after the initialization and before the end.");
    }
    if (!(steps > 0.5) || !(steps < 9e15) || distance(steps, (double)(uint64_t)(steps + 0.5)) > 1e-3) {
        snprintf(sentence, sizeof sentence,
                 "A communication step must be a whole multiple of %.17g s, the step of the model; got %.17g s.", STEP,
                 length);
        return refused(instance, sentence);
    }
    if (!(distance(from, time_of(instance)) <= 1e-3 * STEP)) {
        snprintf(sentence, sizeof sentence, "The step must begin where the last one ended, at %.17g s; got %.17g s.",
                 time_of(instance), from);
        return refused(instance, sentence);
    }
    if (HAS_HORIZON && from + length > HORIZON + 1e-3 * STEP) {
        snprintf(sentence, sizeof sentence, "The equations hold until %.17g s; got a step to %.17g s.", HORIZON,
                 from + length);
        return refused(instance, sentence);
    }
    if (!advance(instance, (uint64_t)(steps + 0.5))) {
        snprintf(sentence, sizeof sentence, "The step from %.17g s gives what is no finite number, and is undone.",
                 time_of(instance));
        instance->values = before;
        return refused(instance, sentence);
    }
    return 1;
}

/* Room for a state of the FMU: the one that an importer hands back, or a new one. */
static saved_t *room_for(instance_t *instance, void **state)
{
    saved_t *saved = (*state != NULL) ? *state : malloc(sizeof(saved_t));
    if (saved == NULL) {
        (void)refused(instance, "There is no memory for the state of the FMU.");
    }
    return saved;
}

static int save(instance_t *instance, void **state)
{
    saved_t *saved = room_for(instance, state);
    if (saved == NULL) {
        return 0;
    }
    memset(saved, 0, sizeof *saved);
    strncpy(saved->token, MODEL_TOKEN, sizeof saved->token - 1);
    saved->values = instance->values;
    *state = saved;
    return 1;
}

static int restore(instance_t *instance, const saved_t *saved)
{
    if (strncmp(saved->token, MODEL_TOKEN, sizeof saved->token) != 0) {
        return refused(instance, "The state of the FMU is none of this model.");
    }
    instance->values = saved->values;
    return 1;
}

static void free_saved(void **state)
{
    free(*state);
    *state = NULL;
}

static int serialize(instance_t *instance, const saved_t *saved, void *bytes, size_t size)
{
    if (size < sizeof(saved_t)) {
        return refused(instance, "The state of the FMU needs more bytes.");
    }
    memcpy(bytes, saved, sizeof(saved_t));
    return 1;
}

static int deserialize(instance_t *instance, const void *bytes, size_t size, void **state)
{
    saved_t *saved = NULL;
    if (size < sizeof(saved_t) || memcmp(bytes, MODEL_TOKEN, sizeof MODEL_TOKEN) != 0) {
        return refused(instance, "The bytes are no state of this FMU.");
    }
    saved = room_for(instance, state);
    if (saved == NULL) {
        return 0;
    }
    memcpy(saved, bytes, sizeof(saved_t));
    *state = saved;
    return 1;
}

#endif
