/* FMI 3.0 for co-simulation over rcac.h; y, z, r, u and theta are arrays. u(k) is there before y(k)
 * comes: a step adapts with what came for it and computes the control of the next one. */
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "rcac.h"

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

typedef void *fmi3Instance, *fmi3InstanceEnvironment, *fmi3FMUState;
typedef uint32_t fmi3ValueReference;
typedef const char *fmi3String;
typedef enum { fmi3OK, fmi3Warning, fmi3Discard, fmi3Error, fmi3Fatal } fmi3Status;
typedef void (*fmi3Logger)(fmi3InstanceEnvironment, fmi3Status, fmi3String, fmi3String);

enum { TIME, Y, Z, R, U, THETA, STATUS };
typedef struct {
    rcac_state s;
    double time, y[RCAC_L_Y + 1], z[RCAC_L_Z], r[RCAC_L_R + 1], u[RCAC_L_U];
    int status, began;
} Data;
typedef struct {
    Data data;
    fmi3Logger logger;
    fmi3InstanceEnvironment environment;
} Instance;

static fmi3Status failed(Instance *m, const char *words) {
    if (m->logger) m->logger(m->environment, fmi3Error, "logStatusError", words);
    return fmi3Error;
}

EXPORT const char *fmi3GetVersion(void) { return "3.0"; }
EXPORT fmi3Status fmi3SetDebugLogging(fmi3Instance c, bool on, size_t n, const fmi3String names[]) {
    (void)c, (void)on, (void)n, (void)names;
    return fmi3OK;
}

EXPORT fmi3Instance fmi3InstantiateCoSimulation(
    fmi3String name, fmi3String token, fmi3String resources, bool visible, bool logging, bool events,
    bool early, const fmi3ValueReference required[], size_t n, fmi3InstanceEnvironment environment,
    fmi3Logger logger, void (*intermediate)(void)) {
    Instance *m;
    (void)name, (void)resources, (void)visible, (void)logging, (void)events, (void)early;
    (void)required, (void)n, (void)intermediate;
    if (!token || strcmp(token, RCAC_FMU_TOKEN) != 0) return NULL;
    m = (Instance *)calloc(1, sizeof *m);
    if (!m) return NULL;
    m->logger = logger;
    m->environment = environment;
    rcac_init(&m->data.s);
    return m;
}
EXPORT void fmi3FreeInstance(fmi3Instance c) { free(c); }
EXPORT fmi3Status fmi3EnterInitializationMode(fmi3Instance c, bool has_tolerance, double tolerance,
                                              double start, bool has_stop, double stop) {
    (void)has_tolerance, (void)tolerance, (void)has_stop, (void)stop;
    ((Instance *)c)->data.time = start;
    return fmi3OK;
}
static void begin(Data *d) {
    if (!d->began) d->status = rcac_control(&d->s, NULL, NULL, NULL, d->u);
    d->began = 1;
}
EXPORT fmi3Status fmi3ExitInitializationMode(fmi3Instance c) {
    begin(&((Instance *)c)->data);
    return fmi3OK;
}
EXPORT fmi3Status fmi3Terminate(fmi3Instance c) { return c ? fmi3OK : fmi3Error; }
EXPORT fmi3Status fmi3Reset(fmi3Instance c) {
    Data *d = &((Instance *)c)->data;
    memset(d, 0, sizeof *d);
    rcac_init(&d->s);
    return fmi3OK;
}

EXPORT fmi3Status fmi3DoStep(fmi3Instance c, double now, double step, bool no_return, bool *event,
                             bool *terminate, bool *early, double *last) {
    Instance *m = (Instance *)c;
    Data *d = &m->data;
    (void)no_return;
    *event = *terminate = *early = false;
    *last = now;
    if (step < RCAC_FMU_STEP * (1 - 1e-6) || step > RCAC_FMU_STEP * (1 + 1e-6))
        return failed(m, "the controller has one sample time, which is the step of every call");
    begin(d);
    d->status = rcac_adapt(&d->s, d->y, d->z, d->r, NULL);
    d->status |= rcac_control(&d->s, NULL, NULL, NULL, d->u);
    *last = d->time = now + step;
    return d->status & RCAC_DIVERGED ? failed(m, "the controller left the range of its numbers") : fmi3OK;
}

static double *variable(Data *d, fmi3ValueReference which, size_t *size) {
    switch (which) {
        case TIME: *size = 1; return &d->time;
        case Y: *size = RCAC_L_Y; return d->y;
        case Z: *size = RCAC_L_Z; return d->z;
        case R: *size = RCAC_L_R; return d->r;
        case U: *size = RCAC_L_U; return d->u;
        case THETA: *size = RCAC_L_THETA; return d->s.theta;
        default: return NULL;
    }
}
EXPORT fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference at[], size_t n, double values[],
                                 size_t count) {
    size_t i, size, used = 0;
    for (i = 0; i < n; ++i) {
        const double *from = variable(&((Instance *)c)->data, at[i], &size);
        if (!from || used + size > count) return fmi3Error;
        memcpy(values + used, from, size * sizeof *from);
        used += size;
    }
    return used == count ? fmi3OK : fmi3Error;
}
EXPORT fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference at[], size_t n,
                                 const double values[], size_t count) {
    size_t i, size, used = 0;
    for (i = 0; i < n; ++i) {
        double *to = variable(&((Instance *)c)->data, at[i], &size);
        if (!to || at[i] < Y || at[i] > R || used + size > count) return fmi3Error;
        memcpy(to, values + used, size * sizeof *to);
        used += size;
    }
    return used == count ? fmi3OK : fmi3Error;
}
EXPORT fmi3Status fmi3GetInt32(fmi3Instance c, const fmi3ValueReference at[], size_t n, int32_t values[],
                               size_t count) {
    size_t i;
    if (n != count) return fmi3Error;
    for (i = 0; i < n; ++i) {
        if (at[i] != STATUS) return fmi3Error;
        values[i] = ((Instance *)c)->data.status;
    }
    return fmi3OK;
}

EXPORT fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *state) {
    if (!*state) *state = malloc(sizeof(Data));
    if (!*state) return fmi3Error;
    memcpy(*state, &((Instance *)c)->data, sizeof(Data));
    return fmi3OK;
}
EXPORT fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState state) {
    if (!state) return fmi3Error;
    memcpy(&((Instance *)c)->data, state, sizeof(Data));
    return fmi3OK;
}
EXPORT fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *state) {
    (void)c;
    if (state) free(*state), *state = NULL;
    return fmi3OK;
}
EXPORT fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState state, size_t *size) {
    (void)c, (void)state;
    *size = sizeof(Data);
    return fmi3OK;
}
EXPORT fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState state, uint8_t bytes[], size_t size) {
    (void)c;
    if (!state || size < sizeof(Data)) return fmi3Error;
    memcpy(bytes, state, sizeof(Data));
    return fmi3OK;
}
EXPORT fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const uint8_t bytes[], size_t size,
                                          fmi3FMUState *state) {
    (void)c;
    if (size != sizeof(Data)) return fmi3Error;
    if (!*state) *state = malloc(sizeof(Data));
    if (!*state) return fmi3Error;
    memcpy(*state, bytes, sizeof(Data));
    return fmi3OK;
}

/* There is nothing of these kinds; loaders ask for every name. */
#define NOTHING(name) EXPORT fmi3Status name(void) { return fmi3Error; }
#define NO_INSTANCE(name) EXPORT fmi3Instance name(void) { return NULL; }
#define NO_TYPE(type) NOTHING(fmi3Get##type) NOTHING(fmi3Set##type)
NO_INSTANCE(fmi3InstantiateModelExchange) NO_INSTANCE(fmi3InstantiateScheduledExecution)
NO_TYPE(Float32) NO_TYPE(Int8) NO_TYPE(UInt8) NO_TYPE(Int16) NO_TYPE(UInt16) NO_TYPE(UInt32)
NO_TYPE(Int64) NO_TYPE(UInt64) NO_TYPE(Boolean) NO_TYPE(String) NO_TYPE(Binary) NO_TYPE(Clock)
NO_TYPE(IntervalDecimal) NO_TYPE(IntervalFraction) NO_TYPE(ShiftDecimal) NO_TYPE(ShiftFraction)
NO_TYPE(ContinuousStates) NOTHING(fmi3SetInt32) NOTHING(fmi3SetTime)
NOTHING(fmi3EnterEventMode) NOTHING(fmi3EnterStepMode) NOTHING(fmi3EnterConfigurationMode)
NOTHING(fmi3ExitConfigurationMode) NOTHING(fmi3EnterContinuousTimeMode)
NOTHING(fmi3CompletedIntegratorStep) NOTHING(fmi3EvaluateDiscreteStates)
NOTHING(fmi3UpdateDiscreteStates) NOTHING(fmi3GetAdjointDerivative)
NOTHING(fmi3GetDirectionalDerivative) NOTHING(fmi3GetContinuousStateDerivatives)
NOTHING(fmi3GetEventIndicators) NOTHING(fmi3GetNominalsOfContinuousStates)
NOTHING(fmi3GetNumberOfContinuousStates) NOTHING(fmi3GetNumberOfEventIndicators)
NOTHING(fmi3GetNumberOfVariableDependencies) NOTHING(fmi3GetVariableDependencies)
NOTHING(fmi3GetOutputDerivatives) NOTHING(fmi3ActivateModelPartition)
