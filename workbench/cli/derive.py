"""The verb `derive`: M, C and G of an arm, to be read or to be computed with."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from workbench.cli.errors import one_sentence, printable_lines

if TYPE_CHECKING:
    from workbench.arms.dynamics import AbstractArm

FORMS = ("text", "latex", "typst", "mathml", "python", "casadi", "c")


@click.command()
@click.argument("robot")
@click.option("--format", "form", type=click.Choice(FORMS), default="text", show_default=True)
@click.option("--numbers", is_flag=True, help="Put the nominal numbers of ROBOT in place of its letters.")
def derive(robot: str, form: str, numbers: bool) -> None:
    """Print M, C and G of ROBOT, an arm of the catalogue or a URDF file.

    Text, LaTeX, Typst and MathML are for reading; Python, CasADi and C compute the same numbers, and inverse
    and forward dynamics too.
    """
    with one_sentence():
        from workbench.arms import code
        from workbench.arms.dynamics import Dynamics

        arm = arm_of(robot)
        click.echo(printable_lines(code.FORMS[form](code.in_numbers(*arm) if numbers else Dynamics.of(*arm))))


def arm_of(robot: str) -> tuple[AbstractArm, str]:
    """An arm of the catalogue, or of a URDF file, and its name."""
    from workbench.arms.mechanics import CATALOGUE, named, urdf

    file = Path(robot)
    if file.suffix.lower() == ".urdf" or (robot not in CATALOGUE and file.is_file()):
        return urdf.read(file), file.stem
    if len(file.parts) > 1 or file.suffix:
        raise LookupError(f"There is no file '{robot}'; a robot is an arm of the catalogue or a URDF file.")
    return named(robot), robot
