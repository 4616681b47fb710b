/* FMI 2.0 for co-simulation.
 *
 * Types and functions are declared here as in "Functional Mock-up Interface for Model Exchange and Co-Simulation",
 * version 2.0.4, sections 2.1 and 4.2 (Modelica Association, fmi-standard.org). No file of the standard is contained.
 */
#ifdef FMI2_FUNCTION_PREFIX
#define FUNCTION_PREFIX FMI2_FUNCTION_PREFIX
#endif
#include "instance.h"

typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } status_t;
typedef enum { fmi2ModelExchange, fmi2CoSimulation } kind_t;
typedef enum { fmi2DoStepStatus, fmi2PendingStatus, fmi2LastSuccessfulTime, fmi2Terminated } asked_t;
typedef void (*logger_t)(void *, const char *, status_t, const char *, const char *, ...);
typedef struct {
    logger_t logger;
    void *(*allocate)(size_t, size_t);
    void (*free)(void *);
    void (*step_finished)(void *, status_t);
    void *environment;
} callbacks_t;

static void write_to_log(instance_t *instance, const char *sentence)
{
    if (instance->logger != NULL) {
        /* Importers that cannot format must get a sentence too; none has a percent sign. */
        ((logger_t)instance->logger)(instance->environment, instance->name, fmi2Error, "logStatusError", sentence);
    }
}

static status_t status(int success)
{
    return success ? fmi2OK : fmi2Error;
}

static status_t without(void *c, size_t count, const char *sentence)
{
    return (count == 0) ? fmi2OK : status(refused(c, sentence));
}

FMI(const char *, fmi2GetTypesPlatform)(void) { return "default"; }

FMI(const char *, fmi2GetVersion)(void) { return "2.0"; }

FMI(void *, fmi2Instantiate)(const char *name, kind_t kind, const char *token, const char *resources,
                             const callbacks_t *callbacks, int visible, int logging)
{
    instance_t *instance = new_instance(name);
    (void)resources;
    (void)visible;
    (void)logging;
    if (instance == NULL) {
        return NULL;
    }
    instance->log = write_to_log;
    if (callbacks != NULL) {
        instance->logger = (void (*)(void))callbacks->logger;
        instance->environment = callbacks->environment;
    }
    if (kind == fmi2CoSimulation && token != NULL && strcmp(token, MODEL_TOKEN) == 0) {
        return instance;
    }
    (void)refused(instance, (kind == fmi2CoSimulation) ? "The model description is that of another FMU: its guid differs."
                                                       : "This FMU is for co-simulation.");
    free_instance(instance);
    return NULL;
}

FMI(void, fmi2FreeInstance)(void *c) { free_instance(c); }

FMI(status_t, fmi2SetDebugLogging)(void *c, int on, size_t count, const char *const categories[])
{
    (void)c;
    (void)on;
    (void)count;
    (void)categories;
    return fmi2OK; /* errors are told always, and nothing else is */
}

FMI(status_t, fmi2SetupExperiment)(void *c, int has_tolerance, double tolerance, double start, int has_stop, double stop)
{
    (void)has_tolerance;
    (void)tolerance;
    (void)has_stop;
    (void)stop;
    return status(begin_at(c, start));
}

FMI(status_t, fmi2EnterInitializationMode)(void *c) { return status(initialize(c)); }

FMI(status_t, fmi2ExitInitializationMode)(void *c) { return status(begin_steps(c)); }

FMI(status_t, fmi2Terminate)(void *c)
{
    ((instance_t *)c)->values.phase = TERMINATED;
    return fmi2OK;
}

FMI(status_t, fmi2Reset)(void *c)
{
    set_to_defaults(c);
    return fmi2OK;
}

FMI(status_t, fmi2GetReal)(void *c, const unsigned references[], size_t count, double values[])
{
    return status(get_values(c, references, count, values));
}

FMI(status_t, fmi2SetReal)(void *c, const unsigned references[], size_t count, const double values[])
{
    return status(set_values(c, references, count, values));
}

#define NO_VALUES(type, name)                                                                             \
    FMI(status_t, fmi2Get##name)(void *c, const unsigned references[], size_t count, type values[])      \
    {                                                                                                     \
        (void)references;                                                                                 \
        (void)values;                                                                                     \
        return without(c, count, "All variables of this FMU are real numbers.");                         \
    }                                                                                                     \
    FMI(status_t, fmi2Set##name)(void *c, const unsigned references[], size_t count, const type values[]) \
    {                                                                                                     \
        (void)references;                                                                                 \
        (void)values;                                                                                     \
        return without(c, count, "All variables of this FMU are real numbers.");                         \
    }

typedef const char *text_t;
NO_VALUES(int, Integer)
NO_VALUES(int, Boolean)
NO_VALUES(text_t, String)

FMI(status_t, fmi2GetFMUstate)(void *c, void **state) { return status(save(c, state)); }

FMI(status_t, fmi2SetFMUstate)(void *c, void *state) { return status(restore(c, state)); }

FMI(status_t, fmi2FreeFMUstate)(void *c, void **state)
{
    (void)c;
    free_saved(state);
    return fmi2OK;
}

FMI(status_t, fmi2SerializedFMUstateSize)(void *c, void *state, size_t *size)
{
    (void)c;
    (void)state;
    *size = sizeof(saved_t);
    return fmi2OK;
}

FMI(status_t, fmi2SerializeFMUstate)(void *c, void *state, char bytes[], size_t size)
{
    return status(serialize(c, state, bytes, size));
}

FMI(status_t, fmi2DeSerializeFMUstate)(void *c, const char bytes[], size_t size, void **state)
{
    return status(deserialize(c, bytes, size, state));
}

FMI(status_t, fmi2GetDirectionalDerivative)(void *c, const unsigned unknowns[], size_t n, const unsigned knowns[],
                                            size_t m, const double known[], double derivatives[])
{
    (void)unknowns;
    (void)n;
    (void)knowns;
    (void)m;
    (void)known;
    (void)derivatives;
    return status(refused(c, "This FMU gives no derivatives."));
}

FMI(status_t, fmi2SetRealInputDerivatives)(void *c, const unsigned references[], size_t count, const int orders[],
                                           const double values[])
{
    (void)references;
    (void)orders;
    (void)values;
    return without(c, count, "Inputs are held over a step: this FMU takes no derivatives of them.");
}

FMI(status_t, fmi2GetRealOutputDerivatives)(void *c, const unsigned references[], size_t count, const int orders[],
                                            double values[])
{
    (void)references;
    (void)orders;
    (void)values;
    return without(c, count, "This FMU gives no derivatives.");
}

FMI(status_t, fmi2DoStep)(void *c, double from, double length, int no_return)
{
    (void)no_return;
    return status(do_step(c, from, length));
}

FMI(status_t, fmi2CancelStep)(void *c) { return status(refused(c, "No step runs beside the caller: none is canceled.")); }

#define NO_STATUS(type, name)                                               \
    FMI(status_t, name)(void *c, asked_t asked, type *value)                \
    {                                                                       \
        (void)c;                                                            \
        (void)asked;                                                        \
        (void)value;                                                        \
        return fmi2Discard; /* no step is pending, and none was terminated */ \
    }

NO_STATUS(status_t, fmi2GetStatus)
NO_STATUS(int, fmi2GetIntegerStatus)
NO_STATUS(text_t, fmi2GetStringStatus)

FMI(status_t, fmi2GetRealStatus)(void *c, asked_t asked, double *value)
{
    *value = time_of(c);
    return (asked == fmi2LastSuccessfulTime) ? fmi2OK : fmi2Discard;
}

FMI(status_t, fmi2GetBooleanStatus)(void *c, asked_t asked, int *value)
{
    (void)c;
    *value = 0;
    return (asked == fmi2Terminated) ? fmi2OK : fmi2Discard;
}
