"""The stop of a process by a signal, as Ctrl-C sends it: within some seconds, or with a sentence."""

import signal
import subprocess

import pytest

PATIENCE = 15.0  # s: a stop takes a second, and other tests may have all processors
DEAF = (
    " This run of the tests ignores Ctrl-C, and so do the processes that it starts: a shell does that to what it "
    "starts in the background. Run the tests in the foreground."
)


def stopped(process, sign=signal.SIGINT):
    """What a process wrote to stdout and stderr until a signal stopped it; one that goes on is killed, and fails."""
    process.send_signal(sign)
    try:
        return process.communicate(timeout=PATIENCE)
    except subprocess.TimeoutExpired:
        process.kill()
        process.communicate()
        why = DEAF if signal.getsignal(signal.SIGINT) == signal.SIG_IGN else ""
        pytest.fail(f"The process went on for {PATIENCE:g} s after {signal.Signals(sign).name}.{why}", pytrace=False)
