"""The pictures of the README: `python docs/live_picture.py` makes them, the live pages in Chromium."""

import contextlib
import runpy
import shutil
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

import workbench as wb  # noqa: E402
from docs.loops import of_plants  # noqa: E402
from studies.performance.chromium import open_page  # noqa: E402

PICTURES = ROOT / "docs" / "pictures"


def main() -> None:
    """Make all pictures."""
    cart_pole()
    first_loop()


def first_loop() -> None:
    """The first loop of the walk: its Bode plot, and its live page as it opens."""
    with tempfile.TemporaryDirectory() as folder:
        with contextlib.chdir(folder):
            loop = runpy.run_path(str(ROOT / "studies" / "first.py"))["loop"]
        shutil.copy(Path(folder) / "first_loop.png", PICTURES)
        path = wb.live(loop, until=2.0).write(Path(folder) / "first.html")
        with open_page(path, "", 900, 900) as shown:
            shown.until("livePage.views.size")
            shown.value("new Promise((done) => setTimeout(done, 1500))")
            shown.picture(PICTURES / "first_live.png")


def cart_pole() -> None:
    """Open the page of a cart-pole, turn its gains and its start, and keep what the window shows."""
    one = of_plants()["LQG, cart-pole"]
    page = wb.live(one.loop, one.until, one.h, title="LQG, cart-pole")
    with tempfile.TemporaryDirectory() as folder:
        path = page.write(Path(folder) / "live.html")
        with open_page(path, "#knobs=controller.K:1.8,plant.phi:0.25", 1200, 640) as shown:
            shown.until("livePage.views.size")
            shown.value("document.querySelector('.bench-motion').open = true")
            shown.value("document.querySelector('figure.drawing').scrollIntoView(); scrollBy(0, -16)")
            shown.value("new Promise((done) => setTimeout(done, 1500))")
            shown.picture(PICTURES / "live.png")


if __name__ == "__main__":
    main()
