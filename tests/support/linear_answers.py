"""Linear answers of loops by Python in the form in which a worker of a live page gives them."""

import json
import math

import numpy as np

RECEIVE = """(() => {{ const answer = {answer}, numbers = (list) => Float64Array.from(list);
  const arrays = ({{re, im}}) => ({{re: numbers(re), im: numbers(im)}});
  if (answer.rests) {{
    answer.omega = numbers(answer.omega);
    for (const name of ["L", "poles", "openPoles"]) answer[name] = arrays(answer[name]);
  }}
  livePage.hear({{ticket: livePage.pool.ticket, loop: 0, printed: false, phase: "linear", linear: answer}}); }})()"""


def received(answer):
    """The script by which the page hears an answer as if its worker had given it."""
    return RECEIVE.format(answer=json.dumps(answer))


def answer_of(linear, omega):
    """The answer of a linear loop at frequencies (m,) in rad/s."""
    L = linear.response(omega, "L").values
    poles, cut = np.array([pole.value for pole in linear.poles]), np.asarray(linear.L.poles(), dtype=complex)
    margins = linear.margins()
    return {
        "rests": True,
        "reason": "",
        "omega": omega.tolist(),
        "L": _parts(L),
        "poles": _parts(poles),
        "openPoles": _parts(cut),
        "stable": linear.stable,
        "margins": [_margins(margins[name]) for name in linear.channels],
        "diskMargin": {"alpha": linear.disk_margin.alpha} if linear.stable else None,
    }


def _parts(numbers):
    return {"re": numbers.real.ravel().tolist(), "im": numbers.imag.ravel().tolist()}


def _margins(found):
    held = found.margins
    numbers = dict.fromkeys(("phaseMargin", "delayMargin", "Ms", "Mt"))
    gains = {"low": None, "high": None}
    if held is not None:
        numbers = {
            "phaseMargin": held.phase_margin.value,
            "delayMargin": held.delay_margin.value,
            "Ms": held.Ms.gain.value,
            "Mt": held.Mt.gain.value,
        }
        gains = {"low": held.gain_low.value or None, "high": held.gain_high.value}
    phases = [one for one in found.phase_crossovers if math.isfinite(one.frequency.value)]
    return {
        "stable": found.stable,
        "gainCrossovers": [{"omega": one.frequency.value, "phase": one.margin.value} for one in found.gain_crossovers],
        "phaseCrossovers": [{"omega": one.frequency.value, "gain": one.margin.value} for one in phases],
        "gainMargin": {name: _known(number) for name, number in gains.items()},
        **{name: _known(number) for name, number in numbers.items()},
    }


def _known(number):
    return None if number is None or not math.isfinite(number) else number
