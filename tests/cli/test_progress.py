"""What one hears of a long run."""

from workbench.cli import progress


def test_progress_is_a_line_now_and_then_where_there_is_no_terminal(monkeypatch):
    clock = iter([0.0, 1.0, 12.0, 15.0, 30.0, 40.0])
    monkeypatch.setattr(progress, "monotonic", lambda: next(clock))
    said = []
    with progress.progress_bar("long", said.append) as tell:
        for share in (0.1, 0.25, 0.3, 0.75, 1.0):
            tell(share)
    # at 12 s a quarter is done: 36 s are left; at 30 s three quarters: 10 s are left
    assert said == ["long: 25% done, about 36 s left", "long: 75% done, about 10 s left"]


def test_runs_are_told_with_their_rate_and_with_those_that_failed(monkeypatch):
    clock = iter([0.0, 0.0, 2.0, 4.0])
    monkeypatch.setattr(progress, "monotonic", lambda: next(clock))
    said = []
    tell = progress.runs(lambda share, remark: said.append((share, remark)))
    for done, failed in ((500, 0), (700, 0), (1500, 3)):
        tell(done, failed, 1500)
    # 500 were done before: they say nothing of the rate, nor of the share of what was missing
    assert said[1:] == [(0.2, "700 of 1,500 runs, 100 a second"), (1.0, "1,500 of 1,500 runs, 250 a second, 3 failed")]


def test_a_run_with_nothing_to_do_is_done():
    said = []
    progress.runs(lambda share, remark: said.append(share))(1500, 0, 1500)
    assert said == [1.0]
