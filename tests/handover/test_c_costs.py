"""What the header of a law in C says of its costs, and the root and the fused product of the processor's own."""

import re
import subprocess
from functools import cache

import pytest

import workbench as wb
from tests.support.c_runs import EACH_COMPILER, compiled, differing, needs_compiler, recorded, warned
from tests.support.cases import heavy_but
from tests.support.digital_laws import kalman_law, motor_law
from tests.support.recorded_laws import LOOPS
from tests.support.targets_here import needs_gcc
from workbench.handover.c99.c_files import c_code
from workbench.handover.targets.binary_size import measured_stack

HARDWARE = ({"sqrt": "hardware"}, {"fma": "hardware"}, {"sqrt": "hardware", "fma": "hardware"})


def head_of(text):
    """The words of the comment at the head of a file."""
    return " ".join(text.partition("*/")[0].replace(" * ", " ").split())


def symbols_of(code, folder, compiler, option="-O2"):
    """The functions of others that the object of a law calls."""
    code.write(folder)
    subprocess.run([compiler, "-std=c99", option, "-c", f"{code.name}.c"], cwd=folder, check=True, timeout=60)
    listing = subprocess.run(["nm", "-u", f"{code.name}.o"], cwd=folder, capture_output=True, text=True, check=True)
    return {line.split()[-1] for line in listing.stdout.splitlines()}


def test_both_files_say_operations_stack_and_libraries():
    code = c_code(motor_law().law(), "law")
    for text in (code.header, code.source):
        head = head_of(text)
        assert re.search(r"A call makes \d+ sums, .*\d+ products", head)
        assert re.search(r"Stack of a call: \d+ bytes at most, counted", head)
        assert "Link flags: none, not even -lm." in head


def test_operations_are_counted_by_kind():
    code = c_code(motor_law(low=None, high=None).law(), "law")
    assert re.fullmatch(
        r"12 sums, 11 products, 1 quotient; \d of them depend on numbers of the law alone", code.costs.operations
    )
    lines = re.sub(
        r"/\*.*?\*/", "", code.source.partition("law_advance(")[2].partition("const bool done")[0], flags=re.S
    )
    found = [len(re.findall(rf" {sign} ", lines)) for sign in ("[+-]", r"\*", "/")]
    assert found == [12, 11, 1]  # the same in the text


@needs_gcc
def test_an_export_has_its_stack_measured_where_gcc_is(tmp_path):
    header, _ = wb.export(motor_law().law(), "c", tmp_path, name="law")
    assert re.search(r"Stack of a call: \d+ bytes, measured: as gcc [\d.]+ -O2", head_of(header.read_text()))


def test_an_export_without_gcc_has_its_stack_counted(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    header, _ = wb.export(motor_law().law(), "c", tmp_path / "law", name="law")
    assert "bytes at most, counted" in head_of(header.read_text())


@cache
def law_of(name):
    """A loop of the catalogue in its computer, and its law."""
    sampled, truths, _ = LOOPS[name]()
    return sampled, sampled.law(truths=truths)


@needs_gcc
@pytest.mark.parametrize("name", heavy_but(LOOPS, "motor PID", "SMC"))
@pytest.mark.parametrize("precision", ["double", "single"])
def test_no_level_of_gcc_takes_more_stack_than_was_counted(name, precision):
    code = c_code(law_of(name)[1], "law", precision=precision)
    for option in ("-O0", "-O2") if precision == "double" else ("-O0",):
        assert int(measured_stack(code, option).split()[0]) <= code.costs.stack


@needs_compiler
@pytest.mark.parametrize("compiler", EACH_COMPILER)
def test_a_law_calls_no_library_but_where_it_says_so(compiler, tmp_path):
    law = kalman_law().law()
    library = {"memcpy", "memset", "_GLOBAL_OFFSET_TABLE_"}  # which compilers may call of themselves
    assert symbols_of(c_code(law, "law"), tmp_path / "a", compiler) <= library
    code = c_code(law, "law", sqrt="hardware", fma="hardware")
    found = symbols_of(code, tmp_path / "b", compiler)
    assert {"sqrt", "fma"} & found
    assert found <= library | {"sqrt", "fma"}
    assert "Link flags: -lm." in head_of(code.header)
    assert "-fno-math-errno" in head_of(code.header)


@needs_compiler
@pytest.mark.parametrize("options", heavy_but(HARDWARE, HARDWARE[2]))
@pytest.mark.parametrize("compiler", EACH_COMPILER)
def test_no_compiler_warns_of_the_processors_own(options, compiler, tmp_path):
    for name, law in {"filter": kalman_law().law(), "motor": motor_law().law()}.items():
        c_code(law, name, **options).write(tmp_path)
    warned(compiler, tmp_path, "filter.c", "motor.c", optimised=options is HARDWARE[2])


@cache
def kalman_run():
    """The law of a Kalman filter and a run of its loop."""
    sampled = kalman_law()
    law = sampled.law()
    return law, recorded(sampled, law, 300)


@needs_compiler
@pytest.mark.parametrize("precision", heavy_but(["double", "single"], "double"))
def test_the_root_of_the_processor_has_the_same_bits(precision, tmp_path):
    law, (y, r, u, z) = kalman_run()
    found = compiled(c_code(law, "law", sqrt="hardware", precision=precision), tmp_path)(y, r)
    if precision == "single":
        (tmp_path / "own").mkdir()
        u, z, _ = compiled(c_code(law, "law", precision=precision), tmp_path / "own")(y, r)
    assert (differing(found[0], u), differing(found[1], z), found[2].max()) == (0, 0, 0)


@cache
def fused_run(name):
    """A law of the catalogue and a run of its loop in the fused arithmetic."""
    sampled, law = law_of(name)
    return law, recorded(sampled, law, 200, arithmetic="fused")


@needs_compiler
@pytest.mark.parametrize(
    ("name", "options"),
    heavy_but(
        [*((name, HARDWARE[2]) for name in ("motor PID", "SMC", "EKF", "Fuzzy-ASMC")), ("EKF", HARDWARE[1])],
        *((name, HARDWARE[2]) for name in ("motor PID", "SMC")),
    ),
)
def test_fused_products_have_the_bits_of_the_fused_simulation(name, options, tmp_path):
    law, (y, r, u, z) = fused_run(name)
    found = compiled(c_code(law, "law", **options), tmp_path)(y, r)
    assert (differing(found[0], u), differing(found[1], z), found[2].max()) == (0, 0, 0)
    if name == "motor PID":  # whose command is at its limit
        return
    (tmp_path / "portable").mkdir()
    other = compiled(c_code(law, "law"), tmp_path / "portable")(y, r)
    assert differing(other[0], u) + differing(other[1], z) > 0  # so the two arithmetics are told apart by this


def test_fused_products_in_single_precision_and_odd_ways_are_refused():
    law = motor_law().law()
    with pytest.raises(ValueError, match=r"`c_code\(fma='hardware'\)` must be in double precision"):
        c_code(law, "law", fma="hardware", precision="single")
    with pytest.raises((ValueError, LookupError), match=r"c_code\(sqrt=\.\.\.\)"):
        c_code(law, "law", sqrt="software")
    with pytest.raises(ValueError, match="takes no `sqrt`"):
        wb.export(law, "python", sqrt="hardware")
