/* FMI 3.0 for co-simulation.
 *
 * Types and functions are declared here as in "Functional Mock-up Interface Specification", version 3.0.2, sections 2.2
 * and 4.2 (Modelica Association, fmi-standard.org). No file of the standard is contained.
 */
#include <stdbool.h>

#ifdef FMI3_FUNCTION_PREFIX
#define FUNCTION_PREFIX FMI3_FUNCTION_PREFIX
#endif
#include "instance.h"

typedef enum { fmi3OK, fmi3Warning, fmi3Discard, fmi3Error, fmi3Fatal } status_t;
typedef void (*logger_t)(void *, status_t, const char *, const char *);
typedef void (*callback_t)(void);
typedef uint32_t reference_t;
typedef const char *text_t;
typedef const uint8_t *binary_t;

static void write_to_log(instance_t *instance, const char *sentence)
{
    if (instance->logger != NULL) {
        ((logger_t)instance->logger)(instance->environment, fmi3Error, "logStatusError", sentence);
    }
}

static status_t status(int success)
{
    return success ? fmi3OK : fmi3Error;
}

static status_t without(void *c, size_t count, const char *sentence)
{
    return (count == 0) ? fmi3OK : status(refused(c, sentence));
}

static instance_t *instance_with_log(const char *name, void *environment, logger_t logger)
{
    instance_t *instance = new_instance(name);
    if (instance != NULL) {
        instance->log = write_to_log;
        instance->logger = (callback_t)logger;
        instance->environment = environment;
    }
    return instance;
}

static void *no_instance(const char *name, void *environment, logger_t logger, const char *sentence)
{
    instance_t *instance = instance_with_log(name, environment, logger);
    if (instance != NULL) {
        (void)refused(instance, sentence);
        free_instance(instance);
    }
    return NULL;
}

FMI(const char *, fmi3GetVersion)(void) { return "3.0"; }

FMI(status_t, fmi3SetDebugLogging)(void *c, bool on, size_t count, const text_t categories[])
{
    (void)c;
    (void)on;
    (void)count;
    (void)categories;
    return fmi3OK; /* errors are told always, and nothing else is */
}

FMI(void *, fmi3InstantiateCoSimulation)(const char *name, const char *token, const char *resources, bool visible,
                                         bool logging, bool event_mode, bool early_return, const reference_t needed[],
                                         size_t count, void *environment, logger_t logger, callback_t update)
{
    (void)resources;
    (void)visible;
    (void)logging;
    (void)event_mode;
    (void)early_return;
    (void)needed;
    (void)count;
    (void)update;
    if (token == NULL || strcmp(token, MODEL_TOKEN) != 0) {
        return no_instance(name, environment, logger,
                           "The model description is that of another FMU: its instantiationToken differs.");
    }
    return instance_with_log(name, environment, logger);
}

FMI(void *, fmi3InstantiateModelExchange)(const char *name, const char *token, const char *resources, bool visible,
                                          bool logging, void *environment, logger_t logger)
{
    (void)token;
    (void)resources;
    (void)visible;
    (void)logging;
    return no_instance(name, environment, logger, "This FMU is for co-simulation.");
}

FMI(void *, fmi3InstantiateScheduledExecution)(const char *name, const char *token, const char *resources,
                                               bool visible, bool logging, void *environment, logger_t logger,
                                               callback_t clock, callback_t lock, callback_t unlock)
{
    (void)token;
    (void)resources;
    (void)visible;
    (void)logging;
    (void)clock;
    (void)lock;
    (void)unlock;
    return no_instance(name, environment, logger, "This FMU is for co-simulation.");
}

FMI(void, fmi3FreeInstance)(void *c) { free_instance(c); }

FMI(status_t, fmi3EnterInitializationMode)(void *c, bool has_tolerance, double tolerance, double start, bool has_stop,
                                           double stop)
{
    (void)has_tolerance;
    (void)tolerance;
    (void)has_stop;
    (void)stop;
    return status(begin_at(c, start) && initialize(c));
}

FMI(status_t, fmi3ExitInitializationMode)(void *c) { return status(begin_steps(c)); }

FMI(status_t, fmi3Terminate)(void *c)
{
    ((instance_t *)c)->values.phase = TERMINATED;
    return fmi3OK;
}

FMI(status_t, fmi3Reset)(void *c)
{
    set_to_defaults(c);
    return fmi3OK;
}

FMI(status_t, fmi3GetFloat64)(void *c, const reference_t references[], size_t count, double values[], size_t size)
{
    return status((size == count) ? get_values(c, references, count, values)
                                  : refused(c, "Every variable is one number: there must be as many as references."));
}

FMI(status_t, fmi3SetFloat64)(void *c, const reference_t references[], size_t count, const double values[], size_t size)
{
    return status((size == count) ? set_values(c, references, count, values)
                                  : refused(c, "Every variable is one number: there must be as many as references."));
}

#define NO_VALUES(type, name)                                                                                     \
    FMI(status_t, fmi3Get##name)(void *c, const reference_t references[], size_t count, type values[], size_t size) \
    {                                                                                                             \
        (void)references;                                                                                         \
        (void)values;                                                                                             \
        (void)size;                                                                                               \
        return without(c, count, "All variables of this FMU are of type Float64.");                              \
    }                                                                                                             \
    FMI(status_t, fmi3Set##name)(void *c, const reference_t references[], size_t count, const type values[],        \
                                 size_t size)                                                                     \
    {                                                                                                             \
        (void)references;                                                                                         \
        (void)values;                                                                                             \
        (void)size;                                                                                               \
        return without(c, count, "All variables of this FMU are of type Float64.");                              \
    }

NO_VALUES(float, Float32)
NO_VALUES(int8_t, Int8)
NO_VALUES(uint8_t, UInt8)
NO_VALUES(int16_t, Int16)
NO_VALUES(uint16_t, UInt16)
NO_VALUES(int32_t, Int32)
NO_VALUES(uint32_t, UInt32)
NO_VALUES(int64_t, Int64)
NO_VALUES(uint64_t, UInt64)
NO_VALUES(bool, Boolean)
NO_VALUES(text_t, String)

FMI(status_t, fmi3GetBinary)(void *c, const reference_t references[], size_t count, size_t sizes[], binary_t values[],
                             size_t size)
{
    (void)references;
    (void)sizes;
    (void)values;
    (void)size;
    return without(c, count, "All variables of this FMU are of type Float64.");
}

FMI(status_t, fmi3SetBinary)(void *c, const reference_t references[], size_t count, const size_t sizes[],
                             const binary_t values[], size_t size)
{
    (void)references;
    (void)sizes;
    (void)values;
    (void)size;
    return without(c, count, "All variables of this FMU are of type Float64.");
}

/* Functions that are handed references and arrays, for things that this FMU has none of. */
#define NONE_OF(name, sentence, ...)                                                       \
    FMI(status_t, name)(void *c, const reference_t references[], size_t count, __VA_ARGS__) \
    {                                                                                      \
        (void)references;                                                                  \
        UNUSED;                                                                            \
        return without(c, count, sentence);                                                \
    }

#define UNUSED (void)a
NONE_OF(fmi3GetClock, "This FMU has no clocks.", bool a[])
NONE_OF(fmi3SetClock, "This FMU has no clocks.", const bool a[])
NONE_OF(fmi3GetShiftDecimal, "This FMU has no clocks.", double a[])
NONE_OF(fmi3SetShiftDecimal, "This FMU has no clocks.", const double a[])
NONE_OF(fmi3SetIntervalDecimal, "This FMU has no clocks.", const double a[])
#undef UNUSED
#define UNUSED ((void)a, (void)b)
NONE_OF(fmi3GetIntervalDecimal, "This FMU has no clocks.", double a[], int b[])
NONE_OF(fmi3SetIntervalFraction, "This FMU has no clocks.", const uint64_t a[], const uint64_t b[])
NONE_OF(fmi3GetShiftFraction, "This FMU has no clocks.", uint64_t a[], uint64_t b[])
NONE_OF(fmi3SetShiftFraction, "This FMU has no clocks.", const uint64_t a[], const uint64_t b[])
#undef UNUSED
#define UNUSED ((void)a, (void)b, (void)d)
NONE_OF(fmi3GetIntervalFraction, "This FMU has no clocks.", uint64_t a[], uint64_t b[], int d[])
NONE_OF(fmi3GetOutputDerivatives, "This FMU gives no derivatives.", const int32_t a[], double b[], size_t d)
#undef UNUSED
#define UNUSED ((void)a, (void)b, (void)d, (void)e, (void)f, (void)g)
NONE_OF(fmi3GetDirectionalDerivative, "This FMU gives no derivatives.", const reference_t a[], size_t b,
        const double d[], size_t e, double f[], size_t g)
NONE_OF(fmi3GetAdjointDerivative, "This FMU gives no derivatives.", const reference_t a[], size_t b, const double d[],
        size_t e, double f[], size_t g)

FMI(status_t, fmi3GetNumberOfVariableDependencies)(void *c, reference_t reference, size_t *count)
{
    (void)reference;
    (void)count;
    return status(refused(c, "Dependencies stand in the model description: they do not change."));
}

FMI(status_t, fmi3GetVariableDependencies)(void *c, reference_t dependent, size_t elements[], reference_t independents[],
                                           size_t of_independents[], int kinds[], size_t count)
{
    (void)dependent;
    (void)elements;
    (void)independents;
    (void)of_independents;
    (void)kinds;
    (void)count;
    return status(refused(c, "Dependencies stand in the model description: they do not change."));
}

FMI(status_t, fmi3GetFMUState)(void *c, void **state) { return status(save(c, state)); }

FMI(status_t, fmi3SetFMUState)(void *c, void *state) { return status(restore(c, state)); }

FMI(status_t, fmi3FreeFMUState)(void *c, void **state)
{
    (void)c;
    free_saved(state);
    return fmi3OK;
}

FMI(status_t, fmi3SerializedFMUStateSize)(void *c, void *state, size_t *size)
{
    (void)c;
    (void)state;
    *size = sizeof(saved_t);
    return fmi3OK;
}

FMI(status_t, fmi3SerializeFMUState)(void *c, void *state, uint8_t bytes[], size_t size)
{
    return status(serialize(c, state, bytes, size));
}

FMI(status_t, fmi3DeserializeFMUState)(void *c, const uint8_t bytes[], size_t size, void **state)
{
    return status(deserialize(c, bytes, size, state));
}

FMI(status_t, fmi3EnterConfigurationMode)(void *c)
{
    return status(refused(c, "This FMU has no structural parameters to be configured."));
}

FMI(status_t, fmi3ExitConfigurationMode)(void *c)
{
    return status(refused(c, "This FMU has no structural parameters to be configured."));
}

FMI(status_t, fmi3EnterEventMode)(void *c) { return status(refused(c, "This FMU has no event mode.")); }

FMI(status_t, fmi3EvaluateDiscreteStates)(void *c) { return status(refused(c, "This FMU has no event mode.")); }

FMI(status_t, fmi3EnterStepMode)(void *c) { return status(refused(c, "This FMU has no event mode to be left.")); }

FMI(status_t, fmi3UpdateDiscreteStates)(void *c, bool *again, bool *terminate, bool *nominals, bool *values,
                                        bool *has_next, double *next)
{
    (void)next;
    *again = *terminate = *nominals = *values = *has_next = false;
    return status(refused(c, "This FMU has no event mode."));
}

FMI(status_t, fmi3DoStep)(void *c, double from, double length, bool no_return, bool *event, bool *terminate,
                          bool *early, double *last)
{
    const int success = do_step(c, from, length);
    (void)no_return;
    *event = *terminate = *early = false;
    *last = time_of(c);
    return status(success);
}

/* Model exchange and scheduled execution: a library must have their functions, and this one refuses them. */
#define OTHERS "This FMU is for co-simulation."

FMI(status_t, fmi3EnterContinuousTimeMode)(void *c) { return status(refused(c, OTHERS)); }

FMI(status_t, fmi3CompletedIntegratorStep)(void *c, bool no_return, bool *event, bool *terminate)
{
    (void)no_return;
    *event = *terminate = false;
    return status(refused(c, OTHERS));
}

FMI(status_t, fmi3SetTime)(void *c, double time)
{
    (void)time;
    return status(refused(c, OTHERS));
}

FMI(status_t, fmi3SetContinuousStates)(void *c, const double values[], size_t count)
{
    (void)values;
    return without(c, count, OTHERS);
}

#define NO_CONTINUOUS(name)                                      \
    FMI(status_t, name)(void *c, double values[], size_t count) \
    {                                                            \
        (void)values;                                            \
        return without(c, count, OTHERS);                        \
    }

NO_CONTINUOUS(fmi3GetContinuousStateDerivatives)
NO_CONTINUOUS(fmi3GetEventIndicators)
NO_CONTINUOUS(fmi3GetContinuousStates)
NO_CONTINUOUS(fmi3GetNominalsOfContinuousStates)

FMI(status_t, fmi3GetNumberOfEventIndicators)(void *c, size_t *count)
{
    *count = 0;
    return status(refused(c, OTHERS));
}

FMI(status_t, fmi3GetNumberOfContinuousStates)(void *c, size_t *count)
{
    *count = 0;
    return status(refused(c, OTHERS));
}

FMI(status_t, fmi3ActivateModelPartition)(void *c, reference_t clock, double time)
{
    (void)clock;
    (void)time;
    return status(refused(c, OTHERS));
}
