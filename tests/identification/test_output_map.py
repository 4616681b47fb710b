"""Outputs at the samples: their derivatives in all directions at once, and searches that need few runs."""

import casadi as ca
import numpy as np
import pytest

import workbench as wb
from workbench.identification.estimation.input_record import MeasuredInput
from workbench.identification.estimation.least_squares import least_squares
from workbench.identification.estimation.output_model import OutputModel
from workbench.identification.estimation.unknown_numbers import NumberSource


@wb.block
class Tank(wb.Plant):
    """h' = (u - a sqrt(h)) / A, with outputs that are no states and hold the input and the parameters."""

    A: float = wb.parameter(default=0.5, unit="m^2", low=0, strict=True)
    a: float = wb.parameter(default=0.2, unit="m^2.5/s", low=0)
    h: float = wb.initial(default=1.0, unit="m")

    inputs = wb.layout(u="m^3/s")
    outputs = wb.layout(outflow="m^3/s", net="m^3/s", h="m")

    def rate(self, t, x, u):
        return {"h": (u["u"] - self.a * ca.sqrt(x["h"])) / self.A}

    def measure(self, t, x):
        return {"outflow": self.a * ca.sqrt(x["h"]), "net": self.A * x["h"] ** 2 + ca.sin(t), "h": x["h"]}


@pytest.mark.parametrize("hold", ["hold", "linear"])
@pytest.mark.parametrize("labels", [("outflow", "net", "h"), ("net",), ("h",)])
def test_derivatives_of_outputs_that_are_no_states_are_differences_of_outputs(hold, labels):
    tank = wb.open_loop(Tank())
    t = np.linspace(0.0, 3.0, 31)
    log = wb.Dataset.of(t, {"u": 0.3 + 0.2 * np.sin(3 * t)}, {"u": "m^3/s"})
    units = dict.fromkeys(labels, "")
    source = NumberSource(tank, tank.parameters.default, np.array([[1.0]]), ("log",), ("u",), units, {})
    numbers = source.numbers(("A", "a", "delay of u", "h(0)", f"scale of {labels[-1]}", f"offset of {labels[0]}"))
    pairs = tuple((label, label) for label in labels)
    inputs, p = (MeasuredInput("u", "u", hold),), tank.parameters.default
    model = OutputModel(tank, log, inputs, pairs, numbers, p, np.ones((1, 1)), (0.05,), (0.0,))
    z = model.starts + np.array([0, 0, 0.033, 0.1, 0.2, 0.1])
    y, J = model.derivatives(z, 0)
    np.testing.assert_array_equal(y, model.values(z[None], 0)[0])  # the same run, by another kernel of the same step
    for i in range(len(z)):
        d = 1e-6 * max(abs(z[i]), 0.01) * np.eye(len(z))[i]
        difference = (model.values((z + d)[None], 0)[0] - model.values((z - d)[None], 0)[0]) / (2 * d[i])
        # a difference over 2e-6 of a number has the rounding of 1e-16 / 2e-6, and a curvature of 1e-12
        assert np.abs(J[:, :, i] - difference).max() < 1e-7 * np.abs(difference).max(), numbers[i].name


def test_the_last_steps_of_a_search_need_no_runs():
    t, calls = np.linspace(0.0, 1.0, 50), []
    samples = np.exp(-2.0 * t) + 0.1 * np.random.default_rng(2).standard_normal(t.size)

    def residuals(z, kind="run"):
        calls.append((kind, z.copy()))
        return z[0] * np.exp(-z[1] * t) - samples

    def linearize(z):
        part = np.exp(-z[1] * t)
        return residuals(z, "line"), np.column_stack([part, -z[0] * t * part])

    end = least_squares(residuals, linearize, np.array([0.5, 1.0]), np.zeros(2), np.full(2, 9.0))
    places, r_end = list(calls), linearize(end.z)
    # the sum changes by 1e-13 of itself where the search ends, the gradient by the root of that, 3e-7 of its terms
    assert (np.abs(r_end[1].T @ r_end[0]) < 1e-6 * (np.abs(r_end[1]).T @ np.abs(r_end[0]))).all()
    assert len({tuple(z) for kind, z in places if kind == "run"}) == sum(kind == "run" for kind, _ in places)
    for i, (_, z) in enumerate(places[1:], 1):
        lines = [at for kind, at in places[:i] if kind == "line"]
        near = [np.abs(z - at).max() < 1e-9 * 0.5 for at in lines[-1:]]
        assert not any(near), "a run beside the last linearisation, where the residuals are known to their rounding"
