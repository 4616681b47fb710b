"""The pictures of README and of the tutorial: `python docs/live_picture.py` makes them, the live pages in Chromium."""

import contextlib
import runpy
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

import workbench as wb  # noqa: E402
from docs.loops import of_plants  # noqa: E402
from studies.performance.chromium import open_page  # noqa: E402

PICTURES = ROOT / "docs" / "pictures"
COLOURS = 128  # of a picture, so that README loads at once


def main() -> None:
    """Draw the loops of the walk, and show the page of the first one, and of a cart-pole whose numbers are turned."""
    with tempfile.TemporaryDirectory() as folder:
        with contextlib.chdir(folder):
            loop = runpy.run_path(str(ROOT / "studies" / "first.py"))["loop"]
            runpy.run_path(str(ROOT / "studies" / "own_plant.py"))
        study = [ROOT / "studies" / "own_study.py", "--out", Path(folder) / "study"]
        subprocess.run([sys.executable, "-m", "workbench", "run", *study], cwd=ROOT, check=True)
        shutil.copy(Path(folder) / "study" / "figures" / "indices.svg", PICTURES / "own_study.svg")
        for name in ("first_loop.png", "own_plant.png"):
            shutil.copy(Path(folder) / name, PICTURES)
        show(wb.live(loop, until=2.0).write(Path(folder) / "first.html"), "", "first_live.png")
        one = of_plants()["LQG, cart-pole"]
        page = wb.live(one.loop, one.until, one.h, title="LQG, cart-pole").write(Path(folder) / "live.html")
        show(page, "#knobs=controller.K:1.8,plant.phi:0.25", "live.png")


def show(page: Path, address: str, name: str) -> None:
    """Keep what the window shows of a page."""
    with open_page(page, address, 1360, 900) as shown:
        shown.until("livePage.data")
        shown.value("new Promise((done) => setTimeout(done, 12000))")  # on a slow machine, too
        shown.picture(PICTURES / name)
    with Image.open(PICTURES / name) as picture:
        picture.convert("RGB").quantize(COLOURS).save(PICTURES / name, optimize=True)


if __name__ == "__main__":
    main()
