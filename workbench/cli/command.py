"""The command `workbench`: its verbs, and the exit status of a wrong call.

An error is one sentence on stderr, with exit status 2; Ctrl-C ends with 130.
"""

from __future__ import annotations

import os
import signal
import sys

import click

from workbench import __version__
from workbench.cli.derive import derive
from workbench.cli.doctor import doctor
from workbench.cli.errors import leave, let_go_of_output, sentence
from workbench.cli.export import export
from workbench.cli.live import live
from workbench.cli.replay import replay
from workbench.cli.report import report
from workbench.cli.results import results
from workbench.cli.run import run
from workbench.cli.status import status
from workbench.cli.verify import verify


@click.group()
@click.version_option(__version__, package_name="control-workbench", prog_name="workbench")
def cli() -> None:
    """Equations in, verdicts and numbers out: design, check and compare control laws."""


for verb in (run, live, report, status, results, export, replay, derive, verify, doctor):
    cli.add_command(verb)


def main() -> None:
    """The command `workbench`."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # with which batch systems end what takes too long
    status: object = 1
    try:
        sys.exit(_status())
    except OSError as error:  # as when the disk that help is written to is full
        leave(sentence(error), 2)
    except SystemExit as end:
        status = end.code
        raise
    finally:
        try:
            sys.stdout.flush()
        except OSError:  # what could not be written now cannot be at the end of the process either
            let_go_of_output()
        executors = sys.modules.get("workbench.study.executors")
        if executors is not None and executors.is_busy():  # with what cannot be ended, and holds up nothing
            sys.stderr.flush()
            os._exit(status if isinstance(status, int) else 1)


def _status() -> int:
    try:
        status = cli.main(prog_name="workbench", standalone_mode=False)
    except click.exceptions.NoArgsIsHelpError as error:
        error.show()
        status = error.exit_code
    except click.ClickException as error:
        leave(error.format_message(), error.exit_code)
    except click.Abort:
        leave("stopped.", 130)
    return status if isinstance(status, int) else 0
