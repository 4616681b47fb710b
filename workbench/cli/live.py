"""The verb `live`: the page of a loop in a file, whose numbers its reader turns."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

import click

from workbench.cli.errors import aside, one_sentence, printable

if TYPE_CHECKING:
    from workbench.blocks.loop import ClosedLoop
    from workbench.core import Ode, SampledSystem

PATH = click.Path(path_type=Path)
USUAL = "loop"
USUAL_STEP = 1e-3  # s


@click.command()
@click.argument("file", type=PATH)
@click.option("--loop", "name", help="The name of the loop in FILE; by default 'loop', or the last loop.")
@click.option("--until", type=float, help="The horizon in s; by default that of the runs in FILE.")
@click.option("--step", type=float, help="The step in s; by default that of the runs in FILE, or 0.001.")
@click.option("--out", type=PATH, help="The page; by default the name of FILE with .html, in the current folder.")
def live(file: Path, name: str | None, until: float | None, step: float | None, out: Path | None) -> None:
    """Run FILE, a Python file with a loop, and write a page on which a reader can change the loop's numbers."""
    from workbench.cli import script

    with one_sentence(file):
        file = script.file_of(file)
        script.check_file(file)
        module = script.module_of(file)
        from workbench.report.loop_page import live as page_of

        name, loop = _loop(module, file, name)
        horizon, usual = _times(module)
        horizon, h = horizon if until is None else until, usual if step is None else step
        if horizon is None:
            raise ValueError(
                f"`workbench live {file}` needs a horizon, as the file has no runs: add `--until SECONDS`."
            )
        page = page_of(loop, horizon, h, title=f"{name} of {file.name}")
        place = page.write(out or Path(f"{file.stem}.html"))
        if page.no_live_reason:
            aside(page.no_live_reason)
        aside(f"'{name}' until {horizon:g} s, at steps of {h:g} s.")
        click.echo(printable(f"The page is {place}."))


def _loop(module: ModuleType, file: Path, name: str | None) -> tuple[str, ClosedLoop | Ode | SampledSystem]:
    """A loop among the names of a script, and its name."""
    from workbench.blocks.loop import ClosedLoop
    from workbench.core import Ode, SampledSystem
    from workbench.core.validation.refusals import known_name

    held = {key: value for key, value in vars(module).items() if isinstance(value, ClosedLoop | SampledSystem | Ode)}
    if not held:
        raise LookupError(
            f"'{file}' has no loop: it must define a `ClosedLoop`, an `Ode` or a `SampledSystem` by a name."
        )
    chosen = known_name(name, held, f"loops in '{file}'") if name else USUAL if USUAL in held else [*held][-1]
    return chosen, held[chosen]


def _times(module: ModuleType) -> tuple[float | None, float]:
    """The horizon and the step of the first runs of a script."""
    from workbench.engine import Trajectories

    runs = (value for value in _values(vars(module)) if isinstance(value, Trajectories))
    return next(((float(one.t[-1]), one.page_step) for one in runs), (None, USUAL_STEP))


def _values(held: Mapping[str, object]) -> Iterator[object]:
    """All values, and those in dictionaries among them, as runs are handed to `plot`."""
    for value in held.values():
        yield value
        if isinstance(value, dict):
            yield from value.values()
