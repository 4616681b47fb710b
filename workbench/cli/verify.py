"""The verb `verify`: compare the equations that a paper prints with those derived for a robot."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from workbench.cli.derive import arm_of
from workbench.cli.errors import one_sentence, printable

COLOURS = {"same": "green", "differs": "red", "not refuted": "yellow"}


@click.command()
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--robot", required=True, help="An arm of the catalogue, or a URDF file.")
def verify(file: Path, robot: str) -> None:
    """Compare the printed M, C and G in FILE (.txt or .tex) with those derived for a robot.

    Each statement is `name = formula`: an entry (M[1,2] = ..., G_1 = ...), a matrix (C(q, qd) = [[...], [...]],
    or LaTeX's bmatrix), or a declaration (l_c1 = links[0].com, theta_1 = q_1, h = m_2*l_1*l_c2). The robot's
    letters are those that `workbench derive` prints. Exit status 1 if an entry differs.
    """
    with one_sentence():
        from workbench.arms.dynamics import Dynamics
        from workbench.cli.printed_comparison import findings

        entries = findings(file, Dynamics.of(*arm_of(robot)))
        for finding in entries:
            head, *details = finding.lines
            click.secho(printable(head), fg=COLOURS.get(finding.kind or ""))
            click.echo("\n".join(map(printable, details)), nl=bool(details))
        sys.exit(1 if any(finding.kind == "differs" for finding in entries) else 0)
