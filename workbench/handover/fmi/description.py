"""modelDescription.xml and buildDescription.xml: what an importer reads of an FMU."""

from __future__ import annotations

import math
from collections.abc import Sequence
from xml.etree import ElementTree as ET

from workbench.core.units import in_base_units, read
from workbench.handover.fmi.co_simulation import FIXED, INPUT, OUTPUT, PARAMETER, Model, Variable

TOOL = "control-workbench"
CAUSALITY = {INPUT: INPUT, PARAMETER: PARAMETER, FIXED: PARAMETER, OUTPUT: OUTPUT}
CAPABILITIES = {
    "needsExecutionTool": "false",
    "canBeInstantiatedOnlyOncePerProcess": "false",
    "canHandleVariableCommunicationStepSize": "false",
}
INSTANTS = 1000  # steps of an experiment, unless the importer states another end


def model_description(model: Model, identifier: str, version: str, token: str, sources: Sequence[str]) -> bytes:
    """The file of an FMU."""
    two = version == "2.0"
    root = ET.Element("fmiModelDescription", fmiVersion=version, modelName=model.name)
    root.set("guid" if two else "instantiationToken", token)
    root.set("description", model.about)
    root.set("generationTool", TOOL)
    root.set("variableNamingConvention", "structured")
    state = "FMUstate" if two else "FMUState"
    capabilities = {"modelIdentifier": identifier, **CAPABILITIES}
    capabilities |= {f"canGetAndSet{state}": "true", f"canSerialize{state}": "true"}
    if two:
        capabilities |= {"canInterpolateInputs": "false", "maxOutputDerivativeOrder": "0"}
        capabilities |= {"canRunAsynchronuously": "false", "canNotUseMemoryManagementFunctions": "true"}
        capabilities |= {"providesDirectionalDerivative": "false"}
    else:
        capabilities |= {"fixedInternalStepSize": repr(float(model.step.h)), "hasEventMode": "false"}
    simulation = ET.SubElement(root, "CoSimulation", capabilities)
    if two:
        files = ET.SubElement(simulation, "SourceFiles")
        for name in sources:
            ET.SubElement(files, "File", name=name)
    _units(root, model)
    categories = ET.SubElement(root, "LogCategories")
    ET.SubElement(categories, "Category", name="logStatusError", description="A call that was refused, and why.")
    step = float(model.step.h)
    stop = min(INSTANTS * step, math.floor(model.horizon / step) * step if math.isfinite(model.horizon) else math.inf)
    ET.SubElement(root, "DefaultExperiment", startTime="0", stopTime=repr(stop), stepSize=repr(step))
    _variables(root, model, two)
    _structure(root, model, two)
    return _text(root)


def build_description(identifier: str, sources: Sequence[str]) -> bytes:
    """The file of FMI 3.0 that says how the sources are compiled."""
    root = ET.Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = ET.SubElement(root, "BuildConfiguration", modelIdentifier=identifier)
    files = ET.SubElement(configuration, "SourceFileSet", language="C99")
    for name in sources:
        ET.SubElement(files, "SourceFile", name=name)
    return _text(root)


def _text(root: ET.Element) -> bytes:
    ET.indent(root)
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{ET.tostring(root, encoding="unicode")}\n'.encode()


def _units(root: ET.Element, model: Model) -> None:
    definitions = ET.SubElement(root, "UnitDefinitions")
    for text in sorted({"s", *(variable.unit for variable in model.variables if variable.unit)}):
        element = ET.SubElement(definitions, "Unit", name=text)
        if (base := in_base_units(read(text))) is not None and all(n.denominator == 1 for _, n in base[1].powers):
            factor = {} if base[0] == 1 else {"factor": repr(float(base[0]))}
            ET.SubElement(element, "BaseUnit", {**{name: str(n) for name, n in base[1].powers}, **factor})


def _variables(root: ET.Element, model: Model, two: bool) -> None:
    variables = ET.SubElement(root, "ModelVariables")
    time = {"name": "time", "valueReference": "0", "causality": "independent", "variability": "continuous"}
    _variable(variables, time, {"unit": "s"}, two)
    for variable in model.variables:
        head = {"name": variable.name, "valueReference": str(variable.reference)}
        head["causality"] = CAUSALITY[variable.role]
        head["variability"] = _variability(model, variable)
        if variable.role != INPUT:
            head["initial"] = "calculated" if variable.role == OUTPUT else "exact"
        _variable(variables, head, _real(variable), two)


def _variability(model: Model, variable: Variable) -> str:
    if variable.role in (PARAMETER, FIXED):
        return "tunable" if variable.role == PARAMETER else "fixed"
    return "discrete" if model.kind == "law" else "continuous"


def _real(variable: Variable) -> dict[str, str]:
    real = {"unit": variable.unit} if variable.unit else {}
    if variable.role != OUTPUT:
        for name, bound in (("min", variable.low), ("max", variable.high)):
            real |= {name: repr(float(bound))} if math.isfinite(bound) else {}
    return real if variable.start is None else {**real, "start": repr(variable.start)}


def _variable(parent: ET.Element, head: dict[str, str], real: dict[str, str], two: bool) -> None:
    if two:
        ET.SubElement(ET.SubElement(parent, "ScalarVariable", head), "Real", real)
    else:
        ET.SubElement(parent, "Float64", {**head, **real})


def _structure(root: ET.Element, model: Model, two: bool) -> None:
    """The outputs with the inputs that they depend on at once, and the outputs as initial unknowns.

    Version 2.0 goes by the place in the list of variables, from 1 on; version 3.0 by the reference.
    """
    structure = ET.SubElement(root, "ModelStructure")
    outputs = [variable.reference for variable in model.variables if variable.role == OUTPUT]
    key, shift = ("index", 1) if two else ("valueReference", 0)
    parent = ET.SubElement(structure, "Outputs") if two and outputs else structure
    for reference, needs in zip(outputs, model.needs, strict=True):
        dependencies = " ".join(str(i + shift) for i in needs)
        unknown = {key: str(reference + shift), "dependencies": dependencies}
        ET.SubElement(parent, "Unknown" if two else "Output", unknown)
    parent = ET.SubElement(structure, "InitialUnknowns") if two and outputs else structure
    for reference in outputs:
        ET.SubElement(parent, "Unknown" if two else "InitialUnknown", {key: str(reference + shift)})
