"""Small pictures for the reference: what each name that draws makes, and the course of each signal in time."""

import io
from pathlib import Path
from typing import Any

import casadi as ca
import control
import numpy as np

import workbench as wb

DOCS = Path(__file__).parent
WIDTH, HEIGHT, RIM = 180.0, 100.0, 8.0  # of a signal's picture, in the units of SVG


def drawings() -> dict[str, str | bytes]:
    """The pictures by name: the text of an SVG, or the bytes of a PNG."""
    pictures: dict[str, str | bytes] = {name: picture.svg for name, picture in pictures_of_systems().items()}
    pictures |= pictures_of_runs() | {name: course(*curve) for name, curve in courses().items()}
    shown = (DOCS / "pictures" / "first_live.png").read_bytes()  # made by `python docs/live_picture.py`
    return pictures | dict.fromkeys(("live", "Knob"), shown)


def pictures_of_systems() -> dict[str, Any]:
    """Pictures of linear systems: a third-order plant at several gains, and a loop with two channels."""
    plant = control.tf([1], [1, 3, 3, 1])
    loop = control.feedback(4 * plant)
    two = control.ss([[-1, 0], [0, -2]], np.eye(2), [[1, 1], [0, 1]], np.zeros((2, 2)))
    omega = np.geomspace(0.1, 10.0, 200)
    bound = wb.GainBound("a limit", [1.0, 100.0], [1.0, 0.01])
    return {
        "bode": wb.bode(4 * plant, margins=True),
        "nyquist": wb.nyquist(4 * plant),
        "nichols": wb.nichols(4 * plant),
        "pole_zero_map": wb.pole_zero_map(loop),
        "root_locus": wb.root_locus(plant, np.linspace(0, 20, 401)),
        "singular_values_plot": wb.singular_values_plot(two),
        "step_response": wb.step_response(loop, until=30.0),
        "FrequencyCurve": wb.bode(wb.FrequencyCurve("a lag", omega, 1 / (1 + 1j * omega))),
        "GainBound": wb.bode(control.tf([1], [1, 1]), bounds=[bound]),
    }


def pictures_of_runs() -> dict[str, str]:
    """Pictures of the first loop of the tutorial, and of Sobol indices."""
    motor = wb.DCMotor()
    law = wb.PID(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0, Kd=10.0, low=-24.0, high=24.0)
    loop = wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0, time=0.1))
    text = io.StringIO()
    wb.simulate(loop, until=2.0).plot("omega", "v_applied").savefig(text, format="svg")
    design = wb.SobolDesign(dimensions=2, base=256)
    u = design.points(0, design.size)
    bars = wb.sobol_bars("bars", "Indices", wb.sobol(design, u[:, 0] + 2 * u[:, 1]), "256 points")
    linear = wb.linear_loop(loop).plot().svg
    car = wb.open_loop(wb.OdePlant.of(lambda t, x, u: [x[1], u[0]], states=("x:m", "v:m/s"), inputs=("a:m/s^2",)))
    plan = wb.plan(car, (1.0, 100.0), end={"x": 300.0, "v": 0.0}, limits={"a": (-2.0, 1.0), "v": (None, 15.0)})
    from workbench.report.picture import Picture

    runs = dict.fromkeys(("simulate", "plot"), text.getvalue())
    return (
        runs
        | dict.fromkeys(("linear_loop", "loop_gain_pictures"), linear)
        | {"sobol_bars": Picture(bars).svg, "plan": plan.plot().svg}
    )


def courses() -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Times and values of each signal, for numbers that show its shape."""
    u, t = ("x", "1"), np.linspace(0.0, 10.0, 1001)
    signals = {
        "Step": wb.Step(*u, 1.0, time=2.0),
        "Constant": wb.Constant(*u, 1.0),
        "Ramp": wb.Ramp(*u, slope=0.2, time=2.0),
        "Sines": wb.Sines(*u, 1.0, 2.0),
        "SquareWave": wb.SquareWave(*u, 1.0, 0.4),
        "Chirp": wb.Chirp(*u, amplitude=1.0, first=0.1, last=1.5, duration=10.0),
        "PulseTrain": wb.PulseTrain(*u, level=1.0, period=2.0, width=0.4, time=1.0),
        "Trapezoid": wb.Trapezoid(*u, goal=1.0, speed=0.2, acceleration=0.1, time=1.0),
        "WayPoints": wb.WayPoints(*u, times=[0.0, 3.0, 6.0, 10.0], points=[0.0, 1.0, 0.4, 0.8]),
        "Table": wb.Table(*u, times=[0.0, 2.0, 5.0, 6.0, 10.0], values=[0.0, 1.0, 0.3, 0.5, 0.0]),
    }
    time = ca.SX.sym("t")
    values = {n: np.ravel(ca.Function("x", [time], [s.at(time).x])(t[None]).full()) for n, s in signals.items()}
    noises = {
        "GaussMarkov": wb.GaussMarkov("x", sigma=1.0, time_constant=0.5),
        "SecondOrderNoise": wb.SecondOrderNoise("x", sigma=1.0, natural_frequency=6.0, damping=0.1),
        "RandomWalk": wb.RandomWalk("x", intensity=0.3),
    }
    for name, noise in noises.items():
        values[name] = np.ravel(noise.path(period=0.01, count=1001, rng=np.random.default_rng(1)))
    values["SineTorque"] = values["Sines"]
    return {name: (t, x) for name, x in values.items()}


def course(t: np.ndarray, x: np.ndarray) -> str:
    """A curve over time without numbers, as an SVG."""
    low, high = float(min(x.min(), 0.0)), float(x.max())
    across = RIM + (t - t[0]) / (t[-1] - t[0]) * (WIDTH - 2 * RIM)
    up = HEIGHT - RIM - (x - low) / (high - low) * (HEIGHT - 2 * RIM)
    zero = HEIGHT - RIM + low / (high - low) * (HEIGHT - 2 * RIM)
    points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(across, up, strict=True))
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH:g} {HEIGHT:g}">'
        f'<path d="M{RIM:g} {zero:.1f}H{WIDTH - RIM:g}" stroke="#999" fill="none"/>'
        f'<polyline points="{points}" stroke="#1f4e79" stroke-width="2" fill="none" stroke-linejoin="round"/></svg>'
    )
