"""What one hears of a long run."""

from workbench import progress


def test_progress_is_a_line_now_and_then_where_there_is_no_terminal(monkeypatch):
    clock = iter([0.0, 1.0, 12.0, 15.0, 30.0, 40.0])
    monkeypatch.setattr(progress, "monotonic", lambda: next(clock))
    said = []
    with progress.shown("long", said.append) as tell:
        for share in (0.1, 0.25, 0.3, 0.75, 1.0):
            tell(share)
    # at 12 s a quarter is done: 36 s are left; at 30 s three quarters: 10 s are left
    assert said == ["long: 25% done, about 36 s left", "long: 75% done, about 10 s left"]
