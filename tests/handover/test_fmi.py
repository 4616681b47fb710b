"""FMUs: FMPy finds nothing to blame, and runs them with the bits of the simulation, in a process without us."""

import io
import zipfile
from xml.etree import ElementTree as ET

import numpy as np
import pytest

import workbench as wb
from tests.support.digital_laws import motor_law
from tests.support.springs import spring
from workbench.handover.fmi import fmu

VERSIONS = "2.0", "3.0"


def description_of(unit):
    """The root of its model description."""
    return ET.fromstring(unit.files["modelDescription.xml"])


def test_the_same_input_gives_the_same_bytes_without_a_path_of_this_machine(tmp_path):
    for version, compiler in zip(VERSIONS, (None, ""), strict=True):  # one call compiles for both versions
        units = [fmu(motor_law().law(), version, compiler=compiler) for _ in range(2)]
        assert units[0].content() == units[1].content()
        assert all(str(tmp_path.parent).encode() not in content for content in units[0].files.values())
        assert not [path for path in units[0].files if path.startswith("/") or ".." in path]
    tokens = {fmu(motor_law(**other).law(), compiler="").token for other in ({}, {"Kp": 99.0})}
    assert len(tokens) == 2


@pytest.mark.parametrize("version", VERSIONS)
def test_the_description_has_units_starts_and_what_can_be_changed(version):
    law = motor_law().law()
    root = description_of(fmu(law, version, compiler=""))
    simulation = root.find("CoSimulation")
    assert (root.get("variableNamingConvention"), simulation.get("needsExecutionTool")) == ("structured", "false")
    assert simulation.get("canHandleVariableCommunicationStepSize") == "false"
    variables = {each.get("name"): each for each in root.find("ModelVariables")}
    gain, reading, command = variables["controller.Kp[0]"], variables["y.omega"], variables["u.v"]
    assert (gain.get("causality"), gain.get("variability")) == ("parameter", "tunable")
    assert (reading.get("causality"), command.get("causality")) == ("input", "output")
    number = gain[0] if version == "2.0" else gain
    assert (number.get("start"), number.get("unit")) == ("100.0", "V s/rad")
    units = {unit.get("name"): dict(unit[0].attrib) for unit in root.find("UnitDefinitions")}
    assert units["V"] == {"kg": "1", "m": "2", "s": "-3", "A": "-1"}
    assert root.find("DefaultExperiment").get("stepSize") == repr(law.period)


def test_an_output_names_the_inputs_that_it_depends_on_at_once():
    for version, key, places in (("2.0", "Outputs/Unknown", ["", "4"]), ("3.0", "Output", ["", "3"])):
        structure = description_of(fmu(spring(), version, h=0.01, compiler="")).find("ModelStructure")
        assert [each.get("dependencies") for each in structure.findall(key)] == places


def test_without_a_compiler_there_are_sources_alone_and_it_says_so(monkeypatch):
    monkeypatch.setenv("PATH", "")
    unit = fmu(motor_law().law(), "3.0", "motor")
    assert repr(unit) == (
        "<Fmu 'motor', FMI 3.0: 10 parameters, 2 inputs, 1 output, steps of 0.01 s; "
        "sources alone: no C compiler is here>"
    )
    assert sorted(unit.files) == [
        "modelDescription.xml",
        *(f"sources/{name}" for name in ("buildDescription.xml", "fmi3.c", "instance.h", "model.h")),
        "sources/motor.c",
        "sources/motor.h",
    ]
    build = ET.fromstring(unit.files["sources/buildDescription.xml"])
    assert [each.get("name") for each in build.iter("SourceFile")] == ["fmi3.c", "motor.c"]


def test_any_text_may_be_the_name_of_a_model_and_its_library_has_a_name_of_c():
    identifiers = {}
    for name in ("<\"&'> */", "model", "8 µm", "Fmi2", "x" * 90):
        unit = fmu(spring(), name=name, h=0.01, compiler="")
        assert description_of(unit).get("modelName") == name
        identifiers[name] = unit.identifier
    assert list(identifiers.values()) == ["fmu", "model_fmu", "fmu_8_m", "Fmi2_fmu", "x" * 40]


def test_the_archive_is_whole_or_not_there_at_all(tmp_path, monkeypatch):
    unit = fmu(spring(), h=0.01, compiler="")
    path = unit.write(tmp_path / "spring.fmu")
    with zipfile.ZipFile(io.BytesIO(path.read_bytes())) as archive:
        assert {name: archive.read(name) for name in archive.namelist()} == unit.files
        assert {entry.date_time for entry in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}

    def broken(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.replace", broken)
    with pytest.raises(ValueError, match="cannot write .*No space left"):
        unit.write(tmp_path / "other.fmu")
    assert [each.name for each in tmp_path.iterdir()] == ["spring.fmu"]


@pytest.mark.parametrize("path", ["motor.zip", "motor", "folder.fmu", "nowhere/motor.fmu"])
def test_an_archive_goes_to_a_file_of_its_own_kind(path, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder.fmu").mkdir()
    with pytest.raises(ValueError, match=r"`Fmu\.write\(path\)` (must be a file|cannot write)"):
        fmu(spring(), h=0.01, compiler="").write(path)
    assert [each.name for each in tmp_path.iterdir()] == ["folder.fmu"]


def noisy():
    motor = wb.DCMotor()
    law = wb.PID(motor.outputs, motor.inputs, Kp=1.0)
    loop = wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0))
    return loop.digital(0.01, wb.Instruments.of(motor, noise={"omega": 1e-3}))


@pytest.mark.parametrize(
    ("make", "error", "text"),
    [
        (lambda: fmu(noisy(), h=0.01), ValueError, "takes no noise.*1 random numbers a step.*no noise"),
        (lambda: fmu(spring()), ValueError, "must be stated.*got None"),
        (lambda: fmu(spring(), h=np.inf), ValueError, r"`fmu\(h=\.\.\.\)` must be .*finite"),
        (lambda: fmu(spring(), h=-1.0), ValueError, r"`fmu\(h=\.\.\.\)` must be"),
        (lambda: fmu(motor_law(), h=0.003), ValueError, "must divide the sampling period 0.01 s"),
        (lambda: fmu(motor_law().law(), h=0.003), ValueError, "is its period, 0.01 s"),
        (lambda: fmu(spring(), "1.0", h=0.01), ValueError, "is one of '2.0', '3.0'; got '1.0'"),
        (lambda: fmu(spring(), name="", h=0.01), ValueError, r"`fmu\(name=\.\.\.\)` must be a name"),
        (lambda: fmu(spring(("k", "F", "G H")), h=0.01), ValueError, "needs names of letters.*got 'G H'"),
        (lambda: fmu(spring(("k", "F", "γ")), h=0.01), ValueError, "needs names of letters.*got 'γ'"),
        (lambda: fmu(spring(("k", "F", "length[0]")), h=0.01), ValueError, "two are called 'length.0.'"),
        (lambda: fmu(spring(("k", "F", "time")), h=0.01), ValueError, "two are called 'time'"),
        (lambda: fmu(spring(), h=0.01, compiler="no-such-compiler"), LookupError, "must be a C compiler on the path"),
        (lambda: fmu(spring(), h=0.01, compiler="false"), ValueError, "'.*false' refuses the sources"),
        (lambda: fmu("motor"), ValueError, r"must be a `SampledLaw` or an `Ode` or a `SampledSystem`; got 'motor'"),
    ],
)
def test_what_cannot_be_an_fmu_is_refused_in_a_sentence(make, error, text):
    with pytest.raises(error, match=text):
        make()
