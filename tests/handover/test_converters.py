"""The converters between a plant and its computer: their codes, their bits as a number, and their place in the law."""

import casadi as ca
import numpy as np
import pytest

import workbench as wb
from tests.support.targets_here import needs_gcc

MOTOR = wb.DCMotor()


def loop(reference=None):
    law = wb.PID(MOTOR.outputs, MOTOR.inputs, Kp=100.0, Ki=200.0)
    return wb.ClosedLoop(MOTOR, controller=law, reference=reference or wb.Sines("omega", "rad/s", 1.0, 3.0))


def converted(x, bits, low, high, rounding="nearest"):
    """The converter as NumPy would have it."""
    codes = 2**bits
    q = (high - low) / codes
    count = {"nearest": lambda v: np.floor(v + 0.5), "down": np.floor, "toward zero": np.trunc}[rounding]
    return low + np.clip(count((x - low) / q), 0, codes - 1) * q


@pytest.mark.parametrize("rounding", ["nearest", "down", "toward zero"])
@pytest.mark.parametrize("bits", [1, 3, 10])
def test_a_converter_gives_one_of_its_codes(bits, rounding):
    gauges = wb.Instruments.of(MOTOR, dac={"v": (bits, -8.0, 8.0, rounding)})
    x, symbol = np.linspace(-10, 10, 4001), ca.SX.sym("x")
    y = np.array(ca.Function("y", [symbol], [gauges.dacs[0].output(symbol)]).map(len(x))(x[None])).ravel()
    np.testing.assert_array_equal(y, converted(x, bits, -8.0, 8.0, rounding))  # powers of two: no rounding
    assert len(set(y)) == 2**bits
    assert (y.min(), y.max()) == (-8.0, 8.0 - gauges.dacs[0].quantum)
    assert [gauges.dacs[0].value(float(each)) for each in x[::500]] == y[::500].tolist()


def test_readings_and_commands_of_a_computer_are_converted():
    gauges = wb.Instruments.of(
        MOTOR, limit={"v": (-6.0, 6.0)}, adc={"omega": (8, -2.0, 2.0)}, dac={"v": (6, -8.0, 8.0)}
    )
    assert (gauges.reads.names, gauges.limits.names, gauges.noises) == (("omega",), ("v",), 0)
    digital = loop().digital(0.01, gauges)
    rows = wb.record(digital, periods=300)
    y = converted(wb.simulate(digital.step(1), until=3.0, arithmetic="portable")["omega"].ravel()[:-1], 8, -2.0, 2.0)
    np.testing.assert_array_equal(rows.y.ravel(), y)  # powers of two
    assert set(rows.u.ravel()) <= set(converted(np.linspace(-6, 6, 2001), 6, -8.0, 8.0))
    assert rows.u.max() == 6.0


@pytest.mark.parametrize("bits", [8, 16, 32])
def test_the_error_of_a_converter_is_a_twelfth_of_the_square_of_its_step(bits):
    digital = loop().digital(0.01, wb.Instruments.of(MOTOR, adc={"omega": (bits, -4.0, 4.0)}))
    rows, q = wb.record(digital, periods=20_000), 8 / 2.0**bits
    run = wb.simulate(digital.step(1), until=199.99, arithmetic="portable")
    error = rows.y.ravel() - run["omega"].ravel()
    assert np.abs(error).max() <= q / 2
    # a sine over some 60 to 1e9 steps is spread evenly over each but the two at its ends
    assert np.sqrt(np.mean(error**2)) == pytest.approx(q / np.sqrt(12), rel=0.05)


def test_the_bits_of_a_converter_are_a_number_that_a_batch_varies():
    bits = [2.0, 5.0, 12.0]
    step = loop().digital(0.01, wb.Instruments.of(MOTOR, adc={"omega": (8, -4.0, 4.0)})).step(2)
    runs = wb.simulate(step, step.parameters.pack({"instruments.adcs[0].bits": bits}), until=3.0)
    for i, each in enumerate(bits):
        made = loop().digital(0.01, wb.Instruments.of(MOTOR, adc={"omega": (each, -4.0, 4.0)})).step(2)
        np.testing.assert_array_equal(wb.simulate(made, until=3.0)["omega"][0], runs["omega"][i])


@needs_gcc
def test_a_converter_of_commands_is_a_part_of_the_law_and_has_its_bits_in_c():
    gauges = wb.Instruments.of(
        MOTOR, noise={"omega": 0.01}, adc={"omega": (8, -2.0, 2.0)}, dac={"v": (7, -10.0, 10.3, "down")}
    )
    digital = loop().digital(0.01, gauges)
    law = digital.law()
    assert {"instruments.dacs[0].bits", "instruments.dacs[0].low"} <= set(law.parameters.names)
    assert not any("adcs" in name or "sensors" in name for name in law.parameters.names)
    assert wb.replay(digital, periods=2000, targets=["numpy", "gcc-O2"]).equal


def test_the_command_that_is_safe_lies_within_the_codes():
    digital = loop().digital(
        0.01, wb.Instruments.of(MOTOR, limit={"v": (-1.0, 1.0)}, dac={"v": (4, -8.0, 8.0, "down")})
    )
    assert digital.law().limits["v"] == (-1.0, 1.0)
    wide = loop().digital(0.01, wb.Instruments.of(MOTOR, dac={"v": (4, -8.0, 8.0)})).law()
    assert wide.limits["v"] == (-8.0, 7.0)


@pytest.mark.parametrize(
    ("given", "kind", "says"),
    [
        ({"adc": {"omga": (8, 0.0, 1.0)}}, LookupError, "no 'omga' among the 1 outputs of the plant"),
        ({"dac": {"v": (8, 1.0)}}, ValueError, r"`Instruments.of\(dac=...\)` must be \(bits, low, high\)"),
        ({"dac": {"v": (0, -1.0, 1.0)}}, ValueError, r"`Converter\(bits=...\)` must be finite, with 1 <= value <= 32"),
        ({"adc": {"omega": (8, 1.0, 1.0)}}, ValueError, r"`Converter\(low=..., high=...\)` of 'omega' must leave room"),
        ({"adc": {"omega": (8, 0.0, 1.0, "up")}}, ValueError, "is one of 'nearest', 'down', 'toward zero'"),
    ],
)
def test_a_converter_that_cannot_be_is_refused(given, kind, says):
    with pytest.raises(kind, match=says):
        wb.Instruments.of(MOTOR, **given)
