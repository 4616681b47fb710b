/* The part of Simulink's simstruc.h that a generated S-function uses, written for tests from its documentation. */
#ifndef SIMSTRUC_H
#define SIMSTRUC_H

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef int int_T;
typedef uint32_t uint32_T;
typedef struct { const double *values; size_t size; } mxArray;
enum { SS_DOUBLE = 0, SS_SINGLE = 1, SS_UINT32 = 7 };
enum { SS_OPTION_EXCEPTION_FREE_CODE = 1 };
enum { MOST = 64 };

typedef struct {
    int width, type, contiguous, feedthrough;
    void *signal;
} port;

typedef struct {
    int parameters, given, inputs, outputs, works, times, major, sizing;
    port input[MOST], output[MOST], work[MOST];
    mxArray parameter[MOST];
    double period, offset;
    const char *error;
} SimStruct;

static inline void ss_require(int truth, const char *what)
{
    if (!truth) {
        fprintf(stderr, "the S-function breaks a rule: %s\n", what);
        exit(3);
    }
}

/* Sizes are set in mdlInitializeSizes alone, and signals are there afterwards alone. */
#define SIZING(S) ss_require((S)->sizing, "sizes outside mdlInitializeSizes")
#define RUNNING(S) ss_require(!(S)->sizing, "signals inside mdlInitializeSizes")
#define ssSetNumSFcnParams(S, n) (SIZING(S), (S)->parameters = (n))
#define ssGetNumSFcnParams(S) ((S)->parameters)
#define ssGetSFcnParamsCount(S) ((S)->given)
#define ssSetSFcnParamTunable(S, i, kind) (SIZING(S), (void)(kind), (void)(i))
#define ssGetSFcnParam(S, i) (ss_require((i) < (S)->given, "a parameter that is not there"), &(S)->parameter[i])
#define mxGetPr(array) ((array)->values)
#define mxIsDouble(array) ((void)(array), 1)
#define mxIsComplex(array) ((void)(array), 0)
#define mxGetNumberOfElements(array) ((array)->size)
#define ssSetErrorStatus(S, text) ((S)->error = (text))
#define ssGetErrorStatus(S) ((S)->error)
#define ssSetNumContStates(S, n) (SIZING(S), (void)(n))
#define ssSetNumDiscStates(S, n) (SIZING(S), (void)(n))
#define ssSetNumInputPorts(S, n) (SIZING(S), ((S)->inputs = (n)) <= MOST)
#define ssSetNumOutputPorts(S, n) (SIZING(S), ((S)->outputs = (n)) <= MOST)
#define ssSetInputPortWidth(S, i, n) (SIZING(S), (S)->input[i].width = (n))
#define ssSetInputPortDataType(S, i, t) (SIZING(S), (S)->input[i].type = (t))
#define ssSetInputPortRequiredContiguous(S, i, t) (SIZING(S), (S)->input[i].contiguous = (t))
#define ssSetInputPortDirectFeedThrough(S, i, t) (SIZING(S), (S)->input[i].feedthrough = (t))
#define ssSetOutputPortWidth(S, i, n) (SIZING(S), (S)->output[i].width = (n))
#define ssSetOutputPortDataType(S, i, t) (SIZING(S), (S)->output[i].type = (t))
#define ssSetNumSampleTimes(S, n) (SIZING(S), (S)->times = (n))
#define ssSetNumDWork(S, n) (SIZING(S), (S)->works = (n))
#define ssSetDWorkWidth(S, i, n) (SIZING(S), (S)->work[i].width = (int)(n))
#define ssSetDWorkDataType(S, i, t) (SIZING(S), (S)->work[i].type = (t))
#define ssSetOptions(S, options) (SIZING(S), (void)(options))
#define ssSetSampleTime(S, i, t) ((S)->period = (t))
#define ssSetOffsetTime(S, i, t) ((S)->offset = (t))
#define ssIsMajorTimeStep(S) ((S)->major)
#define ssGetDWork(S, i) (RUNNING(S), (S)->work[i].signal)
#define ssGetInputPortSignal(S, i) \
    (RUNNING(S), ss_require((S)->input[i].contiguous && (S)->input[i].feedthrough, "a reading of an input"), \
     (const void *)(S)->input[i].signal)
#define ssGetOutputPortSignal(S, i) (RUNNING(S), (S)->output[i].signal)

#endif
