"""The gallery: notebooks, reports and live pages, each with a picture, a plain line, and the file that made it.

A notebook that has been executed is listed in `NOTEBOOKS`. Its `page` is a document of the site without an ending, as
"notebooks/first_loop"; `thumbnail` and `file` are paths below the root of the project.
"""

import html
import re
import shutil
from pathlib import Path
from typing import Any, NamedTuple

import workbench as wb
from docs import fits, loops
from docs.cards import Link, card, grid
from docs.reference_groups import GROUPS

DOCS = Path(__file__).parent
ROOT = DOCS.parent
STATIC = DOCS / "_static"
LOOPS, REPORTS, THUMBNAILS, FILES = (STATIC / name for name in ("loops", "reports", "thumbnails", "files"))
WIDE = 1.1, 1.9  # the least and the largest width over height of a thumbnail
STUDIES = DOCS / "_studies"  # a page for the file of each study


class Notebook(NamedTuple):
    """A notebook: its title, a plain line, a picture, its page on the site, and its file."""

    title: str
    line: str
    thumbnail: str
    page: str
    file: str


NOTEBOOKS: tuple[Notebook, ...] = ()
LINES = {  # of reports, in plain words
    "a0_two_link_arm": "The printed M, C and G of the paper's arm beside the derived ones.",
    "a1_paper_tables": "The tables of the paper, run as printed and as repaired.",
    "a2_claims": "A verdict on each equation, assumption and theorem of the paper.",
    "a3_riccati_gains": "The gains of the law's Riccati equation, and what changes without it.",
    "a4_observer_gains": "The observer's gains: a bound that is proved, and better gains.",
    "a5_linear_analysis": "Poles and margins of the arm under seven laws.",
    "a6_unstated_choices": "Thousands of draws of the numbers that the paper leaves open.",
    "a7_sensitivity": "Sobol indices: which numbers decide the error of each law.",
    "a8_fair_comparison": "Twelve laws, tuned with one budget and compared in paired draws.",
    "a9_sampling": "The laws in a computer: at which period they begin to chatter.",
    "b0_robots": "Arms of the catalogue: the cost of their equations, and their errors.",
    "b1_chattering": "Harmonic balance and simulation of chattering, side by side.",
    "b2_sobol_cost": "A study of 12,288 runs: its time and its memory.",
    "b3_any_plant": "Eight plants under LQG and PID, with a page to turn each.",
    "b4_handover": "Six laws on compilers, microcontrollers and a browser, bit by bit.",
    "c0_identify_arm": "The paper's arm, fitted to its own logs: what they tell, and what that is worth.",
    "c1_real_logs": "Fits of measured logs on data that they did not see, beside published models.",
    "d0_frequency": "Linear answers of six laws beside their nonlinear runs.",
    "d1_benchmarks": "A batch of processes, robust benchmarks, and linear laws for the arm.",
    "d2_planning": "Planned motions that are followed, and predictive laws beside linear ones.",
    "p0_performance": "The speed of the engine and its errors, beside other tools.",
}

LAWS = {  # of the arm, in plain words
    "AOSMC-RGS": "Adaptive sliding mode with an observer; a Riccati equation sets its gains.",
    "ASMC": "Sliding mode with a switching gain that adapts.",
    "Fuzzy-ASMC": "Adaptive sliding mode; fuzzy rules set how fast it adapts.",
    "RBF-ASMC": "Adaptive sliding mode with a Gaussian network for the unknown torque.",
    "PID": "PID on each joint by itself.",
    "PID + gravity": "PID on each joint, with the torque of gravity fed forward.",
    "SMC": "Sliding mode with a boundary layer.",
    "super-twisting": "Sliding mode of second order, with a continuous torque.",
    "feedforward + PD": "The torque of the reference, and linear feedback.",
    "computed torque": "Feedback linearisation.",
    "RISE": "The integral of the sign of the error, without a model.",
    "terminal SMC": "Sliding mode that reaches the reference in finite time.",
}


PLANS = "A law that plans 0.4 s ahead within a limit of the force. Turn its weight, the limit, or the cart's mass."


def gallery() -> str:
    """Write what the gallery leads to; the text of its page."""
    for folder in (LOOPS, REPORTS, THUMBNAILS, FILES, STUDIES):
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
    source_page("loops", ROOT / "docs" / "loops.py", "The loops of the gallery")
    source_page("fits", ROOT / "docs" / "fits.py", "The fits of the gallery")
    about = "[How to read such a page, and to make your own](howto/live_pages.md)"
    parts = [
        "---\nhide-toc: true\n---\n# Gallery\n",
        "Each picture leads to a page. The links below it lead to its laws and to the code that made it.\n",
        *(["## Notebooks\n", grid([notebook_card(one) for one in NOTEBOOKS])] if NOTEBOOKS else []),
        "## Plants to play with\n",
        f"Each page runs its loop in your browser at the numbers that you turn. {about}.\n",
        grid(plant_cards()),
        "## Laws to play with\n",
        "The two-link arm of a paper, under each law of the catalogue.\n",
        grid([loop_card(name, LAWS.get(name, ""), {"play": shown}) for name, shown in loops.of_arms().items()]),
        "## Laws that plan\n",
        "The dashed lines are the plans of the law.\n",
        grid([loop_card(name, PLANS, {"play": shown}) for name, shown in loops.of_plans().items()]),
        "## Fits to play with\n",
        "The curve of a fitted model moves under the samples of its log.\n",
        grid([fit_card(one) for one in fits.of_logs()]),
        "## Reports\n",
        "Each report answers one question. Most of them can be played with, too.\n",
        grid([report_card(path.parent) for path in sorted((ROOT / "reports").glob("*/index.html"))]),
    ]
    return "\n".join(parts)


def notebook_card(one: Notebook) -> str:
    """A notebook, its page, and its file to take away."""
    for path, folder in ((one.thumbnail, THUMBNAILS), (one.file, FILES)):
        shutil.copy(ROOT / path, folder)
    file = f"_static/files/{Path(one.file).name}"
    thumbnail = f"_static/thumbnails/{Path(one.thumbnail).name}"
    return card(one.title, one.line, thumbnail, f"{one.page}.html", [Link(Path(one.file).name, file)])


def plant_cards() -> list[str]:
    """A card for each plant, with a page for each of its laws."""
    purposes = {name: line for group in GROUPS for name, line in group.names.items()}
    plants: dict[str, dict[str, Any]] = {}
    for name, shown in loops.of_plants().items():
        law, _, plant = name.partition(", ")
        plants.setdefault(plant, {})[law] = shown
    return [
        loop_card(
            f"{plant[0].upper()}{plant[1:]}",
            purposes[type(next(iter(laws.values())).loop.plant).__name__],
            laws,
            {law: f"{law}, {plant}" for law in laws},
        )
        for plant, laws in plants.items()
    ]


def loop_card(title: str, line: str, loops_by_word: dict[str, Any], titles: dict[str, str] | None = None) -> str:
    """Write the live page of each loop and its picture; a card that leads to the first of them, with links to all."""
    links = []
    for word, shown in loops_by_word.items():
        name = (titles or {}).get(word, title)
        page = wb.live(shown.loop, shown.until, shown.h, knobs=shown.knobs, title=name)
        stem = re.sub(r"\W+", "-", name.replace("−", " minus").replace("+", " plus ")).strip("-").lower()
        page.write(LOOPS / f"{stem}.html")
        (LOOPS / f"{stem}.svg").write_text(drawn(page.text), encoding="utf-8")
        links.append(Link(word, f"_static/loops/{stem}.html"))
    first = links[0].address
    links.append(Link("code", "_studies/loops.html"))
    return card(title, line, first.replace(".html", ".svg"), first, links)


def fit_card(one: fits.FittedLog) -> str:
    """Write the live page of a fit and its picture; a card that leads to it."""
    page, stem = wb.fit_page(one.fit, one.title).text, re.sub(r"\W+", "-", one.title).lower()
    (LOOPS / f"{stem}.html").write_text(page, encoding="utf-8")
    (LOOPS / f"{stem}.svg").write_text(drawn(page), encoding="utf-8")
    address = f"_static/loops/{stem}.html"
    links = [Link("play", address), Link("code", "_studies/fits.html")]
    return card(one.title, one.line, address.replace(".html", ".svg"), address, links)


def drawn(page: str) -> str:
    """The first figure of a page, as a file of its own."""
    found = re.search(r'<figure[^>]*class="drawing".*?(<svg.*?</svg>)', page, re.S)
    assert found, "the page of a loop or of a fit draws its signals"
    return found[1]


def report_card(report: Path) -> str:
    """Copy a report and its first picture, and write a page for its study; the three as a card."""
    page = (report / "index.html").read_text(encoding="utf-8")
    title = html.unescape(re.search(r"<title>(.*?)</title>", page, re.S)[1]).strip()
    (REPORTS / report.name).mkdir()
    shutil.copy(report / "index.html", REPORTS / report.name)
    thumbnail = ""
    if picture := first_picture(report, page):
        shutil.copy(picture, THUMBNAILS / f"{report.name}.svg")
        thumbnail = f"_static/thumbnails/{report.name}.svg"
    study = report.name.removeprefix("p0_")
    file = ROOT / "studies" / study / "study.py"
    file = file if file.is_file() else ROOT / "studies" / f"{study}.py"
    source_page(report.name, file, title)
    address = f"_static/reports/{report.name}/index.html"
    links = [Link("report", address), Link("code", f"_studies/{report.name}.html")]
    return card(title, LINES.get(report.name, ""), thumbnail, address, links)


def first_picture(report: Path, page: str) -> Path | None:
    """The first figure on a report's page that is neither a strip nor a tower; else its first figure."""
    stems = re.findall(r'id="(?:fig-)?([\w-]+)"', page)
    figures = [place for stem in stems if (place := report / "figures" / f"{stem}.svg").is_file()]
    figures = figures or sorted((report / "figures").glob("*.svg"))
    return next((place for place in figures if WIDE[0] < aspect(place) < WIDE[1]), figures[0] if figures else None)


def aspect(svg: Path) -> float:
    """The width of a drawing over its height."""
    box = re.search(r'viewBox="[\d.]+ [\d.]+ ([\d.]+) ([\d.]+)"', svg.read_text(encoding="utf-8"))
    return float(box[1]) / float(box[2]) if box else 0.0


def source_page(name: str, file: Path, title: str) -> None:
    """A page of the site that shows a file."""
    place = file.relative_to(ROOT).as_posix()
    study = file.parent if file.name == "study.py" else file
    command = f"    workbench run {study.relative_to(ROOT).as_posix()}\n\n" if place.startswith("studies/") else ""
    text = (
        f"---\norphan: true\n---\n# {title}\n\n`{place}`, from the [gallery](../gallery.md):\n\n{command}"
        f"```{{literalinclude}} ../../{place}\n:language: python\n```\n"
    )
    (STUDIES / f"{name}.md").write_text(text, encoding="utf-8")
