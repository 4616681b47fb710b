"""A block of Simulink around the C of a law: a Level-2 S-function in C, and the command that builds it."""

from __future__ import annotations

from collections.abc import Iterable
from string import Template

from workbench.core.layout import Entry, Layout
from workbench.core.notation.comments import harmless
from workbench.core.validation.refusals import require
from workbench.core.validation.signatures import door
from workbench.handover.c99.c_code import CCode
from workbench.handover.c99.c_names import members
from workbench.handover.export_seal import MARK

SOURCE = Template("""/*
 * $title: a Level-2 S-function around ${name}.c, which stays as it is. Made by $mark.
 *
$ports
 *
 * Build it in MATLAB by ${name}_build. Written after the documentation of S-functions, and compiled and run against
 * stubs of simstruc.h alone: where it was made, there was no MATLAB.
 */
#define S_FUNCTION_NAME ${name}_sfun
#define S_FUNCTION_LEVEL 2

#include "simstruc.h"

#include <string.h>

#include "${name}.h"

enum { INPUTS = $inputs, OUTPUTS = $outputs, PARAMETERS = $parameters };

/* Work vectors: the state as it is, and as it is to be after this instant. Copies of bytes, in doubles. */
enum { NOW = 0, NEXT = 1, NUMBERS = (sizeof(${name}_state) + sizeof(double) - 1) / sizeof(double) };

static const int_T input_widths[] = {$input_widths};
static const int_T output_widths[] = {$output_widths};
$checks
static void mdlInitializeSizes(SimStruct *S)
{
    int_T i;
    ssSetNumSFcnParams(S, PARAMETERS);
    if (ssGetNumSFcnParams(S) != ssGetSFcnParamsCount(S)) {
        return; /* Simulink reports the mismatch */
    }
$tunable    ssSetNumContStates(S, 0);
    ssSetNumDiscStates(S, 0);
    if (!ssSetNumInputPorts(S, INPUTS) || !ssSetNumOutputPorts(S, OUTPUTS)) {
        return;
    }
    for (i = 0; i < INPUTS; ++i) {
        ssSetInputPortWidth(S, i, input_widths[i]);
        ssSetInputPortDataType(S, i, $port_type);
        ssSetInputPortRequiredContiguous(S, i, 1);
        ssSetInputPortDirectFeedThrough(S, i, 1);
    }
    for (i = 0; i < OUTPUTS; ++i) {
        ssSetOutputPortWidth(S, i, output_widths[i]);
        ssSetOutputPortDataType(S, i, (i < OUTPUTS - 1) ? $port_type : SS_UINT32);
    }
    ssSetNumSampleTimes(S, 1);
    ssSetNumDWork(S, 2);
    for (i = NOW; i <= NEXT; ++i) {
        ssSetDWorkWidth(S, i, NUMBERS);
        ssSetDWorkDataType(S, i, SS_DOUBLE);
    }
    ssSetOptions(S, SS_OPTION_EXCEPTION_FREE_CODE);
}

static void mdlInitializeSampleTimes(SimStruct *S)
{
    ssSetSampleTime(S, 0, ${upper}_PERIOD);
    ssSetOffsetTime(S, 0, 0.0);
}

#define MDL_START
static void mdlStart(SimStruct *S)
{
    ${name}_state state;
    ${name}_init(&state);
    memcpy(ssGetDWork(S, NOW), &state, sizeof(state));
    memcpy(ssGetDWork(S, NEXT), &state, sizeof(state));
$process}

/* At the start, and whenever a subsystem that resets its states is enabled. */
#define MDL_INITIALIZE_CONDITIONS
static void mdlInitializeConditions(SimStruct *S)
{
    ${name}_state state;
    memcpy(&state, ssGetDWork(S, NOW), sizeof(state));
    ${name}_reset(&state);
    memcpy(ssGetDWork(S, NOW), &state, sizeof(state));
    memcpy(ssGetDWork(S, NEXT), &state, sizeof(state));
}

/* The commands; the memory moves in mdlUpdate, so that Simulink may ask twice. */
static void mdlOutputs(SimStruct *S, int_T tid)
{
    ${name}_state state;
    ${name}_readings readings;
$reference_struct    ${name}_commands commands;
    uint32_T flags;
    (void)tid;
    if (!ssIsMajorTimeStep(S)) {
        return;
    }
    memcpy(&state, ssGetDWork(S, NOW), sizeof(state));
$reads
    flags = (uint32_T)${name}_step(&state, &readings, $reference&commands);
$writes
    memcpy(ssGetOutputPortSignal(S, OUTPUTS - 1), &flags, sizeof(flags));
    memcpy(ssGetDWork(S, NEXT), &state, sizeof(state));
}

#define MDL_UPDATE
static void mdlUpdate(SimStruct *S, int_T tid)
{
    (void)tid;
    memcpy(ssGetDWork(S, NOW), ssGetDWork(S, NEXT), sizeof(${name}_state));
}

static void mdlTerminate(SimStruct *S)
{
    (void)S;
}

#ifdef MATLAB_MEX_FILE
#include "simulink.c"
#else
#include "cg_sfun.h"
#endif
""")

CHECKS = Template("""static const int_T parameter_widths[] = {$widths};

#define MDL_CHECK_PARAMETERS
static void mdlCheckParameters(SimStruct *S)
{
    int_T i;
    for (i = 0; i < PARAMETERS; ++i) {
        const mxArray *parameter = ssGetSFcnParam(S, i);
        if (!mxIsDouble(parameter) || mxIsComplex(parameter) ||
            mxGetNumberOfElements(parameter) != (size_t)parameter_widths[i]) {
            ssSetErrorStatus(S, "A parameter of $name must be real doubles, as many as $name.h has.");
            return;
        }
    }
}

#define MDL_PROCESS_PARAMETERS
static void mdlProcessParameters(SimStruct *S)
{
    ${name}_state state;
    memcpy(&state, ssGetDWork(S, NOW), sizeof(state));
$copies
    memcpy(ssGetDWork(S, NOW), &state, sizeof(state));
    memcpy(ssGetDWork(S, NEXT), &state, sizeof(state));
}
""")

TUNABLE = """    mdlCheckParameters(S);
    if (ssGetErrorStatus(S) != NULL) {
        return;
    }
    for (i = 0; i < PARAMETERS; ++i) {
        ssSetSFcnParamTunable(S, i, 1);
    }
"""

# The bits need each product and each sum rounded by itself.
BUILD = Template("""% Builds the S-function ${name}_sfun. Made by $mark.
if ispc
    mex ${name}_sfun.c ${name}.c
else
    mex CFLAGS='$$CFLAGS -std=c99 -ffp-contract=off' ${name}_sfun.c ${name}.c
end
""")


@door
def simulink(code: CCode) -> dict[str, str]:
    """The files of a Simulink block, by name: NAME_sfun.c, NAME_build.m, and the header and source of the law.

    The block runs once in the period of the law. It has an input port for each reading, then for each reference; an
    output port for each command, then one for the flags (uint32). Parameters that can be set are those of its dialog,
    in the order of the header, a matrix as MATLAB holds it.
    """
    code = require("simulink(code=...)", code, CCode)
    law, single = code.law, code.real == "float"
    parameters = law.parameters if code.settable else Layout()
    inputs = [*law.readings.entries, *law.references.entries]
    held = {
        "name": code.name,
        "upper": code.name.upper(),
        "mark": MARK,
        "title": harmless(law.name),
        "ports": "\n".join(_about(code, parameters)),
        "inputs": str(len(inputs)),
        "outputs": str(len(law.commands.entries) + 1),
        "parameters": str(len(parameters.entries)),
        "input_widths": _widths(inputs),
        "output_widths": ", ".join([_widths(law.commands.entries), "1"]),
        "port_type": "SS_SINGLE" if single else "SS_DOUBLE",
        "reference_struct": f"    {code.name}_references references;\n" if law.references.size else "",
        "reference": "&references, " if law.references.size else "",
        "reads": "\n".join(
            [*_reads(law.readings, "readings", 0), *_reads(law.references, "references", len(law.readings.entries))]
        ),
        "writes": "\n".join(_writes(law.commands)),
        "tunable": "",
        "checks": "",
        "process": "",
    }
    if parameters.size:
        copies, widths = "\n".join(_copies(parameters)), _widths(parameters.entries)
        held |= {"tunable": TUNABLE, "checks": CHECKS.substitute(name=code.name, copies=copies, widths=widths)}
        held["process"] = "    mdlProcessParameters(S);\n"
    files = {f"{code.name}_sfun.c": SOURCE.substitute(held), f"{code.name}_build.m": BUILD.substitute(held)}
    return files | code.files


def _about(code: CCode, parameters: Layout) -> Iterable[str]:
    law = code.law
    yield f" * It runs once in {law.period!r} s."
    ports = {"Inputs": (*law.readings.entries, *law.references.entries), "Outputs": law.commands.entries}
    for word, entries in ports.items():
        for number, entry in enumerate(entries, start=1):
            kind = "reference " if word == "Inputs" and number > len(law.readings.entries) else ""
            yield f" * {word[:-1]} {number}: {kind}{_said(entry)}"
    yield f" * Output {len(law.commands.entries) + 1}: flags, 0 where all is well"
    for number, entry in enumerate(parameters.entries, start=1):
        yield f" * Parameter {number}: {_said(entry)}"


def _said(entry: Entry) -> str:
    unit = f" [{entry.unit}]" if entry.unit else ""
    return harmless(f"{entry.name}{unit}, {entry.size} number{'s' * (entry.size != 1)}")


def _widths(entries: Iterable[Entry]) -> str:
    return ", ".join(str(entry.size) for entry in entries)


def _reads(layout: Layout, struct: str, first: int) -> Iterable[str]:
    names = members(layout)
    for port, entry in enumerate(layout.entries, start=first):
        place = f"{struct}.{names[entry.name]}"
        yield f"    memcpy(&{place}, ssGetInputPortSignal(S, {port}), sizeof({place}));"


def _writes(layout: Layout) -> Iterable[str]:
    names = members(layout)
    for port, entry in enumerate(layout.entries):
        place = f"commands.{names[entry.name]}"
        yield f"    memcpy(ssGetOutputPortSignal(S, {port}), &{place}, sizeof({place}));"


def _copies(layout: Layout) -> Iterable[str]:
    names = members(layout)
    for number, entry in enumerate(layout.entries):
        place = f"state.parameters.{names[entry.name]}"
        yield f"    memcpy(&{place}, mxGetPr(ssGetSFcnParam(S, {number})), sizeof({place}));"
