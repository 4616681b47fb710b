"""Elementary functions and laws in single precision against doubles, against IEEE's floats, and against their own C."""

import ctypes
import shutil
import subprocess

import casadi as ca
import numpy as np
import pytest

from tests.support.recorded_laws import LOOPS, by_hand, recorded
from workbench.engine.machines.c_functions import definitions
from workbench.engine.machines.c_real import SINGLE
from workbench.engine.machines.formula_table import IN_SINGLE
from workbench.engine.machines.machine import Number
from workbench.engine.machines.numpy_spelling import Singles
from workbench.engine.machines.single_functions import LARGEST_ANGLE
from workbench.handover.c99.c_code import c_code
from workbench.handover.c99.c_names import members
from workbench.handover.single.rounding_rules import STATED
from workbench.handover.single.single_precision import single_precision

COUNT = 1_000_000
ODD = np.array([0.0, -0.0, 1.0, -1.0, 1e-45, -1e-45, np.inf, -np.inf, np.nan], np.float32)


def computed(name, *operands):
    """The floats of a function of floats."""
    numbers = [Number(Singles(), np.asarray(operand, np.float32)) for operand in operands]
    with np.errstate(all="ignore"):
        return IN_SINGLE.of(name, *numbers).value


def spread(low, high, seed=0):
    """Floats with even logarithms and with even values, of both signs."""
    draws = np.random.default_rng(seed)
    even = draws.uniform(-high, high, COUNT // 2)
    sizes = np.exp(draws.uniform(np.log(low), np.log(high), COUNT // 2)) * draws.choice([-1, 1], COUNT // 2)
    return np.concatenate([even, sizes]).astype(np.float32)


def errors(name, got, wanted):
    """The largest error in units of 2^-24 of the value, and in units in the last place of the float."""
    off = np.abs(got.astype(float) - wanted)
    last = np.spacing(np.abs(wanted).astype(np.float32)).astype(float)
    return (off / np.maximum(np.abs(wanted), 2.0**-126)).max() * 2**24, (off / last).max()


@pytest.mark.parametrize(
    ("name", "of_doubles", "points"),
    [
        ("sin", np.sin, spread(1e-30, LARGEST_ANGLE)),
        ("cos", np.cos, spread(1e-30, LARGEST_ANGLE)),
        ("exp", np.exp, spread(1e-30, 87.0)),
        ("tanh", np.tanh, spread(1e-30, 12.0)),
        ("log", np.log, np.abs(spread(1e-45, 3e38)) + np.float32(1e-45)),
        ("log", np.log, np.abs(spread(1e-3, 2.0)) + np.float32(1e-45)),
        ("expm1", np.expm1, spread(1e-30, 87.0)),
        ("log1p", np.log1p, np.abs(spread(1e-30, 3e38))),
        ("log1p", np.log1p, spread(1e-30, 0.99)),
        ("sinh", np.sinh, spread(1e-30, 89.0)),
        ("cosh", np.cosh, spread(1e-30, 89.0)),
        ("asinh", np.arcsinh, spread(1e-30, 3e38)),
        ("acosh", np.arccosh, np.float32(1.0) + np.abs(spread(1e-6, 1e30))),
        ("atanh", np.arctanh, spread(1e-30, 0.99999)),
    ],
)
def test_functions_of_a_float_are_within_three_units_in_the_last_place(name, of_doubles, points):
    relative, units = errors(name, computed(name, points), of_doubles(points.astype(float)))
    assert relative <= STATED[name]
    assert units < 3.0


def test_the_angle_of_two_floats_is_within_three_units_in_the_last_place():
    for y, x in ((spread(1e-3, 1.0), spread(1e-3, 1.0, seed=1)), (spread(1e-15, 1e15), spread(1e-15, 1e15, seed=1))):
        x = np.random.default_rng(2).permutation(x)
        relative, units = errors("atan2", computed("atan2", y, x), np.arctan2(y.astype(float), x.astype(float)))
        assert relative <= STATED["atan2"]
        assert units < 3.0


def test_sine_and_cosine_keep_their_digits_at_every_multiple_of_a_quarter_turn():
    quarters = (np.arange(1, 5215) * (np.pi / 2)).astype(np.float32)
    for name, of_doubles in (("sin", np.sin), ("cos", np.cos)):
        assert errors(name, computed(name, quarters), of_doubles(quarters.astype(float)))[0] <= STATED[name]


def test_an_angle_beyond_the_largest_has_no_sine():
    beyond = np.nextafter(np.float32(LARGEST_ANGLE), np.float32(np.inf))
    assert np.isnan(computed("sin", [beyond, -beyond, np.inf, np.nan])).all()
    assert np.isfinite(computed("cos", [LARGEST_ANGLE, -LARGEST_ANGLE])).all()


IEEE = {"asinh": np.arcsinh, "acosh": np.arccosh, "atanh": np.arctanh}


@pytest.mark.parametrize(
    "name", ["exp", "tanh", "log", "expm1", "log1p", "sinh", "cosh", "asinh", "acosh", "atanh", "hypot", "copysign"]
)
def test_functions_of_what_is_no_common_number_are_those_of_ieee(name):
    pairs = name in ("hypot", "copysign")
    given = [side.ravel() for side in np.meshgrid(ODD, ODD)] if pairs else [ODD]
    with np.errstate(all="ignore"):
        wanted = IEEE.get(name, getattr(np, name, None))(*given)
    got = computed(name, *given)
    np.testing.assert_allclose(got, wanted, rtol=3e-7, atol=0)
    numbers = ~np.isnan(wanted)
    assert name == "tanh" or (np.signbit(got) == np.signbit(wanted))[numbers].all()  # tanh -0 is 0 here


def test_the_length_of_two_floats_is_within_three_units_in_the_last_place():
    for low, high in ((1e-3, 1.0), (1e-44, 1e38)):
        y, x = spread(low, high), np.random.default_rng(2).permutation(spread(low, high, seed=1))
        relative, units = errors("hypot", computed("hypot", y, x), np.hypot(y.astype(float), x.astype(float)))
        assert relative <= STATED["hypot"]
        assert units < 3.0


def test_the_angle_of_what_is_no_common_number_is_that_of_ieee():
    y, x = (side.ravel() for side in np.meshgrid(ODD, ODD))
    got, wanted = computed("atan2", y, x), np.arctan2(y, x)
    np.testing.assert_allclose(got, wanted, rtol=3e-7, atol=1e-44)
    numbers = ~np.isnan(wanted)
    assert (np.signbit(got) == np.signbit(wanted))[numbers].all()


def test_the_remainder_is_exact():
    patterns = np.random.default_rng(0).integers(0, 2**32, (2, COUNT), dtype=np.uint32)
    x, any_float = patterns.view(np.float32)
    x = np.where(np.isfinite(x), x, np.float32(1.0))
    for y in (any_float, x / np.random.default_rng(1).integers(1, 10_000, COUNT).astype(np.float32)):
        with np.errstate(all="ignore"):
            known = np.isfinite(y) & (np.abs(x / y) < 2**22)
        np.testing.assert_array_equal(computed("fmod", x, y)[known], np.fmod(x[known], y[known]))
    assert np.isnan(computed("fmod", [1.0, 2.0**24], [0.0, 1.0])).all()


def test_numbers_and_parameters_are_combined_in_doubles_and_rounded_once():
    law = by_hand(lambda y, k, p: p[0] * p[1] * y[0] + y[1], readings=2, p=(0.1, 0.3))
    y = np.random.default_rng(0).normal(size=(1000, 2))
    y32 = y.astype(np.float32)
    wanted = np.float32(0.1 * 0.3) * y32[:, 0] + y32[:, 1]
    np.testing.assert_array_equal(single_precision(law, 0, np.zeros((1000, 0)), y).u[:, 0], wanted)
    other = np.float32(0.7 * 0.9) * y32[:, 0] + y32[:, 1]
    np.testing.assert_array_equal(single_precision(law, 0, np.zeros((1000, 0)), y, p=[0.7, 0.9]).u[:, 0], other)


def test_what_depends_on_the_instant_alone_is_made_in_doubles_and_rounded_once():
    law = by_hand(lambda y, k, p: ca.exp(-1e-4 * k) * y)
    k, y = np.arange(100_000), np.random.default_rng(0).normal(size=(100_000, 1))
    got = single_precision(law, k, np.zeros((len(k), 0)), y).u[:, 0]
    wanted = np.exp(-1e-4 * k).astype(np.float32) * y[:, 0].astype(np.float32)
    assert (got == wanted).mean() > 0.999  # NumPy's own exponential has another last bit, here and there
    np.testing.assert_allclose(got, wanted, rtol=2e-7)


def test_rows_of_another_shape_are_refused_by_name():
    law = by_hand(lambda y, k, p: y[0] + y[1], readings=2)
    with pytest.raises(ValueError, match=r"single_precision\(y=...\).*\(3, 2\).*y\[0\], y\[1\]"):
        single_precision(law, 0, np.zeros((3, 0)), np.zeros((3, 1)))
    with pytest.raises(ValueError, match=r"single_precision\(k=...\)"):
        single_precision(law, 0.5, np.zeros((3, 0)), np.zeros((3, 2)))
    with pytest.raises(ValueError, match="parameters"):
        single_precision(law, 0, np.zeros((3, 0)), np.zeros((3, 2)), p=[1.0])


MARCH = """
#include <stddef.h>
#include <string.h>
#include "law.c"
void march(int n, const unsigned long long *k, const float *z, const float *y, const float *r, float *out,
           unsigned *flags)
{{
    for (int i = 0; i < n; ++i) {{
        law_state s; law_readings a; law_commands u; {references}
        law_init(&s);
        {instant}
        {load}
        memcpy(&a, y + i * {ny}, sizeof a);
        {copy}
        flags[i] = law_step(&s, &a, {argument} &u);
        {store}
        memcpy(out + i * {nx} + {nz}, &u, sizeof u);
    }}
    (void)k; (void)z; (void)r;
}}
"""


def march_of(law):
    """A C file that steps a law from each row."""
    nz, nr, nx = law.memory.size, law.references.size, law.memory.size + law.commands.size
    first = next(iter(members(law.memory).values()), "flags")
    kept = f"(char *)&s + offsetof(law_state, {first})"
    return MARCH.format(
        references="law_references b;" if nr else "",
        instant="s.k = k[i];" if law.uses_time else "",
        load=f"memcpy({kept}, z + i * {nz}, {nz} * sizeof(float));" if nz else "",
        ny=law.readings.size,
        copy=f"memcpy(&b, r + i * {nr}, sizeof b);" if nr else "",
        argument="&b," if nr else "",
        store=f"memcpy(out + i * {nx}, {kept}, {nz} * sizeof(float));" if nz else "",
        nx=nx,
        nz=nz,
    )


def in_c(law, folder, k, z, y, r):
    """Memory and commands of the C of a law in single precision, and its flags."""
    c_code(law, "law", precision="single").write(folder / "code")
    (folder / "code" / "march.c").write_text(march_of(law), encoding="utf-8")
    flags = ["-std=c99", "-O2", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC"]
    subprocess.run([COMPILER, *flags, "march.c", "-o", "march.so"], cwd=folder / "code", check=True, timeout=60)
    results = np.zeros((len(k), law.memory.size + law.commands.size), np.float32)
    raised = np.ones(len(k), np.uint32)
    arrays = [np.ascontiguousarray(k, np.uint64), *(np.ascontiguousarray(part, np.float32) for part in (z, y, r))]
    pointers = (part.ctypes.data_as(ctypes.c_void_p) for part in (*arrays, results, raised))
    ctypes.CDLL(str(folder / "code" / "march.so")).march(len(k), *pointers)
    return results, raised


COMPILER = shutil.which("gcc") or shutil.which("cc")
needs_c = pytest.mark.skipif(COMPILER is None, reason="there is no C compiler here")


@needs_c
@pytest.mark.parametrize("name", LOOPS)
def test_c_and_numpy_have_the_same_floats(name, tmp_path):
    law, k, z, y, r = recorded(name)
    results, flags = in_c(law, tmp_path, k, z, y, r)
    wanted = np.concatenate(single_precision(law, k, z, y, r), axis=1)
    assert not flags.any()
    np.testing.assert_array_equal(results.view(np.uint32), wanted.view(np.uint32))


@needs_c
def test_c_and_numpy_have_the_same_floats_in_every_function(tmp_path):
    def every(y, k, p):
        pair = [ca.sin(y[0]), ca.cos(y[0]), ca.exp(y[0]), ca.tanh(y[0]), ca.log(ca.fabs(y[0]) + 0.1), ca.floor(y[0])]
        pair += [
            ca.expm1(y[0]),
            ca.log1p(ca.fabs(y[0])),
            ca.sinh(y[0]),
            ca.cosh(y[0]),
            ca.asinh(y[0]),
            ca.atanh(y[0] / 99),
        ]
        pair += [ca.acosh(1 + ca.fabs(y[0])), ca.hypot(y[0], y[1]), ca.copysign(y[0], y[1]), ca.ceil(y[0])]
        pair += [ca.atan(y[0]), ca.asin(y[0] / 99), ca.acos(y[0] / 99)]
        pair += [ca.atan2(y[0], y[1]), ca.fmod(y[0], y[1]), ca.fmin(y[0], y[1]), ca.fmax(y[0], y[1]), ca.sign(y[1])]
        return ca.vertcat(
            *pair, ca.sqrt(ca.fabs(y[0])), ca.if_else(y[0] < y[1], y[0], 2 * y[1]), ca.sin(0.01 * k) * y[0]
        )

    law, draws = by_hand(every, readings=2), np.random.default_rng(0)
    y, k = draws.normal(scale=5.0, size=(20_000, 2)), draws.integers(0, 10_000, 20_000)
    none = np.zeros((len(k), 0))
    results, flags = in_c(law, tmp_path, k, none, y, none)
    assert not flags.any()
    np.testing.assert_array_equal(results.view(np.uint32), single_precision(law, k, none, y).u.view(np.uint32))


STRIDE = 127  # of the floats of a domain; 1 was run too, and takes six minutes
EVERYWHERE = """
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
{definitions}
static double worst, least;
static float at(uint32_t bits) {{ float x; memcpy(&x, &bits, 4); return x; }}
static uint32_t bits(float x) {{ uint32_t w; memcpy(&w, &x, 4); return w; }}
static void see(float got, double wanted)
{{
    const double error = fabs((double)got - wanted), size = fabs(wanted);
    if (size >= 0x1p-126) {{
        if (!(error / size <= worst)) worst = error / size;
    }} else if (!(error <= least)) {{
        least = error;
    }}
}}
int main(void)
{{
    for (uint32_t i = bits({low}); i <= bits({high}); i += {stride}u) {{
        const float x = at(i);
        {checks}
    }}
    printf("%.9g %.9g", worst * 0x1p24, least * 0x1p149);
    return 0;
}}
"""
EACH_FLOAT = {  # the function, the sizes of its argument, and what is checked; an odd function at positive ones alone
    "sin": ("turn", "0.0f", "8192.0f", "see(f_turnf(x).sine, sin(x)); see(f_turnf(x).cosine, cos(x));"),
    "exp": ("exp", "0.0f", "88.0f", "see(f_expf(x), exp(x)); if (x <= 87.0f) see(f_expf(-x), exp(-(double)x));"),
    "log": ("log", "0x1p-149f", "0x1.fffffep127f", "see(f_logf(x), log(x));"),
    "tanh": ("tanh", "0.0f", "12.0f", "see(f_tanhf(x), tanh(x));"),
    "expm1": ("expm1", "0.0f", "88.0f", "see(f_expm1f(x), expm1(x)); see(f_expm1f(-x), expm1(-(double)x));"),
    "log1p": (
        "log1p",
        "0.0f",
        "0x1.fffffep127f",
        "see(f_log1pf(x), log1p(x)); if (x < 1.0f) see(f_log1pf(-x), log1p(-(double)x));",
    ),
    "sinh": ("sinh", "0.0f", "89.0f", "see(f_sinhf(x), sinh(x));"),
    "cosh": ("cosh", "0.0f", "89.0f", "see(f_coshf(x), cosh(x));"),
    "asinh": ("asinh", "0.0f", "0x1.fffffep127f", "see(f_asinhf(x), asinh(x));"),
    "acosh": ("acosh", "1.0f", "0x1.fffffep127f", "see(f_acoshf(x), acosh(x));"),
    "atanh": ("atanh", "0.0f", "0x1.fffffep-1f", "see(f_atanhf(x), atanh(x));"),
    "atan2": (
        "atan2",
        "0x1p-30f",
        "1.0f",
        "const double a = atan(x), quarter = 1.57079632679489661923; see(f_atan2f(x, 1.0f), a);"
        "see(f_atan2f(1.0f, x), quarter - a); see(f_atan2f(1.0f, -x), quarter + a);"
        "see(f_atan2f(x, -1.0f), 2 * quarter - a);",
    ),
}


@needs_c
@pytest.mark.heavy
@pytest.mark.parametrize("name", EACH_FLOAT)
def test_the_stated_errors_hold_throughout_the_domain(name, tmp_path):
    function, low, high, checks = EACH_FLOAT[name]
    texts = "\n\n".join(definitions("f", SINGLE, [function]))
    source = EVERYWHERE.format(definitions=texts, low=low, high=high, checks=checks, stride=STRIDE)
    (tmp_path / "every.c").write_text(source, encoding="utf-8")
    compilation = [COMPILER, "-std=c99", "-O2", "-ffp-contract=off", "every.c", "-o", "every", "-lm"]
    subprocess.run(compilation, cwd=tmp_path, check=True, timeout=60)
    run = subprocess.run([tmp_path / "every"], capture_output=True, text=True, check=True, timeout=1200)
    worst, least = map(float, run.stdout.split())
    # the ratio of the sides of an angle is one of these floats, and itself rounded once
    assert worst <= STATED[name] - (name == "atan2")
    assert least <= 1
