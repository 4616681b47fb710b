"""Live pages as they are written: under their own policy, in a frame, of long runs and with noise."""

import numpy as np
import pytest

import workbench as wb
from studies.paper.laws import rival
from studies.performance.chromium import open_page
from tests.support.arms import arm_instruments
from tests.support.browsers import needs_chromium
from tests.support.compilers import needs_llvmlite
from tests.support.live_pages import data_of, write_page
from tests.support.turned_pages import BYTES, IDLE, KNOBS, LOOPS, numbers, opened, python_run, turned

pytestmark = [needs_chromium, needs_llvmlite]


@pytest.mark.heavy
def test_noise_and_long_strides_keep_the_bits(tmp_path, browser):
    noisy = rival("FS", "PID").digital(
        2e-3, arm_instruments(2, noise_q=1e-4, noise_qd=1e-2, quantum_q=1e-5, limit=400.0)
    )
    knobs = [("Kp", "N m/rad", "controller.Kp", 50.0, 500.0, False)]
    data = data_of({("FS", "PID"): noisy}, 1e-3, 6.0, 6.0, knobs, seed=3)
    assert data["loops"][0]["normals"] > 0
    assert data["loops"][0]["whole"]["stride"] > 2000
    with open_page(write_page(tmp_path, data), browser=browser) as page:
        opened(page)
        page.value("livePage.bench.sow('18446744073709551615')")
        page.until(IDLE)
        told = page.value(BYTES % 0)
        runs, _ = python_run(noisy, {}, 1e-3, 6.0, 6.0, 2**64 - 1)
        np.testing.assert_array_equal(numbers(told["x"], runs.x.shape[2]), runs.x[0])


def test_a_long_run_grows_before_it_is_done(tmp_path, browser):
    data = data_of({("FS", "SMC"): LOOPS["FS", "SMC"]}, 5e-5, 60.0, 0.1, KNOBS[:2])
    with open_page(write_page(tmp_path, data), browser=browser) as page:
        opened(page)
        page.value(
            "(() => { window.grown = []; const hear = livePage.hear.bind(livePage); livePage.hear = (view) => {"
            " if (view.phase === 'whole') grown.push([view.rows, view.done, view.y.slice(3 * view.rows).findIndex("
            "Number.isNaN)]); hear(view); }; })()"
        )
        turned(page, knob0=0.2)
        *early, last = page.value("grown")
        assert last[:2] == [600, True]
        assert early
        assert all(rows < 600 and not done and gap == 3 for rows, done, gap in early)
        assert [rows for rows, *_ in early] == sorted({rows for rows, *_ in early})


@pytest.fixture(scope="module")
def small():
    motor = wb.DCMotor()
    law = wb.PID(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0)
    return wb.live(wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0, time=0.1)), until=2.0)


def moves(page):
    page.until("typeof livePage !== 'undefined'")
    page.value("livePage.bench.open()")
    page.value("livePage.bench.knobs[0].turn(500)")
    page.until(IDLE)
    page.until(
        "document.querySelector('svg.live .live-series') !== null && document.querySelector('.live-number') !== null"
    )
    assert page.complaints == []


def test_a_page_as_it_is_written_moves_under_its_own_policy(small, tmp_path, browser):
    path = small.write(tmp_path / "small.html")
    with open_page(path, browser=browser) as page:
        moves(page)
        assert page.requests == [path.resolve().as_uri()]
        page.value("livePage.bench.reset()")
        page.until("!document.querySelector('svg.live') && !document.querySelector('.live-number')")


def test_a_page_in_the_frame_of_a_notebook_moves_and_stays_there(small, tmp_path, browser):
    path = tmp_path / "notebook.html"
    path.write_text(f"<!DOCTYPE html><title>A notebook</title>{small._repr_html_()}", "utf-8")
    with open_page(path, browser=browser) as page:
        frame = page.frame()
        moves(frame)
        assert frame.until("location.hash") == "#knobs=controller.Kp:500"
        assert frame.value("location.href.startsWith('about:srcdoc')")
