"""Ctrl-C ends a study within a second, whatever an item of a work is doing, and says what is kept."""

import sys
import time

import numpy as np
import pytest

import workbench as wb
from tests.support import warm_runs
from tests.support.cases import heavy_but
from tests.support.stops import stopped
from workbench.engine.job import set_stop_check
from workbench.study.executors import CancelledError

BUSY = 2.0  # s more than the second that is promised: other tests may have all processors
LONG = """
import numpy as np
import workbench as wb

def march(item):
    print("under way", flush=True)
    motor = wb.open_loop(wb.DCMotor())
    p = np.tile(motor.parameters.default, (4000, 1))
    return float(wb.simulate(wb.rk4(motor, 1e-4), p, until=1e3, every=1e3)["omega"].max())

def choose(item):
    print("under way", flush=True)
    motor = wb.open_loop(wb.DCMotor())
    return float(wb.measure(motor, (wb.effort("omega"),), until=1e6, h=1e-4, every=1e6).h)

def count(item):
    print("under way", flush=True)
    return sum(i % 7 for i in range(10**10))

def factorise(item):
    print("under way", flush=True)
    return float(np.linalg.svd(np.random.default_rng(1).standard_normal((4000, 4000)))[1][0])

def quick(item):
    return item

study = wb.Study("long", "T", "Q?", "M.", lambda results: [], works=(
    wb.Work("quick", quick, over=(1, 2, 3)), wb.Work("long", {name}, over=(1, 2, 3), seconds=1.0)))
"""


@pytest.mark.skipif(sys.platform == "win32", reason="Windows sends no SIGINT to a process alone")
@pytest.mark.parametrize("name", heavy_but(["march", "choose", "count", "factorise"], "march"))
def test_ctrl_c_ends_an_item_within_a_second_and_says_what_is_kept(tmp_path, name):
    (tmp_path / "long.py").write_text(LONG.replace("{name}", name), encoding="utf-8")
    with warm_runs.start(["run", "long.py", "--out", "out", "--workers", "2"], tmp_path) as process:
        for line in process.stdout:
            if "under way" in line:  # two items that begin at once may share a line
                break
        time.sleep(0.3)
        begin = time.monotonic()
        _, error = stopped(process)
        took = time.monotonic() - begin
    assert process.returncode == 130
    assert error.endswith("chunks are kept in 'out'. The same command goes on from there.\n")
    assert took < 1.0 + BUSY


def test_a_march_asks_the_token_of_its_context_and_ends_by_its_error():
    asked = []

    def look():
        asked.append(1)
        if len(asked) > 3:
            raise CancelledError

    from contextvars import copy_context

    def run():
        set_stop_check(look)
        motor = wb.open_loop(wb.DCMotor())
        wb.simulate(wb.rk4(motor, 1e-3), np.tile(motor.parameters.default, (64, 1)), until=4000.0, every=4000.0)

    with pytest.raises(CancelledError):
        copy_context().run(run)
    assert len(asked) == 4
