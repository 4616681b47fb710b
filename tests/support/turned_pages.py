"""Pages of the laws of the paper: opened, turned, and run again by Python."""

import base64

import numpy as np

from studies.paper.laws import rival
from workbench.engine import metrics, simulate
from workbench.engine.metrics.accumulators import final_values
from workbench.engine.metrics.measured_equation import MeasuredEquation

H, UNTIL, EVERY = 1e-4, 2.0, 0.01
KNOBS = (  # name, unit, path, low, high, log
    ("phi", "rad/s", "controller.phi", 0.001, 0.5, True),
    ("gain: K", "N m", "controller.K", 1.0, 50.0, False),
    ("Kd", "N m s/rad", "controller.Kd", 1.0, 1e6, True),
)
LOOPS = {(scenario, law): rival(scenario, law).ode() for scenario, law in (("FS", "SMC"), ("FS", "PID"), ("SS", "SMC"))}
IDLE = "livePage.flight && !livePage.flight.fine.size && !livePage.held"
BYTES = """(() => { const view = livePage.views.get(%d), text = (a) => {
  let out = ""; for (const byte of new Uint8Array(a.buffer)) out += String.fromCharCode(byte); return btoa(out); };
  return {x: text(view.x), y: text(view.y), scores: view.scores, divergedAt: view.divergedAt}; })()"""


def opened(page):
    page.click(".bench-handle")
    page.until("livePage.data")


def turned(page, **values):
    """Turn knobs by their fields, as a reader does, and wait for the fine runs."""
    for place, value in values.items():
        number = place.removeprefix("knob")
        page.value(
            f"(() => {{ const field = livePage.bench.knobs[{number}].field; field.value = {value!r};"
            " field.dispatchEvent(new Event('change', {bubbles: true})); })()"
        )
    page.until(IDLE)


def numbers(text, width):
    return np.frombuffer(base64.b64decode(text)).reshape(-1, width)


def python_run(loop, changes, h=H, until=UNTIL, every=EVERY, seed=0):
    """The same run as `simulate` makes it, and its metric."""
    measured = MeasuredEquation.of(loop, [metrics.rmse()])
    step, scores = measured.step(h), measured.metrics
    p = step.parameters.default.copy()
    for name, value in changes.items():
        p[step.parameters.slice(name)] = value
    runs = simulate(step, p[np.newaxis], until=until, every=every, seed=seed, arithmetic="portable")
    return runs, final_values(runs, scores)["RMSE"][0]
