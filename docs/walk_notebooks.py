"""The notebooks of the site: the files of the walk cut into cells, with a sentence above each.

`notebook_outputs` runs them when the site is built. The code comes from the file, so the two cannot differ. A cell
begins at the line of the file that begins with its `start`. The notebook shows the pictures that the file saves.
"""

from __future__ import annotations

import ast
import hashlib
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
FOLDER = Path(__file__).parent / "notebooks"
DOWNLOADS = "downloads"  # below FOLDER: the notebooks without the link to themselves
SAVED = re.compile(r'^(\S.*)\.savefig\("[\w.]+"\)$', re.M)  # a picture of the file that the notebook shows instead
INLINE = "%matplotlib inline"
CLONE = (
    "This notebook takes the numbers of the paper from the project: run it in the environment of a clone "
    "(`make env`), from the top folder of the clone."
)


@dataclass(frozen=True)
class Cell:
    """A part of a file, from the line that begins with `start`, and the text above it.

    `shows` is an expression that the notebook adds below, as the file prints nothing. A cell without `start` has that
    alone.
    """

    start: str
    text: str
    shows: str = ""


@dataclass(frozen=True)
class Notebook:
    """A file of the project as a notebook: its title, its cells, and a remark for those who run it elsewhere."""

    source: str
    title: str
    cells: tuple[Cell, ...]
    remark: str = ""

    @property
    def name(self) -> str:
        """The name of its file, without the ending."""
        return Path(self.source).stem

    @property
    def _file(self) -> tuple[str, str]:
        """The docstring of the file and the code below it."""
        text = (ROOT / self.source).read_text(encoding="utf-8")
        first = ast.parse(text).body[0]
        assert isinstance(first, ast.Expr)
        return ast.literal_eval(first.value), "\n".join(text.splitlines()[first.end_lineno :])

    @property
    def about(self) -> str:
        """The first sentence of the file."""
        return self._file[0].strip()

    @property
    def parts(self) -> list[str]:
        """The code of the file, cut where the cells begin."""
        code = self._file[1]
        starts = [one.start for one in self.cells if one.start]
        places = []
        for start in starts:
            found = [match.start() for match in re.finditer(rf"^{re.escape(start)}", code, re.M)]
            if len(found) != 1:
                raise ValueError(f"A cell of {self.source} begins with {start!r}, and {len(found)} lines do so.")
            places += found
        if places != sorted(places) or code[: places[0]].strip():
            raise ValueError(f"The cells of {self.source} must be in the order of its lines, and leave none out.")
        return [code[a:b].strip("\n") for a, b in zip(places, [*places[1:], len(code)], strict=True)]

    def document(self, download: bool = False) -> dict[str, Any]:
        """The notebook in the form of Jupyter, 4.5; with `download`, also the link by which a page gives its file."""
        head = [f"# {self.title}\n\n{self.about}"]
        if self.remark:
            head.append(self.remark)
        if download:
            head.append(f"{{download}}`Download this notebook <{DOWNLOADS}/{self.name}.ipynb>`")
        cells = [_markdown("\n\n".join(head)), _markdown("This line makes a notebook show figures of matplotlib.")]
        cells.append(_code(INLINE))
        parts = iter(self.parts)
        for one in self.cells:
            code = SAVED.sub(r"\1", next(parts)) if one.start else ""
            cells += [_markdown(one.text), _code("\n\n".join(filter(None, (code, one.shows))))]
        for i, cell in enumerate(cells):
            cell["id"] = hashlib.sha256(f"{self.name} {i}".encode()).hexdigest()[:8]
        kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
        about = {"kernelspec": kernel, "language_info": {"name": "python", "pygments_lexer": "ipython3"}}
        return {"cells": cells, "metadata": about, "nbformat": 4, "nbformat_minor": 5}


def _markdown(text: str) -> dict[str, Any]:
    return {"cell_type": "markdown", "metadata": {}, "source": text}


def _code(text: str) -> dict[str, Any]:
    return {"cell_type": "code", "execution_count": None, "metadata": {}, "outputs": [], "source": text}


NOTEBOOKS = (
    Notebook(
        "studies/first.py",
        "A first loop",
        (
            Cell("import workbench", "All names of the workbench are in `wb`."),
            Cell(
                "motor = ", "The plant is a motor, the law a PID with limits. The reference steps to 1 rad/s at 0.1 s."
            ),
            Cell("runs = ", "A run of two seconds. The picture has the speed, its reference and the voltage."),
            Cell("wb.linear_loop", "The loop as a linear system: its Bode and Nyquist plots, with the margins."),
            Cell("", "The source of the plant and of the law, for a list of references.", "wb.cite(loop)"),
        ),
    ),
    Notebook(
        "studies/own_plant.py",
        "A plant of your own",
        (
            Cell("import numpy", "The arrays of NumPy, and the workbench."),
            Cell(
                "@wb.block",
                "A plant is a class. Each number has a unit and bounds. `rate` has the equations: the derivative of "
                "each state.",
            ),
            Cell(
                "ball, rest, current",
                "The magnet holds the ball 1 cm below itself at a current of 1 A. There the plant is linearised, and "
                "LQR finds the gain of a regulator.",
                "design.K",
            ),
            Cell("loop = ", "The loop in continuous time."),
            Cell("computer = ", "The same law in a computer: 2 ms a period, a noisy sensor, a limit, and a delay."),
            Cell("runs = ", "Both loops start with the ball 2 mm too low."),
        ),
    ),
    Notebook(
        "studies/own_law.py",
        "A law of your own",
        (
            Cell("import control", "Transfer functions come from python-control."),
            Cell("@wb.block", "A law is a class, too. `command` is the law, and `rate` has its memory: the integral."),
            Cell("def case", "A case is a loop with its horizon, its step and its metrics."),
            Cell("lead = ", "A lead compensator of the motor's speed error."),
            Cell("study = ", "The study asks a question and compares both laws."),
            Cell(
                "",
                "`workbench run` writes the report of a study. Here its cases are run, and their values stand in a "
                "table of pandas, each with its error.",
                "results = wb.study.run(study)\n"
                'results.to_frame().pivot(index=["metric", "unit"], columns="law", values=["value", "error"])',
            ),
            Cell(
                "",
                "The speed under both laws, at steps that the workbench chooses.",
                "wb.plot({case.law: wb.simulate(case.run.loop, until=5.0) for case in study.cases})",
            ),
        ),
    ),
    Notebook(
        "studies/own_study.py",
        "A study of your own",
        (
            Cell("import workbench", "All names of the workbench are in `wb`."),
            Cell("@wb.block", "The plant is a tank. A pump fills it, and an outlet empties it."),
            Cell("law = ", "A computer holds the level by a PID. Its sensor is noisy, and its commands come late."),
            Cell(
                "outlet = ",
                "Three numbers are uncertain: the outlet, a gain and the noise. Sobol's design varies them.",
            ),
            Cell(
                "def sections",
                "The section of the report: the share that each number has in the variance of the error.",
            ),
            Cell("title, question", "The study itself."),
            Cell(
                "",
                "`workbench run` runs all of this and writes the report. Here the sweep is run, and the picture of the "
                "section is shown.",
                "from workbench.report.picture import Picture\n"
                "from workbench.study.compiled import compile_sweep\n\n"
                "compiled = compile_sweep(sweep)\n"
                "sample = compiled.sample([compiled.chunk(0, sweep.design.size)])\n"
                "Picture(sections(wb.Results(samples=(sample,)))[0].blocks[0])",
            ),
        ),
    ),
    Notebook(
        "docs/paper_walk.py",
        "The paper in small",
        (
            Cell("import workbench", "The laws and the numbers of the paper are in `studies/paper`."),
            Cell("derived = ", "The arm of the paper, derived from its energies.", "derived"),
            Cell(
                "printed = ",
                "The paper prints M, C and G. Each entry is compared with the derived one. `same` is proved for all "
                "states and parameters.",
                "verdicts",
            ),
            Cell("wrong = ", "One entry differs. Here is a state at which anyone can check it.", "values"),
            Cell(
                "skew = ",
                "The proof of stability needs M' - 2C to be skew-symmetric. With the printed C it is not.",
                "skew",
            ),
            Cell("loops = ", "Four laws on the arm, in the scenario with the square wave."),
            Cell("metrics = ", "A case for each law, and a study of the four."),
            Cell(
                "results = ",
                "The values of the metrics. `table` also has the error of each, from a second run at half the step.",
                'table.pivot(index=["metric", "unit", "signal"], columns="law", values="value")',
            ),
            Cell("runs = ", "The angles and the torques of both joints, under two of the laws.", "figure"),
            Cell("citation = ", "The publications behind these laws.", "citation"),
        ),
        remark=CLONE,
    ),
)
