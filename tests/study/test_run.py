"""One run, whoever names it: the same loop, step and seed are the same number in every table."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy.io import loadmat

from tests.support.motors import Motor, motor_loop
from workbench.blocks.loop import AbstractController, Instruments
from workbench.core import block, initial, layout
from workbench.engine.metrics import measure, rmse
from workbench.study import Case, Factor, LogUniform, MonteCarlo, Run, Study, Sweep, Trial, Tuning, Uniform
from workbench.study.case_runs import run
from workbench.study.compiled_sweep import compile_sweep
from workbench.study.tuning import tune
from workbench.study.uncertainty.designs import ListedPoints
from workbench.study.uncertainty.local_sensitivity import local_sensitivities

METRICS, UNTIL, PERIOD = (rmse("omega"),), 2.0, 0.02
GAIN = Factor("kp", ("controller.kp",), LogUniform(1.0, 100.0))
NOISE = Instruments.of(Motor(), noise={"omega": 0.01})
LOOPS = {
    "a loop": motor_loop(),
    "its equations": motor_loop().ode(),
    "a computer": motor_loop().digital(PERIOD),
    "a computer with noise": motor_loop().digital(PERIOD, NOISE),
}


def outcome(asked):
    """What a case of a run gives."""
    return run(Study("s", "t", "q", "m", lambda results: (), cases=(Case("S", "law", asked),))).outcomes[0]


def sample(sweep):
    """All runs of a sweep."""
    made = compile_sweep(sweep)
    return made.sample([made.chunk(0, sweep.design.size)])


@pytest.mark.parametrize("loop", LOOPS.values(), ids=LOOPS.keys())
def test_a_run_has_the_same_bits_in_a_case_a_sweep_of_one_point_and_the_best_of_a_tuning(loop):
    asked = Run(loop, METRICS, UNTIL, h=PERIOD / 4, seed=3)
    trial, nothing = Trial("one", asked), lambda runs: runs["one"].score("RMSE of omega").value
    found = tune(Tuning("search", (trial,), (GAIN,), nothing, evaluations=8, population=8))
    point = found.points[found.place]
    swept = sample(Sweep("one", asked, (GAIN,), ListedPoints(point[np.newaxis])))
    case = outcome(replace(asked, loop=found.best_equations(loop)))
    assert case.score("RMSE of omega").value[0] == swept.score("RMSE of omega").value[0] == found.objective


def test_the_error_of_a_case_is_twice_its_change_to_half_the_step():
    fine, rough = (outcome(Run(motor_loop(), METRICS, UNTIL, h=h)).score("RMSE of omega").pair for h in (0.01, 0.02))
    assert rough[1] == 2 * abs(fine[0] - rough[0]) > 0


def test_the_seed_of_a_run_is_that_of_its_noise():
    """Two cases of one loop march together, each under its own noise."""
    runs = (Run(LOOPS["a computer with noise"], METRICS, UNTIL, h=PERIOD / 2, seed=seed) for seed in (0, 0, 1))
    study = Study("s", "t", "q", "m", lambda r: (), cases=tuple(Case("S", f"{i}", one) for i, one in enumerate(runs)))
    first, again, other = (one.score("RMSE of omega").pair[0] for one in run(study).outcomes)
    assert first == again != other


@pytest.mark.parametrize("loop", [LOOPS["a loop"], LOOPS["a computer"]], ids=["in time", "a computer"])
@pytest.mark.parametrize("tolerance", [1e-2, 1e-6])
def test_a_step_that_nobody_named_keeps_the_tolerance_and_is_told(loop, tolerance):
    asked = Run(loop, METRICS, UNTIL, tolerance=tolerance)
    case, swept = outcome(asked), sample(Sweep("s", asked, (GAIN,), MonteCarlo(1, 8, seed=1), half_step_every=1))
    value, error = case.score("RMSE of omega").pair
    assert error <= tolerance * value
    assert any(f"for a tolerance of {tolerance:g}" in note for note in case.notes)
    assert swept.score("RMSE of omega").largest_error <= tolerance * swept.score("RMSE of omega").value.max()
    assert f"step {swept.h:g} s" in swept.note
    assert f"chosen by pilot runs for a tolerance of {tolerance:g}" in swept.note


def test_a_smaller_tolerance_takes_more_substeps_each_a_part_of_the_period():
    found = [
        measure(LOOPS["a computer"], METRICS, until=UNTIL, tolerance=t).trajectories.step.substeps for t in (1, 1e-9)
    ]
    assert found[0] < found[1]


def test_the_step_of_a_sweep_is_that_of_its_fastest_run():
    """K R = 1 in a motor with L down to 1 mH: its mode of -R/L = -1000 / s is stable up to 5.8 ms at the most."""
    asked = Run(motor_loop(), METRICS, UNTIL)
    slow, fast = (Factor("L", ("plant.L",), LogUniform(low, 0.5)) for low in (0.4, 1e-3))
    steps = [compile_sweep(Sweep("s", asked, (one,), MonteCarlo(1, 16, seed=1))).h for one in (slow, fast)]
    assert steps[1] < 5.8e-3 < steps[0]


def test_a_tuning_without_a_step_has_one_chosen_at_the_ends_of_its_ranges():
    asked = Trial("one", Run(motor_loop(), METRICS, UNTIL, tolerance=1e-4))
    found = tune(Tuning("s", (asked,), (GAIN,), lambda runs: runs["one"].score("RMSE of omega").value, 8, 8))
    assert found.step_error <= 1e-4 * found.objective
    assert f"step of the simulation is {found.samples['one'].h:g} s" in found.note


@pytest.mark.heavy
def test_a_tolerance_that_no_step_keeps_is_refused_with_what_is_left():
    loop = LOOPS["a computer"]
    with pytest.raises(ValueError, match=r"No step `h` keeps the tolerance of .*: that of .* still changes"):
        measure(loop, METRICS, until=UNTIL, tolerance=1e-18)


def test_a_period_of_one_step_has_its_error_from_two_substeps():
    value, error = outcome(Run(LOOPS["a computer"], METRICS, UNTIL, h=PERIOD)).score("RMSE of omega").pair
    half, _ = outcome(Run(LOOPS["a computer"], METRICS, UNTIL, h=PERIOD / 2)).score("RMSE of omega").pair
    assert error == 2 * abs(value - half) > 0


def test_a_local_sensitivity_of_a_computer_is_that_of_its_own_step():
    found = local_sensitivities(LOOPS["a computer"], METRICS, ["controller.kp"], until=UNTIL, h=PERIOD / 2)
    assert found.holds("RMSE of omega").all()


@block
class Silent(AbstractController):
    """A law that returns nothing."""

    reads = follows = layout(omega="rad/s")
    drives = layout(v="V")

    def command(self, t, z, est, ref):
        """None."""


@block
class Misspelt(AbstractController):
    """A law whose rate has a key that its memory lacks."""

    z: float = initial(0.0, unit="rad")

    reads = follows = layout(omega="rad/s")
    drives = layout(v="V")

    def command(self, t, z, est, ref):
        """The memory."""
        return {"v": z.z}

    def rate(self, t, z, est, ref):
        """The error, under another name."""
        return {"zz": ref.omega - est.omega}


LOOP = "`Run(loop=...)` must be an `Ode`, a `SampledSystem`, or a loop, whose `ode(name)` gives its equations"
WRONG = [
    (lambda: Run(None, METRICS, 1.0), f"{LOOP}, as a `ClosedLoop` does; got None."),
    (lambda: Run(Motor(), METRICS, 1.0), f"{LOOP}, as a `ClosedLoop` does; got a `Motor`"),
    (
        lambda: Run(motor_loop(), [rmse], 1.0),
        "`Run(metrics=...)` must be a tuple of `AbstractMetric`; got the function `rmse` itself: call it at [0].",
    ),
    (
        lambda: measure(motor_loop().ode(), [rmse], until=1.0, h=0.1),
        "`measure(metrics=...)` must be a tuple of `AbstractMetric`; got the function `rmse` itself: call it at [0].",
    ),
    (
        lambda: measure(GAIN, METRICS, until=1.0, h=0.1),
        "`measure(equation=...)` must be an `Ode`, a `SampledSystem`, or a loop, whose `ode(name)` gives its "
        "equations, as a `ClosedLoop` does; got a `Factor`",
    ),
    (
        lambda: Case("S", "law", motor_loop()),
        "`Case(run=...)` must be a `Run`; got a `ClosedLoop`: write `Run(loop, metrics, until)`.",
    ),
    (lambda: Sweep("s", None, (GAIN,), MonteCarlo(1, 2)), "`Sweep(run=...)` must be a `Run`; got None."),
    (
        lambda: Trial("t", motor_loop().ode()),
        "`Trial(run=...)` must be a `Run`; got an `Ode`: write `Run(loop, metrics, until)`.",
    ),
    (
        lambda: outcome(Run(motor_loop(Silent()), METRICS, 1.0)),
        "S: law: `Silent.command(...)` must return 'v'; it returned None.",
    ),
    (lambda: outcome(Run(motor_loop(Misspelt()), METRICS, 1.0)), "S: law: `Misspelt.rate(...)` must return"),
]


@pytest.mark.parametrize(("made", "said"), WRONG, ids=[said[:50] for _, said in WRONG])
def test_what_takes_a_loop_says_in_one_sentence_what_it_got_instead(made, said):
    with pytest.raises(ValueError) as refusal:
        made()
    assert str(refusal.value).startswith(said)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("bad", [0.0, -1.0, float("nan"), float("inf")])
@pytest.mark.parametrize("name", ["until", "every", "h", "tolerance"])
def test_a_run_refuses_a_number_that_is_none(name, bad):
    with pytest.raises(ValueError, match=rf"^`Run\({name}=...\)` must be a positive, finite number"):
        Run(motor_loop(), METRICS, **({"until": 1.0} | {name: bad}))


def test_a_factor_of_a_sweep_may_be_an_initial_state_of_a_computer():
    start = Factor("start", ("plant.omega",), Uniform(0.0, 2.0))
    found = sample(Sweep("s", Run(LOOPS["a computer"], METRICS, UNTIL, h=PERIOD), (start,), MonteCarlo(1, 4)))
    assert np.isfinite(found.score("RMSE of omega").value).all()


STUDY = """
from tests.support.motors import motor_loop
from workbench.engine.metrics import rmse
from workbench.study import Case, Paragraph, Run, Section, Study

def sections(results):
    return [Section("Runs", (Paragraph("One."),))]

CASE = Case("=S", "PI", Run(motor_loop(), (rmse("omega"),), until=0.5, h=0.005))
study = Study("single", "T", "Q?", "M.", sections, cases=(CASE,))
"""


def test_the_values_of_single_cases_are_a_table_in_every_form(command, tmp_path):
    (tmp_path / "single.py").write_text(STUDY, encoding="utf-8")
    assert command("run", "single.py", "--out", "out").exit_code == 0
    table = tmp_path / "out" / "runs" / "cases.csv"
    value, error = outcome(Run(motor_loop(), METRICS, 0.5, h=0.005)).score("RMSE of omega").pair
    assert table.read_text("utf-8").splitlines()[1] == f"'=S,PI,RMSE of omega,rad/s,omega,{value!r},{error!r},"
    for form in ("csv", "parquet", "mat"):
        done = command("results", "out", "--format", form)
        assert (done.exit_code, done.stdout) == (
            0,
            f"out/runs/cases.{form}: the single cases, one row a metric and number.\n",
        )
    assert pd.read_parquet(table.with_suffix(".parquet")).value.tolist() == [value]
    assert loadmat(table.with_suffix(".mat"))["error"].item() == error


def test_a_sweep_whose_table_would_be_that_of_the_cases_is_refused():
    asked = Run(motor_loop(), METRICS, UNTIL, h=0.01)
    swept = Sweep("cases", asked, (GAIN,), MonteCarlo(1, 2))
    with pytest.raises(ValueError, match=r"^`Study\(sweeps=...\)` needs another name for 'cases'"):
        Study("s", "t", "q", "m", lambda results: (), cases=(Case("S", "law", asked),), sweeps=(swept,))


def test_the_traceback_of_the_users_own_code_can_be_had(command, tmp_path):
    (tmp_path / "odd.py").write_text(STUDY.replace("return [", "return 1 / 0, ["), encoding="utf-8")
    plain, traced = command("run", "odd.py"), command("run", "odd.py", "--traceback")
    assert (plain.exit_code, traced.exit_code) == (2, 2)
    (sentence,) = plain.stderr.splitlines()
    first, *rest = traced.stderr.splitlines()
    assert first == sentence
    assert '    return 1 / 0, [Section("Runs", (Paragraph("One."),))]' in rest
    assert "ZeroDivisionError: division by zero" in rest
