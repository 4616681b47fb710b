"""The command line: one verb, one function, one screen of output.

Whatever is wrong is said in one sentence on stderr, with exit status 2; Ctrl-C ends with 130.
"""

from __future__ import annotations

import gc
import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from traceback import format_exception
from typing import TYPE_CHECKING, Any, NoReturn

import click

from workbench import __version__
from workbench.cli import sentences

if TYPE_CHECKING:
    from workbench.core import AbstractArm

FORMS = ("text", "latex", "typst", "mathml", "python", "casadi", "c")


def main() -> None:
    """The command `workbench`."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # with which batch systems end what takes too long
    try:
        sys.exit(_status())
    except OSError as error:  # as when the disk that help is written to is full
        _leave(sentences.sentence(error), 2)
    finally:
        try:
            sys.stdout.flush()
        except OSError:  # what could not be written now cannot be at the end of the process either
            _let_go_of_output()


def _status() -> int:
    try:
        status = cli.main(prog_name="workbench", standalone_mode=False)
    except click.exceptions.NoArgsIsHelpError as error:
        error.show()
        status = error.exit_code
    except click.ClickException as error:
        _leave(error.format_message(), error.exit_code)
    except click.Abort:
        _leave("stopped.", 130)
    return status if isinstance(status, int) else 0


def _let_go_of_output() -> None:
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


@click.group()
@click.version_option(__version__, package_name="control-workbench", prog_name="workbench")
def cli() -> None:
    """Equations in, verdicts and numbers out: design, check and compare control laws."""


@cli.command()
@click.argument("study", type=click.Path(path_type=Path))
@click.option("--out", type=click.Path(path_type=Path), help="Folder of the report; reports/NAME if not given.")
@click.option("--samples", type=int, help="Samples of each sweep, in place of those in STUDY.")
@click.option("--workers", type=int, help="Threads, or workers of a local cluster; one a processor if not given.")
@click.option("--cluster", metavar="ADDRESS", help="The scheduler of a Dask cluster; 'local' starts one here.")
@click.option(
    "--arithmetic", type=click.Choice(("fused", "portable")), help="That of the sweeps; the ledger's if not given."
)
@click.option("--fresh", is_flag=True, help="Compute again what the ledger holds.")
@click.option("--ack", is_flag=True, help="Print each chunk and its SHA-256 once it is on the disk.")
@click.option("--yes", is_flag=True, help="Begin, however much time, memory and disk it takes.")
@click.option("--traceback", is_flag=True, help="Print Python's own after the sentence that says what is wrong.")
def run(study: Path, out: Path | None, ack: bool, traceback: bool, **asked: Any) -> None:
    """Run the study in the Python file STUDY and write its report.

    Of its sweeps nothing is computed twice: what was stopped, the same command goes on with.
    """
    del traceback  # `_leave` looks it up
    asked |= {"acknowledge": lambda chunk: click.echo(f"ACK {chunk.name} {chunk.digest.hex()}")} if ack else {}
    _run(study, out, asked)


@cli.command()
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
@click.option("--study", type=click.Path(path_type=Path), help="The file of the study, which is run as you named it.")
def report(folder: Path, study: Path | None) -> None:
    """Write the report in DIR again: sweeps from its ledger, single cases run anew.

    A folder may come from anywhere, so the file that it names is never run: name it yourself.
    """
    with _one_sentence():
        from workbench.cli import ledgers

        named, samples = ledgers.study_of(folder, study)
        _run(named, folder, {"samples": samples, "only_report": True})


@cli.command()
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
def status(folder: Path) -> None:
    """Say how much of the study in DIR is done, and what has failed."""
    with _one_sentence():
        from workbench.cli import ledgers

        click.echo("\n".join(ledgers.status(folder)))


@cli.command()
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
@click.option("--digests", is_flag=True, help="Print the SHA-256 of each chunk as JSON, and write nothing.")
@click.option("--format", "form", type=click.Choice(("csv", "parquet", "mat")), default="csv", show_default=True)
def results(folder: Path, digests: bool, form: str) -> None:
    """Write the runs of each sweep in DIR as a table, one row a run, and its single cases as another, to DIR/runs."""
    with _one_sentence():
        from workbench.cli import ledgers

        click.echo(ledgers.digests(folder) if digests else "\n".join(ledgers.write(folder, form)))


def _run(study: Path, out: Path | None, asked: dict[str, Any]) -> None:
    """Run a study, as far as its ledger lacks something, and write its report."""
    with _one_sentence(study):
        from workbench.cli import script

        script.check_file(study)
        # What a report needs comes before the study, whose folder goes first on the path: a file beside the study may
        # have the name of a module that is used here. Matplotlib comes behind it, when that folder is the last.
        with suppress(ImportError):  # llvmlite has no wheel here, and the other engine serves
            import workbench.simulate.kernel.native  # noqa: F401
        from concurrent.futures import ThreadPoolExecutor
        from dataclasses import replace
        from importlib import import_module

        from workbench.cli import sweeping
        from workbench.cli.progress import shown
        from workbench.report import folder
        from workbench.study import rows
        from workbench.study.runner import run as run_all
        from workbench.study.writeup import document, headlines

        loaded = script.resized(script.load(study), asked["samples"])
        target = out or Path("reports") / loaded.name
        folder.check_place(target)
        with sweeping.swept(loaded, target, sweeping.Order(study, say=_aside, **asked)) as answered:
            loaded = answered.study
            with _of_the_study(study, loaded.sections), shown(loaded.name, _aside) as progress:
                # what was imported stays, and little is made that only the collector can free: 0.25 s of looking
                gc.freeze()
                gc.set_threshold(50_000)
                with ThreadPoolExecutor(1) as beside:
                    beside.submit(import_module, "workbench.report.figures.figure_sheet")  # 0.3 s, for the end
                    found = replace(answered.results, outcomes=run_all(loaded, progress).outcomes)
            with _of_the_study(study, loaded.headlines):
                findings = headlines(loaded, found)
            with _of_the_study(study, loaded.sections):
                page = document(loaded, found, command=script.command(study, out, asked["samples"]))
                tables = {f"runs/{s.name}.csv": rows.to_csv(s) for s in found.all_samples}
                tables |= {rows.CASES: rows.cases_to_csv(found)} if found.rows else {}
                folder.write(page, target, tables)
        click.echo("\n".join([*findings, f"The report is {target / 'index.html'}, and {target / 'report.pdf'}."]))
        gc.freeze()  # nothing more is freed before the process ends, which frees all


@cli.command()
@click.argument("robot")
@click.option("--format", "form", type=click.Choice(FORMS), default="text", show_default=True)
@click.option("--numbers", is_flag=True, help="Put the nominal numbers of ROBOT in place of its letters.")
def derive(robot: str, form: str, numbers: bool) -> None:
    """Print M, C and G of ROBOT, an arm of the catalogue or a URDF file.

    Text, LaTeX, Typst and MathML are for reading; Python, CasADi and C compute the same numbers, and inverse
    and forward dynamics too.
    """
    with _one_sentence():
        from workbench import handover as derivation
        from workbench.core import Dynamics

        arm = _arm(robot)
        click.echo(derivation.FORMS[form](derivation.in_numbers(*arm) if numbers else Dynamics.of(*arm)))


@cli.command()
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--robot", required=True, help="An arm of the catalogue, or a URDF file.")
def verify(file: Path, robot: str) -> None:
    """Hold the printed M, C and G in FILE (.txt or .tex) against those derived for a robot.

    Each statement is `name = formula`: an entry (M[1,2] = ..., G_1 = ...), a matrix (C(q, qd) = [[...], [...]],
    or LaTeX's bmatrix), or a declaration (l_c1 = links[0].com, theta_1 = q_1, h = m_2*l_1*l_c2). The robot's
    letters are those that `workbench derive` prints. Exit status 1 if an entry differs.
    """
    with _one_sentence():
        from workbench.cli.verification import findings
        from workbench.core import Dynamics

        found = findings(file, Dynamics.of(*_arm(robot)))
        for finding in found:
            head, *details = finding.lines
            click.secho(head, fg={"same": "green", "differs": "red", "not refuted": "yellow"}.get(finding.kind or ""))
            click.echo("\n".join(details), nl=bool(details))
        sys.exit(1 if any(finding.kind == "differs" for finding in found) else 0)


@cli.command()
def doctor() -> None:
    """Check that all the workbench needs is here and works."""
    with _one_sentence():
        from workbench.cli.doctor import findings

        well = True
        for finding in findings():
            click.echo(f"{'ok' if finding.well else 'wrong':6} {finding.name:18} {finding.said}")
            well = well and finding.well
        sys.exit(0 if well else 1)


@cli.command()
@click.option("--json", "as_json", is_flag=True, help="Print the table as JSON.")
@click.option("--only", default="", metavar="NAME", help="Measure only the rows with NAME in theirs.")
@click.option("--quick", is_flag=True, help="Measure once what is else measured several times.")
def bench(as_json: bool, only: str, quick: bool) -> None:
    """Measure how fast the engine is, beside its peers and its bars."""
    with _one_sentence():
        from workbench.bench import effort, table

        rows = table.measured(effort.QUICK if quick else effort.Effort(), only, _aside)
        click.echo((table.as_json if as_json else table.as_text)(list(rows)))


def _arm(robot: str) -> tuple[AbstractArm, str]:
    """An arm of the catalogue, or of a URDF file, and its name."""
    from workbench.robots import CATALOGUE, named, urdf

    file = Path(robot)
    if file.suffix.lower() == ".urdf" or (robot not in CATALOGUE and file.is_file()):
        return urdf.read(file), file.stem
    if len(file.parts) > 1 or file.suffix:
        raise LookupError(f"There is no file '{robot}'; a robot is an arm of the catalogue or a URDF file.")
    return named(robot), robot


def _aside(said: str) -> None:
    click.echo(sentences.printable(said), err=True)


@contextmanager
def _one_sentence(script: Path | None = None) -> Iterator[None]:
    """Turn what is raised on purpose, or by the user's own script, into one sentence and an exit status."""
    try:
        yield
    except KeyboardInterrupt as stop:
        _leave(str(stop) or "stopped; no report was written.", 130)
    except BrokenPipeError:  # the reader of our output has left, as `head` does
        _let_go_of_output()
        sys.exit(0)
    except Exception as error:
        where = sentences.place(error, script) if script is not None else ""
        if not where and not sentences.is_said(error):
            raise
        _leave(where + sentences.sentence(error), 2, error)


@contextmanager
def _of_the_study(script: Path, function: Callable[..., object]) -> Iterator[None]:
    """What goes wrong in here is said with its place in the script, else with that of the `function` it comes from.

    Not so what a case raises, nor what the machine does: those have a sentence of their own, or are ours.
    """
    from workbench.report.folder import ReportError
    from workbench.study.runner import CaseError

    code = getattr(function, "__code__", None)
    of_function = (
        f"{sentences.shown(code.co_filename)}, line {code.co_firstlineno}: "
        if code
        else f"{sentences.shown(str(script))}: "
    )
    try:
        yield
    except SystemExit as error:
        place = sentences.place(error, script) or of_function
        _leave(f"{place}the study ended by itself, with status {error.code}, before its report was written.", 2)
    except (ReportError, CaseError, OSError, MemoryError):
        raise
    except Exception as error:
        _leave((sentences.place(error, script) or of_function) + sentences.sentence(error), 2, error)


def _leave(sentence: str, status: int, error: BaseException | None = None) -> NoReturn:
    click.echo(sentences.printable(f"workbench: {sentence}"), err=True)
    if error is not None and (context := click.get_current_context(silent=True)) and context.params.get("traceback"):
        for line in "".join(format_exception(error)).splitlines():
            _aside(line)
    sys.exit(status)
