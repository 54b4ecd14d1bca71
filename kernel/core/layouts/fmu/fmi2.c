/* FMI 2.0 for co-simulation over rcac.h. u(k) is there before y(k) comes: a step adapts with what came
 * for it and computes the control of the next one. */
#include <stdlib.h>
#include <string.h>

#include "rcac.h"

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

typedef void *fmi2Component, *fmi2ComponentEnvironment, *fmi2FMUstate;
typedef unsigned int fmi2ValueReference;
typedef int fmi2Boolean;
typedef const char *fmi2String;
typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef void (*fmi2Logger)(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String, ...);
typedef struct {
    fmi2Logger logger;
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*step_finished)(fmi2ComponentEnvironment, fmi2Status);
    fmi2ComponentEnvironment environment;
} fmi2CallbackFunctions;

enum {
    Z = RCAC_L_Y, R = Z + RCAC_L_Z, U = R + RCAC_L_R, THETA = U + RCAC_L_U,
    STATUS = THETA + RCAC_L_THETA
};
typedef struct {
    rcac_state s;
    double in[RCAC_L_Y + RCAC_L_Z + RCAC_L_R + 1], u[RCAC_L_U];
    int status, began;
} Data;
typedef struct {
    Data data;
    fmi2Logger logger;
    fmi2ComponentEnvironment environment;
    char name[128];
} Instance;

static fmi2Status failed(Instance *m, const char *words) {
    if (m->logger) m->logger(m->environment, m->name, fmi2Error, "logStatusError", "%s", words);
    return fmi2Error;
}

EXPORT const char *fmi2GetTypesPlatform(void) { return "default"; }
EXPORT const char *fmi2GetVersion(void) { return "2.0"; }
EXPORT fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String names[]) {
    (void)c, (void)on, (void)n, (void)names;
    return fmi2OK;
}

EXPORT fmi2Component fmi2Instantiate(fmi2String name, int kind, fmi2String guid, fmi2String place,
                                     const fmi2CallbackFunctions *callbacks, fmi2Boolean visible,
                                     fmi2Boolean logging) {
    Instance *m;
    (void)place, (void)visible, (void)logging;
    if (kind != 1 || !guid || strcmp(guid, RCAC_FMU_TOKEN) != 0) return NULL;
    m = (Instance *)calloc(1, sizeof *m);
    if (!m) return NULL;
    if (callbacks) m->logger = callbacks->logger, m->environment = callbacks->environment;
    if (name) strncpy(m->name, name, sizeof m->name - 1);
    rcac_init(&m->data.s);
    return m;
}
EXPORT void fmi2FreeInstance(fmi2Component c) { free(c); }
EXPORT fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean has_tolerance, double tolerance,
                                      double start, fmi2Boolean has_stop, double stop) {
    (void)c, (void)has_tolerance, (void)tolerance, (void)start, (void)has_stop, (void)stop;
    return fmi2OK;
}
EXPORT fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return c ? fmi2OK : fmi2Error; }
static void begin(Data *d) {
    if (!d->began) d->status = rcac_control(&d->s, NULL, NULL, NULL, d->u);
    d->began = 1;
}
EXPORT fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    begin(&((Instance *)c)->data);
    return fmi2OK;
}
EXPORT fmi2Status fmi2Terminate(fmi2Component c) { return c ? fmi2OK : fmi2Error; }
EXPORT fmi2Status fmi2Reset(fmi2Component c) {
    Data *d = &((Instance *)c)->data;
    memset(d, 0, sizeof *d);
    rcac_init(&d->s);
    return fmi2OK;
}

EXPORT fmi2Status fmi2DoStep(fmi2Component c, double now, double step, fmi2Boolean no_return) {
    Instance *m = (Instance *)c;
    Data *d = &m->data;
    (void)now, (void)no_return;
    if (step < RCAC_FMU_STEP * (1 - 1e-6) || step > RCAC_FMU_STEP * (1 + 1e-6))
        return failed(m, "the controller has one sample time, which is the step of every call");
    begin(d);
    d->status = rcac_adapt(&d->s, d->in, d->in + Z, d->in + R, NULL);
    d->status |= rcac_control(&d->s, NULL, NULL, NULL, d->u);
    return d->status & RCAC_DIVERGED ? failed(m, "the controller left the range of its numbers") : fmi2OK;
}

EXPORT fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference at[], size_t n, double values[]) {
    const Data *d = &((Instance *)c)->data;
    size_t i;
    for (i = 0; i < n; ++i) {
        const int k = (int)at[i];
        if (at[i] >= STATUS) return fmi2Error;
        values[i] = k < U ? d->in[k] : k < THETA ? d->u[k - U] : d->s.theta[k - THETA];
    }
    return fmi2OK;
}
EXPORT fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference at[], size_t n, const double values[]) {
    Data *d = &((Instance *)c)->data;
    size_t i;
    for (i = 0; i < n; ++i) {
        if (at[i] >= U) return fmi2Error;
        d->in[at[i]] = values[i];
    }
    return fmi2OK;
}
EXPORT fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference at[], size_t n, int values[]) {
    size_t i;
    for (i = 0; i < n; ++i) {
        if (at[i] != STATUS) return fmi2Error;
        values[i] = ((Instance *)c)->data.status;
    }
    return fmi2OK;
}

EXPORT fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    if (!*state) *state = malloc(sizeof(Data));
    if (!*state) return fmi2Error;
    memcpy(*state, &((Instance *)c)->data, sizeof(Data));
    return fmi2OK;
}
EXPORT fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    if (!state) return fmi2Error;
    memcpy(&((Instance *)c)->data, state, sizeof(Data));
    return fmi2OK;
}
EXPORT fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) {
    (void)c;
    if (state) free(*state), *state = NULL;
    return fmi2OK;
}
EXPORT fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size) {
    (void)c, (void)state;
    *size = sizeof(Data);
    return fmi2OK;
}
EXPORT fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, char bytes[], size_t size) {
    (void)c;
    if (!state || size < sizeof(Data)) return fmi2Error;
    memcpy(bytes, state, sizeof(Data));
    return fmi2OK;
}
EXPORT fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const char bytes[], size_t size, fmi2FMUstate *state) {
    (void)c;
    if (size != sizeof(Data)) return fmi2Error;
    if (!*state) *state = malloc(sizeof(Data));
    if (!*state) return fmi2Error;
    memcpy(*state, bytes, sizeof(Data));
    return fmi2OK;
}

/* There is nothing of these kinds. */
#define NOTHING(name) EXPORT fmi2Status name(void) { return fmi2Error; }
NOTHING(fmi2SetInteger) NOTHING(fmi2GetBoolean) NOTHING(fmi2SetBoolean) NOTHING(fmi2GetString)
NOTHING(fmi2SetString) NOTHING(fmi2GetDirectionalDerivative) NOTHING(fmi2SetRealInputDerivatives)
NOTHING(fmi2GetRealOutputDerivatives) NOTHING(fmi2CancelStep) NOTHING(fmi2GetStatus)
NOTHING(fmi2GetRealStatus) NOTHING(fmi2GetIntegerStatus) NOTHING(fmi2GetBooleanStatus)
NOTHING(fmi2GetStringStatus)
