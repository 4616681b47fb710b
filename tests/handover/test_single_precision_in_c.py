"""Single precision in C: the floats of NumPy, and stated errors that hold throughout the domain."""

import ctypes
import shutil
import subprocess

import casadi as ca
import numpy as np
import pytest

from tests.support.cases import heavy_but
from tests.support.recorded_laws import LOOPS, by_hand, recorded
from workbench.engine.machines.c_elementary_functions import definitions
from workbench.engine.machines.c_real import SINGLE
from workbench.handover.c99.c_files import c_code
from workbench.handover.c99.c_names import members
from workbench.handover.single.rounding_rules import RELATIVE_ERRORS
from workbench.handover.single.single_precision import single_precision

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
@pytest.mark.parametrize("name", heavy_but(LOOPS, "motor PID", "SMC"))
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


STRIDE = 509  # of the floats of a domain; 1 was run too, and takes six minutes
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
    assert worst <= RELATIVE_ERRORS[name] - (name == "atan2")
    assert least <= 1
