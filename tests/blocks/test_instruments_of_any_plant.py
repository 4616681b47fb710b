"""What a computer reads of any plant, and what it can ask of it."""

import numpy as np
import pytest

from tests.support.compilers import needs_llvmlite
from workbench.blocks.loop import AbstractController, AbstractPlant, ClosedLoop, Instruments
from workbench.core import block, initial, layout, lift
from workbench.engine import simulate

PERIOD = 0.1


@block
class Tank(AbstractPlant):
    """A level and two temperatures that stay as they are, whatever is pumped."""

    level: float = initial(0.3, unit="m")
    T: np.ndarray = initial([20.0, 30.0], unit="K", shape=("2",))
    inputs = layout(flow="m^3/s")
    outputs = layout(level="m", T=("K", [0, 0]))

    def rate(self, t, x, u):
        return {"level": 0 * u.flow, "T": 0 * x.T}


@block
class Reader(AbstractController):
    """A pump at ten times the level, which shows what it reads."""

    reads = layout(level="m", T=("K", [0, 0]))
    drives = layout(flow="m^3/s")

    def command(self, t, z, est, ref):
        return {"flow": 10 * est.level}

    def signals(self, z, est, ref):
        return {"heat": est.T}


def readings(until=50.0, seed=1, sets=None, runs=1, **options):
    """Levels (B, N) and temperatures (B, N, 2) as the computer reads them."""
    digital = ClosedLoop(Tank(), controller=Reader()).digital(PERIOD, Instruments.of(Tank(), **options))
    step = digital.step()
    p = np.tile(step.parameters.pack(sets), (runs, 1))
    run = simulate(step, p, until=until, seed=seed)
    return run["level"].squeeze(-1) - run["level_error"].squeeze(-1), run["heat"]


def test_without_instruments_for_it_an_output_is_read_as_it_is():
    level, T = readings(noise={"level": 0.1})
    np.testing.assert_array_equal(T[0], np.tile([20.0, 30.0], (len(T[0]), 1)))
    assert np.ptp(level) > 0.1


def test_the_noise_of_each_number_has_its_own_size_and_no_memory():
    _, T = readings(until=2000.0, noise={"T": [0.5, 2.0]})
    noise = T[0] - [20.0, 30.0]
    # of 20001 draws a standard deviation is known to 0.5 %, a mean and a correlation to 0.7 %: four times that
    np.testing.assert_allclose(noise.std(axis=0), [0.5, 2.0], rtol=0.02)
    assert (np.abs(noise.mean(axis=0)) < 0.03 * np.array([0.5, 2.0])).all()
    z = noise / [0.5, 2.0]
    assert abs(np.mean(z[:, 0] * z[:, 1])) < 0.03
    assert (np.abs(np.mean(z[1:] * z[:-1], axis=0)) < 0.03).all()


def test_a_command_stays_within_its_limits():
    digital = ClosedLoop(Tank(), controller=Reader()).digital(
        PERIOD, Instruments.of(Tank(), limit={"flow": (0.0, 2.5)})
    )
    np.testing.assert_array_equal(simulate(digital.step(), until=1.0)["flow"], 2.5)


def test_the_numbers_of_an_instrument_are_parameters_in_the_unit_of_the_signal():
    options = {"noise": {"level": 0.1}, "quantum": {"T": 1.0}, "limit": {"flow": (0, 1)}}
    parameters = lift(Instruments.of(Tank(), **options), "instruments.").layout
    assert {entry.name: (entry.unit, entry.shape) for entry in parameters.entries} == {
        "instruments.sensors[0].noise": ("m", ()),
        "instruments.sensors[0].quantum": ("m", ()),
        "instruments.sensors[1].noise": ("K", (2,)),
        "instruments.sensors[1].quantum": ("K", (2,)),
        "instruments.bounds[0].low": ("m^3/s", ()),
        "instruments.bounds[0].high": ("m^3/s", ()),
    }


@needs_llvmlite
@pytest.mark.parametrize("arithmetic", ["fused", "portable"])
def test_readings_have_the_same_bits_in_the_compiled_march_and_in_numpy(arithmetic):
    options = {"noise": {"T": 0.1, "level": 0.1}, "quantum": {"level": 0.01}}
    step = ClosedLoop(Tank(), controller=Reader()).digital(PERIOD, Instruments.of(Tank(), **options)).step(2)
    runs = [simulate(step, until=5.0, seed=3, engine=e, arithmetic=arithmetic) for e in ("native", "numpy")]
    np.testing.assert_array_equal(*(run.x.view(np.uint64) for run in runs))


@pytest.mark.parametrize(
    ("options", "kind", "says"),
    [
        ({"noise": {"levl": 1}}, LookupError, "no 'levl' among the 2 outputs of the plant. Did you mean 'level'"),
        ({"quantum": {"flow": 1}}, LookupError, "no 'flow' among the 2 outputs of the plant"),
        ({"limit": {"level": (0, 1)}}, LookupError, "no 'level' among the 1 inputs of the plant"),
        ({"noise": {"level": -1}}, ValueError, r"`Sensor\(noise=...\)` must be finite, with 0 <= value \[m\]; got -1"),
        ({"quantum": {"T": np.nan}}, ValueError, r"`Sensor\(quantum=...\)` must be finite"),
        (
            {"noise": {"T": [1, 2, 3]}},
            ValueError,
            r"`Instruments.of\(noise=...\)` must have 2 numbers or one for all of 'T'; got shape \(3,\)",
        ),
        (
            {"quantum": {"level": [1.0]}},
            ValueError,
            r"`Instruments.of\(quantum=...\)` must have one number for 'level'; got shape \(1,\)",
        ),
        ({"limit": {"flow": 3}}, ValueError, r"`Instruments.of\(limit=...\)` must be a pair \(low, high\) for 'flow'"),
        (
            {"limit": {"flow": (1, 1)}},
            ValueError,
            r"`Limit\(low=..., high=...\)` of 'flow' must leave room between them",
        ),
    ],
)
def test_instruments_that_fit_no_plant_are_refused(options, kind, says):
    with pytest.raises(kind, match=says):
        Instruments.of(Tank(), **options)
